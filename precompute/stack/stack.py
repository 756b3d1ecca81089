# SPDX-License-Identifier: GPL-3.0-or-later
"""Films on a substrate, with groups that repeat: how they are written, kept and what they reflect."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ..constants import WAVELENGTH_MIN_M
from ..errors import ParameterError
from .material import Material
from .materials import material_of
from .transfer import reflectance

#: Most films after groups are written out, and the thickest pile that is one coherent stack (metres).
FILMS_MAX, THICKEST_M = 400, 25e-6

#: Angles a fringe: linear interpolation between them errs by a part of 2e-4 of it.
_ANGLES_A_FRINGE, _ANGLES_LEAST, _ANGLES_MOST = 160, 513, 16385

#: Angles, in all and a fringe, that R is reckoned at first; what a spline through them may err by before there are
#: twice as many, nearer to the normal than the cosine `_GRAZING`, below which no slice of a table lies.
_FIRST_STEPS, _FIRST_A_FRINGE, _SPLINE_ERROR, _GRAZING = 64, 8, 8e-4, 0.03

_GROUP = re.compile(r"^\((.*)\)\s*[xX*]\s*(\S+)$", re.DOTALL)
_HOW = "write MATERIAL:NM, for instance SiO2:250, or (MATERIAL:NM,MATERIAL:NM)xTIMES"


@dataclass(frozen=True)
class Film:
    """A layer: its material and its thickness in metres."""

    material: Material
    thickness_m: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.thickness_m) and self.thickness_m >= 0.0):
            raise ParameterError(
                f"The film of {self.material.name} is {self.thickness_m * 1e9:g} nm thick; give 0 or more nanometres."
            )

    def __str__(self) -> str:
        return f"{self.material.name}:{self.thickness_m * 1e9:.6g}"


@dataclass(frozen=True)
class Group:
    """Films that repeat, outermost first."""

    films: tuple[Film, ...]
    times: int

    def __post_init__(self) -> None:
        if not self.films or self.times < 1:
            raise ParameterError(f"A group of {len(self.films)} films {self.times} times is no group; {_HOW}.")

    def __str__(self) -> str:
        return f"({','.join(map(str, self.films))})x{self.times}"


@dataclass(frozen=True)
class Stack:
    """A substrate and what lies on it.

    Parameters
    ----------
    substrate
        The half space below.
    films
        From the outside in: `Film` or `Group`.

    Raises
    ------
    ParameterError
        For more films, or a thicker pile, than make one coherent stack.
    """

    substrate: Material
    films: tuple[Film | Group, ...] = ()

    def __post_init__(self) -> None:
        count = sum(len(part.films) * part.times if isinstance(part, Group) else 1 for part in self.films)
        if count > FILMS_MAX:
            raise ParameterError(f"The stack has {count} films; at most {FILMS_MAX} can be told apart.")
        pile = sum(film.thickness_m for film in self.layers)
        if pile > THICKEST_M:
            raise ParameterError(
                f"The films are {pile * 1e6:.4g} um thick together, beyond {THICKEST_M * 1e6:g} um, where their fringes"
                " are finer than a nanometre; leave the thick one out, or lay it over the relief as a lacquer."
            )

    @property
    def layers(self) -> tuple[Film, ...]:
        """All films from the outside in, groups written out."""
        out: list[Film] = []
        for part in self.films:
            out.extend(part.films * part.times if isinstance(part, Group) else (part,))
        return tuple(out)

    @property
    def materials(self) -> tuple[Material, ...]:
        """Each material once, from the outside in."""
        found: dict[Material, None] = dict.fromkeys(film.material for film in self.layers)
        return (*found, self.substrate) if self.substrate not in found else tuple(found)

    @property
    def notes(self) -> tuple[str, ...]:
        """What is to be said of the materials' ranges."""
        return tuple(material.note for material in self.materials if material.note)

    def __str__(self) -> str:
        return (
            " on ".join((" on ".join(map(str, self.films)), self.substrate.name)) if self.films else self.substrate.name
        )

    def reflectance(
        self, wavelengths_m: np.ndarray, cos_theta: np.ndarray, outer: Material | None = None
    ) -> np.ndarray:
        """R of unpolarised light.

        Parameters
        ----------
        wavelengths_m
            ``(L,)`` metres.
        cos_theta
            Cosines of the angle in the outer medium, of any shape.
        outer
            The medium that the light comes from; None is air. What it absorbs is not counted.

        Returns
        -------
        ndarray
            ``(L, ...)`` in [0, 1].
        """
        lam, cos = np.asarray(wavelengths_m, float), np.asarray(cos_theta, float)
        index = {material: material.index(lam) for material in self.materials}
        outside = np.ones(lam.shape) if outer is None else outer.index(lam).real
        films = self.layers
        indices = [outside, *(index[film.material] for film in films), index[self.substrate]]
        found = reflectance(indices, [film.thickness_m for film in films], lam, cos.ravel())
        return found.reshape(len(lam), *cos.shape)

    def sampled(self, wavelengths_m: np.ndarray, outer: Material | None = None) -> tuple[np.ndarray, np.ndarray]:
        """R over even steps of the cosine, fine enough for linear interpolation.

        Returns
        -------
        cosines : ndarray
            ``(C,)`` from 0 to 1.
        reflectance : ndarray
            ``(L, C)``.
        """
        optical = sum(
            film.thickness_m * abs(film.material.index(np.array([WAVELENGTH_MIN_M]))[0].real) for film in self.layers
        )
        fringes = 2.0 * optical / WAVELENGTH_MIN_M
        fine = min(max(_ANGLES_LEAST, int(_ANGLES_A_FRINGE * fringes) + 1), _ANGLES_MOST)
        wanted = np.linspace(0.0, 1.0, fine)
        steps = max(_FIRST_STEPS, int(_FIRST_A_FRINGE * fringes))
        cosines = np.linspace(0.0, 1.0, steps + 1)
        found = self.reflectance(wavelengths_m, cosines, outer)
        # Half the step until a spline foretells what lies between.
        while len(cosines) < fine:
            from scipy.interpolate import CubicSpline

            spline = CubicSpline(cosines, found, axis=1)
            between = 0.5 * (cosines[1:] + cosines[:-1])
            exact = self.reflectance(wavelengths_m, between, outer)
            off = np.abs(spline(between) - exact)[:, between > _GRAZING].max()
            cosines, both = np.linspace(0.0, 1.0, 2 * len(cosines) - 1), np.empty((len(found), 2 * len(cosines) - 1))
            both[:, ::2], both[:, 1::2] = found, exact
            found = both
            if off < _SPLINE_ERROR:
                return wanted, np.clip(CubicSpline(cosines, found, axis=1)(wanted), 0.0, 1.0)
        return cosines, found


