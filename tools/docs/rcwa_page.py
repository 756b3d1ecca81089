# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/rcwa.md: the scalar model beside Maxwell's equations, on gratings. Fills its tables and draws its pictures.

Rigorous values come from `tests.truth.rigorous`: coupled waves for lamellar profiles, the coordinate
transformation for sinusoids. Everything is at 550 nm, light unpolarised (the mean of TE and TM).
"""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from precompute.evaluate.orders import order_efficiencies  # noqa: E402
from tests.truth.rigorous import ALUMINIUM, KERATIN, TE, TM, fresnel, lamellar, sinusoidal  # noqa: E402
from tools.docs import rcwa_more  # noqa: E402
from tools.docs.fill_page import fill, table  # noqa: E402

PAGE = ROOT / "docs" / "rcwa.md"
PICTURES = ROOT / "docs" / "pictures"
WAVELENGTH = 550e-9
MATERIALS = {"keratin": KERATIN, "aluminium": ALUMINIUM}
SHAPES = ("sinusoidal", "lamellar")
ANGLES = (0, 30, 60, 80)
PERIODS_UM = (0.6, 0.8, 1.0, 1.3, 1.6, 2.5, 3.5, 5.0)
DEPTHS_NM = (20, 50, 100, 150, 200, 300, 400)

#: Where the model is called right.
LIMIT = 0.05


@dataclass(frozen=True)
class Grating:
    """Material, shape, period, depth from trough to crest; lamellar ridges fill half the period."""

    material: str
    shape: str
    period_um: float
    depth_nm: float

    @property
    def index(self):
        return MATERIALS[self.material]

    @property
    def profile(self):
        """``(1000,)`` heights of one period in metres."""
        x = (np.arange(1000) + 0.5) / 1000
        unit = 0.5 * np.sin(2.0 * np.pi * x) if self.shape == "sinusoidal" else np.where(x < 0.5, 1.0, 0.0)
        return self.depth_nm * 1e-9 * unit

    def rigorous(self, theta_deg, polarisation):
        """Efficiencies of all orders."""
        solve, factor = (sinusoidal, 1) if self.shape == "sinusoidal" else (lamellar, 2)
        period = self.period_um * 1e-6
        harmonics = factor * (int(2 * period / WAVELENGTH) + 10)
        return solve(
            self.index, self.depth_nm * 1e-9, period, WAVELENGTH, np.radians(theta_deg), polarisation, harmonics
        )

    def scalar(self, theta_deg, fresnel=True):
        """Orders and their efficiencies in the scalar model; without Fresnel R = 1."""
        r0 = abs((self.index - 1.0) / (self.index + 1.0)) ** 2 if fresnel else None
        return order_efficiencies(self.profile, self.period_um * 1e-6, WAVELENGTH, np.radians(theta_deg), r0)


def misplaced(model, truth):
    """``sum |model - truth| / sum truth``: the part of the light that is in the wrong order, missing or too much."""
    return float(np.abs(model - truth).sum() / truth.sum())


@dataclass(frozen=True)
class Errors:
    """Misplaced parts: of all light and of the diffracted orders, relative to the flat surface's reflectance; of
    all light with the model's own Fresnel term."""

    all_light: float
    diffracted: float
    absolute: float


def errors(grating, theta_deg):
    """`Errors` of one grating and angle of incidence."""
    truth = 0.5 * (grating.rigorous(theta_deg, TE) + grating.rigorous(theta_deg, TM))
    flat = np.mean(fresnel(grating.index, np.radians(theta_deg)))
    m, plain = grating.scalar(theta_deg, fresnel=False)
    _, model = grating.scalar(theta_deg)
    side = m != 0
    return Errors(misplaced(plain, truth / flat), misplaced(plain[side], truth[side] / flat), misplaced(model, truth))


def sweep():
    """``{(material, shape, angle, period, depth): Errors}`` of the whole grid."""
    found = {}
    for material in MATERIALS:
        for shape in SHAPES:
            for angle in ANGLES:
                for period in PERIODS_UM:
                    for depth in DEPTHS_NM:
                        grating = Grating(material, shape, period, depth)
                        found[material, shape, angle, period, depth] = errors(grating, angle)
            print(material, shape, flush=True)
    return found


def deepest(of_depth):
    """Largest depth up to which no value passes the limit, or None. Keys are depths in nm."""
    reached = None
    for depth in sorted(of_depth):
        if of_depth[depth] > LIMIT:
            break
        reached = depth
    return reached


