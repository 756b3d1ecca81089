# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials by name, by numbers and from files, and stacks as they are typed and kept."""

import json

import numpy as np
import pytest

from precompute.errors import ParameterError
from precompute.stack import MATERIALS, Stack, material_of, parse_stack, stack_of, to_json
from precompute.stack.dispersion import Curve
from precompute.stack.material_files import read_material


def at(name, nm):
    return complex(material_of(name).index(np.array([nm * 1e-9]))[0])


@pytest.mark.parametrize(
    ("name", "nm", "n", "k"),
    [  # lines of the papers' own tables
        ("Al", 563.57, 1.0728, 6.7839),
        ("ag", 582.1, 0.05, 3.858),
        ("GOLD", 582.1, 0.29, 2.863),
        ("si", 550, 4.077, 0.028109),
        ("water", 550, 1.333, 1.96e-9),
    ],
)
def test_tables_hold_the_papers_figures(name, nm, n, k):
    found = at(name, nm)
    assert found.real == pytest.approx(n, abs=2e-3)
    assert found.imag == pytest.approx(k, abs=2e-3)


@pytest.mark.parametrize(
    ("name", "n"),
    [  # at the sodium line, as handbooks have it
        ("SiO2", 1.4585), ("MgF2", 1.3777), ("Al2O3", 1.7681), ("TiO2", 2.613), ("PC", 1.5848), ("PMMA", 1.4906),
        ("PS", 1.5916), ("water", 1.333), ("keratin", 1.532 + 5890 / 589.3**2), ("chitin", 1.517 + 8800 / 589.3**2),
        ("melanin", 1.648 + 23700 / 589.3**2),
    ],
)  # fmt: skip
def test_formulas_give_the_index_of_the_sodium_line(name, n):
    assert at(name, 589.3).real == pytest.approx(n, abs=2e-3)


def test_melanin_absorbs_by_its_formula():
    assert at("melanin", 540.0).imag == pytest.approx(0.56 * np.exp(-2.0))


def test_all_materials_of_the_list_are_there_with_a_source():
    wanted = """Al Ag Au Cu Cr Ni Ti Fe Si SiO2 TiO2 MgF2 Al2O3 ZnS
                water polycarbonate PMMA polystyrene keratin chitin melanin"""
    assert set(wanted.split()) == set(MATERIALS)
    lam = np.linspace(380e-9, 780e-9, 401)
    for name, material in MATERIALS.items():
        assert len(material.source) > 10
        assert material_of(name.upper()) is material_of(name.lower()) is material
        assert np.isfinite(material.index(lam)).all()


def test_formulas_are_continued_and_say_so_and_tables_are_not():
    assert "continued" in MATERIALS["polycarbonate"].note
    assert "436.8" in MATERIALS["polycarbonate"].note
    assert MATERIALS["SiO2"].note == MATERIALS["Au"].note == ""
    assert parse_stack("Au", ["TiO2:50", "SiO2:20"]).notes == (MATERIALS["TiO2"].note,)


@pytest.mark.parametrize(
    ("text", "index"), [("1.46", 1.46), ("0.2,3.4", 0.2 + 3.4j), (2, 2.0), (1.5 + 0.1j, 1.5 + 0.1j)]
)
def test_numbers_are_materials(text, index):
    material = material_of(text)
    assert material.index(np.array([5e-7]))[0] == index
    assert material_of(material.to_json()) == material


@pytest.mark.parametrize(
    "text", ["unobtainium", "", "-1.5", "0", "1.5,-0.2", "nan", "1,2,3", "99", "1.5,inf", "no/such/file.csv"]
)
def test_what_is_no_material_is_refused_in_one_sentence(text):
    with pytest.raises(ParameterError) as caught:
        material_of(text)
    assert str(caught.value).startswith("The")
    assert str(caught.value).rstrip().endswith(".")


