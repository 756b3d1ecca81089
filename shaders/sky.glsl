// SPDX-License-Identifier: GPL-3.0-or-later
// Light of an image of the surroundings by filtered importance sampling (Krivanek & Colbert, 2008; GPU Gems 3, chapter 20):
// SKY directions a pixel from the densities of precompute/table/importance.py, the same for all pixels, each weighted with
// what the image holds on average over the part of the sphere that the direction stands for. No shadows.

#ifdef SKYLIT
// The image as levels of a mip map, in the equal-area square of Clarberg (2008), each with a border of one texel that
// repeats its neighbours on the sphere (addon/viewport/data/sky.py).
vec3 sky_texels(vec2 square, float level)
{
    float side = SKY_SIDE * exp2(-level);
    vec2 corner = level < 0.5 ? vec2(0.0) : vec2(SKY_SIDE + 2.0, SKY_SIDE - 2.0 * side + 2.0 * (level - 1.0));
    return textureLod(df_sky, (corner + 1.0 + square * side) * df_frame.sky[3].xy, 0.0).rgb;
}

// Place of a direction in world space in the square.
vec2 sky_square(vec3 direction)
{
    vec3 d = vec3(dot(df_frame.sky[0].xyz, direction), dot(df_frame.sky[1].xyz, direction),
                  dot(df_frame.sky[2].xyz, direction));
    float r = sqrt(max(1.0 - abs(d.z), 0.0)), v = r * 4.0 * turns(abs(d.xy)), u = r - v;
    vec2 square = d.z < 0.0 ? vec2(1.0 - v, 1.0 - u) : vec2(u, v);
    return 0.5 + 0.5 * square * vec2(d.x < 0.0 ? -1.0 : 1.0, d.y < 0.0 ? -1.0 : 1.0);
}

vec3 sky_strength()
{
    return vec3(df_frame.sky[0].w, df_frame.sky[1].w, df_frame.sky[2].w);
}

// What a diffuse surface sends on of albedo 1 and this normal: irradiance over pi.
vec3 sky_diffuse(vec3 n)
{
    vec2 at = SKY_DIFFUSE.xy + 1.0 + sky_square(n) * SKY_DIFFUSE.z;
    return sky_strength() * textureLod(df_sky, at * df_frame.sky[3].xy, 0.0).rgb;
}

// Radiance from a direction in world space, a mean over `solid_angle`.
vec3 sky_radiance(vec3 direction, float solid_angle)
{
    vec2 square = sky_square(direction);
    float level = clamp(0.5 * log2(solid_angle * (SKY_SIDE * SKY_SIDE / (4.0 * PI))), 0.0, SKY_LEVELS - 1.0);
    float lower = min(floor(level), SKY_LEVELS - 2.0);
    return sky_strength() * mix(sky_texels(square, lower), sky_texels(square, lower + 1.0), level - lower);
}

#endif

#ifdef SKY
// The row of the densities that belongs to the stored view nearest to wr in a set, and a third of dr / ds at its specular
// peak.
float sky_view(vec3 wr, float chosen, out float slope)
{
    float most = chosen > 0.0 ? IMPORTANCE_AZIMUTHS_SETS : IMPORTANCE_AZIMUTHS_MAX;
    float i = floor(log((1.0 + length(wr.xy)) / wr.z) * (IMPORTANCE_N_VIEWS / IMPORTANCE_VIEW_END) + 0.5);
    i = min(i, IMPORTANCE_N_VIEWS - 1.0);
    float full = most / IMPORTANCE_AZIMUTHS_STEP, below = min(i, full);
    float count = clamp(IMPORTANCE_AZIMUTHS_STEP * i, 1.0, most);
    float first = i > 0.0 ? 1.0 + 0.5 * IMPORTANCE_AZIMUTHS_STEP * below * (below - 1.0) : 0.0;
    first += most * (i - below);
    if (chosen > 0.0)
        first += IMPORTANCE_FIRST_VIEWS + IMPORTANCE_SET_VIEWS * (chosen - 1.0);
    float j = floor(turns(wr.xy) * count + 0.5);
    slope = min(2.0 / (1.0 + exp((i + 0.5) * (2.0 * IMPORTANCE_VIEW_END / IMPORTANCE_N_VIEWS))), 2.0 / 3.0);
    return first + (j >= count ? 0.0 : j);
}

