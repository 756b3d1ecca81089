# SPDX-License-Identifier: GPL-3.0-or-later
"""What `make test-4.5` runs in Blender 4.5 LTS: beginnings of test names, from the zip's installation to a picture."""

SMOKE = (
    "tests/test_house_extension.py",
    "tests/test_house_manifest.py",
    "tests/test_house_versions.py",
    "tests/precompute/test_brdf.py",
    "tests/precompute/test_table.py",
    "tests/addon/test_register.py",
    "tests/addon/test_suns.py::test_sphere_under_one_sun",
    "tests/addon/test_suns.py::test_light_from_the_right_lights_the_side_that_a_tilted_facet_faces",
    "tests/addon/test_suns.py::test_v_grows_upwards_whichever_way_u_runs",
    "tests/addon/test_nodes.py::test_file_is_packed_and_needs_nothing_else",
    "tests/addon/test_nodes.py::test_nodes_follow_new_lamps",
    "tests/addon/test_operators.py",
    "tests/addon/test_blend_life.py",
    "tests/viewport/test_table.py::test_each_lamp",
)


def is_smoke(name):
    """Whether a test, by its full name without parameters, belongs to them."""
    return any(name == start or name.startswith(start + "::") for start in SMOKE)
