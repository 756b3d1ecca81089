// SPDX-License-Identifier: GPL-3.0-or-later
// The light that a point of a surface sends to the viewer: diffraction of all lamps and, where the surface is replaced
// and not added to, the pigment underneath.

#ifdef PAINTED  // scale, depth, rotation, mask of a paint (precompute/paint/maps.py), the closest texel
vec4 painted_here()
{
    vec2 size = vec2(textureSize(df_paint, 0));
    return texelFetch(df_paint, ivec2(min(fract(world_uv) * size, size - 1.0)), 0);
}
#endif

// The scan's frame as in diffraction.osl: t along its x, b along its y, right-handed or mirrored as the UV map is.
mat3 scan_frame(vec3 n)
{
    vec3 t = world_tangent.xyz;
    t -= dot(t, n) * n;
    if (dot(t, t) < 1e-12)  // no UV map: along the object's x, or y where that stands upright
        t = df_model[0].xyz;
    t -= dot(t, n) * n;
    if (dot(t, t) < 1e-12)
        t = cross(n, df_model[1].xyz);
    t = normalize(t);
    vec3 across = cross(n, t) * (world_tangent.w < 0.0 ? -1.0 : 1.0);
    float c = df_surface.rotation.x, s = df_surface.rotation.y;
#ifdef TURNED  // an image of angles, white is a whole turn
    vec2 size = vec2(textureSize(df_angle, 0));
    float turn = texelFetch(df_angle, ivec2(min(fract(world_uv) * size, size - 1.0)), 0).r;
    float angle = TWO_PI * turn + df_surface.rotation.w;
    c = cos(angle);
    s = sin(angle);
#endif
#ifdef PAINTED
    float angle = painted_here().b + df_surface.rotation.w;
    c = cos(angle);
    s = sin(angle);
#endif
    return mat3(c * t + s * across, c * across - s * t, n);
}

#if defined(LACQUER) && !defined(SUN_APART)
#define OUTER_FACE
// The outer face of a lacquer: what it sends of a lamp's irradiance (GGX, Smith's masking, reflectance at the view's
// angle as in diffraction.osl). `wide` is the lamp's angular radius, by which the lobe grows: few points stand for it.
float outer_mirror(vec3 wi, vec3 wr, float wide)
{
    float a2 = df_surface.kept[1].w * df_surface.kept[1].w + 0.25 * wide * wide;
    vec3 h = normalize(wi + wr);
    float d = h.z * h.z * (a2 - 1.0) + 1.0;
    float li = sqrt(a2 + (1.0 - a2) * wi.z * wi.z), lr = sqrt(a2 + (1.0 - a2) * wr.z * wr.z);
    // D G / (4 cos_i cos_r) cos_i, with G / (4 cos_i cos_r) = 1 / (2 (cos_i lr + cos_r li))
    return a2 / (PI * d * d) * wi.z / (2.0 * (wi.z * lr + wr.z * li));
}
#endif

