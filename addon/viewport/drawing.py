# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws diffraction over what is already in the framebuffer."""

from __future__ import annotations

import traceback
from collections import OrderedDict
from collections.abc import Callable, Hashable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

import bpy
import numpy as np

from ...precompute.errors import DiffractionError
from ..materials import material
from ..materials.node import paint_nodes
from . import gathering, items, lamps, looks, surroundings
from .data import blocks, masks, orientation, sources
from .data.batches import Meshes
from .data.directions import Directions
from .data.display import Display
from .data.series import SeriesTextures
from .data.sky import Skies
from .data.textures import Tables
from .looks import View
from .manners import PLAIN, Manners
from .surroundings import Surroundings

#: Directions in which an image of the surroundings is looked up, by the points that stand for a wide lamp.
SKY_POINTS = {1: 8, 4: 16, 16: 32}

#: Views of different scenes or layers whose lists are kept; a view of a studio light has two.
_LISTS = 8


@dataclass(eq=False)
class _Listing:
    """What one scene and view layer hold, as of a version."""

    version: int
    items: list[items.Item]
    lamps: np.ndarray


@dataclass(frozen=True)
class _Lights:
    """What shines on all surfaces of a drawing beside lamps.

    Parameters
    ----------
    ambient
        Whether a plain world does.
    sky
        Texture of an image all around, or None.
    mean
        What was gathered before, of a view that gathers: texture, place of its corner in the framebuffer, and the
        weight of what is added.
    gathers
        Whether this drawing adds to it; else it shows it.
    """

    ambient: bool
    sky: Any
    mean: Any = None
    gathers: bool = False


@contextmanager
def _state(blend: str, writes_depth: bool) -> Iterator[None]:
    """The GPU's state while surfaces are drawn, and afterwards what it was."""
    import gpu

    state = gpu.state.blend_get(), gpu.state.depth_test_get(), gpu.state.depth_mask_get()
    gpu.state.blend_set(blend)
    gpu.state.depth_test_set("LESS_EQUAL")
    gpu.state.depth_mask_set(writes_depth)
    try:
        yield
    finally:
        gpu.state.face_culling_set("NONE")
        gpu.state.blend_set(state[0])
        gpu.state.depth_test_set(state[1])
        gpu.state.depth_mask_set(state[2])


