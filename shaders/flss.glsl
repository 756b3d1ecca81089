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
