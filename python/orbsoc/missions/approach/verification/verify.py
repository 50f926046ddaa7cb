"""All that is flown and judged of one programme."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf
from typing import Any

import numpy as np

from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.relative_flight import TRUTHS, drifts
from orbsoc.guidance.safety import CutBurn, audit_cut_burns
from orbsoc.orbit.array import Array

from ..model.approach import Approach
from .aborts import Abort, aborts
from .closed_loop import CorrectedFlights, fly_corrected
from .cuts import audit_cuts
from .errors import room_m
from .held_cuts import audit_held
from .linear import LIMIT_M, Arc, Check, arcs, checks

MISS_M, MISS_M_S = 0.1, 0.01
"""By which the corrected flight about the Earth may miss the last point and its velocity."""
AN_ORBIT = 180
"""Instants of drifts about the Earth."""


@dataclass(frozen=True, slots=True, eq=False)
class Verification:
    """The arcs, every condition, the burns before the gate cut and whole, aborts, and the corrected flight about the Earth.

    `drift_with_j2_m`: how near to the target the drifts of that flight before the gate come, with J2 and drag, less the
    keep-out; infinite where no drift is asked for.
    """

    arcs: tuple[Arc, ...]
    checks: tuple[Check, ...]
    cuts: tuple[CutBurn, ...]
    aborts: tuple[Abort, ...]
    corrected: CorrectedFlights
    drift_with_j2_m: float
    keep_out_m: float
    cut_burns: bool
    room_m: float
    """How far outside the keep-out that flight stays before the gate, less what errors reach; infinite without `[uncertainty]`."""

    @property
    def least_m(self) -> float:
        """How near to the target the drifts of whole burns before the gate come, m."""
        return min((cut.completed_m for cut in self.cuts), default=inf)

    @property
    def least_cut_m(self) -> float:
        """The same of burns cut anywhere."""
        return min((cut.distance_m for cut in self.cuts), default=inf)

    @property
    def safe(self) -> bool:
        """Whether drifts before the gate stay out as the scenario asks."""
        least = self.least_cut_m if self.cut_burns else self.least_m
        return least >= self.keep_out_m - LIMIT_M

    @property
    def unsafe_aborts(self) -> tuple[Abort, ...]:
        """Instants at which neither the drift is safe nor an impulse within the limit makes it so."""
        return tuple(each for each in self.aborts if each.dv_m_s is None)

    @property
    def failures(self) -> tuple[str, ...]:
        """Every condition that is broken, in words."""
        found = [str(check) for check in self.checks if not check.kept]
        if not self.safe:
            least = self.least_cut_m if self.cut_burns else self.least_m
            found.append(f"a drift before the gate comes within {least:.2f} m")
        if self.room_m < -LIMIT_M:
            found.append(
                f"errors reach {-self.room_m:.1f} m into the keep-out; more impulses before the gate leave less"
            )
        flight = self.corrected
        where = "with J2 and drag, corrected at each impulse, the flight"
        limits: tuple[tuple[Any, float, str], ...] = (
            (-flight.outside_m, LIMIT_M, "is {:.2f} m inside the keep-out"),
            (-flight.corridor_m, LIMIT_M, "is {:.2f} m outside the corridor"),
            (flight.miss_m, MISS_M, "misses the last point by {:.2f} m"),
            (flight.miss_m_s, MISS_M_S, "misses the last velocity by {:.3f} m/s"),
        )
        found += [
            f"{where} {words.format(float(each[0]))}" for each, limit, words in limits if each[0] > limit
        ]
        return tuple(found)

    @property
    def bounded(self) -> bool:
        """Whether what is told of the nearest drift is known from below, to 10 mm."""
        return all(
            low is not None and low >= near - LIMIT_M
            for cut in self.cuts
            for near, low in (
                (cut.distance_m, cut.at_least_m),
                (cut.completed_m, cut.completed_at_least_m),
            )
        )

    @property
    def verified(self) -> bool:
        return not self.failures


def verify(approach: Approach, programme: ImpulseProgramme) -> Verification:
    """Fly a programme, the planner's or a user's. Raises PropagationError."""
    scenario, flown = approach.scenario, arcs(approach, programme)
    errors = scenario.uncertainty
    corrected = fly_corrected(approach, programme, flown)
    before = int(np.searchsorted(programme.times_s, approach.gate_s - 1e-6))
    return Verification(
        arcs=flown,
        checks=checks(approach, programme, flown),
        cuts=_cuts(approach, programme.first(before), flown),
        aborts=aborts(approach, flown),
        corrected=corrected,
        drift_with_j2_m=_drifts(approach, corrected.pairs_before(before)),
        keep_out_m=float(approach.axes_m.min()),
        cut_burns=scenario.safety.cut_burns,
        room_m=inf if errors is None else room_m(approach, programme, flown, errors),
    )


def _cuts(approach: Approach, programme: ImpulseProgramme, flown: tuple[Arc, ...]) -> tuple[CutBurn, ...]:
    """Of the impulses that are fired, and of the first; the drift after another one is that before it."""
    if approach.horizon_s == 0.0 or not len(programme):
        return ()
    fired = programme.worth_firing.copy()
    fired[0] = True
    if approach.held:
        return audit_held(approach, programme, flown, np.flatnonzero(fired))
    burns = ImpulseProgramme(programme.times_s[fired], programme.dv_m_s[fired])
    if approach.circular and approach.spherical:
        found = audit_cut_burns(
            burns, approach.start, approach.motion, float(approach.axes_m.min()),
            mean_motion_rad_s=approach.mean_motion_rad_s, orbits=approach.horizon_s / approach.period_s,
        )  # fmt: skip
    else:
        found = audit_cuts(approach, burns, approach.horizon_s)
    return tuple(replace(cut, number=int(k) + 1) for cut, k in zip(found, np.flatnonzero(fired), strict=True))


def _drifts(approach: Approach, pairs: Array) -> float:
    """How far outside the keep-out drifts about the Earth stay, with J2 and drag, at instants of at most two orbits, m."""
    span = min(approach.horizon_s, 2.0 * approach.period_s)
    if span == 0.0 or not len(pairs):
        return inf
    times = np.linspace(0.0, span, int(np.ceil(AN_ORBIT * span / approach.period_s)) + 1)
    return float(approach.outside_m(drifts(pairs, times, TRUTHS["j2_drag"], rtol=1e-9)).min())
