# SPDX-License-Identifier: GPL-3.0-or-later
"""What `make test-4.5` runs in Blender 4.5 LTS: beginnings of test names, from the zip's installation to a picture."""

SMOKE = (
    "tests/house/test_extension.py",
    "tests/house/test_manifest.py",
    "tests/house/test_release.py",
    "tests/house/test_versions.py",
    "tests/precompute/test_scipy_kernels.py",
    "tests/precompute/evaluate/test_surface.py",
    "tests/precompute/table/test_table.py",
    "tests/addon/test_register.py",
    "tests/addon/materials/test_suns.py::test_sphere_under_one_sun",
    "tests/addon/materials/test_suns.py::test_light_from_the_right_lights_the_side_that_a_tilted_facet_faces",
    "tests/addon/materials/test_suns.py::test_v_grows_upwards_whichever_way_u_runs",
    "tests/addon/materials/test_nodes.py::test_file_is_packed_and_needs_nothing_else",
    "tests/addon/materials/test_nodes.py::test_nodes_follow_new_lamps",
    "tests/addon/materials/test_guard.py",
    "tests/addon/materials/test_object_types.py",
    "tests/addon/materials/test_users_wiring.py",
    "tests/addon/watch/test_report.py",
    "tests/addon/operators/test_pack.py",
    "tests/addon/operators/test_operators.py",
    "tests/addon/operators/test_blend_life.py",
    "tests/addon/viewport/test_table.py::test_each_lamp",
)


def is_smoke(name):
    """Whether a test, by its full name without parameters, belongs to them."""
    return any(name == start or name.startswith(start + "::") for start in SMOKE)