// A direction of light and its solid angle per probability, by which f cos is to be multiplied.
vec3 sky_direction(vec3 wr, float row, float slope, vec2 xi, out float gain)
{
    float place_r = xi.x * IMPORTANCE_N_R, k = floor(place_r);
    vec3 ring = texelFetch(df_importance, ivec2(k, row), 0).rgb;
    float place_phi = xi.y * IMPORTANCE_N_PHI, l = floor(place_phi);
    vec3 turn = texelFetch(df_importance, ivec2(IMPORTANCE_N_R + ring.z * IMPORTANCE_N_PHI + l, row), 0).rgb;
    float s = sqrt(ring.x + (place_r - k) * (ring.y - ring.x));
    float x = place_phi - l, c = (turn.y - turn.z) / (turn.z - turn.x), bend = x + c * (1.0 - x);
    float phi = TWO_PI * (turn.x + (turn.y - turn.x) * x / bend), cos_phi = cos(phi), sin_phi = sin(phi);
    float area = (IMPORTANCE_N_R * TWO_PI * IMPORTANCE_N_PHI) * (ring.y - ring.x) * (turn.y - turn.x) * c / (bend * bend);

    float b = wr.x * cos_phi + wr.y * sin_phi, root = sqrt(b * b + wr.z * wr.z);
    float horizon = b > 0.0 ? b + root : wr.z * wr.z / (root - b), reach = wr.z * wr.z / horizon;
    float a = min(slope, reach), t = 1.0 - s;
    float per_s = 3.0 * a * t * t + reach * s * (3.0 - 2.0 * s), r = s * per_s;
    float rest = sqrt(max((reach * (1.0 + 2.0 * s) - 3.0 * a * s) * (r + horizon), 1e-20));
    gain = area * per_s * 1.5 * (a * (1.0 - 3.0 * s) + 2.0 * reach * s) / rest;
    return vec3(-r * cos_phi - wr.x, -r * sin_phi - wr.y, t * rest);
}

#ifdef SCALED
// Number of the set of views for the depth of the surface; see `depth_set` in importance.py.
float sky_set(float cos_r, float s, float depth)
{
    float sine2 = 1.0 - IMPORTANCE_SET_COSINE * IMPORTANCE_SET_COSINE, judged = depth;
    if (s < 1.0)
        judged *= (cos_r + IMPORTANCE_SET_COSINE)
                  / (sqrt(1.0 - s * s * (1.0 - cos_r * cos_r)) + sqrt(1.0 - s * s * sine2));
    return clamp(floor((1.0 - judged) / IMPORTANCE_DEPTH_STEP + 0.5), 0.0, IMPORTANCE_SETS - 1.0);
}

// How much of the probability can lie above the horizon of a surface stretched by s < 1; see `cut` in importance.py.
float sky_within(float row, float cos_r, float s)
{
    float sine = sqrt(max(1.0 - cos_r * cos_r, 0.0)), ratio = s * (1.0 + sine) / (1.0 + s * sine);
    float place = min(ceil((0.5 - sin(asin(1.0 - 2.0 * ratio) / 3.0)) * (IMPORTANCE_CUTS - 1.0)), IMPORTANCE_CUTS - 1.0);
    return texelFetch(df_importance, ivec2(IMPORTANCE_WIDTH - IMPORTANCE_CUTS + place, row), 0).r;
}
#endif

// Place `i` of a Fibonacci lattice, moved within its cells from one drawing of a picture to the next.
vec2 sky_places(int i)
{
    return vec2((float(i) + fract(0.5 + df_frame.counts.z)) / float(SKY),
                fract(0.5 + df_frame.counts.w + 0.6180339887 * float(i)));
}

vec3 sky_light(mat3 frame, vec3 wr, float albedo_r)
{
    vec3 light = vec3(0.0);
#ifdef SCALED  // on a stretched surface, for the viewer whose wr.xy is as much shorter, see importance.osl
    float s = min(scaled_here.x, 1.0);
    vec3 viewer = vec3(s * wr.xy, 0.0);
    viewer.z = s < 1.0 ? sqrt(max(1.0 - dot(viewer.xy, viewer.xy), 0.0)) : wr.z;
    float slope, row = sky_view(viewer, sky_set(wr.z, s, scaled_here.y), slope), gain;
    float within = s < 1.0 ? sky_within(row, wr.z, s) : 1.0;
#else
    vec3 viewer = wr;
    float slope, row = sky_view(viewer, 0.0, slope), gain;
    const float within = 1.0;
#endif
    // A part of the sphere for each direction, of all drawings that make a mean.
    float part = float(SKY) * df_frame.sky[3].z;
    for (int i = 0; i < SKY; i++) {
        vec2 xi = sky_places(i);
        vec3 wi = sky_direction(viewer, row, slope, vec2(xi.x * within, xi.y), gain);
        gain *= within;
#ifdef SCALED
        if (s < 1.0) {
            vec2 place = (wi.xy + viewer.xy) / s - wr.xy;
            float rest = 1.0 - dot(place, place), z = sqrt(max(rest, 1e-12));
            gain = rest > 0.0 ? gain * wi.z / (s * s * z) : 0.0;
            wi = vec3(place, z);
        }
#endif
        float mirror = max(1.0 + dot(wi, wr), 0.0);
        vec3 weight = gain * diffraction_f_cos(wi, wr, mirror, albedo_r) * fresnel(sqrt(0.5 * mirror));
        if (gain > 0.0 && wi.z > 0.0)
            light += weight * sky_radiance(frame * wi, gain / part);
    }
    return light / float(SKY);
}
#endif
