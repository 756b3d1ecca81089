// SPDX-License-Identifier: GPL-3.0-or-later
// A corner of a mesh: its place, normal and tangent in world space, and its UV.

void main()
{
    mat3 linear = mat3(df_model);
    // The cofactor matrix transforms normals, and exists for flat scales too.
    mat3 cofactor = mat3(cross(linear[1], linear[2]), cross(linear[2], linear[0]), cross(linear[0], linear[1]));
    float hand = dot(linear[0], cofactor[0]) < 0.0 ? -1.0 : 1.0;
    vec4 world = df_model * vec4(pos, 1.0);
    world_place = world.xyz;
    world_normal = hand * (cofactor * nor);
    world_tangent = vec4(linear * tan.xyz, hand * tan.w);
#ifdef PICTURED
    world_uv = uv;
#endif
    vec4 view = df_frame.view * world;
    // The scene's own pass has computed the same depth by other steps: a hair towards the viewer, so that its rounding
    // does not hide us.
    if (df_frame.viewer.w > 0.5)
        view.xyz *= 1.0 - 2e-5;
    gl_Position = df_frame.projection * view;
    gl_Position.z -= 2e-6 * gl_Position.w;
}
