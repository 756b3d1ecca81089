// SPDX-License-Identifier: GPL-3.0-or-later
// One triangle that covers the frame.

void main()
{
    place = pos;
    gl_Position = vec4(pos, 0.0, 1.0);
}
