// SPDX-License-Identifier: GPL-3.0-or-later
// The light that reaches a point from a lamp: its surface is replaced by the nodes of a quadrature, in solid angle for
// balls and suns, in area for area lamps, each with the irradiance that it sends. No shadows. Only the kinds that shine
// are compiled (SUNS, BALLS, SPOTS, AREAS; WIDE where more than one point is asked for): what runs in step takes every branch.

// Node `index` of `count` = 1, 4 or 16 on a lamp: two places in [0, 1] and a weight. Square: Gauss's product rule. Round:
// places are the squared radius (or 1 - cosine) and the turn, rings of Gauss's rule, each with even spokes.
vec3 lamp_node(int index, int count, bool is_round)
{
#ifndef WIDE
    return vec3(is_round ? 0.0 : 0.5, 0.5, 1.0);
#else
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
#endif
}

// A unit vector about `axis` whose 1 - cosine is `one_minus_cos`, at `turn` of the way round.
vec3 around(vec3 axis, float one_minus_cos, float turn)
{
    float z = 1.0 - one_minus_cos, r = sqrt(max(0.0, one_minus_cos * (1.0 + z)));
    vec3 side = normalize(cross(abs(axis.z) < 0.7 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0), axis));
    return r * cos(TWO_PI * turn) * side + r * sin(TWO_PI * turn) * cross(axis, side) + z * axis;
}

// Angular radius of a lamp, about.
float lamp_width(DiffractionLamp lamp, vec3 from)
{
    float kind = lamp.place.w;
    if (kind == LAMP_SUN)
        return lamp.colour.w;
    float wide = kind == LAMP_BALL ? lamp.colour.w : max(length(lamp.half_u.xyz), length(lamp.half_v.xyz));
    return min(wide / max(length(lamp.place.xyz - from), 1e-9), 1.0);
}

// How many points stand for a lamp as seen from `from`: one where it looks small.
int lamp_points(DiffractionLamp lamp, vec3 from)
{
#ifndef WIDE
    return 1;
#else
    float kind = lamp.place.w, apart = kind == LAMP_SUN ? 1.0 : max(length(lamp.place.xyz - from), 1e-9);
    float wide = kind == LAMP_SUN || kind == LAMP_BALL ? lamp.colour.w : max(length(lamp.half_u.xyz), length(lamp.half_v.xyz));
    return wide < 0.002 * apart ? 1 : int(df_frame.counts.y);
#endif
}

#ifdef SUNS
vec3 sun_light(DiffractionLamp lamp, vec3 node, int count, out vec3 wi)
{
    vec3 axis = lamp.place.xyz;
    wi = count > 1 ? around(axis, lamp.extra.x * node.x, node.y) : axis;
    // Solid angle over projected solid angle: a sun's strength is the irradiance on a surface that faces it.
    return lamp.colour.rgb * (node.z * 2.0 / (2.0 - lamp.extra.x));
}
#endif

#ifdef BALLS
vec3 ball_light(DiffractionLamp lamp, vec3 from, vec3 node, int count, out vec3 wi)
{
    vec3 d = lamp.place.xyz - from;
    float d2 = max(dot(d, d), 1e-18), apart = sqrt(d2);
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
#ifdef SPOTS
    if (lamp.half_u.w > 0.5) {  // spot: its cone, as long and wide as the object is scaled
        vec3 ray = vec3(dot(axis, lamp.half_u.xyz), dot(axis, lamp.half_v.xyz), -dot(axis, lamp.normal.xyz));
        float edge = clamp((normalize(ray).z - lamp.extra.x) * lamp.extra.y, 0.0, 1.0);
        irradiance *= edge * edge * (3.0 - 2.0 * edge);
    }
#endif
    return lamp.colour.rgb * (node.z * irradiance);
}
#endif

#ifdef AREAS
vec3 area_light(DiffractionLamp lamp, vec3 from, vec3 node, int count, out vec3 wi)
{
    vec3 d = lamp.place.xyz - from;
    vec2 q = 2.0 * node.xy - 1.0;
    if (lamp.place.w == LAMP_ELLIPSE)
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
    return lamp.colour.rgb * (node.z * spread * lamp.normal.w * cos_lamp / to2);
}
#endif

// Direction `wi` to point `index` of the lamp, and the irradiance it sends to a surface that faces it.
vec3 lamp_light(DiffractionLamp lamp, vec3 from, int index, int count, out vec3 wi)
{
    float kind = lamp.place.w;
    vec3 node = lamp_node(index, count, kind != LAMP_RECTANGLE);
#ifdef SUNS
    if (kind == LAMP_SUN)
        return sun_light(lamp, node, count, wi);
#endif
#ifdef BALLS
    if (kind == LAMP_BALL)
        return ball_light(lamp, from, node, count, wi);
#endif
#ifdef AREAS
    if (kind >= LAMP_RECTANGLE)
        return area_light(lamp, from, node, count, wi);
#endif
    wi = vec3(0.0, 0.0, 1.0);
    return vec3(0.0);
}