def test_csv_in_nanometres_and_micrometres(tmp_path):
    nm = np.arange(350, 801, 50)
    (tmp_path / "a.csv").write_text("wavelength (nm), n, k\n" + "".join(f"{x}, {1.4 + x / 1e4}, 0.1\n" for x in nm))
    (tmp_path / "b.txt").write_text("# mine\n" + "".join(f"{x / 1e3}\t{1.4 + x / 1e4}\n" for x in nm))
    a, b = read_material(tmp_path / "a.csv"), material_of(str(tmp_path / "b.txt"))
    assert a.index(np.array([575e-9]))[0] == pytest.approx(1.4575 + 0.1j)
    assert b.index(np.array([575e-9]))[0] == pytest.approx(1.4575)
    assert a.name == "a.csv"
    # A sidecar keeps the figures, and the file may go.
    stack = parse_stack("Au", [f"{tmp_path / 'a.csv'}:100"])
    kept = json.loads(json.dumps(to_json(stack)))
    (tmp_path / "a.csv").unlink()
    assert stack_of(kept) == stack


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("400 1.5\n780 1.5\n", "covers 400-780 nm"),
        ("380 1.5\n500 1.6\n450 1.5\n800 1.5\n", "do not rise"),
        ("380 1.5\nhello\n800 1.5\n", "line 2"),
        ("380 1.5 0.1\n800 1.5\n", "two and of three"),
        ("nothing\n", "no numbers"),
        ("380 -1.5\n800 1.5\n", "refractive index of -1.5"),
        ("380 1.5 -0.1\n800 1.5 0\n", "extinction"),
    ],
)
def test_bad_tables_are_refused(tmp_path, text, says):
    (tmp_path / "m.csv").write_text(text)
    with pytest.raises(ParameterError, match=says):
        read_material(tmp_path / "m.csv")


YML = """# a comment
REFERENCES: "Somebody (1999)"
DATA:
  - type: {kind}
    {fields}
SPECS:
    n_is_absolute: true
"""


def yml(tmp_path, kind, fields):
    path = tmp_path / "m.yml"
    path.write_text(YML.format(kind=kind, fields=fields))
    return read_material(path)


@pytest.mark.parametrize(
    ("formula", "coefficients", "index"),
    [  # each written out by hand at 0.5 um
        (1, "0 1.0 0.1 0.5 0.2", lambda x: np.sqrt(1 + x**2 / (x**2 - 0.01) + 0.5 * x**2 / (x**2 - 0.04))),
        (2, "0.1 1.0 0.01", lambda x: np.sqrt(1.1 + x**2 / (x**2 - 0.01))),
        (3, "2.25 0.01 -2 0.001 -4", lambda x: np.sqrt(2.25 + 0.01 * x**-2 + 0.001 * x**-4)),
        (4, "5.913 0.2441 0 0.0803 1 0 0 0 1", lambda x: np.sqrt(5.913 + 0.2441 / (x**2 - 0.0803))),
        (4, "2.0 0.1 2 0.1 2 0.2 0 0.1 2 0.01 2", lambda x: np.sqrt(
            2 + 0.1 * x**2 / (x**2 - 0.01) + 0.2 / (x**2 - 0.01) + 0.01 * x**2)),
        (5, "1.5 0.004 -2", lambda x: 1.5 + 0.004 / x**2),
        (6, "0 0.05 230 0.002 57", lambda x: 1 + 0.05 / (230 - x**-2) + 0.002 / (57 - x**-2)),
        (7, "1.5 0.01 0.001 0.001", lambda x: 1.5 + 0.01 / (x**2 - 0.028) + 0.001 / (x**2 - 0.028) ** 2 + 0.001 * x**2),
        (8, "0.3 0.01 0.02 0", lambda x: np.sqrt((1 + 2 * (q := 0.3 + 0.01 * x**2 / (x**2 - 0.02))) / (1 - q))),
        (9, "2.2 0.01 0.01 0.1 0.5 1.0", lambda x: np.sqrt(
            2.2 + 0.01 / (x**2 - 0.01) + 0.1 * (x - 0.5) / ((x - 0.5) ** 2 + 1.0))),
    ],
)  # fmt: skip
def test_formulas_of_the_database(tmp_path, formula, coefficients, index):
    fields = f"wavelength_range: 0.45 0.7\n    coefficients: {coefficients}"
    material = yml(tmp_path, f"formula {formula}", fields)
    x = np.array([0.4, 0.5, 0.75])
    assert material.index(x * 1e-6).real == pytest.approx(index(x), rel=1e-12)
    assert "continued" in material.note


