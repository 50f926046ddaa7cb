"""The paper's way to a long approach, as a first guess: plane bias, phasing orbit, epochs. Its equations (1) to (3).

Equation (2) is printed with (1 − e²) for its square. The rules use mean elements and no short-period terms: shooting in
the true motion follows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, pi, sin, sqrt, tau

import numpy as np
from scipy.optimize import brentq

from orbsoc.guidance.scenario_file import Complaint, ScenarioError
from orbsoc.orbit import EARTH, ConstantsSet, Elements, elements_from_state
from orbsoc.orbit.array import Array
from orbsoc.orbit.perturbations import fast_coast

from ..model.approach import Approach, Roll, approach_at, state_at
from ..scenario import Scenario


@dataclass(frozen=True, slots=True)
class Phasing:
    """Epochs of the plane's turn, of the phasing burn and of the meeting; the period of the phasing orbit, its height at
    the other apsis, and the tangential velocity changes into it and out of it."""

    start_s: float
    phasing_s: float
    end_s: float
    period_s: float
    other_apsis_m: float
    into_m_s: float
    out_m_s: float

    @property
    def tangential_m_s(self) -> float:
        return abs(self.into_m_s) + abs(self.out_m_s)


def node_rate_rad_s(
    sma_m: float, ecc: float, inc_rad: float, power: int = 2, about: ConstantsSet = EARTH
) -> float:
    """By J2, equation (2); `power` 1 is as printed, of 1 − e²."""
    motion = sqrt(about.mu_m3_s2 / sma_m**3)
    shape = (about.earth_radius_m / sma_m) ** 2 / (1.0 - ecc**2) ** power
    return -1.5 * about.j2 * motion * shape * cos(inc_rad)


def elements(state: Array, about: ConstantsSet = EARTH) -> Elements:
    return elements_from_state(state[:3], state[3:], about)


def latitude_argument(orbit: Elements) -> float:
    """Angle from the node, rad, in [0, 2π)."""
    return (orbit.argp_rad + orbit.true_anomaly_rad) % tau


def plan_phasing(scenario: Scenario) -> Phasing:
    """Of the meetings that the window allows the cheapest. Raises ScenarioError where no phasing orbit meets the target."""
    window, about = scenario.window, scenario.constants
    count = window.revolutions
    assert count is not None
    start_s = _plane_burn(scenario) if window.start_s is None else window.start_s
    after = state_at(scenario, "chaser", start_s)
    orbit, goal = elements(after, about), scenario.target.elements
    # the chaser passes where the target's apogee will be; both perigees drift by a few degrees, which shooting mends
    angle = (goal.argp_rad + pi - latitude_argument(orbit)) % tau
    phasing_s = window.phasing_s
    if phasing_s is None:
        phasing_s = start_s + _coast_angle_s(orbit, angle) + window.start * orbit.period_s()
    radius = orbit.sma_m
    latest_s = start_s + 3600.0 * window.latest_h
    ends = [window.end_s] if window.end_s is not None else _apogees(scenario, phasing_s, latest_s)
    found: list[Phasing] = []
    others: list[float] = []
    for end_s in ends:
        turn_s = (end_s - phasing_s) / count
        sma = (about.mu_m3_s2 * (turn_s / tau) ** 2) ** (1.0 / 3.0)
        other = 2.0 * sma - radius
        low, high = sorted((radius, other))
        others.append((other - about.earth_radius_m) / 1e3)
        limits = scenario.limits
        within = (
            low - about.earth_radius_m >= 1e3 * limits.perigee_height_km
            and high - about.earth_radius_m <= 1e3 * limits.apogee_height_km
        )
        if within:
            speeds = [sqrt(about.mu_m3_s2 * (2.0 / radius - 1.0 / a)) for a in (orbit.sma_m, sma, goal.sma_m)]
            found.append(
                Phasing(start_s, phasing_s, end_s, turn_s, other - about.earth_radius_m,
                        speeds[1] - speeds[0], speeds[2] - speeds[1])
            )  # fmt: skip
    if not found:
        limits = scenario.limits
        others.sort(key=lambda h: max(limits.perigee_height_km - h, h - limits.apogee_height_km))
        nearest = ", ".join(f"{height:.0f}" for height in others[:3])
        allowed = (
            f"no phasing orbit meets the target within latest_h = {window.latest_h:g}: its other apsis would be at"
            f" {nearest or 'no'} km, and {limits.perigee_height_km:g} to {limits.apogee_height_km:g} km are"
            " allowed; must be another number of revolutions, or wider limits"
        )
        raise ScenarioError(scenario.name, [Complaint("window.revolutions", str(count), allowed)])
    return min(found, key=lambda each: each.tangential_m_s)


def plane_bias_m_s(scenario: Scenario, phasing: Phasing) -> float:
    """The normal velocity change that turns the node so that J2 brings both planes together at the meeting."""
    about = scenario.constants
    at_start = elements(state_at(scenario, "chaser", phasing.start_s), about)
    goal = elements(state_at(scenario, "target", phasing.end_s), about)
    radius = at_start.sma_m
    apsis = about.earth_radius_m + phasing.other_apsis_m
    sma, ecc = 0.5 * (radius + apsis), abs(apsis - radius) / (apsis + radius)
    waiting = node_rate_rad_s(radius, 0.0, at_start.inc_rad, about=about) * (
        phasing.phasing_s - phasing.start_s
    )
    phased = node_rate_rad_s(sma, ecc, at_start.inc_rad, about=about) * (phasing.end_s - phasing.phasing_s)
    turn = (goal.raan_rad - waiting - phased - at_start.raan_rad + pi) % tau - pi
    speed = sqrt(about.mu_m3_s2 / radius)
    return turn * sin(at_start.inc_rad) * speed / sin(latitude_argument(at_start))


def shoot(
    scenario: Scenario, phasing: Phasing, *, trim: bool = True, ballistic_m2_kg: float | None = None
) -> tuple[Approach, Roll | None]:
    """The scheme in the true motion: a normal burn, a phasing burn, a trim at the last apsis, and a meeting; the flight is
    None where Newton's method finds none. With `trim` the phasing burn is tangential, without it is in the plane. The
    approach has no other instants."""
    half_s = phasing.end_s - 0.5 * phasing.period_s
    times = np.array([phasing.start_s, phasing.phasing_s, *([half_s] if trim else []), phasing.end_s])
    approach = approach_at(scenario, times, ballistic_m2_kg=ballistic_m2_kg)
    at = range(times.size)
    dv = np.zeros((approach.times_s.size, 3))
    dv[0] = plane_bias_m_s(scenario, phasing) * approach.normal
    dv = _phased(approach, dv, at[1], phasing.into_m_s)
    directions: list[Sequence[int]] = [(2,), (1,), (1,), (0, 1, 2)] if trim else [(2,), (0, 1), (0, 1, 2)]

    def basis(roll: Roll) -> Array:
        columns = []
        for k, axes in zip(at, directions, strict=True):
            rows = approach.axes(roll, k)
            for axis in axes:
                column = np.zeros_like(dv)
                column[k] = rows[axis]
                columns.append(column.ravel())
        return np.array(columns).T

    return approach, approach.restore(dv, basis)


def _phased(approach: Approach, dv: Array, k: int, into_m_s: float) -> Array:
    """With the tangential burn at instant k that ends the flight beside the target, and the last one that stops it there."""

    def lag(size: float) -> float:
        """Angle of the target ahead of the chaser at the end, within half a turn."""
        dv[k] = size * tangent
        end = approach.roll(dv).states[-1]
        momentum = np.cross(end[:3], end[3:])
        across = np.cross(momentum / np.linalg.norm(momentum), end[:3])
        return float(np.arctan2(approach.goal[:3] @ across, approach.goal[:3] @ end[:3]))

    tangent = approach.axes(approach.roll(dv), k)[1]
    # a secant from the analytic size; the lag grows by some 3 rad by 100 m/s and ten revolutions
    one, two = into_m_s, into_m_s + 0.5
    lag_one, lag_two = lag(one), lag(two)
    for _ in range(20):
        if abs(lag_two) < 1e-5 or lag_two == lag_one:
            break
        step = np.clip(-lag_two * (two - one) / (lag_two - lag_one), -20.0, 20.0)
        one, lag_one, two = two, lag_two, two + float(step)
        lag_two = lag(two)
    dv[k] = two * tangent
    dv[-1] = approach.goal[3:] - approach.roll(dv).states[-1, 3:]
    return dv


def _plane_burn(scenario: Scenario) -> float:
    """The first time after both epochs at which the chaser is at argument of latitude 90° or 270°, where a normal burn turns
    the node alone, equation (1)."""
    begin = max(scenario.chaser.epoch_s, scenario.target.epoch_s)
    orbit = elements(state_at(scenario, "chaser", begin), scenario.constants)
    angle = (0.5 * pi - latitude_argument(orbit)) % pi
    return begin + _coast_angle_s(orbit, angle)


def _coast_angle_s(orbit: Elements, angle: float) -> float:
    """By the mean motion: for orbits that are nearly circular."""
    return angle / tau * orbit.period_s()


def _apogees(scenario: Scenario, after_s: float, until_s: float) -> list[float]:
    """Times at which the target is at its apogee."""
    target, forces = scenario.target, scenario.forces_on(scenario.target.ballistic_m2_kg)
    begin, period_s = max(after_s, target.epoch_s + 1.0), target.elements.period_s()
    times = np.arange(begin, until_s + period_s, period_s / 40.0)
    if times.size < 2:
        return []
    states = fast_coast([target.state], [target.epoch_s, *times], forces)[1:, 0]
    rates = np.einsum("ki,ki->k", states[:, :3], states[:, 3:])
    found = []
    for k in np.flatnonzero((rates[:-1] > 0.0) & (rates[1:] <= 0.0)):

        def rate(s: float, state: Array = states[k]) -> float:
            there = fast_coast([state], [0.0, s], forces)[-1, 0] if s > 0.0 else state
            return float(there[:3] @ there[3:])

        t = float(times[k]) + float(brentq(rate, 0.0, float(times[k + 1] - times[k]), xtol=1e-3))
        if t <= until_s:
            found.append(t)
    return found
