# SPDX-License-Identifier: GPL-3.0-or-later
"""Look for the system libraries that Blender as a module needs, and name the Debian packages that bring them.

`check_system.py` says in one sentence what is missing (exit code 1); `check_system.py --packages` prints only the
names of the packages, for `apt-get install`. Only Linux needs this: on other systems the wheel holds all.
"""

import ctypes
import sys

# What the shared objects of the bpy wheel need (ldd) and do not carry themselves, and EGL with a driver, which Blender
# loads when it draws without a window. Any soname of a line will do; the package named is Mesa's.
PACKAGES = {
    ("libX11.so.6",): "libx11-6",
    ("libXext.so.6",): "libxext6",
    ("libXrender.so.1",): "libxrender1",
    ("libXfixes.so.3",): "libxfixes3",
    ("libXi.so.6",): "libxi6",
    ("libxkbcommon.so.0",): "libxkbcommon0",
    ("libSM.so.6",): "libsm6",
    ("libICE.so.6",): "libice6",
    ("libGL.so.1",): "libgl1",
    ("libEGL.so.1",): "libegl1",
    ("libEGL_mesa.so.0", "libEGL_nvidia.so.0"): "libegl-mesa0",
}


def opens(soname):
    """Whether the loader finds a shared object of this name."""
    try:
        ctypes.CDLL(soname)
    except OSError:
        return False
    return True


def missing(present=opens):
    """What Blender needs and `present` does not find.

    Parameters
    ----------
    present : callable
        Takes a soname, tells whether it can be loaded.

    Returns
    -------
    dict of str to str
        Sonames and the Debian packages that bring them.
    """
    return {names[0]: package for names, package in PACKAGES.items() if not any(map(present, names))}


def sentence(absent):
    """One sentence that says what is missing and which packages bring it."""
    libraries, packages = ", ".join(absent), " ".join(absent.values())
    return f"Blender needs {libraries}, which this machine lacks: install with 'apt-get install {packages}'."


def main():
    """Exit code 0 where all is there."""
    if not sys.platform.startswith("linux"):
        return 0
    absent = missing()
    if "--packages" in sys.argv[1:]:
        print(" ".join(absent.values()))
        return 0
    if absent:
        print(sentence(absent), file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
