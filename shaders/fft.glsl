// SPDX-License-Identifier: GPL-3.0-or-later
// The transforms of a bake, one small step a dispatch: every thread writes one element of `dst`, a complex number (or a real one in
// STAGE_REAL). What the steps compute together is in precompute/bake/intensity.py. Steps work on the lower left corner of the textures.

vec2 df_product(vec2 a, vec2 b)
{
    return vec2(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x);
}

// cos and sin: GLSL promises neither accuracy nor range. Quadrants are taken off in three parts (Cody and Waite, 1980), the rest are
// Taylor polynomials on [-pi/4, pi/4], wrong by less than 4e-8.
vec2 df_cos_sin(float x)
{
    float quadrant = floor(x * 0.63661977 + 0.5);
    float r = ((x - quadrant * 1.5703125) - quadrant * 4.837513e-4) - quadrant * 7.54979e-8;
    float s = r * r;
    float sine = r * (1.0 + s * (-1.0 / 6.0 + s * (1.0 / 120.0 + s * (-1.0 / 5040.0 + s / 362880.0))));
    float cosine = 1.0 + s * (-0.5 + s * (1.0 / 24.0 + s * (-1.0 / 720.0 + s / 40320.0)));
    int turn = int(quadrant) & 3;
    vec2 value = (turn & 1) == 0 ? vec2(cosine, sine) : vec2(-sine, cosine);
    return (turn & 2) == 0 ? value : -value;
}

// Index in a periodic transform of `length` of element i of its middle `kept`, both in the order of a discrete Fourier transform.
int df_kept(int i, int kept, int length)
{
    return i < (kept + 1) / 2 ? i : i + length - kept;
}

void main()
{
    ivec2 here = ivec2(gl_GlobalInvocationID.xy);
    // df_size: what is written (x, y) and what is read (z, w).
    if (here.x >= df_size.x || here.y >= df_size.y)
        return;
    vec2 value = vec2(0.0);

#if defined(STAGE_PHASE)
    // window * exp(-i kappa h), padded with zeros along x. df_size.zw: the patch.
    if (here.x < df_size.z) {
        float weight = texelFetch(df_along_x, ivec2(here.x, 0), 0).r * texelFetch(df_along_y, ivec2(here.y, 0), 0).r;
        value = weight * vec2(1.0, -1.0) * df_cos_sin(texelFetch(df_src, here, 0).r * df_kappa);
    }

#elif defined(STAGE_PASS)
    // One pass of a Stockham transform (Cooley and Tukey, 1965) of any radix: transforms of length `done` become such of done * radix.
    // df_pass: length, done, radix, sign of the exponent; df_along is (1, 0) for rows, (0, 1) for columns.
    int out_place = here.x * df_along.x + here.y * df_along.y;
    ivec2 line = here * (ivec2(1) - df_along);
    int group = df_pass.y * df_pass.z;
    int within = out_place % group;
    int first = (out_place / group) * df_pass.y + within % df_pass.y;
    int stride = df_pass.x / df_pass.z;
    int jump = within * (df_pass.x / group);
    int turn = 0;
    for (int r = 0; r < df_pass.z; ++r) {
        vec2 root = texelFetch(df_roots, ivec2(turn, 0), 0).rg;
        root.y *= float(df_pass.w);
        value += df_product(root, texelFetch(df_src, line + df_along * (first + r * stride), 0).rg);
        turn += jump;
        if (turn >= df_pass.x)
            turn -= df_pass.x;
    }

#elif defined(STAGE_BAND)
    // The band along x, padded with zeros along y. df_size.zw: length of the transform along x, rows of the patch.
    if (here.y < df_size.w)
        value = texelFetch(df_src, ivec2(df_kept(here.x, df_size.x, df_size.z), here.y), 0).rg;

#elif defined(STAGE_POWER)
    // |P|^2 on the band. df_size.w: length of the transform along y.
    vec2 amplitude = texelFetch(df_src, ivec2(here.x, df_kept(here.y, df_size.y, df_size.w)), 0).rg;
    value.x = dot(amplitude, amplitude);

#elif defined(STAGE_LAGS)
    // The lags that the window leaves, in the room of the last transform. df_size.zw: the band; df_cut: lags kept either side.
    ivec2 lag = ivec2(here.x < df_size.x / 2 ? here.x : here.x - df_size.x,
                      here.y < df_size.y / 2 ? here.y : here.y - df_size.y);
    if (abs(lag.x) <= df_cut.x && abs(lag.y) <= df_cut.y) {
        float weight = texelFetch(df_along_x, ivec2(here.x, 0), 0).r * texelFetch(df_along_y, ivec2(here.y, 0), 0).r;
        ivec2 place = ivec2(lag.x < 0 ? lag.x + df_size.z : lag.x, lag.y < 0 ? lag.y + df_size.w : lag.y);
        value = weight * texelFetch(df_src, place, 0).rg;
    }

#elif defined(STAGE_REAL)
    // The real part with frequency zero in the middle.
    ivec2 half_size = df_size.xy / 2;
    ivec2 place = ivec2(here.x < half_size.x ? here.x + half_size.x : here.x - half_size.x,
                        here.y < half_size.y ? here.y + half_size.y : here.y - half_size.y);
    value.x = texelFetch(df_src, place, 0).r;
#endif

    imageStore(df_dst, here, vec4(value, 0.0, 0.0));
}
