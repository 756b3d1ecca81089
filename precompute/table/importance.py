# SPDX-License-Identifier: GPL-3.0-or-later
"""Where to look for the environment: densities of directions that follow f cos of a spectral table.

For light from everywhere a renderer draws a direction wi from a density p (per solid angle) and
weights the sample by f cos / p. The closer p follows the luminance of f cos, the less noise; any
p that is positive where f is gives the right mean. A density is stored for each of a few views
(``docs/lighting.md``, "Environment"); the nearest one is used as if it were the viewer's own.

Coordinates that move with the viewer make a stored density fit its neighbours. With (u, v) =
-(wi + wr)_xy in polar coordinates (r, phi), the horizon |wi_xy| = 1 lies at

    R(phi) = -b + sqrt(b^2 + cos_r^2),    b = wr_x cos(phi) + wr_y sin(phi)

and a cubic in s runs from the specular direction (s = 0) to that horizon (s = 1):

    r(s) = 3 a s (1 - s)^2 + R s^2 (3 - 2 s)

Its slope 3 a at the specular peak is the same for all viewers of a stored view, so that the peak
keeps its width, and 0 at the horizon, which takes out the 1 / cos_i of du dv = cos_i d omega. A
direction below the surface is never drawn. The density over (s^2, phi) is stored as inverse
distributions in equal steps of probability:

    view     i = round(n_views * artanh(sin_r) / VIEW_END),  j = round(azimuths(i) * phi_r / 2 pi)
    radius   step k = floor(n_r * xi_1):    s^2 between two edges, even; and the row of its angles
    angle    step l = floor(n_phi * xi_2):  turn between two edges t_0, t_1 with half of the probability on
             either side of t_m, by  turn = t_0 + (t_1 - t_0) x / (x + c (1 - x)),  c = (t_1 - t_m) / (t_m - t_0)

A surface stretched by s takes the same densities in scaled coordinates: for s <= 1 a direction is drawn for the viewer
whose ``wr_xy`` is s times as long, and (u, v) = (u', v') / s. All that a viewer can receive is drawn; what falls beyond
the horizon is nothing. Most of that is left out beforehand: in scaled coordinates the horizon lies at no more than

    smoothstep(s) = s^2 (3 - 2 s) = k (1 + sin_r) / (1 + k sin_r)     (k the scale)

and ``CUTS`` texels a view say which part of the probability lies within j / (CUTS - 1) of s.

Which orders are strong is up to the depth: there is a set of views for each of `DEPTHS`, of which a deepened surface
takes the nearest. A stretched one sends the same order out more slantingly, with a smaller |w|, as a shallower one
would: `depth_set`.

The image holds the rows of the views from the bottom, and above them the albedos of scaled surfaces
(`scaled_albedo`), which renderers look up only where a surface is painted.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import TableError
from ..files.atomic import atomic_path
from ..files.exr import write_image
from . import scaled_albedo
from .layout import GUARD, GUARD_SIDE, TableLayout
from .table import SpectralTable, read_sidecar

#: Polar angles of the views, steps of the radius, rows of angles, steps of the angle.
N_VIEWS, N_R, N_ROWS, N_PHI = 14, 256, 36, 36

#: artanh(sin_r) of the last view would be this at index N_VIEWS: artanh widens towards grazing views, where the
#: horizon moves faster than the view does.
VIEW_END = 2.4

#: Azimuths at polar angle i: this many times i, at most the second; one where i = 0. At most the third in the sets for
#: other depths.
AZIMUTHS_STEP, AZIMUTHS_MAX, AZIMUTHS_SETS = 8, 32, 16


def azimuths(i: int, chosen: int = 0) -> int:
    """Views at polar angle ``i`` of a set."""
    return min(max(AZIMUTHS_STEP * i, 1), AZIMUTHS_SETS if chosen else AZIMUTHS_MAX)


def first_view(i: int, chosen: int = 0) -> int:
    """Index of the first view of polar angle ``i`` of a set."""
    start = FIRST_VIEWS + (chosen - 1) * SET_VIEWS if chosen else 0
    return start + sum(azimuths(k, chosen) for k in range(i))


#: Depths that have a set of views each, in even steps from that of the table down, and the number of views in the
#: first set and in another.
DEPTHS = (1.0, 0.75, 0.5, 0.25)
FIRST_VIEWS, SET_VIEWS = (sum(azimuths(i, chosen) for i in range(N_VIEWS)) for chosen in (0, 1))

#: cos_i of the direction by which the depth of a stretched surface is judged.
SET_COSINE = 0.75

#: Texels of a view that say how much of the probability lies within a part of s, see above.
CUTS = 33

#: Size of the image: a row a view, the albedos of scaled surfaces, and a guard above as the atlas has one
#: (`layout.GUARD`).
VIEWS = FIRST_VIEWS + SET_VIEWS * (len(DEPTHS) - 1)
WIDTH, HEIGHT = N_R + N_ROWS * N_PHI + CUTS, VIEWS + scaled_albedo.HEIGHT + GUARD_SIDE

#: Texel of the guard.
GUARD_X, GUARD_Y = GUARD_SIDE // 2, HEIGHT - GUARD_SIDE + GUARD_SIDE // 2

#: Version of the file, with all that its reader takes for granted; an image of another one is made anew.
VERSION = (
    f"5 {N_VIEWS} {VIEW_END} {AZIMUTHS_STEP} {AZIMUTHS_MAX} {AZIMUTHS_SETS} {N_R} {N_ROWS} {N_PHI} {len(DEPTHS)} {CUTS}"
)

#: Shares of X, Y and Z in a density: the luminance and a little more; that alone would leave the blue orders to chance.
_XYZ_SHARES = np.array((0.07, 0.86, 0.07), np.float32)

#: Share of an even density, for regions that hold no light at all.
_EVEN = 0.01

#: Least density over a ring's angles, relative to its mean: a step that spans the gap between two orders would hold
#: the bright flanks of both.
_ANGLE_FLOOR = 0.04

#: Cells of the quadrature of a view: in s, in phi; and of one of a set for another depth.
_FINE, _COARSE = (160, 288), (96, 144)

#: s where the rows of angles turn from even steps of log s to even steps of s.
_ROW_S = 0.05


@dataclass(frozen=True, eq=False)
class Importance:
    """Inverse distributions of a table.

    Parameters
    ----------
    radius
        ``(VIEWS, n_r, 2)`` lower and upper edge of each step of s^2.
    row
        ``(VIEWS, n_r)`` row of angles that a step of the radius uses.
    turn
        ``(VIEWS, n_rows, n_phi, 3)`` lower edge, upper edge and median of each step of phi / 2 pi.
    albedos
        ``(scaled_albedo.HEIGHT, scaled_albedo.WIDTH, 3)`` of scaled surfaces.
    """

    radius: np.ndarray
    row: np.ndarray
    turn: np.ndarray
    albedos: np.ndarray

    def draw_scaled(
        self, wr: np.ndarray, xi_1: np.ndarray, xi_2: np.ndarray, scale: float, depth: float = 1.0
    ) -> tuple[np.ndarray, np.ndarray]:
        """Draw directions of light on a surface stretched by `scale` and deepened by `depth`, as the shader does.

        Returns
        -------
        wi : ndarray
            ``(n, 3)``; on the horizon where the draw fell beyond it.
        gain : ndarray
            ``(n,)`` 1 / density per solid angle, 0 for those.
        """
        s = min(scale, 1.0)
        chosen = depth_set(float(wr[2]), s, depth)
        if s == 1.0:
            return self.draw(wr, xi_1, xi_2, chosen)
        viewer = np.array([s * wr[0], s * wr[1], np.sqrt(max(1.0 - s * s * (wr[0] ** 2 + wr[1] ** 2), 0.0))])
        view = _nearest_view(float(viewer[0]), float(viewer[1]), float(viewer[2]), chosen)[1]
        within = float(self.cuts()[view, cut(float(wr[2]), s)])
        wi, gain = self.draw(viewer, np.minimum(xi_1 * within, 0.9999999), xi_2, chosen)
        place = (wi[:, :2] + viewer[:2]) / s - wr[:2]
        rest = 1.0 - (place**2).sum(-1)
        cos_i = np.sqrt(np.maximum(rest, 1e-12))
        gain = np.where(rest > 0.0, gain * wi[:, 2] * (within / (s * s)) / cos_i, 0.0)
        return np.concatenate([place, cos_i[:, None]], -1), gain

    def cuts(self) -> np.ndarray:
        """``(VIEWS, CUTS)`` probability of what lies within j / (CUTS - 1) of s."""
        places = np.linspace(0.0, 1.0, CUTS) ** 2
        probability = np.linspace(0.0, 1.0, N_R + 1)
        edges = np.concatenate([self.radius[:, :, 0], np.ones((VIEWS, 1))], 1)
        return np.stack([np.interp(places, each, probability) for each in edges]).astype(np.float32)

    def draw(
        self, wr: np.ndarray, xi_1: np.ndarray, xi_2: np.ndarray, chosen: int = 0
    ) -> tuple[np.ndarray, np.ndarray]:
        """Draw directions of light, as the shader does.

        Parameters
        ----------
        wr
            ``(3,)`` direction of the viewer, above the surface.
        xi_1, xi_2
            ``(n,)`` random numbers in [0, 1).
        chosen
            Set of views, see `depth_set`.

        Returns
        -------
        wi : ndarray
            ``(n, 3)`` directions above the surface.
        gain : ndarray
            ``(n,)`` 1 / density per solid angle: f cos times it is the weight of a sample.
        """
        x_r, y_r, cos_r = (float(value) for value in wr)
        i, view = _nearest_view(x_r, y_r, cos_r, chosen)
        n_r, n_phi = N_R, N_PHI
        k, column = (xi_1 * n_r).astype(int), (xi_2 * n_phi).astype(int)
        e_0, e_1 = np.moveaxis(self.radius[view, k].astype(float), -1, 0)
        t_0, t_1, t_m = np.moveaxis(self.turn[view, self.row[view, k], column].astype(float), -1, 0)
        s = np.sqrt(e_0 + (xi_1 * n_r - k) * (e_1 - e_0))
        x, c = xi_2 * n_phi - column, (t_1 - t_m) / (t_m - t_0)
        bend = x + c * (1.0 - x)
        phi = 2.0 * np.pi * (t_0 + (t_1 - t_0) * x / bend)
        b = x_r * np.cos(phi) + y_r * np.sin(phi)
        r, cos_i, solid_angle = _from_s(s, b, cos_r, _peak_slope(i))
        area = n_r * (e_1 - e_0) * 2.0 * np.pi * n_phi * (t_1 - t_0) * c / bend**2  # of s^2 and phi, per probability
        wi = np.stack([-r * np.cos(phi) - x_r, -r * np.sin(phi) - y_r, cos_i], -1)
        return wi, solid_angle * area

    def image(self) -> np.ndarray:
        """``(HEIGHT, WIDTH, 3)`` float32, row 0 at the bottom: a row a view.

        First the steps of the radius (two edges and the row of angles), then the rows of angles one after another
        (two edges and the median), then the cuts. The albedos of scaled surfaces lie above all views, from the left,
        the guard above them.
        """
        image = np.zeros((HEIGHT, WIDTH, 3), np.float32)
        image[:VIEWS, :N_R, :2] = self.radius
        image[:VIEWS, :N_R, 2] = self.row
        image[:VIEWS, N_R:-CUTS] = self.turn.reshape(VIEWS, N_ROWS * N_PHI, 3)
        image[:VIEWS, -CUTS:] = self.cuts()[:, :, None]
        image[VIEWS : VIEWS + scaled_albedo.HEIGHT, : scaled_albedo.WIDTH] = self.albedos
        image[GUARD_Y, GUARD_X] = GUARD
        return image


def importance(table: SpectralTable) -> Importance:
    """Inverse distributions that follow the luminance of f cos, energy conservation on.

    Parameters
    ----------
    table
        The spectral table.
    """
    albedos = scaled_albedo.scaled_albedos(table)
    tiles = {sectors: _sector_tiles(table, sectors) for _, sectors in (_FINE, _COARSE)}
    losses = [_losses(table, albedos, depth) for depth in DEPTHS]
    radius = np.empty((VIEWS, N_R, 2), np.float32)
    row = np.empty((VIEWS, N_R), int)
    turn = np.empty((VIEWS, N_ROWS, N_PHI, 3), np.float32)

    def fill(which: tuple[int, int]) -> None:
        chosen, i = which
        cells, sectors = _COARSE if chosen else _FINE
        edges = _cell_edges(cells)
        masses = _masses(table, tiles[sectors], edges, i, chosen, losses[chosen])
        for view, mass in enumerate(masses, first_view(i, chosen)):
            radius[view], row[view], turn[view] = _invert(mass, edges)

    with ThreadPoolExecutor(min(os.cpu_count() or 1, N_VIEWS)) as pool:
        list(pool.map(fill, [(chosen, i) for chosen in range(len(DEPTHS)) for i in range(N_VIEWS)]))
    return Importance(radius, row, turn, albedos)


def depth_set(cos_r: float, scale: float, depth: float) -> int:
    """Which set of views a surface takes that is stretched by `scale`, at most 1, and deepened by `depth`.

    In scaled coordinates a stretched surface has the |w| of less slanting directions: its depth counts as much less as
    |w| is smaller, for the viewer and light at `SET_COSINE`.
    """
    sines = 1.0 - np.square((cos_r, SET_COSINE))
    judged = depth * (cos_r + SET_COSINE) / np.sqrt(1.0 - scale**2 * sines).sum()
    last = len(DEPTHS) - 1
    return int(np.clip(np.floor((1.0 - judged) / (DEPTHS[0] - DEPTHS[1]) + 0.5), 0, last))


def cut(cos_r: float, scale: float) -> int:
    """Which of the ``CUTS`` holds the horizon of a surface stretched by `scale` below 1."""
    sine = np.sqrt(max(1.0 - cos_r**2, 0.0))
    ratio = scale * (1.0 + sine) / (1.0 + scale * sine)
    s = 0.5 - np.sin(np.arcsin(1.0 - 2.0 * ratio) / 3.0)  # the inverse of smoothstep
    return int(min(np.ceil(s * (CUTS - 1)), CUTS - 1))


def _losses(table: SpectralTable, albedos: np.ndarray, depth: float) -> np.ndarray:
    """``(n_albedo_phi, n_theta)`` what f is divided by to conserve energy, at a depth."""
    layout = table.layout
    if depth == 1.0:
        first = layout.conserving_y + 1
        return np.maximum(table.atlas[first : first + layout.n_albedo_phi, : layout.n_theta, 0].astype(np.float32), 1.0)
    phi = (np.arange(layout.n_albedo_phi) * (2.0 * np.pi / layout.n_albedo_phi))[:, None]
    theta = np.arange(layout.n_theta) * (0.5 * np.pi / (layout.n_theta - 1))
    shape = (len(phi), len(theta))
    parts = (np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.broadcast_to(np.cos(theta), shape))
    most_s, most_q = table.headroom
    found = scaled_albedo.look_up(
        albedos, np.stack(parts, -1), np.full(shape, 1.0 / most_s), np.full(shape, depth / most_q)
    )
    return np.maximum(found, 1.0).astype(np.float32)


def albedo_free_cosine(table: SpectralTable) -> float:
    """Smallest cosine above which no albedo of the table passes 1, so that a renderer need not look it up.

    0 where none passes 1 at all, more than 1 where that happens straight above already.
    """
    layout = table.layout
    first = layout.conserving_y + 1
    above = (table.atlas[first : first + layout.n_albedo_phi, : layout.n_theta, 0] > 1.0).any(axis=0)
    if not above.any():
        return 0.0
    column = int(np.argmax(above)) - 1  # between this column and the next the albedo may pass 1
    return 2.0 if column < 0 else float(np.cos(column * (0.5 * np.pi / (layout.n_theta - 1))))


def _nearest_view(x_r: float, y_r: float, cos_r: float, chosen: int) -> tuple[int, int]:
    """Index of the polar angle, and of the view of a set."""
    sin_r = np.hypot(x_r, y_r)
    i = min(int(np.log((1.0 + sin_r) / cos_r) * (N_VIEWS / VIEW_END) + 0.5), N_VIEWS - 1)
    count = azimuths(i, chosen)
    return i, first_view(i, chosen) + int(np.floor(np.arctan2(y_r, x_r) / (2.0 * np.pi) * count + 0.5)) % count


def _peak_slope(i: int) -> float:
    """A third of dr / ds at s = 0: the nearest horizon of the flattest view that uses view ``i``."""
    return min(1.0 - np.tanh((i + 0.5) * (VIEW_END / N_VIEWS)), 2.0 / 3.0)


def _from_s(s: np.ndarray, b: np.ndarray, cos_r: float, slope: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Radius r, cos_i and d omega / (d(s^2) d phi); exact at the horizon, where differences would cancel."""
    root = np.sqrt(b**2 + cos_r**2)
    far = np.where(b > 0.0, b + root, cos_r**2 / (root + np.abs(b)))  # the horizon behind: -far
    reach = cos_r**2 / far
    a = np.minimum(slope, reach)
    per_s = 3.0 * a * (1.0 - s) ** 2 + reach * s * (3.0 - 2.0 * s)
    r = s * per_s
    # cos_i^2 = (R - r)(r + far), and R - r = (1 - s)^2 (R (1 + 2 s) - 3 a s)
    rest = np.sqrt(np.maximum((reach * (1.0 + 2.0 * s) - 3.0 * a * s) * (r + far), 1e-20))
    # du dv = r dr dphi = cos_i domega,  dr / ds = 3 (1 - s)(a (1 - 3 s) + 2 R s)
    return r, (1.0 - s) * rest, per_s * 1.5 * (a * (1.0 - 3.0 * s) + 2.0 * reach * s) / rest


