# SPDX-License-Identifier: GPL-3.0-or-later
"""What the types of Blender's Python (fake-bpy-module) leave open, closed for `check_types.py`.

They are made from Blender's own description of its properties, which knows neither which pointers are never empty, nor
that a node's attributes follow from the name that it was made with. What stands here holds wherever an extension runs.
"""

import re

#: Never empty where an extension runs: classes of `bpy.types`, and their attributes.
NEVER_NONE = {
    "AddonPreferences": ("layout",),
    "ColorManagedViewSettings": ("curve_mapping",),
    "Context": ("preferences", "scene", "selected_objects", "view_layer", "window_manager"),
    "Depsgraph": ("scene", "scene_eval", "view_layer", "view_layer_eval"),
    "DepsgraphObjectInstance": ("object",),
    "DepsgraphUpdate": ("id",),
    "DriverVariable": ("targets",),
    "FCurve": ("driver",),
    "Header": ("layout",),
    "ID": ("original",),
    "Image": ("colorspace_settings",),
    "LayerCollection": ("collection",),
    "Material": ("node_tree",),
    "Menu": ("layout",),
    "NodeLink": ("from_node", "from_socket", "to_node", "to_socket"),
    "NodeTree": ("interface",),
    "Operator": ("layout",),
    "Panel": ("layout",),
    "Preferences": ("addons", "filepaths", "inputs", "system", "view"),
    "RenderSettings": ("image_settings",),
    "Scene": ("collection", "display_settings", "render", "unit_settings", "view_settings"),
    "Window": ("scene", "screen", "view_layer", "workspace"),
    "World": ("node_tree",),
}

#: Of a type that no annotation can name: an object's data follow from its `type`.
ANY = {"AreaSpaces": ("active",), "Context": ("space_data",), "Object": ("data",), "RenderEngine": ("render",)}

#: Attributes of these follow from the type of the thing, which a collection of them does not know.
OPEN = ("Light", "Node", "NodeSocket", "NodeTree", "NodeTreeInterfaceItem", "Property", "Space")

_SEQUENCE = (
    "def __iter__(self) -> typing.Iterator[typing.Any]: ...",
    "def __len__(self) -> int: ...",
    "def __getitem__(self, key: typing.Any) -> typing.Any: ...",
    "def __setitem__(self, key: typing.Any, value: typing.Any) -> None: ...",
)
_CONTEXT = ("def __enter__(self) -> typing.Self: ...", "def __exit__(self, *error: object) -> None: ...")

#: Lines that a class lacks: custom properties, and the methods of sequences and of a `with`.
ADDED = {
    "ContextTempOverride": _CONTEXT,
    "ID": ("def __contains__(self, key: object) -> bool: ...",),
    "Operator": ("@classmethod", "def poll_message_set(cls, message: str, *arguments: object) -> None: ..."),
    "bpy_prop_array": _SEQUENCE,
    **dict.fromkeys(
        OPEN,
        (
            "def __getattr__(self, name: str) -> typing.Any: ...",
            "def __setattr__(self, name: str, value: typing.Any) -> None: ...",
        ),
    ),
}

#: The same for other modules, by their file in the stubs.
ADDED_ELSEWHERE = {
    "gpu-stubs/types/__init__.pyi": {"OffScreenStackContext": _CONTEXT},
    "mathutils-stubs/__init__.pyi": {"MatrixAccess": _SEQUENCE, "Vector": _SEQUENCE[:1]},
}


#: What is replaced everywhere: enumerations, which we often choose at run time, or which differ in 4.5, are strings; an
#: array property takes any sequence; whatever takes numbers takes arrays and vectors; what Blender calls us with is
#: there; a driver is one of one property; an icon is a number, too.
WIDER = (
    (re.compile(r"typing\.Literal\[[^\]]*\]"), "str"),
    (re.compile(r"^(    \w+): bpy_prop_array\[.*$", re.MULTILINE), r"\1: typing.Any"),
    (re.compile(r"collections\.abc\.Sequence\["), "collections.abc.Iterable["),
    (re.compile(r"\b(context: Context|depsgraph: Depsgraph|event: Event)( \| None)+"), r"\1"),
    (re.compile(r"tuple\[str, str, str, str, int\]"), "tuple[str, str, str, str | int, int]"),
    (re.compile(r"-> FCurve \| list\[FCurve\]:"), "-> FCurve:"),
)


def wider(text):
    """The stub after all of `WIDER`."""
    for pattern, by in WIDER:
        text = pattern.sub(by, text)
    return text


def with_lines(text, name, lines):
    """The stub with more lines in a class; None where it has no such class."""
    head = re.search(rf"^class {name}\b.*?:\n", text, re.MULTILINE | re.DOTALL)
    if head is None:
        return None
    return text[: head.end()] + "".join(f"    {line}\n" for line in lines) + text[head.end() :]


def amended(text, registered):
    """The stub of `bpy.types` with what stands above, and what is not to be found in it.

    Parameters
    ----------
    text : str
        The stub.
    registered : dict of str to dict of str to str
        Of each class the properties that the extension gives it, with their types.

    Returns
    -------
    tuple of str and list of str
        The new stub, and the names of classes and attributes that it has not, so that no line here outlives its use.
    """
    # Cycles registers its settings itself.
    text, count = re.subn(r"def cycles\(self\) -> None \| None:", "def cycles(self) -> typing.Any:", text)
    missing = [] if count else ["cycles"]
    for name in sorted({*NEVER_NONE, *ANY, *ADDED, *registered}):
        found = re.search(rf"^class {name}\b.*?(?=^(?:class |def |@))", text, re.MULTILINE | re.DOTALL)
        if found is None:
            missing.append(name)
            continue
        block = found[0]
        for attribute in NEVER_NONE.get(name, ()):
            block, count = re.subn(
                rf"^(    (?:{attribute}: |def {attribute}\(self\) -> ))([^\n=]*?)(:?)$",
                lambda line: line[1] + " | ".join(p for p in line[2].split(" | ") if p != "None") + line[3],
                block,
                flags=re.MULTILINE,
            )
            missing += [] if count else [f"{name}.{attribute}"]
        for attribute in ANY.get(name, ()):
            block, count = re.subn(
                rf"^    (?:@property\n    def {attribute}\(|{attribute}: ).*?(?=^    [^\s)]|^\S|\Z)",
                f"    {attribute}: typing.Any\n",
                block,
                flags=re.MULTILINE | re.DOTALL,
            )
            missing += [] if count else [f"{name}.{attribute}"]
        lines = [*ADDED.get(name, ()), *(f"{key}: {kind}" for key, kind in registered.get(name, {}).items())]
        text = text[: found.start()] + with_lines(block, name, lines) + text[found.end() :]
    return text, missing
