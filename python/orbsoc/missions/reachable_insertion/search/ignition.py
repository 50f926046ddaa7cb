"""When to burn: an outer search over the length of the coast, by laws that are flown and then by the sequence itself.

The coast costs nothing but time, so the shortest burn counts. Times are ranked by what an impulse would cost there and by how
far the vehicle is from the target orbit; at the best local minima laws are flown onto the orbit, and about the best of those
the burn of the sequence decides.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from orbsoc.guidance.mission import PlanStatus
from orbsoc.orbit import EARTH, PropagationError, elements_from_state
from orbsoc.orbit.vectors import specific_energy

from ..model.coast import coasted
from ..plan.burn_plan import COLD, BurnPlan
from ..starts.directions import REACHED, Start, burn_time, impulse
from ..starts.steering_law import Law, corrected, smoothed, turn_of
from .found import Found
from .setup import InsertionSetup
from .start_search import Search

Array = NDArray[np.float64]

PER_BURN = 4.0
"""Ignition times that are ranked in the time that an impulsive burn takes: what changes over a burn is not stepped over."""
FEWEST, MOST = 90, 2000
"""Ranked ignition times."""
FLOWN = 8
"""Local minima of the ranking, at which a law is flown."""
WITHOUT_PERIOD_S = 7200.0
"""Latest ignition by default on a first orbit that never returns."""
LEAST_SHARE = 0.01
"""Of the burn, that a later ignition has to save to be worth a word."""
SAME_SHARE = 1e-4
"""Of the burn, that is not worth a revolution more of coast."""
LOOKS = 4001
"""Of a coast whose perigee is too low."""
OBLATE_M = 50e3
"""By which J2 lowers a perigee at most, and more."""
GOLDEN = 0.5 * (3.0 - np.sqrt(5.0))
CLOSE_ENOUGH_S = 1.0
"""Of the ignition: the shortest burn is flat there."""


def best_ignition(ready: InsertionSetup, search: Search) -> Found:
    """The shortest burn found over all ignition times up to the latest; ignition now where no later one is shorter."""
    now = search.run(ready)
    if now.interrupted or now.iterate.trajectory.duration == 0.0:
        return now
    try:
        flown = _flown(ready)
        if not flown:
            return now
        best = _converged(ready, search, flown, now)
    except KeyboardInterrupt:
        now.interrupted = "interrupted in the search for the ignition"
        return now
    return best


@dataclass(frozen=True, slots=True)
class LaterIgnition:
    """A burn that starts later, flown, not estimated: how long the coast and the burn take."""

    ignition_s: float
    burn_s: float


@lru_cache(maxsize=8)
def later_ignition(plan: BurnPlan) -> LaterIgnition | None:
    """The best later ignition as its law flies it; None where it saves nothing worth a word.

    Looked for only where thrust along the velocity did not lead to a plan.
    """
    scenario, led = plan.scenario, {stage.start for stage in plan.stages} <= {COLD}
    if (
        scenario.problem != "min_time"
        or scenario.burn.ignition != "now"
        or plan.status is PlanStatus.INTERRUPTED
    ):
        return None
    if plan.time_of_flight_s == 0.0 or (led and plan.status is PlanStatus.VERIFIED):
        return None
    ready = InsertionSetup.of(scenario)
    try:
        flown = _flown(ready)
    except PropagationError:
        return None
    if not flown:
        return None
    ignition_s, law = flown[0]
    burn = InsertionSetup.of(ready.scenario, ignition_s).burn
    law = smoothed(burn, ready.target, law, ready.scenario.method.max_nodes) or law
    limit = plan.trajectory.duration if plan.verification is not None else np.inf
    bound = ready.rate_bound
    if bound is not None and turn_of(law) > bound:
        return None
    if ignition_s == 0.0 or law.duration > (1.0 - LEAST_SHARE) * limit:
        return None
    return LaterIgnition(ignition_s, law.duration * ready.units.time_s)


def latest_s(ready: InsertionSetup) -> float:
    """The latest ignition: the scenario's, or one revolution of the first orbit, and no later than the coast is too low."""
    scenario = ready.scenario
    asked = scenario.burn.latest_ignition_s
    latest = asked if asked is not None else (_period_s(ready) or WITHOUT_PERIOD_S)
    lowest_m = EARTH.earth_radius_m + 1e3 * scenario.limits.lowest_altitude_km
    start = scenario.launch_inertial(scenario.initial)
    if (
        elements_from_state(start[:3], start[3:]).perigee_radius_m
        > lowest_m + OBLATE_M * scenario.burn.coast_j2
    ):
        return latest
    times = np.linspace(0.0, latest, LOOKS)
    low = np.linalg.norm(coasted(scenario, times)[:, :3], axis=1) < lowest_m
    return float(times[max(int(low.argmax()) - 1, 0)]) if low.any() else latest


def _period_s(ready: InsertionSetup) -> float | None:
    start = ready.burn.start
    energy = specific_energy(start[:3], start[3:], 1.0)
    if energy >= -1e-6:
        return None
    return float(2.0 * np.pi * (-0.5 / energy) ** 1.5 * ready.units.time_s)