def _sector_tiles(table: SpectralTable, sectors: int) -> np.ndarray:
    """``(n_w, sectors, n_r)`` texels weighted by `_XYZ_SHARES`, as means over even sectors that begin at phi = 0."""
    layout = table.layout
    edges = np.arange(sectors + 1) * (layout.n_phi / sectors) + 0.5  # a texel's angle is the middle of its row
    whole = edges.astype(int)
    part = (edges - whole)[:, None]
    tiles = np.empty((layout.n_w, sectors, layout.n_r), np.float32)
    for index in range(layout.n_w):
        x, y = layout.tile_origin(index)
        tile = table.atlas[y + 1 : y + 1 + layout.n_phi, x : x + layout.n_r].astype(np.float32) @ _XYZ_SHARES
        tile = np.maximum(tile, 0.0).astype(float)
        cumulative = np.concatenate([np.zeros((1, layout.n_r)), np.cumsum(np.concatenate([tile, tile[:1]]), axis=0)])
        at = cumulative[whole] + part * tile[whole % layout.n_phi]
        tiles[index] = np.diff(at, axis=0) * (sectors / layout.n_phi)
    return tiles


def _cell_edges(cells: int) -> np.ndarray:
    """Edges of the quadrature in s: finer towards the specular peak."""
    h = np.linspace(0.0, 1.0, cells + 1)
    return h * (0.3 + 0.7 * h)