@dataclass(eq=False)
class Renderer:
    """All that the viewport keeps between two drawings."""

    tables: Tables = field(default_factory=Tables)
    series: SeriesTextures = field(default_factory=SeriesTextures)
    meshes: Meshes = field(default_factory=Meshes)
    display: Display = field(default_factory=Display)
    skies: Skies = field(default_factory=Skies)
    directions: Directions = field(default_factory=Directions)
    gathering: gathering.Gathering = field(default_factory=gathering.Gathering)
    #: What the user is to know; empty while all is well.
    message: str = ""
    #: Counts changes of the scene.
    version: int = 0
    _changed: set[int] = field(default_factory=set)
    _forget_all: bool = False
    _listings: OrderedDict[tuple, _Listing] = field(default_factory=OrderedDict)
    _uniforms: dict[tuple, tuple[bytes, Any]] = field(default_factory=dict)
    _failed: tuple | None = None

    # What may be called from any thread: it only takes notes.

    def note(self, changed: set[int] | None = None) -> None:
        """The scene changed: the geometry of these data-blocks (session uids), of all for None."""
        if changed is None:
            self._forget_all = True
        else:
            self._changed |= changed
        self.version += 1

    def clear(self) -> None:
        """Let go of everything on the GPU."""
        self._listings.clear()
        self._uniforms.clear()
        self.meshes.forget()
        self.tables.clear()
        self.series.clear()
        self.display.clear()
        self.skies.clear()
        self.directions.clear()
        self.gathering.clear()
        self._changed.clear()
        self.message, self._failed = "", None
        self.version += 1

    # Drawing.

    def draw(
        self,
        depsgraph: bpy.types.Depsgraph,
        view_matrix: np.ndarray,
        projection: np.ndarray,
        view: View,
        through_display: bool,
        visible: Callable[[bpy.types.Object], bool],
        list_key: Hashable = 0,
        skips_nodes: bool = False,
        loose_depth: bool = False,
        asks: Manners = PLAIN,
        around: Surroundings | None = None,
        moved: tuple[float, float] = (0.0, 0.0),
        together: int = 1,
        gathers: Hashable | None = None,
    ) -> int:
        """Draw into the framebuffer in force; never raises. Returns the number of pieces drawn.

        Parameters
        ----------
        view_matrix, projection
            ``(4, 4)``, rows first.
        view
            The user's choice.
        through_display
            Whether colours must pass through the view transform here.
        visible
            Whether an original object is to be drawn.
        list_key
            Tells apart views that show different objects.
        skips_nodes
            Whether materials made of nodes have shown their diffraction already, as they do in EEVEE.
        loose_depth
            Whether the framebuffer's depth was sampled elsewhere in the pixels, as EEVEE's is.
        asks
            What the view asks of whoever draws in it.
        around
            What surrounds the scene; None: its world.
        moved
            Of a picture that is the mean of several drawings: where this one looks into the surroundings, one of
            `gathering.moves`.
        together
            How many drawings that picture is the mean of.
        gathers
            Key of a view that is drawn again and again and gathers light of the surroundings while it stands still;
            None: this is a picture of its own.
        """
        attempt = (self.version, view)
        if self._failed == attempt:
            return 0
        try:
            skips = skips_nodes and view.surface == "ADD"
            listing = self._listing(depsgraph, visible, list_key, "OTHERS" if skips else "ALL")
            count = self._draw(
                listing, depsgraph, view_matrix, projection, view, through_display, loose_depth, asks, around,
                moved, together, gathers,
            )  # fmt: skip
            if skips and around is not None and around.sky is not None and around.sun_above > 0.0:
                nodes = self._listing(depsgraph, visible, list_key, "NODES")
                count += self._draw_suns(
                    nodes, depsgraph, view_matrix, projection, view, through_display, loose_depth, asks, around
                )
        except DiffractionError as error:
            self._fail(attempt, str(error))
            return 0
        except Exception as error:
            traceback.print_exc()
            self._fail(attempt, f"The viewport cannot draw diffraction here ({error}); render with Cycles instead.")
            return 0
        self._failed = None
        return count

    def _fail(self, attempt: tuple, message: str) -> None:
        if message != self.message and bpy.app.background:  # a window shows it in the panel
            print(f"Diffraction: {message}")
        self.message, self._failed = message, attempt

    def _draw(
        self, listing: _Listing, depsgraph: bpy.types.Depsgraph, view_matrix: np.ndarray, projection: np.ndarray,
        view: View, through_display: bool, loose_depth: bool, asks: Manners, around: Surroundings | None,
        moved: tuple[float, float], together: int, gathers: Hashable | None,
    ) -> int:  # fmt: skip
        import gpu

        self.message = ""
        if not listing.items:
            return 0
        around = around if around is not None else surroundings.of_world(depsgraph.scene.original.world)
        # An operator can wait for what a drawing must not stop for.
        lit = self.skies.get(around.sky, wait=not through_display) if around.sky is not None else None
        sky = lit.texture if lit is not None else None
        rows = listing.lamps if around.lamps else listing.lamps[:0]
        if lit is not None and around.sky is not None:
            rows = np.concatenate([rows, lamps.sun_rows(lit.suns, around.sky)])[: lamps.LAMPS_MAX]
        if view.lights == "STUDIO" or (not len(rows) and around.sky is None and around.lamps):
            rows = lamps.studio_rows(view_matrix)
        exposure = depsgraph.scene.original.view_settings.exposure
        frame = blocks.Frame(
            view_matrix, projection, rows, view.points, through_display, exposure, around.ambient,
            clip=asks.clip, border=asks.border, sky=around.sky.rows() if around.sky is not None else None, moved=moved,
            together=together, width=gpu.state.viewport_get()[2],
        )  # fmt: skip
        # What shines through adds up, of which a mean of what lies in front knows nothing.
        mean = None
        if gathers is not None and sky is not None and view.method == "TABLE" and asks.see_through == 1.0:
            state = (self.version, view, view_matrix.tobytes(), projection.tobytes(), asks, around, id(sky))
            mean = self._gathered(gathers, state, listing, frame, view, sky, not through_display)
        elif gathers is not None:
            self.gathering.forget(gathers)
        lights = _Lights(any(around.ambient), sky, mean)
        return self._draw_frame("frame", frame, listing, depsgraph, view, lights, loose_depth, asks)

    def _draw_suns(
        self, listing: _Listing, depsgraph: bpy.types.Depsgraph, view_matrix: np.ndarray, projection: np.ndarray,
        view: View, through_display: bool, loose_depth: bool, asks: Manners, around: Surroundings,
    ) -> int:  # fmt: skip
        """Add to materials that EEVEE shows what it takes out of a studio light as a sun."""
        import gpu

        lit = self.skies.get(around.sky, wait=not through_display) if listing.items and around.sky is not None else None
        if lit is None or around.sky is None:
            return 0
        rows = lamps.sun_rows(lit.suns_above(around.sun_above), around.sky)
        if not len(rows):
            return 0
        frame = blocks.Frame(
            view_matrix, projection, rows, view.points, through_display,
            depsgraph.scene.original.view_settings.exposure, clip=asks.clip, border=asks.border,
            width=gpu.state.viewport_get()[2],
        )  # fmt: skip
        apart = frozenset({"SUN_APART"})
        return self._draw_frame("sun", frame, listing, depsgraph, view, _Lights(False, None), loose_depth, asks, apart)

    def _draw_frame(
        self, name: str, frame: blocks.Frame, listing: _Listing, depsgraph: bpy.types.Depsgraph, view: View,
        lights: _Lights, loose_depth: bool, asks: Manners, more: frozenset[str] = frozenset(),
    ) -> int:  # fmt: skip
        """Draw all pieces over what is there, the frame's numbers in a buffer of that name: how many were drawn.

        ``more`` are flags of their shaders besides.
        """
        view = replace(view, brightness=view.brightness * asks.see_through)
        shared = more | frame.flags() | ({"LOOSE_DEPTH"} if loose_depth else set())
        display = self.display.texture(depsgraph.scene.original) if frame.display else None
        with _state("NONE" if view.surface == "REPLACE" else "ADDITIVE", writes_depth=False):
            uniform = self._uniform((name,), frame.rows())
            drawn, _ = self._draw_items(listing, view, shared, uniform, lights, display, wait=not frame.display)
        return drawn

    def _gathered(
        self, key: Hashable, state: Hashable, listing: _Listing, frame: blocks.Frame, view: View, sky: Any, wait: bool
    ) -> Any:
        """The mean of what this view has gathered, after more was added to it; None in the first drawing of a state."""
        import gpu

        x, y, width, height = gpu.state.viewport_get()
        directions = SKY_POINTS[view.points]
        total = max(1, gathering.DIRECTIONS // directions)
        held = self.gathering.of(key, (width, height), (state, x, y), total)
        if held is None:
            return None
        without = replace(frame, lamps=frame.lamps[:0], display=False, together=total)
        moves = gathering.moves(total, directions)
        for place, number in enumerate(held.due()):
            uniform = self._uniform(("gathered", place), replace(without, moved=moves[number]).rows())
            target, before = held.begin()
            with target.bind(), _state("NONE", writes_depth=True):
                gpu.state.active_framebuffer_get().clear(color=(0.0, 0.0, 0.0, 0.0), depth=1.0)
                lights = _Lights(False, sky, (before, x, y, 1.0 / (number + 1.0)), gathers=True)
                flags = frozenset(without.flags())
                _, read = self._draw_items(listing, view, flags, uniform, lights, None, wait)
                held.end(read)
        return (held.mean, x, y, 0.0) if held.count else None

    def _draw_items(
        self, listing: _Listing, view: View, shared: frozenset[str], frame: Any, lights: _Lights, display: Any,
        wait: bool,
    ) -> tuple[int, tuple]:  # fmt: skip
        """Draw all pieces: their number, and the textures that decide which directions they look in."""
        import gpu

        shader: Any = None
        bound, facing, drawn = 0, "", 0
        read: list[tuple] = []
        replaces = view.surface == "REPLACE"
        for item in listing.items:
            if item.uid != bound:
                bound, facing = item.uid, ""  # what has to be copied first is drawn from both sides
                shader, textures = self._bind(item.material, view, shared, lights, wait)
                read.append(textures)
                if shader is not None:
                    shader.uniform_block("df_frame", frame)
                    if display is not None:
                        shader.uniform_sampler("df_display", display)
            if shader is None:
                continue
            # Nothing is added to a surface's back.
            culled = "NONE" if replaces else "FRONT" if item.mirrored else "BACK"
            if culled != facing:
                facing = culled
                gpu.state.face_culling_set(culled)
            shader.uniform_float("df_model", item.matrix)
            item.batch.draw(shader)
            drawn += 1
        return drawn, tuple(read)

    def _bind(
        self, shaded: bpy.types.Material, view: View, shared: frozenset[str], lights: _Lights, wait: bool
    ) -> tuple[Any, tuple]:
        """The shader of a material, with all that it reads, and the textures that decide where it looks.

        None while a thread reads its table.
        """
        import gpu

        path = looks.table_path(shaded)
        table = self.tables.get(path, wait)
        if table is None:
            return None, ()
        look = looks.surface(shaded, table.layout, table.info, view)
        flags = shared | look.flags(lights.ambient)
        tiles = None
        if "SCALED" in flags and flags & {"CONSERVE", "AMBIENT"}:
            tiles = self.tables.tiles(path, wait)
            if tiles is None:
                return None, ()
        directions, sky, mean = None, lights.sky, lights.mean
        if sky is not None and view.method == "TABLE":
            if look.environment:
                directions = self.directions.texture(path, wait)
            if directions is not None:
                looks_itself = lights.gathers or mean is None
                flags |= {"SKYLIT", f"SKY_{SKY_POINTS[view.points]}" if looks_itself else "GATHERED"}
            if view.surface == "REPLACE":
                flags |= {"SKYLIT"}
        if lights.gathers:
            flags |= {"GATHERS"}
        shader = sources.surface(view.method, flags)
        shader.bind()
        shader.uniform_block("df_surface", self._uniform(("surface", shaded.session_uid), look.rows()))
        shader.uniform_sampler("df_table", table.slices)
        if flags & {"CONSERVE", "AMBIENT"}:
            if tiles is not None:
                shader.uniform_sampler("df_tiles", tiles)
            else:
                shader.uniform_sampler("df_albedo", table.albedo)
        if "SKYLIT" in flags:
            shader.uniform_sampler("df_sky", sky)
        if directions is not None and "GATHERED" not in flags:
            shader.uniform_sampler("df_importance", directions)
        if flags & {"GATHERS", "GATHERED"}:
            shader.uniform_sampler("df_gathered", mean[0])
            shader.uniform_float("df_gathering", (*mean[1:], 0.0))
        painted = paint_nodes.image(shaded)
        if painted is not None:
            shader.uniform_sampler("df_paint", gpu.texture.from_image(painted))
        turned = orientation.angle_image(shaded)
        if turned is not None and painted is None:
            shader.uniform_sampler("df_angle", gpu.texture.from_image(turned[0]))
        if "MASKED" in flags:
            where: Any = masks.of(shaded).image
            shader.uniform_sampler("df_mask", gpu.texture.from_image(where))
        if view.method == "FLSS":
            series = self.series.get(path, table.info)
            shader.uniform_block("df_series", series.uniform)
            shader.uniform_sampler("df_terms", series.terms)
        return shader, (id(table), id(directions))

    def _uniform(self, key: tuple, rows: np.ndarray) -> Any:
        """A uniform buffer with these rows, the last one where nothing changed."""
        content = rows.tobytes()
        held = self._uniforms.get(key)
        if held is None:
            held = (content, blocks.uniform(rows))
        elif held[0] != content:
            held[1].update(blocks.buffer(rows))
            held = (content, held[1])
        self._uniforms[key] = held
        return held[1]

    def _listing(self, depsgraph: bpy.types.Depsgraph, visible: Any, list_key: Hashable, which: str) -> _Listing:
        """What there is to draw of ``ALL`` materials, those of ``NODES``, or the ``OTHERS``."""
        scene = depsgraph.scene.original
        key = (scene.session_uid, depsgraph.view_layer.name, list_key, which)
        version = self.version
        listing = self._listings.get(key)
        if listing is None or listing.version != version:
            self._forget()
            found, made = items.gather(
                depsgraph, self.meshes, visible, lambda m: which == "ALL" or (which == "NODES") == _is_of_nodes(m)
            )
            middle = found[len(found) // 2].matrix.translation if found else None
            rows = lamps.scene_rows(depsgraph, visible, made, middle) if found else np.zeros((0, 6, 4), np.float32)
            listing = self._listings[key] = _Listing(version, found, rows)
            while len(self._listings) > _LISTS:
                self._listings.popitem(last=False)
            self._drop_unused()
        self._listings.move_to_end(key)
        return listing

    def _forget(self) -> None:
        """Give up meshes that are noted as changed."""
        if self._forget_all:
            self._listings.clear()
            self.meshes.forget()
        elif self._changed:
            self.meshes.forget(self._changed)
        self._changed, self._forget_all = set(), False

    def _drop_unused(self) -> None:
        """Tables and uniforms of materials that no view shows."""
        shown = {item.material for listing in self._listings.values() for item in listing.items}
        paths = {looks.table_path(m) for m in shown}
        self.tables.keep(paths)
        self.series.keep(paths)
        self.directions.keep(paths)
        uids = {m.session_uid for m in shown}
        for key in [k for k in self._uniforms if k[0] == "surface" and k[1] not in uids]:
            del self._uniforms[key]


def _is_of_nodes(shaded: bpy.types.Material) -> bool:
    return material.shader_node(shaded) is not None and not material.needs_osl(shaded)
