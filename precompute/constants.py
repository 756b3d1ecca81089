# SPDX-License-Identifier: GPL-3.0-or-later
"""Physical constants, conventions and defaults, each in one place.

Everything is in SI units: metres and radians.
"""

import math

#: Limits of the visible spectrum used for every colour integral (metres).
WAVELENGTH_MIN_M = 380e-9
WAVELENGTH_MAX_M = 780e-9

#: Largest value of |w| = cos(theta_i) + cos(theta_r).
W_MAX = 2.0

#: Largest kappa = k |w|, and largest spatial frequency |(u, v)| / lambda that visible light can reach (1/m).
KAPPA_MAX = 2.0 * math.pi * W_MAX / WAVELENGTH_MIN_M
FREQUENCY_MAX = W_MAX / WAVELENGTH_MIN_M

#: Pixels above lambda_min / 4 put false orders into view (|u| reaches 2 and the
#: transform is periodic in u with period lambda / dx).
PIXEL_MAX_M = WAVELENGTH_MIN_M / 4.0

#: Coherence length of sunlight; its window has the standard deviation of a quarter of it.
COHERENCE_LENGTH_SUN_M = 65e-6

#: Fraction of a patch that the Tukey taper of the ensemble average rolls off (both sides together).
TAPER_FRACTION = 0.2

#: Version of the spectral table's files (EXR atlas and JSON sidecar), and those that can be read.
TABLE_FORMAT_VERSION = 2
TABLE_FORMATS = (1, 2)

#: Version of the files of a series' terms.
TERMS_FORMAT_VERSION = 1

#: Version of the computation: raise it whenever the same scan and parameters give other texels, so that
#: no cache hands out what an older release computed.
BAKE_VERSION = 5

#: Largest bake without an explicit limit (bytes of texels as a renderer loads them).
TABLE_LIMIT_BYTES = 1024 * 1024 * 1024

#: Most texels that slices, radii and angles may take for the sake of their error; a table that is larger without them
#: stays as it is.
REFINED_LIMIT_BYTES = 256 * 1024 * 1024

#: Largest cache of tables without an explicit limit (bytes on disk).
CACHE_LIMIT_BYTES = 4 * 1024 * 1024 * 1024

#: Reflectances of a stack below this are not divided by.
LEAST_REFLECTANCE = 1e-3

#: A Scale or Depth of a painted surface below this, or that is no number, counts as this.
LEAST_SCALE = 0.01
