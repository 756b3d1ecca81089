// SPDX-License-Identifier: GPL-3.0-or-later
// Lookups of the spectral table, as docs/architecture.md describes it ("The spectral table"). Its slices are the layers
// of df_table, its albedo tile is df_albedo; the numbers of its layout come in df_surface.

#define PI 3.14159265358979
#define TWO_PI 6.28318530717959

float arsinh(float x)  // x >= 0
{
    return log(x + sqrt(x * x + 1.0));
}

// Angle of a vector in turns, [0, 1]; a vector of length zero has the angle 0.
float turns(vec2 d)
{
    float turn = dot(d, d) > 0.0 ? atan(d.y, d.x) * (1.0 / TWO_PI) : 0.0;
    return turn < 0.0 ? turn + 1.0 : turn;
}

// T(u, v, w) as XYZ in 1/sr; w_abs = |w| > 0.
vec3 table_transform(vec2 uv, float w_abs)
{
    float column = min(df_surface.radial.x * arsinh(length(uv) * df_surface.radial.y), df_surface.radial.z);
    float row = turns(uv) * df_surface.radial.w;
    float position = clamp(df_surface.slices.x * (arsinh(w_abs * df_surface.slices.y) - df_surface.slices.z), 0.0,
                           df_surface.slices.w);
    float lower = min(floor(position), df_surface.slices.w - 1.0);
    vec2 at = vec2(column + 0.5, row + 1.5) * df_surface.texel.xy;
    vec3 below = textureLod(df_table, vec3(at, lower), 0.0).rgb;
    vec3 above = textureLod(df_table, vec3(at, lower + 1.0), 0.0).rgb;
    return mix(below, above, position - lower) * (df_surface.value.x * pow(w_abs, df_surface.value.y));
}

// Directional albedo a(theta, phi) of the raw model with R = 1, of a local direction above the surface.
float table_albedo(vec3 direction)
{
    float column = acos(clamp(direction.z, 0.0, 1.0)) * (2.0 / PI) * df_surface.value.z;
    float row = turns(direction.xy) * df_surface.value.w;
    return textureLod(df_albedo, vec2(column + 0.5, row + 1.5) * df_surface.texel.zw, 0.0).r;
}
// SPDX-License-Identifier: GPL-3.0-or-later
// The reference method of the thesis (Single 2014, "full lambda sampling"): for each wavelength the spectrum of the phase
// is put together from the terms of a series (layers of df_terms: real and imaginary part on the bins of the patch's
// DFT) and convolved with the transform of the Gaussian window over the 3 x 3 bins next to (u, v) / lambda.

// Sum of all terms on one bin, for kappa.
vec2 flss_bin(ivec2 bin, float kappa)
{
    ivec2 size = textureSize(df_terms, 0).xy;
    if (any(lessThan(bin, ivec2(0))) || any(greaterThanEqual(bin, size)))
        return vec2(0.0);
    int count = int(df_series.loops.x);
    vec2 sum = vec2(0.0);
    if (df_series.loops.y < 0.5) {  // Taylor: (kappa h_half)^n / n!
        float x = kappa * df_series.loops.w, weight = 1.0;
        for (int n = 0; n < count; n++) {
            sum += weight * texelFetch(df_terms, ivec3(bin, n), 0).rg;
            weight *= x / float(n + 1);
        }
        return sum;
    }
    // Chebyshev: T_n(2 kappa / kappa_max - 1) by its recurrence.
    float x = 2.0 * kappa / df_series.loops.z - 1.0, before = x, weight = 1.0;
    for (int n = 0; n < count; n++) {
        sum += weight * texelFetch(df_terms, ivec3(bin, n), 0).rg;
        float next = 2.0 * x * weight - before;
        before = weight;
        weight = next;
    }
    return sum;
}

// T(u, v, w) as XYZ in 1/sr; w_abs = |w| > 0.
vec3 flss_transform(vec2 uv, float w_abs)
{
    vec3 xyz = vec3(0.0);
    int wavelengths = int(df_series.window.w);
    for (int l = 0; l < wavelengths; l++) {
        float wavelength = df_series.spectrum[l].w;
        float kappa = TWO_PI * w_abs / wavelength;
        vec2 place = (uv / wavelength - df_series.bins.xy) / df_series.bins.zw;
        ivec2 nearest = ivec2(floor(place + 0.5));
        vec2 sum = vec2(0.0);
        for (int j = -1; j <= 1; j++) {
            for (int i = -1; i <= 1; i++) {
                vec2 away = vec2(nearest + ivec2(i, j)) - place;
                // The window stands in the middle of the patch: its transform changes sign from bin to bin.
                float sign = ((i + j) & 1) == 0 ? 1.0 : -1.0;
                float weight = sign * exp(-dot(df_series.window.xy, away * away));
                sum += weight * flss_bin(nearest + ivec2(i, j), kappa);
            }
        }
        xyz += df_series.spectrum[l].rgb * (dot(sum, sum) / (wavelength * wavelength));
    }
    return xyz * df_series.window.z;
}
// SPDX-License-Identifier: GPL-3.0-or-later
// The BRDF: factor, Fresnel, energy, colour. Directions are local: (along t, along b, along n).

// Schlick's reflectance of a dielectric at the half-angle.
float fresnel_dielectric(float ior, float cos_half)
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

vec3 fresnel(float cos_half)
{
    if (df_surface.fresnel.x == FRESNEL_DIELECTRIC)
        return vec3(fresnel_dielectric(df_surface.fresnel.y, cos_half));
    if (df_surface.fresnel.x == FRESNEL_CONDUCTOR)
        return fresnel_conductor(df_surface.conductor_n.rgb, df_surface.conductor_k.rgb, cos_half);
    return vec3(1.0);
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
// 1 / cos_i then drops out.
vec3 f_cos_of(vec3 transform_xyz, vec3 wi, vec3 wr, float albedo_r)
{
    float w_abs = wi.z + wr.z, mirror = 1.0 + dot(wi, wr);
    float factor = mirror * mirror / (wr.z * w_abs * w_abs);
    if (df_surface.fresnel.z > 0.5)
        factor /= max(1.0, max(albedo_r, table_albedo(wi)));
    vec3 xyz = factor * transform_xyz;
    vec3 rgb = vec3(dot(df_surface.to_red.xyz, xyz), dot(df_surface.to_green.xyz, xyz),
                    dot(df_surface.to_blue.xyz, xyz));
    return into_gamut(rgb, xyz.y);
}

vec3 diffraction_f_cos(vec3 wi, vec3 wr, float albedo_r)
{
    vec2 uv = -(wi.xy + wr.xy);
    float w_abs = wi.z + wr.z;
#ifdef METHOD_FLSS
    return f_cos_of(flss_transform(uv, w_abs), wi, wr, albedo_r);
#else
    return f_cos_of(table_transform(uv, w_abs), wi, wr, albedo_r);
#endif
}
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
    vec3 xyz = table_transform(-(wi.xy + wr.xy), wi.z + wr.z);
#endif
    if (df_light.w > 0.5) {
        out_colour = vec4(xyz, 1.0);
        return;
    }
    float albedo_r = df_surface.fresnel.z > 0.5 ? table_albedo(wr) : 1.0;
    out_colour = vec4(f_cos_of(xyz, wi, wr, albedo_r), 1.0);
}