def _flown(ready: InsertionSetup) -> list[tuple[float, Law]]:
    """Ignition times and laws that reach the orbit, shortest burn first; the first is the best of its neighbourhood."""
    latest = latest_s(ready)
    burn_s = (
        burn_time(ready.burn, float(np.linalg.norm(impulse(ready.burn, ready.target)))) * ready.units.time_s
    )
    count = int(np.clip(PER_BURN * latest / max(burn_s, 1e-3), FEWEST, MOST))
    times = np.linspace(0.0, latest, count + 1)
    costs = _costs(ready, ready.units.state_from_si(coasted(ready.scenario, times)))
    padded = np.pad(costs, 1, constant_values=np.inf)
    minima = np.flatnonzero((costs <= padded[:-2]) & (costs <= padded[2:]))
    chosen = minima[np.argsort(costs[minima], kind="stable")][:FLOWN]
    found = [each for each in (_law_at(ready, float(times[k])) for k in (*chosen, 0)) if each is not None]
    found.sort(key=lambda each: each[1].duration)
    if found:
        found.insert(0, _first_of_the_best(ready, found, float(times[1]), latest))
    return found


def _first_of_the_best(
    ready: InsertionSetup, found: list[tuple[float, Law]], step_s: float, latest: float
) -> tuple[float, Law]:
    """The earliest ignition of those whose burns are as good as equal: an orbit comes back to each after a revolution."""
    near = [each for each in found if each[1].duration <= (1.0 + LEAST_SHARE) * found[0][1].duration]
    converged = [_best_near(ready, each, step_s, latest) for each in near]
    shortest = min(law.duration for _, law in converged)
    return min(
        (each for each in converged if each[1].duration <= (1.0 + SAME_SHARE) * shortest),
        key=lambda each: each[0],
    )


def _law_at(ready: InsertionSetup, ignition_s: float, near: Law | None = None) -> tuple[float, Law] | None:
    """The ignition and a law from there that reaches the orbit, corrected from one of a near ignition."""
    burn = InsertionSetup.of(ready.scenario, ignition_s).burn
    towards = impulse(burn, ready.target)
    size = float(np.linalg.norm(towards))
    if size < 1e-9:
        return None
    guess = near or Law((towards / size)[None], burn_time(burn, size)).of_degree(1)
    law, miss = corrected(burn, ready.target, guess, iterations=20)
    return (ignition_s, law) if miss <= REACHED else None


def _best_near(
    ready: InsertionSetup, at: tuple[float, Law], step_s: float, latest: float
) -> tuple[float, Law]:
    """The shortest burn by steps that shrink, of laws each corrected from the best."""
    best = at
    while step_s > CLOSE_ENOUGH_S:
        for tried in (best[0] - step_s, best[0] + step_s):
            found = _law_at(ready, tried, best[1]) if 0.0 <= tried <= latest else None
            if found is not None and found[1].duration < best[1].duration:
                best = found
                break
        else:
            step_s *= 0.4
    return best


def _costs(ready: InsertionSetup, states: Array) -> Array:
    """Of an ignition at each state (K, 6): the impulse in the middle of its burn, and the speed that closes the gap to the orbit."""
    target, exhaust = ready.target, ready.burn.acceleration / ready.burn.flow
    first = np.linalg.norm(target.there(states)[1] - states[:, 3:], axis=1)
    half = np.minimum(-0.5 * np.expm1(-first / exhaust) / ready.burn.flow, 0.5 * ready.burn.longest)[:, None]
    r, v = states[:, :3], states[:, 3:]
    pull = -r / np.linalg.norm(r, axis=1, keepdims=True) ** 3
    middle = np.hstack([r + half * v + 0.5 * half**2 * pull, v + half * pull])
    position, velocity = target.there(middle)
    gap = np.linalg.norm(position - middle[:, :3], axis=1)
    # A burn of length t shifts the vehicle by some t Δv / 2 beside its turn: a gap asks for gap / t more.
    costs = np.linalg.norm(velocity - middle[:, 3:], axis=1) + gap / np.maximum(half[:, 0], 1e-3)
    return np.asarray(np.nan_to_num(costs, nan=np.inf))


def _converged(ready: InsertionSetup, search: Search, flown: list[tuple[float, Law]], now: Found) -> Found:
    """Golden section on the ignition about the best law, the sequence's own burn as measure; all stages are kept."""
    latest = latest_s(ready)
    width = max(0.25 * flown[0][1].duration * ready.units.time_s, 10.0 * CLOSE_ENOUGH_S)
    best = now
    stages = list(now.stages)

    law = flown[0][1]

    def burn_at(ignition_s: float) -> float:
        nonlocal best, law
        ignited = InsertionSetup.of(ready.scenario, ignition_s)
        law, miss = corrected(ignited.burn, ready.target, law, iterations=20)
        start = Start(f"thrust towards the target's velocity, ignition at {ignition_s:.1f} s", law, miss)
        if not start.reaches:
            return np.inf
        found = search.run_from(ignited, start)
        stages.extend(found.stages)
        if found.interrupted:
            raise KeyboardInterrupt
        if not found.verified:
            return np.inf
        duration = found.iterate.trajectory.duration
        if not best.verified or duration < best.iterate.trajectory.duration:
            best = found
        return duration

    middle = flown[0][0]
    value = burn_at(middle)
    low, high = max(0.0, middle - width), min(latest, middle + width)
    while high - low > CLOSE_ENOUGH_S:
        wide = high - middle > middle - low
        tried = middle + GOLDEN * (high - middle) if wide else middle - GOLDEN * (middle - low)
        if abs(tried - middle) < 0.1 * CLOSE_ENOUGH_S:
            break
        new = burn_at(tried)
        if new < value:
            low, high = (middle, high) if wide else (low, middle)
            middle, value = tried, new
        else:
            low, high = (low, tried) if wide else (tried, high)
    best.stages = stages
    return best
