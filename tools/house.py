# SPDX-License-Identifier: GPL-3.0-or-later
"""The floors of the house: which wing may import which, in one place, for the test and for the picture in the docs.

A module may import what stands on a lower floor, and what stands in its own wing; wings of one floor do not know each
other. `house.py` prints each arrow between wings.
"""

import ast
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]

#: The wings of each half from the ground up: what stands in one line stands on one floor. A wing is a folder or a file
#: without its ending; what is named nowhere is a fault.
FLOORS = {
    "precompute": (
        ("constants", "errors", "faces", "old_names", "scipy_kernels"),
        ("light", "files", "stack"),
        ("parameters",),
        ("scan",),
        ("readers", "presets", "table", "paint"),
        ("bake",),
        ("evaluate", "sweep"),
        ("commands",),
        ("cli",),
        ("__main__", "__init__"),
    ),
    "addon": (
        ("app_handlers", "colour_spaces", "given", "notices", "numbers", "paths", "shader_files", "versions"),
        ("gpu_context", "jobs", "pictures", "renderers"),
        ("tables", "lights"),
        ("materials",),
        ("viewport", "watch"),
        ("assets", "preset_properties"),
        ("paint_properties",),
        ("properties", "preferences"),
        ("operators",),
        ("panels",),
        ("__init__",),
    ),
}


def modules(half: str, root: Path = ROOT) -> dict[str, Path]:
    """Dotted names below a half of the house, and their files; a folder's name is that of its ``__init__.py``."""
    found = {}
    for path in sorted((root / half).rglob("*.py")):
        parts = path.relative_to(root).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" and len(parts) > 2 else parts)] = path
    return found


def imported(path: Path, half: str, names: dict[str, Path], root: Path = ROOT) -> set[str]:
    """The modules of the same half that a file imports, also inside functions."""
    parts = path.relative_to(root).with_suffix("").parts
    package = parts[:-1]
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"), filename=str(path))):
        if not isinstance(node, ast.ImportFrom) or node.level == 0:
            continue
        base = package[: len(package) - (node.level - 1)]
        module = ".".join((*base, *(node.module.split(".") if node.module else ())))
        for alias in node.names:
            for name in (f"{module}.{alias.name}", module):
                if name in names:
                    found.add(name)
                    break
    return {name for name in found if names[name] != path}


def wing(name: str) -> str:
    """The wing of a module: the second part of its dotted name."""
    return name.split(".")[1]


def arrows(half: str, root: Path = ROOT) -> dict[str, set[str]]:
    """For each module of a half those that it imports."""
    names = modules(half, root)
    return {name: imported(path, half, names, root) for name, path in names.items()}


def floor_faults(half: str, root: Path = ROOT) -> list[str]:
    """A sentence for each import that climbs, naming both files, and for each file without a floor."""
    floor = {name: number for number, names in enumerate(FLOORS[half]) for name in names}
    names = modules(half, root)

    def file(name: str) -> str:
        return str(names[name].relative_to(root))

    faults = [f"{file(name)} stands on no floor" for name in names if wing(name) not in floor]
    for name, targets in arrows(half, root).items():
        for target in sorted(targets):
            here, there = floor.get(wing(name)), floor.get(wing(target))
            if wing(name) != wing(target) and here is not None and there is not None and there >= here:
                faults.append(f"{file(name)} (floor {here + 1}) imports {file(target)} (floor {there + 1})")
    return faults


def circles(half: str, root: Path = ROOT) -> list[list[str]]:
    """Files that import each other in a circle, each circle once, beginning with the first by name.

    A folder's face imports its files, which may import each other but never their face.
    """
    graph = arrows(half, root)
    names = modules(half, root)
    found, done = [], set()

    def visit(name: str, trail: list[str]) -> None:
        if name in trail:
            circle = trail[trail.index(name) :]
            first = circle.index(min(circle))
            circle = circle[first:] + circle[:first]
            if circle not in found:
                found.append(circle)
            return
        if name in done:
            return
        for target in sorted(graph[name]):
            visit(target, [*trail, name])
        done.add(name)

    for name in sorted(graph):
        visit(name, [])
    return [[str(names[name].relative_to(root)) for name in circle] for circle in found]


def main() -> None:
    for half in FLOORS:
        print(f"{half}/")
        for number, floor in reversed(list(enumerate(FLOORS[half], 1))):
            print(f"{number:4}  {'  '.join(floor)}")
        for sentence in floor_faults(half):
            print(sentence)
        for circle in circles(half):
            print("in a circle: " + " -> ".join(circle))


if __name__ == "__main__":
    main()