def limits_table(found, kind):
    """Deepest grating within the limit, for each period (columns)."""
    rows = []
    for material in MATERIALS:
        for shape in SHAPES:
            for angle in ANGLES:
                cells = []
                for period in PERIODS_UM:
                    values = {d: getattr(found[material, shape, angle, period, d], kind) for d in DEPTHS_NM}
                    cells.append(deepest(values) or "-")
                rows.append([f"{material}, {shape}, {angle} deg", *cells])
    return table(["", *[f"{p:g} um" for p in PERIODS_UM]], rows)


def worst_table(found):
    """Errors by kind of grating and angle, both materials together: how many are within the limit, and the worst."""
    periods = (("period 2.5 um and more", 2.5, 99.0), ("period 1 to 1.6 um", 1.0, 2.0), ("period below 1 um", 0.0, 0.9))
    depths = (("up to 50 nm", 0, 50), ("100 to 150 nm", 100, 150), ("200 nm and more", 200, 999))
    rows = []
    for shape in SHAPES:
        for long, p0, p1 in periods:
            for deep, d0, d1 in depths:
                cells = []
                for angle in ANGLES:
                    values = [
                        e.all_light
                        for (_, s, a, p, d), e in found.items()
                        if (s, a) == (shape, angle) and p0 <= p <= p1 and d0 <= d <= d1
                    ]
                    within = sum(value <= LIMIT for value in values)
                    cells.append(f"{within} of {len(values)}, {100 * max(values):.0f} %")
                rows.append([f"{shape}, {long}, depth {deep}", *cells])
    return table(["within 5 %, worst", *[f"{a} deg" for a in ANGLES]], rows)


#: Gratings of the side-by-side table, and the angles of incidence in degrees.
SIDE_BY_SIDE = (
    (Grating("aluminium", "sinusoidal", 2.5, 100), 20),
    (Grating("aluminium", "lamellar", 1.6, 120), 20),
    (Grating("aluminium", "lamellar", 5.0, 100), 20),
    (Grating("keratin", "sinusoidal", 1.5, 100), 20),
    (Grating("keratin", "lamellar", 1.5, 50), 20),
    (Grating("keratin", "sinusoidal", 0.6, 50), 20),
    (Grating("keratin", "sinusoidal", 1.5, 300), 60),
)


def side_by_side_rows(grating, angle):
    """Rows of the orders -2 ... 2, as far as they exist."""
    te, tm = grating.rigorous(angle, TE), grating.rigorous(angle, TM)
    m, model = grating.scalar(angle)
    _, plain = grating.scalar(angle, fresnel=False)
    flat = np.mean(fresnel(grating.index, np.radians(angle)))
    name = f"{grating.material}, {grating.shape}, {grating.period_um:g} um, {grating.depth_nm:g} nm, {angle} deg"
    rows = []
    for order, s, p, a, b in zip(m, model, plain, te, tm, strict=True):
        if abs(order) > 2:
            continue
        truth = 0.5 * (a + b)
        values = (a, b, truth, s, truth / flat, p)
        rows.append([name, f"{order:d}", *[f"{100 * value:.3f}" for value in values]])
        name = ""
    return rows


def side_by_side_table():
    """Order efficiencies in percent."""
    rows = [row for grating, angle in SIDE_BY_SIDE for row in side_by_side_rows(grating, angle)]
    head = ["grating", "order", "TE", "TM", "mean", "scalar", "mean / flat", "scalar, R = 1"]
    return table(head, rows)


def fresnel_table():
    """Schlick's reflectance beside the exact one, in percent."""
    angles = (0, 30, 45, 60, 70, 80, 85)
    rows = []
    for name, index in MATERIALS.items():
        r0 = abs((index - 1.0) / (index + 1.0)) ** 2
        exact = [np.mean(fresnel(index, np.radians(a))) for a in angles]
        schlick = [r0 + (1.0 - r0) * (1.0 - np.cos(np.radians(a))) ** 5 for a in angles]
        rows.append([f"{name}, exact", *[f"{100 * value:.2f}" for value in exact]])
        rows.append([f"{name}, Schlick", *[f"{100 * value:.2f}" for value in schlick]])
    return table(["reflectance, percent", *[f"{a} deg" for a in angles]], rows)


