# SPDX-License-Identifier: GPL-3.0-or-later
"""What numpy says of the sphere of `scenes` under suns without size, per pixel."""

import numpy as np

from precompute.light.colour import xyz_to_rgb_matrix
from tests.support.blender import scenes
from tests.truth import radiance


def expected(ob, table, suns, size, reflectance=lambda wi, wr: 1.0, **options):
    """RGB of the sphere under unit suns from `suns` (world directions), and the pixels that can be compared."""
    hit, _, t, b, n = scenes.sphere_frames(ob, size)
    to_viewer = -scenes.camera_rays(size)[1]
    wr = radiance.local(to_viewer, t, b, n)
    total, good = np.zeros((*hit.shape, 3)), hit & (wr[..., 2] > 0.05)
    for sun in suns:
        wi = radiance.local(np.asarray(sun) / np.linalg.norm(sun), t, b, n)
        f_cos = radiance.gamut_step(radiance.f_cos_xyz(table, wi, wr, **options), xyz_to_rgb_matrix())
        total += f_cos * np.asarray(reflectance(wi, wr))[..., None]
        good &= wi[..., 2] > 0.05
    return total, good & (total.max(-1) > 1e-3)
