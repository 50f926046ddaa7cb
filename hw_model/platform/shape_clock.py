"""The clock of an engine by its shape: a law fitted to the engines that open tools placed and routed (route.json).

log MHz = a + b log2(lanes) + c [binary64] + d log2(lanes in a cluster) + e [compressed microcode] log2(lanes), by least squares over
shapes, each the mean of its seeds. The decoder of compressed microcode grows with the lanes. A term in which no two routed shapes
differ is left out, and shapes that differ from them in it are beyond the law.
"""

from __future__ import annotations

import json
from collections import defaultdict
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np

from hw_model.vocabulary import Datapath

RECORD = Path(__file__).parent / "route.json"
PART = "ecp5_85_8"
"""The part on which shapes were routed."""


class RoutedShape(NamedTuple):
    """What the clock is a function of. `clusters`: equal parts of lanes and banks; `compressed`: its microcode."""

    datapath: Datapath
    lanes: int
    clusters: int
    compressed: bool = False

    @property
    def words(self) -> str:
        """For a reader."""
        split = f" in {self.clusters} clusters" if self.clusters > 1 else ", one crossbar"
        lanes = "one lane" if self.lanes == 1 else f"{self.lanes} lanes{split}"
        return f"{self.datapath}, {lanes}, {'compressed' if self.compressed else 'flat'}"


@dataclass(frozen=True, slots=True)
class ClockLaw:
    """`shapes`: MHz that were routed; `terms`: which of the module's formula are in it, natural logarithms in `coefficients`."""

    shapes: dict[RoutedShape, float]
    terms: tuple[int, ...]
    coefficients: tuple[float, ...]

    def mhz(self, shape: RoutedShape) -> float:
        """On the part of the record."""
        return float(np.exp(np.dot(_chosen(shape, self.terms), self.coefficients)))

    @property
    def slowest(self) -> RoutedShape:
        """Of those that were routed: clocks of devices are of it (docs/hardware-model.md, Clock)."""
        return min(self.shapes, key=lambda shape: self.shapes[shape])

    def gain(self, shape: RoutedShape) -> float:
        """Its clock over that of the slowest."""
        return self.mhz(shape) / self.mhz(self.slowest)

    def error(self, shape: RoutedShape) -> float:
        """Relative, of a shape that was routed."""
        return self.mhz(shape) / self.shapes[shape] - 1.0

    @property
    def residual(self) -> float:
        """The largest error of a routed shape."""
        return max(abs(self.error(shape)) for shape in self.shapes)

    def reaches(self, shape: RoutedShape) -> bool:
        """Whether each term of the shape lies where shapes were routed."""
        known = np.array([_terms(other) for other in self.shapes])
        asked = np.array(_terms(shape))
        return bool(np.all((known.min(axis=0) <= asked) & (asked <= known.max(axis=0))))

    def without(self, shape: RoutedShape) -> ClockLaw:
        """The law of the other shapes."""
        return fitted({other: mhz for other, mhz in self.shapes.items() if other != shape})


@cache
def clock_law(path: Path = RECORD) -> ClockLaw:
    """Of the record."""
    found: defaultdict[RoutedShape, list[float]] = defaultdict(list)
    for row in json.loads(path.read_text(encoding="utf-8"))["rows"]:
        if row["module"] == "engine" and row["part"] == PART:
            found[_shape_of(row["parameters"])].append(row["mhz"])
    return fitted({shape: float(np.exp(np.mean(np.log(mhz)))) for shape, mhz in found.items()})


def fitted(shapes: dict[RoutedShape, float]) -> ClockLaw:
    """To these MHz. Raises ValueError where they do not determine the terms in which they differ."""
    known = np.array([_terms(shape) for shape in shapes])
    terms = (0, *(k for k in range(1, known.shape[1]) if np.ptp(known[:, k]) > 0.0))
    if np.linalg.matrix_rank(known[:, terms]) < len(terms):
        raise ValueError(f"{len(shapes)} shapes do not determine {len(terms)} terms")
    found = np.linalg.lstsq(known[:, terms], np.log(list(shapes.values())), rcond=None)[0]
    return ClockLaw(shapes, terms, tuple(float(value) for value in found))


def _chosen(shape: RoutedShape, terms: tuple[int, ...]) -> list[float]:
    known = _terms(shape)
    return [known[k] for k in terms]


def _terms(shape: RoutedShape) -> list[float]:
    return [
        1.0,
        float(np.log2(shape.lanes)),
        float(shape.datapath == "f64"),
        float(np.log2(shape.lanes / shape.clusters)),
        float(shape.compressed * np.log2(shape.lanes)),
    ]


def _shape_of(parameters: str) -> RoutedShape:
    given = dict(pair.split("=") for pair in parameters.split())
    datapath: Datapath = "f64" if given["FP"] == "64" else "f32"
    return RoutedShape(
        datapath, int(given["LANES"]), int(given.get("CLUSTERS", "1")), compressed=given["SEQUENCER"] != "0"
    )