def _masses(
    table: SpectralTable, tiles: np.ndarray, edges: np.ndarray, i: int, chosen: int, albedo: np.ndarray
) -> Iterator[np.ndarray]:
    """``(sectors, cells)`` integrals of f cos over cells of (s, phi) at a set's depth, for the azimuths of view ``i``.

    All geometry depends on phi - phi_r, so that one set of places serves all azimuths.
    """
    layout: TableLayout = table.layout
    sin_r = np.tanh(i * (VIEW_END / N_VIEWS))
    cos_r = np.sqrt(1.0 - sin_r**2)
    sectors, depth, count = tiles.shape[1], DEPTHS[chosen], azimuths(i, chosen)
    s = 0.5 * (edges[1:] + edges[:-1])[None]
    turn = ((np.arange(sectors) + 0.5) * (2.0 * np.pi / sectors))[:, None]
    r, cos_i, solid_angle = _from_s(s, sin_r * np.cos(turn), cos_r, _peak_slope(i))
    cell = solid_angle * np.diff(edges**2) * (2.0 * np.pi / sectors)
    w = cos_i + cos_r
    # 1 + wi.wr = |wi + wr|^2 / 2, with wi + wr = -(u, v, w).
    gain = ((r**2 + w**2) / 2.0) ** 2 / (cos_r * w**2) * (layout.scale * layout.gain(depth * w)) * cell

    position, column = layout.slice_coordinate(depth * w), layout.column(r)
    lower, left = np.minimum(position.astype(int), layout.n_w - 2), np.minimum(column.astype(int), layout.n_r - 2)
    up, right = (position - lower).astype(np.float32), (column - left).astype(np.float32)
    stride = sectors * layout.n_r
    place = lower * stride + left
    flat = tiles.reshape(-1)

    polar = np.rint(np.arccos(np.minimum(cos_i, 1.0)) * ((layout.n_theta - 1) / (0.5 * np.pi))).astype(int)
    # Azimuth of wi relative to the viewer's, in rows of the albedo.
    around = np.arctan2(-r * np.sin(turn), -r * np.cos(turn) - sin_r) * (layout.n_albedo_phi / (2.0 * np.pi))
    viewer = round(np.arccos(cos_r) * ((layout.n_theta - 1) / (0.5 * np.pi)))

    for j in range(count):
        shift = j * sectors // count
        sector = (np.arange(sectors) + shift) % sectors
        at = place + (sector * layout.n_r)[:, None]
        below = flat[at] * (1.0 - right) + flat[at + 1] * right
        above = flat[at + stride] * (1.0 - right) + flat[at + stride + 1] * right
        turn_rows = j * layout.n_albedo_phi / count
        losses = albedo[np.rint(around + turn_rows).astype(int) % layout.n_albedo_phi, polar]
        losses = np.maximum(losses, albedo[round(turn_rows) % layout.n_albedo_phi, viewer])
        mass = (below * (1.0 - up) + above * up) * gain / losses
        mass = (1.0 - _EVEN) * mass / max(mass.sum(), 1e-30) + _EVEN * cell * cos_i / np.pi
        yield np.roll(mass, shift, axis=0)


