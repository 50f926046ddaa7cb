"""When to burn: an outer search over the length of the coast, by laws that are flown and then by the sequence itself.

The coast costs nothing but time, so the shortest burn counts. Times are ranked by what an impulse would cost there and by how
far the vehicle is from the target orbit; at the best of them laws are flown onto the orbit, and about the best of those the burn
of the sequence decides.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from orbsoc.orbit import PropagationError
from orbsoc.orbit.vectors import specific_energy

from .burn_plan import LaterIgnition
from .coast import coasted
from .made_ready import MadeReady
from .search import Found, Search
from .smooth_burn import Law, corrected, shortened
from .starts import REACHED, burn_time, impulse

Array = NDArray[np.float64]

PER_REVOLUTION = 90
"""Ignition times that are ranked, on each revolution of the first orbit; at most four times as many in all."""
FLOWN = 20
"""Of the ranked times, at which a law is flown."""
WITHOUT_PERIOD_S = 7200.0
"""Latest ignition by default on a first orbit that never returns."""
LEAST_SHARE = 0.01
"""Of the burn, that a later ignition has to save to be worth a word."""
GOLDEN = 0.5 * (3.0 - np.sqrt(5.0))
CLOSE_ENOUGH_S = 0.5
"""Of the ignition: the shortest burn is flat there."""


def best_ignition(ready: MadeReady, search: Search) -> Found:
    """The shortest burn found over all ignition times up to the latest; ignition now where no later one is shorter."""
    now = search.run(ready)
    if now.interrupted or now.iterate.trajectory.duration == 0.0:
        return now
    try:
        flown = _flown(ready)
        if not flown:
            return now
        best = _settled(ready, search, flown, now)
    except KeyboardInterrupt:
        now.interrupted = "interrupted in the search for the ignition"
        return now
    return best


def later_ignition(found: Found) -> LaterIgnition | None:
    """The best later ignition as its law flies it; None where it saves nothing worth a word."""
    ready = found.ready
    try:
        flown = _flown(ready)
    except (PropagationError, KeyboardInterrupt):
        return None
    if not flown:
        return None
    ignition_s, law = flown[0]
    burn = MadeReady.of(ready.scenario, ignition_s).burn
    law = shortened(burn, ready.target, law, ready.scenario.method.max_nodes)
    limit = found.iterate.trajectory.duration if found.verification is not None else np.inf
    if ignition_s == 0.0 or law.duration > (1.0 - LEAST_SHARE) * limit:
        return None
    return LaterIgnition(ignition_s, law.duration * ready.units.time_s)


def latest_s(ready: MadeReady) -> float:
    """The latest ignition: the scenario's, or one revolution of the first orbit."""
    asked = ready.scenario.burn.latest_ignition_s
    return asked if asked is not None else (_period_s(ready) or WITHOUT_PERIOD_S)


def _period_s(ready: MadeReady) -> float | None:
    start = ready.burn.start
    energy = specific_energy(start[:3], start[3:], 1.0)
    if energy >= -1e-6:
        return None
    return 2.0 * np.pi * (-0.5 / energy) ** 1.5 * ready.units.time_s


def _flown(ready: MadeReady) -> list[tuple[float, Law]]:
    """Ignition times and laws that reach the orbit, shortest burn first."""
    latest = latest_s(ready)
    count = int(PER_REVOLUTION * np.clip(latest / (_period_s(ready) or latest), 0.2, 4.0))
    times = np.linspace(0.0, latest, count + 1)
    states = ready.units.state_from_si(coasted(ready.start_si, times))
    found: list[tuple[float, Law]] = []
    for k in _ranked(ready, states)[:FLOWN]:
        burn = replace(ready.burn, start=states[k])
        towards = impulse(burn, ready.target)
        size = float(np.linalg.norm(towards))
        if size < 1e-9:
            continue
        guess = Law((towards / size)[None], burn_time(burn, size)).of_degree(1)
        law, miss = corrected(burn, ready.target, guess, iterations=20)
        if miss <= REACHED:
            found.append((float(times[k]), law))
    return sorted(found, key=lambda each: each[1].duration)


def _ranked(ready: MadeReady, states: Array) -> Array:
    """Indices of states, cheapest first: the impulse in the middle of its burn, and the speed that closes the gap to the orbit."""
    costs = np.empty(len(states))
    for k, state in enumerate(states):
        burn = replace(ready.burn, start=state)
        half = 0.5 * burn_time(burn, float(np.linalg.norm(impulse(burn, ready.target))))
        middle = state + half * np.concatenate([state[3:], -state[:3] / np.linalg.norm(state[:3]) ** 3])
        burn = replace(burn, start=middle)
        position = middle[:3]
        velocity = ready.target.velocity_along(position)
        across = position @ ready.target.normal
        flat = position - across * ready.target.normal
        along = flat / np.linalg.norm(flat)
        there = ready.target.momentum**2 / (1.0 + ready.target.eccentricity * float(ready.target.perigee @ along))
        gap = float(np.linalg.norm(position - there * along)) if there > 0.0 else np.inf
        # A burn of length t shifts the vehicle by some t Δv / 2 beside its turn: a gap asks for gap / t more.
        costs[k] = float(np.linalg.norm(velocity - middle[3:])) + gap / max(half, 1e-3)
    return np.argsort(costs, kind="stable")


def _settled(ready: MadeReady, search: Search, flown: list[tuple[float, Law]], now: Found) -> Found:
    """Golden section on the ignition about the best law, the sequence's own burn as measure; all stages are kept."""
    latest = latest_s(ready)
    step = flown[min(len(flown) - 1, 1)][0] - flown[0][0]
    width = max(latest / PER_REVOLUTION, min(abs(step), 0.05 * latest))
    best = now
    stages = list(now.stages)

    def burn_at(ignition_s: float) -> float:
        nonlocal best
        found = search.run(MadeReady.of(ready.scenario, ignition_s))
        stages.extend(replace(each, note=f"ignition at {ignition_s:.1f} s: {each.note}") for each in found.stages)
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