def parse_stack(substrate: Any, films: Iterable[Any] = ()) -> Stack | None:
    """A stack as it is typed.

    Parameters
    ----------
    substrate
        What `material_of` takes; None or an empty text where there is no stack.
    films
        From the outside in: ``MATERIAL:NM`` or ``(MATERIAL:NM,MATERIAL:NM)xTIMES``.

    Raises
    ------
    ParameterError
        For films without a substrate, unknown materials and thicknesses that are none.
    """
    parts = tuple(_part(text) for text in films)
    if substrate is None or substrate == "":
        if parts:
            raise ParameterError("A film lies on something; name the substrate too, for instance Si or 1.5.")
        return None
    return Stack(material_of(substrate), parts)


def split_films(text: str) -> tuple[str, ...]:
    """Films in one line of text, outermost first: blanks or semicolons part them, except within brackets."""
    films, depth, current = [], 0, ""
    for sign in text:
        depth += (sign == "(") - (sign == ")")
        if depth <= 0 and (sign == ";" or sign.isspace()):
            films.append(current)
            current = ""
        else:
            current += sign
    return tuple(film for film in (*films, current) if film.strip())


def _part(text: Any) -> Film | Group:
    if isinstance(text, Film | Group):
        return text
    text = str(text).strip()
    group = _GROUP.match(text)
    if group is None:
        return _film(text)
    try:
        times = int(group[2])
    except ValueError:
        raise ParameterError(f"The group '{text[:60]}' repeats '{group[2]}' times; give a whole number.") from None
    # A comma stands between films and within n,k: what has no thickness belongs to what follows.
    pieces, held = [], ""
    for piece in group[1].split(","):
        held = f"{held},{piece}" if held else piece
        if ":" in piece:
            pieces.append(held)
            held = ""
    if held:
        raise ParameterError(f"The film '{held.strip()[:40]}' has no thickness; {_HOW}.")
    return Group(tuple(_film(piece.strip()) for piece in pieces), times)


def _film(text: str) -> Film:
    material, colon, thickness = text.rpartition(":")
    try:
        thickness_m = float(thickness) * 1e-9
    except ValueError:
        colon = ""
        thickness_m = 0.0
    if not colon or not material.strip():
        raise ParameterError(f"The film '{text[:60]}' is not understood; {_HOW}.")
    return Film(material_of(material), thickness_m)


def to_json(stack: Stack | None) -> dict[str, Any] | None:
    """What a sidecar holds of a stack; `stack_of` reads it back, figures of files included."""
    if stack is None:
        return None

    def film(each: Film) -> list[Any]:
        return [each.material.to_json(), each.thickness_m]

    films: list[Any] = []
    for part in stack.films:
        films.append(
            {"times": part.times, "films": [film(f) for f in part.films]} if isinstance(part, Group) else film(part)
        )
    return {"substrate": stack.substrate.to_json(), "films": films}


def stack_of(value: Any) -> Stack | None:
    """The stack that an entry of a sidecar means; None for None.

    Raises
    ------
    ParameterError
        If it is none.
    """
    if value is None or isinstance(value, Stack):
        return value
    try:
        if not isinstance(value, Mapping):
            raise TypeError("no stack")
        films = [_film_of(part) if not isinstance(part, Mapping) else _group_of(part) for part in value["films"]]
        return Stack(material_of(value["substrate"]), tuple(films))
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        raise ParameterError("The stack of the table is damaged; bake it again.") from error


def _film_of(part: Sequence[Any]) -> Film:
    material, thickness_m = part
    return Film(material_of(material), float(thickness_m))


def _group_of(part: Mapping[str, Any]) -> Group:
    return Group(tuple(_film_of(each) for each in part["films"]), int(part["times"]))


@lru_cache(maxsize=8)
def sampled(stack: Stack, wavelengths_m: tuple[float, ...], outer: Material | None) -> tuple[np.ndarray, np.ndarray]:
    """`Stack.sampled`, kept for the stacks that were asked for last."""
    return stack.sampled(np.array(wavelengths_m), outer)