def _invert(mass: np.ndarray, cell_edges: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Steps of the radius, their rows of angles, and the steps of the angle in each row."""
    squared = cell_edges**2
    total = np.concatenate([[0.0], np.cumsum(mass.sum(axis=0))])
    probability = np.linspace(0.0, 1.0, N_R + 1)
    edges = np.interp(probability * total[-1], total, squared)
    edges[0], edges[-1] = 0.0, 1.0
    radius = edges.astype(np.float32)

    # Rows of angles go half by probability and half by the logarithm of s: the peak, which is round, shares few of
    # them, and dim outskirts, where the angles differ most, get some.
    spread = np.arcsinh(np.sqrt(edges) / _ROW_S) / np.arcsinh(1.0 / _ROW_S)
    measure = 0.5 * (probability + spread)
    row = np.minimum((0.5 * (measure[1:] + measure[:-1]) * N_ROWS).astype(int), N_ROWS - 1)

    place = np.clip(np.searchsorted(squared, edges, side="right") - 1, 0, len(squared) - 2)
    part = (edges - squared[place]) / (squared[place + 1] - squared[place])
    cumulative = np.concatenate([np.zeros((len(mass), 1)), np.cumsum(mass, axis=1)], axis=1)
    at = cumulative[:, place] * (1.0 - part) + cumulative[:, place + 1] * part
    turn = np.zeros((N_ROWS, N_PHI, 3), np.float32)
    used, first = np.unique(row, return_index=True)
    last = np.append(first[1:], N_R)
    steps = np.maximum(at[:, last] - at[:, first], 0.0).T
    steps = np.maximum(steps, _ANGLE_FLOOR * steps.mean(axis=1, keepdims=True))
    # All rows in one table: that of row k runs from k to k + 1, its ends are known.
    count = np.arange(len(used))[:, None]
    cdf = np.concatenate([np.zeros((len(used), 1)), np.cumsum(steps, axis=1)], axis=1)
    cdf /= cdf[:, -1:]
    sectors = np.linspace(0.0, 1.0, len(mass) + 1)
    targets = np.linspace(0.0, 1.0, 2 * N_PHI + 1)
    found = np.interp((targets + count).ravel(), (cdf + count).ravel(), np.tile(sectors, len(used)))
    angles = found.reshape(len(used), -1)
    angles[:, 0], angles[:, -1] = 0.0, 1.0
    # Few digits make the file small; no step is so narrow that they would close it.
    angles = np.rint(angles * 2.0**19) / 2.0**19
    turn[used] = np.stack([angles[:, :-1:2], angles[:, 2::2], angles[:, 1::2]], -1)
    return np.stack([radius[:-1], radius[1:]], -1), row, turn


def save_importance(
    image: np.ndarray, path: str | os.PathLike[str], atlas_sha256: str, albedo_free: float = 2.0
) -> None:
    """Write the image of `Importance.image` as a 32-bit EXR that names the atlas it was made from.

    Parameters
    ----------
    image
        ``(HEIGHT, WIDTH, 3)``, row 0 at the bottom.
    path
        Of the file.
    atlas_sha256
        Hash of the table's atlas.
    albedo_free
        What `albedo_free_cosine` says of the table; 2 has every albedo looked up.

    Raises
    ------
    OutputError
        If the folder cannot be written.
    """
    import OpenEXR

    header = {
        # A third smaller with ZIP, but the window waits for it, and a Blender that brings an OpenEXR of its own
        # (Linux distributions) prints a line for every compressed image.
        "compression": OpenEXR.NO_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        "atlasSha256": atlas_sha256,
        "importanceVersion": VERSION,
        "albedoFreeCosine": repr(albedo_free),
    }
    with atomic_path(path) as temporary:
        write_image(temporary, header, {"RGB": np.ascontiguousarray(image[::-1], np.float32)})


def read_origin(path: str | os.PathLike[str]) -> tuple[str, float] | None:
    """Hash of the atlas that an importance image was made from, and the cosine above which no albedo passes 1.

    None where there is no such image or one of another version.
    """
    import OpenEXR

    if not Path(path).is_file():
        return None
    try:
        with OpenEXR.File(os.fspath(path), header_only=True) as file:
            header = file.header()
            if header.get("importanceVersion") != VERSION or Path(path).stat().st_size < _least_bytes(header):
                return None
            return header["atlasSha256"], float(header["albedoFreeCosine"])
    except Exception:  # whatever is wrong with it, it is made anew
        return None


def _least_bytes(header: dict) -> int:
    """What an image cannot be shorter than: its numbers are not compressed, and each row has its place and its size."""
    (left, top), (right, bottom) = header["dataWindow"]
    return int(bottom - top + 1) * (int(right - left + 1) * 3 * np.dtype(np.float32).itemsize + 16)


def ensure_importance(path: str | os.PathLike[str], table: SpectralTable | None = None) -> tuple[Path, float]:
    """The image beside a table and the table's albedo-free cosine; made where it is missing, or of another table.

    Half a second's work: a window does it in the thread of its bake.

    Parameters
    ----------
    path
        The table's EXR.
    table
        The same table where it is at hand; else it is read where it is needed.

    Raises
    ------
    TableError
        If the table cannot be read.
    OutputError
        If the folder cannot be written.
    """
    path = Path(path)
    target = path.with_name(f"{path.stem}.importance.exr")
    atlas_sha256 = read_sidecar(path)["atlas"]["sha256"]
    origin = read_origin(target)
    if origin is None or origin[0] != atlas_sha256:
        table = SpectralTable.load(path) if table is None else table
        origin = (atlas_sha256, albedo_free_cosine(table))
        save_importance(importance(table).image(), target, *origin)
    return target, origin[1]


def load_image(path: str | os.PathLike[str]) -> np.ndarray:
    """``(HEIGHT, WIDTH, 3)`` float32, row 0 at the bottom: what `save_importance` wrote.

    Raises
    ------
    TableError
        If the file is damaged.
    """
    import OpenEXR

    try:
        with OpenEXR.File(os.fspath(path)) as file:
            channels = file.channels()
            image = channels["RGB"].pixels if "RGB" in channels else np.stack([channels[c].pixels for c in "RGB"], -1)
    except Exception as error:
        raise TableError(
            f"'{Path(path).name}' cannot be read ({error}); remove it, then apply the material again."
        ) from error
    if image.shape != (HEIGHT, WIDTH, 3):
        raise TableError(f"'{Path(path).name}' is of another size; remove it, then apply the material again.")
    return np.ascontiguousarray(image[::-1], np.float32)
