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
// The light that reaches a point from a lamp: its surface is replaced by the nodes of a quadrature, in solid angle for
// balls and suns, in area for area lamps, each with the irradiance that it sends. No shadows.

// Node `index` of `count` = 1, 4 or 16 on a lamp: two places in [0, 1] and a weight. Square: Gauss's product rule. Round:
// places are the squared radius (or 1 - cosine) and the turn, rings of Gauss's rule, each with even spokes.
vec3 lamp_node(int index, int count, bool is_round)
{
    if (count == 1)
        return vec3(is_round ? 0.0 : 0.5, 0.5, 1.0);
    if (is_round) {
        int spokes = count == 4 ? 4 : 8, ring = index / spokes;
        float place = count == 4 ? 0.5 : (ring == 0 ? 0.2113248654 : 0.7886751346);
        return vec3(place, (float(index - ring * spokes) + 0.5 * float(ring)) / float(spokes), 1.0 / float(count));
    }
    int side = count == 4 ? 2 : 4, row = index / side;
    vec2 at = vec2(float(index - row * side), float(row)) - 0.5 * float(side - 1);  // -1.5, -0.5, 0.5, 1.5
    if (side == 2)
        return vec3(0.5 + at * 0.5773502692, 0.25);
    bvec2 inner = lessThan(abs(at), vec2(1.0));
    vec2 place = sign(at) * mix(vec2(0.4305681558), vec2(0.1699905218), vec2(inner));
    vec2 weight = mix(vec2(0.1739274226), vec2(0.3260725774), vec2(inner));
    return vec3(0.5 + place, weight.x * weight.y);
}

// A unit vector about `axis` whose 1 - cosine is `one_minus_cos`, at `turn` of the way round.
vec3 around(vec3 axis, float one_minus_cos, float turn)
{
    float z = 1.0 - one_minus_cos, r = sqrt(max(0.0, one_minus_cos * (1.0 + z)));
    vec3 side = normalize(cross(abs(axis.z) < 0.7 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0), axis));
    return r * cos(TWO_PI * turn) * side + r * sin(TWO_PI * turn) * cross(axis, side) + z * axis;
}

// How many points stand for a lamp as seen from `from`: one where it looks small.
int lamp_points(DiffractionLamp lamp, vec3 from)
{
    float kind = lamp.place.w, apart = kind == LAMP_SUN ? 1.0 : max(length(lamp.place.xyz - from), 1e-9);
    float wide = kind == LAMP_SUN || kind == LAMP_BALL ? lamp.colour.w : max(length(lamp.half_u.xyz), length(lamp.half_v.xyz));
    return wide < 0.002 * apart ? 1 : int(df_frame.counts.y);
}

// Direction `wi` to point `index` of the lamp, and the irradiance it sends to a surface that faces it.
vec3 lamp_light(DiffractionLamp lamp, vec3 from, int index, int count, out vec3 wi)
{
    float kind = lamp.place.w;
    vec3 node = lamp_node(index, count, kind != LAMP_RECTANGLE);
    float share = node.z;
    if (kind == LAMP_SUN) {
        vec3 axis = lamp.place.xyz;
        float s = sin(0.5 * lamp.colour.w), one_minus_cos = 2.0 * s * s;
        wi = count > 1 ? around(axis, one_minus_cos * node.x, node.y) : axis;
        // Solid angle over projected solid angle: a sun's strength is the irradiance on a surface that faces it.
        return lamp.colour.rgb * (share * 2.0 / (2.0 - one_minus_cos));
    }
    vec3 d = lamp.place.xyz - from;
    float d2 = max(dot(d, d), 1e-18), apart = sqrt(d2);
    if (kind == LAMP_BALL) {
        vec3 axis = d / apart;
        float t = lamp.colour.w / apart, t2 = t * t, one_minus_cos, irradiance;
        if (lamp.extra.z > 0.5) {  // soft falloff: a disc that faces the point
            float q = sqrt(1.0 + t2);
            one_minus_cos = t2 / (q * (q + 1.0));
            irradiance = 2.0 / (d2 * q * (q + 1.0));
        } else {
            float s = 1.0 + sqrt(max(0.0, 1.0 - t2));
            one_minus_cos = min(t2, 1.0) / s;
            irradiance = 2.0 / (max(d2, lamp.colour.w * lamp.colour.w) * s);
        }
        wi = count > 1 ? around(axis, one_minus_cos * node.x, node.y) : axis;
        if (lamp.half_u.w > 0.5) {  // spot: its cone, as long and wide as the object is scaled
            vec3 ray = vec3(dot(axis, lamp.half_u.xyz), dot(axis, lamp.half_v.xyz), -dot(axis, lamp.normal.xyz));
            float edge = clamp((normalize(ray).z - lamp.extra.x) * lamp.extra.y, 0.0, 1.0);
            irradiance *= edge * edge * (3.0 - 2.0 * edge);
        }
        return lamp.colour.rgb * (share * irradiance);
    }
    vec2 q = 2.0 * node.xy - 1.0;
    if (kind == LAMP_ELLIPSE)
        q = sqrt(node.x) * vec2(cos(TWO_PI * node.y), sin(TWO_PI * node.y));
    vec3 to = count > 1 ? d + q.x * lamp.half_u.xyz + q.y * lamp.half_v.xyz : d;
    float to2 = max(dot(to, to), 1e-18);
    wi = to * inversesqrt(to2);
    float cos_lamp = -dot(wi, lamp.normal.xyz);
    if (cos_lamp <= 0.0)
        return vec3(0.0);
    float spread = 1.0;
    if (lamp.extra.y > 0.0)  // a grid in front of the lamp that hides light which leaves at an angle
        spread = max(0.0, lamp.extra.x - sqrt(max(0.0, 1.0 - cos_lamp * cos_lamp)) / cos_lamp) * lamp.extra.y;
    return lamp.colour.rgb * (share * spread * lamp.normal.w * cos_lamp / to2);
}
// SPDX-License-Identifier: GPL-3.0-or-later
// From scene-linear RGB to what the framebuffer holds. Blender draws handlers after its view transform, on a picture that
// is linear in the display's light: there the scene's view transform is looked up in df_display.

