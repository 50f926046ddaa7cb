"""Fly the plan by integrators that the optimiser does not use, and judge every condition of the scenario.

Twice: the linear equations of relative motion by DOP853, on which the conditions are judged, and target and chaser each
about the Earth with J2 and drag, whose differences are told.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, isfinite
from typing import Any

import numpy as np

from orbsoc.guidance import mission
from orbsoc.guidance.impulses import ImpulseProgramme
from orbsoc.guidance.linear_flight import LinearFlight
from orbsoc.guidance.relative_flight import TRUTHS, drifts, fly
from orbsoc.guidance.safety import CutBurn, audit_cut_burns
from orbsoc.orbit import state_from_elements
from orbsoc.orbit.array import Array

from .model import problem
from .model.approach import Approach, cone_rows
from .scenario import DEFAULT_SAMPLES

LIMIT_M = 0.01
"""Within which a condition on a length counts as kept."""
LIMIT_M_S = 1e-5
SAMPLES = 720
"""An orbit, of drifts that are judged and drawn."""


class Check(mission.Check):
    """One condition of the scenario."""

    @property
    def kept(self) -> bool:
        return self.margin >= -(LIMIT_M if self.unit == "m" else LIMIT_M_S)

    def __str__(self) -> str:
        return f"{self.name} is broken by {-self.margin:.3g} {self.unit} at {self.at_s:.0f} s"


@dataclass(frozen=True, slots=True, eq=False)
class Truth:
    """The programme about the Earth: how far from the capture point it ends, how near to the target the drift after the
    first impulse comes and how deep into the half-space those after the others stay, m; track (K, 3) and those drifts."""

    name: str
    capture_miss_m: float
    first_range_m: float
    least_depth_m: float
    track: Array

    def to_dict(self) -> dict[str, Any]:
        found = {name: getattr(self, name) for name in ("capture_miss_m", "first_range_m", "least_depth_m")}
        return {name: value if isfinite(value) else None for name, value in found.items()}


@dataclass(frozen=True, slots=True, eq=False)
class Verification:
    """What the flights found. Tracks: positions (K, 3) in (R, T, N) at times_s (K,), and of each drift (N, SAMPLES + 1, 3)
    over one orbit after its impulse."""

    times_s: Array
    track: Array
    after: Array
    drifts: Array
    drift_times_s: Array
    terminal_position_m: float
    terminal_velocity_m_s: float
    checks: tuple[Check, ...]
    cuts: tuple[CutBurn, ...]
    cuts_within_orbits: tuple[CutBurn, ...]
    """For the orbits of `interruption_orbits`; empty without."""
    truths: tuple[Truth, ...]

    @property
    def verified(self) -> bool:
        return all(check.kept for check in self.checks)

    @property
    def failures(self) -> tuple[str, ...]:
        """Every condition that is broken, in words."""
        return tuple(str(check) for check in self.checks if not check.kept)


def verify(approach: Approach, programme: ImpulseProgramme) -> Verification:
    """Fly a programme of this approach, the planner's or a user's. Raises PropagationError."""
    model = _linear_flight(approach)
    times = np.unique(np.concatenate([np.linspace(0.0, approach.duration_s, 361), programme.times_s]))
    states, after, anomalies = model.flown(programme, approach.start, times)
    lapse = np.linspace(0.0, approach.period_s, SAMPLES + 1)
    free = model.coasted(after, anomalies, lapse)
    end = states[-1].copy()
    if programme.times_s[-1] == times[-1]:
        end[3:] = after[-1][3:]
    wanted = approach.capture_velocity
    return Verification(
        times_s=times,
        track=states[:, :3],
        after=after,
        drifts=np.moveaxis(free[:, :, :3], 0, 1),
        drift_times_s=lapse,
        terminal_position_m=float(np.linalg.norm(end[:3] - approach.capture)),
        terminal_velocity_m_s=0.0 if wanted is None else float(np.linalg.norm(end[3:] - wanted)),
        checks=tuple(_checks(approach, programme, model, states, times, after, anomalies, end)),
        cuts=_cuts(approach, programme, inf),
        cuts_within_orbits=_cuts(approach, programme, float(approach.scenario.interruption_orbits)),
        truths=tuple(_truth(approach, programme, name) for name in TRUTHS),
    )


def _cuts(approach: Approach, programme: ImpulseProgramme, orbits: float) -> tuple[CutBurn, ...]:
    if orbits == 0.0 or not len(programme):
        return ()
    return audit_cut_burns(
        programme, approach.start, approach.motion, approach.keep_out_m,
        mean_motion_rad_s=approach.mean_motion_rad_s, orbits=orbits, circular=approach.circular,
    )  # fmt: skip


def _linear_flight(approach: Approach) -> LinearFlight:
    ecc = 0.0 if approach.circular else approach.scenario.target.eccentricity
    return LinearFlight(approach.mean_motion_rad_s, ecc, approach.orbit().true_anomaly_rad)


def _checks(
    approach: Approach,
    programme: ImpulseProgramme,
    model: LinearFlight,
    states: Array,
    times: Array,
    after: Array,
    anomalies: Array,
    end: Array,
) -> list[Check]:
    scenario, n, keep_out = approach.scenario, approach.mean_motion_rad_s, approach.keep_out_m
    duration = approach.duration_s
    off_m = end[:3] - approach.capture
    miss = float(np.abs(off_m).max()) if scenario.capture_box_m else float(np.linalg.norm(off_m))
    found = [Check(problem.CAPTURE, scenario.capture_box_m - miss, "m", duration)]
    if approach.capture_velocity is not None:
        off = float(np.linalg.norm(end[3:] - approach.capture_velocity))
        found.append(Check(problem.CAPTURE_VELOCITY, -off, "m/s", duration))
    if not approach.guarded or not len(programme):
        return found

    away = np.linalg.norm(states[:, :3], axis=1)
    nearest = int(away.argmin())
    found.append(Check(problem.TRACK, float(away[nearest]) - keep_out, "m", float(times[nearest])))

    def lapse(orbits: float, samples: int) -> Array:
        return approach.period_s * np.arange(0, int(orbits * samples) + 1) / samples

    def least(name: str, k: int, orbits: float, samples: int, weight: Array) -> Check:
        """Of weight · position − keep-out over the drift after the k-th impulse."""
        lapsed = lapse(orbits, samples)
        depth = model.coasted(after[k : k + 1], anomalies[k : k + 1], lapsed)[:, 0, :3] @ weight
        if samples != SAMPLES:
            depth[0] = depth[-1] if approach.circular else inf  # the paper's samples begin after the impulse
        at = int(depth.argmin())
        return Check(name, float(depth[at]) - keep_out, "m", float(programme.times_s[k] + lapsed[at]))

    deep, short = approach.side * np.eye(3)[0], -approach.ahead * np.eye(3)[1]
    samples = SAMPLES if scenario.safety == "cone" else scenario.samples or DEFAULT_SAMPLES
    first_s = float(programme.times_s[0])
    if scenario.condition == "none" and approach.side * approach.start[0] >= keep_out:
        found.append(least(problem.drift_name(1), 0, 1.0, samples, deep))
    elif scenario.condition == "none":
        found.append(least(problem.SHORT, 0, 1.0, problem.HALF_PLANE_SAMPLES, short))
    else:
        if approach.circular:
            closed = abs(float(cone_rows(n)[0] @ after[0]))
            found.append(Check(problem.CLOSED, -closed, "m", first_s))
        if len(programme) > 1:
            at = int(np.searchsorted(times, programme.times_s[1]))
            depth = approach.side * float(states[at, 0]) - keep_out
            found.append(Check(problem.CLEARED, depth, "m", float(times[at])))
        if scenario.condition == "short":
            found.append(least(problem.SHORT, 0, 1.0, SAMPLES, short))
        else:
            found.append(_encloses(approach, model, after[0], float(anomalies[0]), first_s))
    for k in range(1, len(programme)):
        found.append(least(problem.drift_name(k + 1), k, 1.0, samples, deep))
    if scenario.interruption_orbits and len(programme) > 1:
        orbits = float(scenario.interruption_orbits)
        found.append(least(problem.UNINTERRUPTED, 1, orbits, problem.HALF_PLANE_SAMPLES, short))
    return found


def _encloses(approach: Approach, model: LinearFlight, state: Array, anomaly: float, at_s: float) -> Check:
    """The first drift passes around the target: at samples, by the paper's (8), its far vertex; otherwise everywhere."""
    lapsed = np.linspace(0.0, approach.period_s, SAMPLES + 1)
    track = model.coasted(state[None], np.array([anomaly]), lapsed)[:, 0, :3]
    if approach.scenario.safety == "samples":
        far = approach.ahead * track[:, 1]
        k = int(far.argmax())
        return Check(problem.BEYOND, float(far[k]) - approach.keep_out_m, "m", at_s + float(lapsed[k]))
    away = np.linalg.norm(track, axis=1)
    k = int(away.argmin())
    return Check(problem.BEYOND, float(away[k]) - approach.keep_out_m, "m", at_s + float(lapsed[k]))


def _truth(approach: Approach, programme: ImpulseProgramme, name: str) -> Truth:
    target = np.concatenate(state_from_elements(approach.orbit()))
    forces = TRUTHS[name]
    times = np.linspace(0.0, approach.duration_s, 181)
    flown = fly(programme, approach.start, target, times, forces)
    free = drifts(flown.pairs_after, np.linspace(0.0, approach.period_s, SAMPLES + 1), forces)
    depth = (approach.side * free[1:, :, 0]).min() if len(free) > 1 else inf
    return Truth(
        name=name,
        capture_miss_m=float(np.linalg.norm(flown.states[-1, :3] - approach.capture)),
        first_range_m=float(np.linalg.norm(free[0], axis=1).min()) if len(free) else inf,
        least_depth_m=float(depth),
        track=flown.states[:, :3],
    )
