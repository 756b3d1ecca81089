// SPDX-License-Identifier: GPL-3.0-or-later
// f cos(theta_i) as seen from directions above the surface: `place` is (x, y) of the direction to the viewer, the frame's
// sides reach df_reach of the unit disc. df_light.xyz points to the light; df_light.w > 0 shows XYZ of T instead of RGB of f cos.

void main()
{
    float r2 = dot(place, place);
    out_colour = vec4(0.0);
    if (r2 >= 1.0)
        return;
    vec3 wr = vec3(place, sqrt(1.0 - r2)), wi = df_light.xyz;
#ifdef METHOD_FLSS
    vec3 xyz = flss_transform(-(wi.xy + wr.xy), wi.z + wr.z);
#else
    vec3 xyz = table_transform(-(wi.xy + wr.xy), path_w(wi, wr));
#endif
    if (df_light.w > 0.5) {
        out_colour = vec4(xyz, 1.0);
        return;
    }
    float albedo_r = 1.0;
#ifdef CONSERVE
    albedo_r = table_albedo(wr);
#endif
    out_colour = vec4(f_cos_of(xyz, wi, wr, 1.0 + dot(wi, wr), albedo_r), 1.0);
}
