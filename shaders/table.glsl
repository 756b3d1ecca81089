// SPDX-License-Identifier: GPL-3.0-or-later
// Lookups of the spectral table, as docs/architecture.md describes it ("The spectral table"). Its slices are the layers
// of df_table, its albedo is df_albedo; the numbers of its layout come in df_surface.

#define PI 3.14159265358979
#define TWO_PI 6.28318530717959

float arsinh(float x)  // x >= 0
{
    return log(x + sqrt(x * x + 1.0));
}

// Angle of a vector in turns, [0, 1]; a vector of length zero has the angle 0. A minimax polynomial for the arc tangent,
// wrong by less than 4e-7 turns: atan() itself is the dearest function here.
float turns(vec2 d)
{
    vec2 a = abs(d);
    float m = min(a.x, a.y) / max(max(a.x, a.y), 1e-30), s = m * m;
    float turn = m * (0.159151503 + s * (-0.052936484 + s * (0.030780405 + s * (-0.018467907 + s * (0.008312048
                 - s * 0.001839807)))));
    turn = a.y > a.x ? 0.25 - turn : turn;
    turn = d.x < 0.0 ? 0.5 - turn : turn;
    return d.y < 0.0 ? 1.0 - turn : turn;
}

// T(u, v, w) as XYZ in 1/sr; w_abs = |w| > 0.
vec3 table_transform(vec2 uv, float w_abs)
{
    float column = min(df_surface.radial.x * arsinh(length(uv) * df_surface.radial.y), df_surface.radial.z);
    float row = turns(uv) * df_surface.radial.w;
    // Between the first two slices the coordinate is that of 1 / w: a constant T, as a mirror has it, stays so. Below slice
    // 0 T is that of slice 0. The smallest w and the share stand in spare numbers.
    float w_min = df_surface.conductor_n.w, w = max(w_abs, w_min), first = (1.0 - w_min / w) * df_surface.conductor_k.w;
    float position = max(df_surface.slices.x * (arsinh(w * df_surface.slices.y) - df_surface.slices.z), min(first, 1.0));
    position = min(position, df_surface.slices.w);
    float lower = min(floor(position), df_surface.slices.w - 1.0);
    vec2 at = vec2(column + 0.5, row + 1.5) * df_surface.texel.xy;
    vec3 below = textureLod(df_table, vec3(at, lower), 0.0).rgb;
    vec3 above = textureLod(df_table, vec3(at, lower + 1.0), 0.0).rgb;
#ifdef LINEAR_IN_W
    return mix(below, above, position - lower) * (df_surface.value.x * w);
#else
    return mix(below, above, position - lower) * (df_surface.value.x * pow(w, df_surface.value.y));
#endif
}

#ifdef SCALED
// Period and depth over the table's, here: constants of the material, or the paint's.
vec2 scaled_here;
#endif

#if defined(SCALED) && (defined(CONSERVE) || defined(AMBIENT))
// The albedo of a painted surface, from tiles of a few scales whose channels are three depths
// (precompute/table/scaled_albedo.py).
float table_albedo(vec3 direction)
{
    float at = clamp(-SCALED_STEPS * log2(scaled_here.x / df_surface.value.z), 0.0, SCALED_N_SCALES - 1.0);
    float lower = min(floor(at), SCALED_N_SCALES - 2.0);
    float a = SCALED_DEPTH_0, b = SCALED_DEPTH_1, c = SCALED_DEPTH_2;
    float q = clamp(scaled_here.y / df_surface.value.w, c, a);
    vec3 shares = vec3((q - b) * (q - c) / ((a - b) * (a - c)), (q - a) * (q - c) / ((b - a) * (b - c)),
                       (q - a) * (q - b) / ((c - a) * (c - b)));
    float theta = acos(clamp(direction.z, 0.0, 1.0)), row = turns(direction.xy) * SCALED_N_PHI + 1.5;
    vec2 texel = 1.0 / vec2(SCALED_N_SCALES * SCALED_N_THETA, SCALED_N_PHI + 2.0);
    vec2 place = vec2(theta * (2.0 / PI) * (SCALED_N_THETA - 1.0) + lower * SCALED_N_THETA + 0.5, row) * texel;
    vec3 low = textureLod(df_tiles, place, 0.0).rgb;
    vec3 high = textureLod(df_tiles, place + vec2(SCALED_N_THETA * texel.x, 0.0), 0.0).rgb;
    return dot(mix(low, high, at - lower), shares);
}
#elif defined(CONSERVE) || defined(AMBIENT)
// Directional albedo a(theta, phi) of the raw model with R = 1, of a local direction above the surface. df_albedo holds the
// hemisphere in stereographic projection, so that the place costs no arc functions (data/textures.py).
float table_albedo(vec3 direction)
{
    vec2 at = direction.xy / (1.0 + max(direction.z, 0.0));
    return textureLod(df_albedo, at * df_surface.texel.z + 0.5, 0.0).r;
}
#endif
