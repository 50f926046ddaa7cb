"""The front of time and energy, and which entry of the table of energies it hangs on.

An entry moves the energy of its own action in proportion, so no run is priced again. The front is of the points that
fit; each entry is taken to both ends of its band by itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hw_model.energy.actions import DYNAMIC

if TYPE_CHECKING:
    from hw_model.platform.platform import Platform

    from .study import Point


@dataclass(frozen=True, slots=True)
class Sensitivity:
    """One entry at one end of its band: how many designs leave the front of a device, and how many enter it."""

    device: str
    entry: str
    value: float
    front: int
    left: int
    entered: int
    fastest_share: float
    """Share that the entry's action has in the energy of the fastest design, nominally."""


def energy_front(points: Sequence[Point], energies_mj: Mapping[int, float] | None = None) -> list[Point]:
    """The points that fit and that no other on their device beats in time and energy, fastest first.

    `energies_mj`: by position, in place of the nominal ones.
    """
    order = sorted(
        (k for k, point in enumerate(points) if point.budget.fits),
        key=lambda k: (points[k].times_ms[0], _energy(points, k, energies_mj)),
    )
    least: dict[str, float] = {}
    front: list[Point] = []
    for k in order:
        device, energy = points[k].device, _energy(points, k, energies_mj)
        if energy < least.get(device, float("inf")):
            least[device] = energy
            front.append(points[k])
    return front


def sensitivities(points: Sequence[Point], platform: Platform) -> list[Sensitivity]:
    """Of the front of `platform`, to both ends of the band of each entry that its designs use."""
    own = [point for point in points if point.device == platform.name]
    nominal = energy_front(own)
    shares = [{row.action: row.share for row in point.energy.rows} for point in own]
    found: list[Sensitivity] = []
    for action in dict.fromkeys(action for row in shares for action in row):
        name = f"{action}_pj" if action in DYNAMIC else f"{action}_mw"
        entry = getattr(platform.energy, name)
        for end in (entry.low, entry.high):
            energies = {
                k: point.energy.nominal_mj * (1.0 + share.get(action, 0.0) * (end / entry.value - 1.0))
                for k, (point, share) in enumerate(zip(own, shares, strict=True))
            }
            moved = energy_front(own, energies)
            share = shares[own.index(nominal[0])].get(action, 0.0) if nominal else 0.0
            found.append(
                Sensitivity(
                    platform.name,
                    name,
                    end,
                    len(moved),
                    _missing(nominal, moved),
                    _missing(moved, nominal),
                    share,
                )
            )
    return found


def words(device: str, front: Sequence[Point], found: Sequence[Sensitivity]) -> str:
    """The front of a device and what moves it, in a sentence."""
    own = [point for point in front if point.device == device]
    if not own:
        return f"{device}: nothing that fits, so no front of time and energy"
    fastest, thrifty = own[0], own[-1]
    moving = sorted({row.entry for row in found if row.device == device and (row.left or row.entered)})
    moves = (
        f"moved by {', '.join(moving)} within their bands" if moving else "the same within every entry's band"
    )
    if fastest is thrifty:
        best = f"{fastest.partition} is best in both ({fastest.times_ms[0]:.3f} ms, {fastest.energy.nominal_mj:.2f} mJ)"
        return f"{device}: time and energy: {best}; {moves}"
    return (
        f"{device}: time and energy: {len(own)} designs on the front, from {fastest.partition} ({fastest.times_ms[0]:.3f} ms,"
        f" {fastest.energy.nominal_mj:.2f} mJ) to {thrifty.partition} ({thrifty.times_ms[0]:.3f} ms, {thrifty.energy.nominal_mj:.2f} mJ); {moves}"
    )


def _energy(points: Sequence[Point], k: int, energies_mj: Mapping[int, float] | None) -> float:
    return points[k].energy.nominal_mj if energies_mj is None else energies_mj[k]


def _missing(there: Sequence[Point], here: Sequence[Point]) -> int:
    """How many of `there` are not among `here`."""
    known = {id(point) for point in here}
    return sum(id(point) not in known for point in there)