void main()
{
#ifdef LOOSE_DEPTH
    // EEVEE's depth was seen through another point of the pixel: as far towards the viewer as the surface rises there.
    float slack = min(DEPTH_SLACK * fwidth(gl_FragCoord.z), df_frame.ambient.w * gl_FragCoord.w);
    gl_FragDepth = clamp(gl_FragCoord.z - slack, 0.0, 1.0);
#endif
#ifdef BOUNDED
    for (int i = 0; i < 6; i++) {
        if (dot(df_frame.clip[i], vec4(world_place, 1.0)) <= 0.0)
            discard;
    }
    vec2 pixel = gl_FragCoord.xy;
#ifdef GATHERS
    pixel += df_gathering.xy;
#endif
    bool outside = any(lessThan(pixel, df_frame.border.xy)) || any(greaterThan(pixel, df_frame.border.zw));
    if (df_frame.border.z > 0.0 && outside)
        discard;
#endif
    float mask = df_surface.rotation.z;  // 0 shows the pigment alone
#ifdef PAINTED
    vec4 paint = painted_here();
    mask = paint.a;
#elif defined(MASKED)
    vec4 texel = textureLod(df_mask, fract(world_uv), 0.0);
    mask += df_surface.fresnel.z * (df_surface.pigment.w > 0.5 ? texel.a : dot(texel.rgb, vec3(0.2126, 0.7152, 0.0722)));
#endif
    mask = clamp(mask, 0.0, 1.0);
#ifdef CUTOUT
    if (mask < 0.5)
        discard;
#endif
    vec3 to_viewer = df_frame.viewer.w > 0.5 ? normalize(df_frame.viewer.xyz - world_place) : df_frame.viewer.xyz;
    vec3 n = normalize(world_normal);
    float cos_r = dot(n, to_viewer);
#ifdef REPLACE
    bool mirrored = dot(df_model[0].xyz, cross(df_model[1].xyz, df_model[2].xyz)) < 0.0;
    bool front = gl_FrontFacing != mirrored;
    bool diffracts = front && cos_r > 0.0;
#else  // back faces are culled; no discard, which would shade what the depth hides
    bool diffracts = cos_r > 0.0;
#endif

    vec3 light = vec3(0.0), pigment = vec3(0.0), outer = vec3(0.0);
#ifdef PAINTED
    scaled_here = vec2(paint.r >= SCALE_LEAST ? paint.r : SCALE_LEAST, paint.g >= SCALE_LEAST ? paint.g : SCALE_LEAST);
#elif defined(SCALED)
    scaled_here = vec2(df_surface.texel.w, df_surface.fresnel.x);
#endif
    mat3 frame = scan_frame(n);
    vec3 wr = to_viewer * frame;  // its components along t, b, n
    float albedo_r = 1.0;
#ifdef CONSERVE
    albedo_r = table_albedo(wr);
#endif
#ifdef GATHERS  // the mean of light of the surroundings (addon/viewport/gathering.py)
    vec3 gathered = vec3(0.0);
#ifdef SKY
    if (diffracts)
        gathered = min(sky_light(frame, wr, albedo_r), vec3(6e4));
#endif
    if (df_gathering.z < 1.0)
        gathered = mix(texelFetch(df_gathered, ivec2(gl_FragCoord.xy), 0).rgb, gathered, df_gathering.z);
    // To the nearest half float here: what cuts the rest off makes each drawing darker, 64 of them 1 %.
    uvec3 bits = floatBitsToUint(gathered);
    out_colour = vec4(uintBitsToFloat((bits + 0xFFFu + ((bits >> 13u) & 1u)) & ~0x1FFFu), 1.0);
#else
    for (int i = 0; i < LAMPS; i++) {
        DiffractionLamp lamp = df_frame.lamps[i];
#ifdef WIDE
        int points = lamp_points(lamp, world_place);
        for (int j = 0; j < points; j++) {
#else
        const int points = 1, j = 0;
        {
#endif
            vec3 wi;
            vec3 irradiance = lamp_light(lamp, world_place, j, points, wi);
            float cos_i = dot(wi, n);
#ifdef REPLACE
            pigment += irradiance * max(front ? cos_i : -cos_i, 0.0);
#endif
            if (cos_i > 0.0) {
                float mirror = max(1.0 + dot(wi, to_viewer), 0.0);
                light += irradiance * diffraction_f_cos(wi * frame, wr, mirror, albedo_r) * fresnel(sqrt(0.5 * mirror));
#ifdef OUTER_FACE
                outer += irradiance * outer_mirror(wi * frame, wr, lamp_width(lamp, world_place));
#endif
            }
        }
    }
#ifdef AMBIENT  // a plain world, seen by a surface that sends it back from all over the hemisphere alike
#ifndef CONSERVE
    albedo_r = table_albedo(wr);
#endif
    light += df_frame.ambient.rgb * min(albedo_r, 1.0) * fresnel(cos_r);
#endif
#ifdef SKY
    if (diffracts)
        light += sky_light(frame, wr, albedo_r);
#endif
#ifdef GATHERED
    light += texelFetch(df_gathered, ivec2(gl_FragCoord.xy - df_gathering.xy), 0).rgb;
#endif
    light = diffracts ? light * df_surface.fresnel.w : vec3(0.0);
#ifdef OUTER_FACE
    outer += df_frame.ambient.rgb;
#ifdef SKYLIT
    outer += sky_radiance(reflect(-to_viewer, n), 4.0 * PI * df_surface.kept[1].w * df_surface.kept[1].w * max(cos_r, 0.01));
#endif
    light += diffracts ? outer * fresnel_exact(df_surface.kept[0].w, cos_r) : vec3(0.0);
#endif
    light *= mask;
#ifdef REPLACE
    vec3 around = df_frame.ambient.rgb;
#ifdef SKYLIT
    around += sky_diffuse(front ? n : -n);
#endif
    pigment = df_surface.pigment.rgb * (pigment * (1.0 / PI) + around);
    light += (vec3(1.0) - mask * kept_from_below(abs(cos_r))) * pigment;
#endif
    out_colour = vec4(displayed(light), 1.0);
#endif
}