def test_tables_of_the_database(tmp_path):
    rows = "data: |\n" + "".join(f"        {x:.2f} {1 + x} {0.1 * x}\n" for x in (0.3, 0.5, 0.9))
    material = yml(tmp_path, "tabulated nk", rows)
    assert material.index(np.array([4e-7]))[0] == pytest.approx(1.4 + 0.04j)
    with pytest.raises(ParameterError, match="380-780"):
        yml(tmp_path, "tabulated nk", "data: |\n        0.3 1 1\n        0.7 1 1\n")
    with pytest.raises(ParameterError, match="no refractive index"):
        yml(tmp_path, "tabulated k", "data: |\n        0.3 1\n        0.9 1\n")
    with pytest.raises(ParameterError, match="formulas 1 to 9"):
        yml(tmp_path, "formula 42", "coefficients: 1 2 3")


def test_n_by_formula_and_k_by_table_make_one_material(tmp_path):
    text = YML.format(kind="formula 5", fields="wavelength_range: 0.3 2\n    coefficients: 1.5 0.004 -2\n"
                      "  - type: tabulated k\n    data: |\n        0.3 0.5\n        0.9 0.1")  # fmt: skip
    (tmp_path / "m.yml").write_text(text)
    found = read_material(tmp_path / "m.yml").index(np.array([6e-7]))[0]
    assert found == pytest.approx(1.5 + 0.004 / 0.36 + 0.3j)


def test_stacks_as_they_are_typed():
    stack = parse_stack("melanin", ["1.46:250", "(chitin:100,0.2,3.4:80)x12", "au:5"])
    assert [str(part) for part in stack.films] == ["1.46:250", "(chitin:100,0.2,3.4:80)x12", "Au:5"]
    assert len(stack.layers) == 26
    assert stack_of(json.loads(json.dumps(to_json(stack)))) == stack
    assert stack_of(None) is None
    assert parse_stack(None) is None
    assert str(parse_stack("au", ["1.46:250"])) == "1.46:250 on Au"
    assert isinstance(hash(stack), int)


@pytest.mark.parametrize(
    ("substrate", "films", "says"),
    [
        (None, ["SiO2:100"], "substrate"),
        ("au", ["SiO2:-5"], "-5 nm thick"),
        ("au", ["SiO2"], "not understood"),
        ("au", ["SiO2:thick"], "not understood"),
        ("au", ["SiO2:nan"], "nan nm thick"),
        ("au", ["gunk:10"], "no material 'gunk'"),
        ("au", ["(SiO2:10,TiO2)x3"], "no thickness"),
        ("au", ["(SiO2:10)x0"], "no group"),
        ("au", ["(SiO2:10)x2.5"], "whole number"),
        ("au", ["(SiO2:1,TiO2:1)x999"], "at most"),
        ("au", ["SiO2:30000"], "30 um thick"),
    ],
)
def test_what_is_no_stack_is_refused(substrate, films, says):
    with pytest.raises(ParameterError, match=says):
        parse_stack(substrate, films)


@pytest.mark.parametrize("value", [3, {}, {"substrate": "Au"}, {"substrate": "Au", "films": [["SiO2"]]}, "Au"])
def test_damaged_sidecars_are_refused(value):
    with pytest.raises(ParameterError, match="damaged"):
        stack_of(value)


def test_films_in_one_line_of_text():
    from precompute.stack import split_films

    assert split_films("SiO2:250  1.46:3;(chitin:100, melanin:80)x12") == (
        "SiO2:250", "1.46:3", "(chitin:100, melanin:80)x12",
    )  # fmt: skip
    assert split_films("  ") == ()


def test_equal_figures_are_one_material():
    assert Stack(material_of("1.5")) == Stack(material_of(1.5))
    assert material_of(1.5) != material_of("1.5,0.1")
    assert Curve("constant", (1.5,)) == material_of("1.5").n
