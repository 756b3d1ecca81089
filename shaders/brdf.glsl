// SPDX-License-Identifier: GPL-3.0-or-later
// The BRDF: factor, Fresnel, energy, colour. Directions are local: (along t, along b, along n).

// Schlick's approximation of the reflectance of a dielectric.
float fresnel_schlick(float ior, float cos_half)
{
    float root = (ior - 1.0) / (ior + 1.0), r0 = root * root, m = 1.0 - clamp(cos_half, 0.0, 1.0);
    return r0 + (1.0 - r0) * m * m * m * m * m;
}

// Reflectance of a conductor of index n + i k for unpolarised light, exact (Born & Wolf, 14.2), a channel at a time.
vec3 fresnel_conductor(vec3 n, vec3 k, float cos_half)
{
    float c = clamp(cos_half, 0.0, 1.0), c2 = c * c, s2 = 1.0 - c2;
    vec3 d = n * n - k * k - s2;
    vec3 a2b2 = sqrt(d * d + 4.0 * n * n * k * k);
    vec3 a = sqrt(max(0.5 * (a2b2 + d), vec3(0.0)));
    vec3 rs = (a2b2 + c2 - 2.0 * c * a) / (a2b2 + c2 + 2.0 * c * a);
    vec3 rp = rs * (c2 * a2b2 + s2 * s2 - 2.0 * c * s2 * a) / (c2 * a2b2 + s2 * s2 + 2.0 * c * s2 * a);
    return 0.5 * (rs + rp);
}

// Reflectance of a face to a clear medium of index ior for unpolarised light, exact (Born & Wolf, 1.5.2).
float fresnel_exact(float ior, float cosine)
{
    float c = clamp(cosine, 1e-7, 1.0), inside = sqrt(max(ior * ior - 1.0 + c * c, 0.0));
    float s = (c - inside) / (c + inside), p = (ior * ior * c - inside) / (ior * ior * c + inside);
    return 0.5 * (s * s + p * p);
}

// A direction inside a clear layer, still pointing outwards.
vec3 refracted(vec3 outside, float ior)
{
    vec2 inside = outside.xy / ior;
    return vec3(inside, sqrt(max(1.0 - dot(inside, inside), 0.0)));
}

// |w| of T: under a lacquer with the cosines inside.
float path_w(vec3 wi, vec3 wr)
{
#ifdef LACQUER
    float n = df_surface.kept[0].w;
    return n * (refracted(wi, n).z + refracted(wr, n).z);
#else
    return wi.z + wr.z;
#endif
}

// What the table holds already is 1 here.
vec3 fresnel(float cos_half)
{
#if defined(DIELECTRIC)
    return vec3(fresnel_exact(df_surface.fresnel.y, cos_half));
#elif defined(SCHLICK)
    return vec3(fresnel_schlick(df_surface.fresnel.y, cos_half));
#elif defined(CONDUCTOR)
    return fresnel_conductor(df_surface.conductor_n.rgb, df_surface.conductor_k.rgb, cos_half);
#else
    return vec3(1.0);
#endif
}

// What the surface keeps from the pigment below, towards the viewer.
vec3 kept_from_below(float cos_r)
{
#ifdef INSIDE
    float place = acos(clamp(cos_r, 0.0, 1.0)) * (2.0 / PI) * float(KEPT - 1);
    int lower = min(int(place), KEPT - 2);
    return mix(df_surface.kept[lower].rgb, df_surface.kept[lower + 1].rgb, place - float(lower));
#else
    return fresnel(cos_r);
#endif
}

// A colour outside the gamut moves towards the grey of its luminance until no component is negative.
vec3 into_gamut(vec3 rgb, float luminance)
{
    float lowest = min(rgb.r, min(rgb.g, rgb.b));
    if (lowest >= 0.0)
        return rgb;
    if (luminance <= 0.0)
        return vec3(0.0);
    return max(luminance + (rgb - luminance) * (luminance / (luminance - lowest)), vec3(0.0));
}

// From a transform in XYZ to f cos(theta_i) in the working space's RGB, R = 1. Multiplied by the cosine here because
// 1 / cos_i then drops out. mirror is 1 + wi.wr.
vec3 f_cos_of(vec3 transform_xyz, vec3 wi, vec3 wr, float mirror, float albedo_r)
{
#ifdef LACQUER
    float n = df_surface.kept[0].w;
    vec3 li = refracted(wi, n), lr = refracted(wr, n);
    float sum = li.z + lr.z, inside = 1.0 + dot(li, lr);
    float through = (1.0 - fresnel_exact(n, wi.z)) * (1.0 - fresnel_exact(n, wr.z));
    float factor = through * inside * inside * wi.z / (li.z * lr.z * sum * sum);
#else
    float w_abs = wi.z + wr.z;
    float factor = mirror * mirror / (wr.z * w_abs * w_abs);
#endif
#ifdef CONSERVE
    factor /= max(1.0, max(albedo_r, table_albedo(wi)));
#endif
    vec3 xyz = factor * transform_xyz;
    vec3 rgb = vec3(dot(df_surface.to_red.xyz, xyz), dot(df_surface.to_green.xyz, xyz),
                    dot(df_surface.to_blue.xyz, xyz));
    return into_gamut(rgb, xyz.y);
}

vec3 diffraction_f_cos(vec3 wi, vec3 wr, float mirror, float albedo_r)
{
    vec2 uv = -(wi.xy + wr.xy);
    float w_abs = path_w(wi, wr), gain = 1.0;
#ifdef SCALED  // T'(u, v, w) = s^2 T(s u, s v, q w)
    uv *= scaled_here.x;
    w_abs *= scaled_here.y;
    gain = scaled_here.x * scaled_here.x;
#endif
#if defined(SCALED) && defined(INSIDE) && !defined(LACQUER)
    // The stack's reflectance was taken at another half-angle than that of the directions.
    vec2 true_uv = wi.xy + wr.xy;
    float own = 0.5 * sqrt(dot(true_uv, true_uv) + (wi.z + wr.z) * (wi.z + wr.z));
    float taken = min(0.5 * sqrt(dot(uv, uv) + w_abs * w_abs), 1.0);
    vec3 corrected = kept_from_below(own) / max(kept_from_below(taken), vec3(REFLECTANCE_LEAST));
#else
    const vec3 corrected = vec3(1.0);
#endif
#ifdef METHOD_FLSS
    return corrected * f_cos_of(gain * flss_transform(uv, w_abs), wi, wr, mirror, albedo_r);
#else
    return corrected * f_cos_of(gain * table_transform(uv, w_abs), wi, wr, mirror, albedo_r);
#endif
}
