// SPDX-License-Identifier: GPL-3.0-or-later
// From scene-linear RGB to what the framebuffer holds. Blender draws handlers after its view transform, on a picture that
// is linear in the display's light: there the scene's view transform is looked up in df_display.

vec3 displayed(vec3 rgb)
{
#ifndef DISPLAY
    return rgb;
#else
    vec3 at = log2(max(rgb, vec3(0.0)) * df_frame.display.x + 1.0) * df_frame.display.y;
    vec3 encoded = textureLod(df_display, clamp(at, 0.0, 1.0) * df_frame.display.z + df_frame.display.w, 0.0).rgb;
    // The display's transfer curve (IEC 61966-2-1) taken off again.
    return mix(encoded / 12.92, pow((max(encoded, vec3(0.04045)) + 0.055) / 1.055, vec3(2.4)),
               step(vec3(0.04045), encoded));
#endif
}
