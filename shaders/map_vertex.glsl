// SPDX-License-Identifier: GPL-3.0-or-later
// One triangle that covers the frame; df_reach is the part of the unit disc that its sides reach.

void main()
{
    place = df_reach * pos;
    gl_Position = vec4(pos, 0.0, 1.0);
}