def draw_limits(found, path):
    """The misplaced light over period and depth, one panel for each material, shape and angle."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 9.0), dpi=80, layout="constrained")
    axes = figure.subplots(4, len(ANGLES), sharex=True, sharey=True)
    pairs = [(material, shape) for material in MATERIALS for shape in SHAPES]
    for line, (material, shape) in zip(axes, pairs, strict=True):
        for axis, angle in zip(line, ANGLES, strict=True):
            values = np.array([[found[material, shape, angle, p, d].all_light for p in PERIODS_UM] for d in DEPTHS_NM])
            shown = np.log10(np.clip(100.0 * values, 0.1, 100.0))
            image = axis.contourf(PERIODS_UM, DEPTHS_NM, shown, levels=np.linspace(-1.0, 2.0, 13), cmap="RdYlGn_r")
            axis.contour(PERIODS_UM, DEPTHS_NM, shown, levels=[np.log10(100.0 * LIMIT)], colors="k", linewidths=2)
            axis.set_xscale("log")
            axis.set_xticks([0.6, 1, 2, 5], ["0.6", "1", "2", "5"])
            axis.minorticks_off()
            axis.set_title(f"{material}, {shape}, {angle} deg", fontsize=9)
        line[0].set_ylabel("depth, nm")
    for axis in axes[-1]:
        axis.set_xlabel("period, um")
    bar = figure.colorbar(image, ax=axes, ticks=[-1, 0, np.log10(5), 1, 2], shrink=0.6)
    bar.ax.set_yticklabels(["0.1 %", "1 %", "5 %", "10 %", "100 %"])
    figure.savefig(path)


#: Panels of the picture over the angle of incidence.
CURVES = (
    Grating("aluminium", "sinusoidal", 2.5, 100),
    Grating("aluminium", "lamellar", 1.6, 120),
    Grating("keratin", "sinusoidal", 1.5, 100),
    Grating("keratin", "lamellar", 0.8, 100),
)


def draw_curves(path):
    """Efficiency of the orders 0, -1 and -2 over the angle of incidence."""
    from matplotlib.figure import Figure

    angles = np.arange(1.0, 86.0, 2.0)
    figure = Figure(figsize=(10.0, 7.0), dpi=80, layout="constrained")
    for axis, grating in zip(figure.subplots(2, 2).flat, CURVES, strict=True):
        chosen = (0, -1, -2)
        rigorous, model = np.full((2, 3, len(angles)), np.nan), np.full((3, len(angles)), np.nan)
        for column, angle in enumerate(angles):
            m, scalar = grating.scalar(angle)
            both = [grating.rigorous(angle, polarisation) for polarisation in (TE, TM)]
            for row, order in enumerate(chosen):
                here = m == order
                if here.any():
                    model[row, column] = scalar[here][0]
                    rigorous[:, row, column] = [values[here][0] for values in both]
        for row, order in enumerate(chosen):
            colour = f"C{row}"
            axis.fill_between(angles, *(100 * rigorous[:, row]), color=colour, alpha=0.2, linewidth=0)
            axis.plot(angles, 100 * rigorous[:, row].mean(axis=0), color=colour, label=f"order {order}, rigorous")
            axis.plot(angles, 100 * model[row], "--", color=colour, label=f"order {order}, scalar")
        top = 110.0 if grating.material == "aluminium" else 30.0
        axis.set_ylim(0.0, top)
        axis.set_title(
            f"{grating.material}, {grating.shape}, {grating.period_um:g} um, {grating.depth_nm:g} nm", fontsize=10
        )
        axis.set_xlabel("angle of incidence, degrees")
        axis.set_ylabel("efficiency, percent")
        axis.legend(fontsize=7)
    figure.savefig(path)


def main():
    PICTURES.mkdir(parents=True, exist_ok=True)
    found = sweep()
    draw_limits(found, PICTURES / "rcwa_limits.png")
    draw_curves(PICTURES / "rcwa_orders.png")
    blocks = {
        "limits": limits_table(found, "all_light"),
        "limits of the diffracted orders": limits_table(found, "diffracted"),
        "limits with Fresnel": limits_table(found, "absolute"),
        "worst": worst_table(found),
        "side by side": side_by_side_table(),
        "fresnel": fresnel_table(),
        **rcwa_more.blocks(),
    }
    fill(PAGE, blocks)


if __name__ == "__main__":
    main()
