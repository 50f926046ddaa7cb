"""When to burn: an outer search over the length of the coast, by laws that are flown and then by the sequence itself.

The coast costs nothing but time, so the shortest burn counts. Times are ranked by what an impulse would cost there and by how
far the vehicle is from the target orbit; at the best local minima laws are flown onto the orbit, and about the best of those
the burn of the sequence decides.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from orbsoc.guidance.mission import PlanStatus
from orbsoc.orbit import PropagationError
from orbsoc.orbit.array import Array

from .. import tuning
from ..model.coast import coasted
from ..starts.directions import Start, burn_time, impulse
from ..starts.steering_law import Law, corrected, smoothed, turn_of
from .run import COLD, Attempt, Claim, SearchResult
from .setup import InsertionSetup

SearchFrom = Callable[[InsertionSetup, Start, tuple[float, ...]], SearchResult]
"""A search of its own, from one law at one ignition, with the shares by which a smooth law is shortened."""


@dataclass(frozen=True, slots=True)
class LaterIgnition:
    """A burn that starts later, flown, not estimated: how long the coast and the burn take."""

    ignition_s: float
    burn_s: float


@lru_cache(maxsize=8)
def later_ignition(result: SearchResult) -> LaterIgnition | None:
    """The best later ignition as its law flies it; None where it saves nothing worth a word.

    Looked for only where thrust along the velocity did not lead to a plan.
    """
    scenario = result.scenario
    led = result.status is PlanStatus.VERIFIED and all(each.start is COLD for each in result.attempts)
    if (
        scenario.problem != "min_time"
        or scenario.burn.ignition != "now"
        or result.status is PlanStatus.INTERRUPTED
        or result.time_of_flight_s == 0.0
        or led
    ):
        return None
    setup = result.setup
    try:
        flown = _flown(setup)
    except PropagationError:
        return None
    if not flown:
        return None
    ignition_s, law = flown[0]
    law = smoothed(setup.at(ignition_s).burn, setup.target, law, scenario.method.max_nodes) or law
    limit = result.trajectory.duration if result.verification is not None else np.inf
    if setup.rate_bound is not None and turn_of(law) > setup.rate_bound:
        return None
    if ignition_s == 0.0 or law.duration > (1.0 - tuning.LEAST_SHARE) * limit:
        return None
    return LaterIgnition(ignition_s, law.duration * setup.units.time_s)


def later_burns(result: SearchResult, search_from: SearchFrom) -> Iterator[Attempt]:
    """Golden section on the ignition about the best law, the sequence's own burn as measure.

    Smooth laws are found by shortening. They are compared by coarse shares, and about the shortest burn, which is flat there, no
    closer than these tell apart; that of the best ignition gets all shares.
    """
    setup = result.setup
    flown = _flown(setup)
    if not flown:
        return
    law, smooth = flown[0][1], False

    def burn_at(
        ignition_s: float, shares: tuple[float, ...] = tuning.SHORTENED_TO_COMPARE
    ) -> Generator[Attempt, None, float]:
        nonlocal law, smooth
        ignited = setup.at(ignition_s)
        law, miss = corrected(ignited.burn, setup.target, law, iterations=20)
        start = Start(f"thrust towards the target's velocity, ignition at {ignition_s:.1f} s", law, miss)
        if not start.reaches:
            return np.inf
        made = search_from(ignited, start, shares)
        smooth |= made.claim is Claim.SMOOTH_TURN
        for each in made.attempts:  # their law is of no use at another ignition
            told = replace(each, start=Start(each.start.name))
            yield told if made.verified and each is made.best else told.on_the_way
        if made.interrupted:
            raise KeyboardInterrupt
        return made.trajectory.duration if made.verified else np.inf

    middle, width = flown[0][0], max(0.25 * law.duration * setup.units.time_s, 10.0 * tuning.CLOSE_ENOUGH_S)
    value = yield from burn_at(middle)
    coarsely = np.sqrt(tuning.SHORTENED_TO_COMPARE[-1]) * law.duration * setup.units.time_s
    low, high = max(0.0, middle - width), min(setup.latest_ignition_s, middle + width)
    while high - low > (coarsely if smooth else tuning.CLOSE_ENOUGH_S):
        wide = high - middle > middle - low
        tried = middle + tuning.GOLDEN * (high - middle) if wide else middle - tuning.GOLDEN * (middle - low)
        if abs(tried - middle) < 0.1 * tuning.CLOSE_ENOUGH_S:
            break
        new = yield from burn_at(tried)
        if new < value:
            low, high = (middle, high) if wide else (low, middle)
            middle, value = tried, new
        else:
            low, high = (low, tried) if wide else (tried, high)
    if smooth:
        yield from burn_at(middle, tuning.SHORTENED)


def _flown(setup: InsertionSetup) -> list[tuple[float, Law]]:
    """Ignition times and laws that reach the orbit, shortest burn first; the first is the best of its neighbourhood."""
    latest = setup.latest_ignition_s
    burn_s = (
        burn_time(setup.burn, float(np.linalg.norm(impulse(setup.burn, setup.target)))) * setup.units.time_s
    )
    count = int(np.clip(tuning.PER_BURN * latest / max(burn_s, 1e-3), tuning.FEWEST_TIMES, tuning.MOST_TIMES))
    times = np.linspace(0.0, latest, count + 1)
    costs = _costs(setup, setup.units.state_from_si(coasted(setup.scenario, times)))
    padded = np.pad(costs, 1, constant_values=np.inf)
    minima = np.flatnonzero((costs <= padded[:-2]) & (costs <= padded[2:]))
    chosen = minima[np.argsort(costs[minima], kind="stable")][: tuning.FLOWN_TIMES]
    found = [each for each in (_law_at(setup, float(times[k])) for k in (*chosen, 0)) if each is not None]
    found.sort(key=lambda each: each[1].duration)
    if found:
        found.insert(0, _first_of_the_best(setup, found, float(times[1]), latest))
    return found


def _first_of_the_best(
    setup: InsertionSetup, found: list[tuple[float, Law]], step_s: float, latest: float
) -> tuple[float, Law]:
    """The earliest ignition of those whose burns are as good as equal: an orbit comes back to each after a revolution."""
    near = [each for each in found if each[1].duration <= (1.0 + tuning.LEAST_SHARE) * found[0][1].duration]
    converged = [_best_near(setup, each, step_s, latest) for each in near]
    shortest = min(law.duration for _, law in converged)
    return min(
        (each for each in converged if each[1].duration <= (1.0 + tuning.SAME_SHARE) * shortest),
        key=lambda each: each[0],
    )


def _law_at(setup: InsertionSetup, ignition_s: float, near: Law | None = None) -> tuple[float, Law] | None:
    """The ignition and a law from there that reaches the orbit, corrected from one of a near ignition."""
    burn = setup.at(ignition_s).burn
    towards = impulse(burn, setup.target)
    size = float(np.linalg.norm(towards))
    if size < 1e-9:
        return None
    guess = near or Law((towards / size)[None], burn_time(burn, size)).of_degree(1)
    law, miss = corrected(burn, setup.target, guess, iterations=20)
    return (ignition_s, law) if miss <= tuning.REACHED else None


def _best_near(
    setup: InsertionSetup, at: tuple[float, Law], step_s: float, latest: float
) -> tuple[float, Law]:
    """The shortest burn by steps that shrink, of laws each corrected from the best."""
    best = at
    while step_s > tuning.CLOSE_ENOUGH_S:
        for tried in (best[0] - step_s, best[0] + step_s):
            found = _law_at(setup, tried, best[1]) if 0.0 <= tried <= latest else None
            if found is not None and found[1].duration < best[1].duration:
                best = found
                break
        else:
            step_s *= 0.4
    return best


def _costs(setup: InsertionSetup, states: Array) -> Array:
    """Of an ignition at each state (K, 6): the impulse in the middle of its burn, and the speed that closes the gap to the orbit."""
    target, exhaust = setup.target, setup.burn.acceleration / setup.burn.flow
    first = np.linalg.norm(target.there(states)[1] - states[:, 3:], axis=1)
    half = np.minimum(-0.5 * np.expm1(-first / exhaust) / setup.burn.flow, 0.5 * setup.burn.longest)[:, None]
    r, v = states[:, :3], states[:, 3:]
    pull = -r / np.linalg.norm(r, axis=1, keepdims=True) ** 3
    middle = np.hstack([r + half * v + 0.5 * half**2 * pull, v + half * pull])
    position, velocity = target.there(middle)
    gap = np.linalg.norm(position - middle[:, :3], axis=1)
    # A burn of length t shifts the vehicle by some t Δv / 2 beside its turn: a gap asks for gap / t more.
    costs = np.linalg.norm(velocity - middle[:, 3:], axis=1) + gap / np.maximum(half[:, 0], 1e-3)
    return np.asarray(np.nan_to_num(costs, nan=np.inf))