vec3 displayed(vec3 rgb)
{
    if (df_frame.counts.z < 0.5)
        return rgb;
    vec3 at = log2(max(rgb, vec3(0.0)) * df_frame.display.x + 1.0) * df_frame.display.y;
    vec3 encoded = textureLod(df_display, clamp(at, 0.0, 1.0) * df_frame.display.z + df_frame.display.w, 0.0).rgb;
    // The display's transfer curve (IEC 61966-2-1) taken off again.
    return mix(encoded / 12.92, pow((max(encoded, vec3(0.04045)) + 0.055) / 1.055, vec3(2.4)),
               step(vec3(0.04045), encoded));
}
// SPDX-License-Identifier: GPL-3.0-or-later
// The light that a point of a surface sends to the viewer: diffraction of all lamps and, where the surface is replaced
// and not added to, the pigment underneath.

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
    if (df_surface.rotation.z > 0.5) {  // an image of angles, white is a whole turn
        vec2 size = vec2(textureSize(df_angle, 0));
        float turn = texelFetch(df_angle, ivec2(min(fract(world_uv) * size, size - 1.0)), 0).r;
        float angle = TWO_PI * turn + df_surface.rotation.w;
        c = cos(angle);
        s = sin(angle);
    }
    return mat3(c * t + s * across, c * across - s * t, n);
}

void main()
{
#ifdef LOOSE_DEPTH
    // EEVEE's depth was seen through another point of the pixel: as far towards the viewer as the surface rises there.
    gl_FragDepth = clamp(gl_FragCoord.z - df_frame.counts.w * fwidth(gl_FragCoord.z), 0.0, 1.0);
#endif
    vec3 to_viewer = df_frame.viewer.w > 0.5 ? normalize(df_frame.viewer.xyz - world_place) : df_frame.viewer.xyz;
    vec3 n = normalize(world_normal);
    bool mirrored = dot(df_model[0].xyz, cross(df_model[1].xyz, df_model[2].xyz)) < 0.0;
    bool front = gl_FrontFacing != mirrored;
    float cos_r = dot(n, to_viewer);
    bool diffracts = front && cos_r > 0.0;
    bool replaces = df_surface.pigment.w > 0.5;
    if (!diffracts && !replaces)
        discard;

    vec3 light = vec3(0.0), pigment = vec3(0.0);
    mat3 frame = scan_frame(n);
    vec3 wr = to_viewer * frame;  // its components along t, b, n
    float albedo_r = df_surface.fresnel.z > 0.5 && diffracts ? table_albedo(wr) : 1.0;
    int lamps = int(df_frame.counts.x);
    for (int i = 0; i < lamps; i++) {
        DiffractionLamp lamp = df_frame.lamps[i];
        int points = lamp_points(lamp, world_place);
        for (int j = 0; j < points; j++) {
            vec3 wi;
            vec3 irradiance = lamp_light(lamp, world_place, j, points, wi);
            float cos_i = dot(wi, n);
            if (replaces)
                pigment += irradiance * max(front ? cos_i : -cos_i, 0.0);
            if (!diffracts || cos_i <= 0.0 || irradiance.r + irradiance.g + irradiance.b <= 0.0)
                continue;
            vec3 f_cos = diffraction_f_cos(wi * frame, wr, albedo_r);
            light += irradiance * f_cos * fresnel(sqrt(max(0.0, 0.5 * (1.0 + dot(wi, to_viewer)))));
        }
    }
    // A plain world, seen by a surface that sends it back from all over the hemisphere alike.
    if (diffracts && df_surface.conductor_n.w > 0.5)
        light += df_frame.ambient.rgb * min(table_albedo(wr), 1.0) * fresnel(cos_r);
    light *= df_surface.fresnel.w;
    if (replaces) {
        pigment = df_surface.pigment.rgb * (pigment * (1.0 / PI) + df_frame.ambient.rgb);
        light += (vec3(1.0) - fresnel(abs(cos_r))) * pigment;
    }
    out_colour = vec4(displayed(light), 1.0);
}
