"""Figures of a plan: the approach over time, the distance after the meeting, the front, the surprise, the primer.

Matplotlib is imported when a figure is drawn, with the Agg canvas and without pyplot: no global state, no display.
"""

from __future__ import annotations

from math import isfinite
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from orbsoc.guidance.figure_style import BLUE, GREEN, GREY, PLAIN, STYLE, VERMILION, panels, write_png
from orbsoc.guidance.mission import FigureFile
from orbsoc.guidance.orbit_space import Curve, Whole, ground_figure, space_figure
from orbsoc.orbit.perturbations import fast_coast

from .model.approach import state_at, states_at
from .planner import PhasingPlan
from .scenario import zero_utc
from .search.descent import Descended, PhasingImpulses
from .verification.flight import Flight

TRACK_S = 30.0
"""Between points of the track on the ground."""


def draw_figures(plan: PhasingPlan, folder: Path) -> tuple[FigureFile, ...]:
    """Write the figures of a plan that was flown into `folder`; empty when there is nothing to show."""
    flight = plan.verification
    if flight is None or plan.programme is None:
        return ()
    import matplotlib as mpl

    found = []
    with mpl.rc_context(PLAIN):
        found += _in_space(plan, flight, folder)
    with mpl.rc_context(STYLE):
        found += [_approach(plan, flight, folder), _distance(plan, flight, folder)]
        if plan.analysis is not None and plan.analysis.front:
            found.append(_front(plan, folder))
        if plan.analysis is not None and plan.analysis.surprised is not None:
            found.append(_surprise(plan, folder))
        if plan.descended is not None:
            found.append(_primer(plan, plan.descended, folder))
    return tuple(found)


def _in_space(plan: PhasingPlan, flight: Flight, folder: Path) -> list[FigureFile]:
    """Both orbits with the impulses about the body, and with a date the chaser's track on the ground."""
    assert plan.programme is not None
    scenario, about = plan.scenario, plan.scenario.constants
    at = np.clip(np.searchsorted(flight.times_s, plan.programme.times_s), 0, len(flight.times_s) - 1)
    burns = Curve("impulses", VERMILION, flight.chaser[at, :3], flight.times_s[at], style="")
    end = flight.chaser[-1:, :3]
    meeting = Curve("meeting", GREEN, end, flight.times_s[-1:], style="")
    orbits = [
        Whole("chaser before", BLUE, scenario.chaser.elements),
        Whole("target", GREEN, scenario.target.elements, "--"),
    ]
    figure = space_figure(f"{scenario.name}: orbits and impulses", about, orbits, [burns, meeting])
    words = "The orbits of chaser and target with the impulses, about the body with its equator and graticule of 30°; dotted behind it."
    found = [write_png(figure, folder, "space.png", words)]
    date = scenario.chaser.epoch_utc
    if date is not None:
        times_s = np.arange(flight.times_s[0], flight.times_s[-1], TRACK_S)
        flown = CubicHermiteSpline(flight.times_s, flight.chaser[:, :3], flight.chaser[:, 3:])
        way = Curve("chaser", BLUE, flown(times_s), times_s, width=0.9)
        zero = zero_utc(date, scenario.chaser.epoch_s)
        track = ground_figure(f"{scenario.name}: ground track", "TEME", zero, [way, burns, meeting])
        found.append(
            write_png(
                track,
                folder,
                "ground.png",
                "The chaser's track on the ground, with its impulses and the meeting.",
            )
        )
    return found


def _approach(plan: PhasingPlan, flight: Flight, folder: Path) -> FigureFile:
    """Heights and distance with the impulses."""
    assert plan.programme is not None
    figure, axes = panels((7.6, 5.0), (2, 2))
    zero, scenario = plan.programme.times_s[0], plan.scenario
    hours = (flight.times_s - zero) / 3600.0
    after = flight.times_s > scenario.target.epoch_s
    target = states_at(scenario, "target", flight.times_s[after])
    for states, where, colour, name in (
        (target, after, VERMILION, "target"),
        (flight.chaser, slice(None), BLUE, "chaser"),
    ):
        height = (np.linalg.norm(states[:, :3], axis=1) - scenario.constants.earth_radius_m) / 1e3
        axes[0].plot(hours[where], height, color=colour, linewidth=1.2, label=name)
    axes[0].set_ylabel("height (km)")
    axes[0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.1)
    apart = np.linalg.norm(flight.chaser[after, :3] - target[:, :3], axis=1) / 1e3
    axes[1].semilogy(hours[after][:-1], apart[:-1], color=BLUE, linewidth=1.2)
    axes[1].set_ylabel("distance (km)")
    for each in axes:
        for t in plan.programme.times_s:
            each.axvline((t - zero) / 3600.0, color=GREY, linewidth=0.8, linestyle=":")
    axes[-1].set_xlabel("time after the first burn (h)")
    figure.suptitle(
        f"{scenario.name}: {plan.programme.total_m_s:.2f} m/s in {len(plan.programme)} impulses (dotted)"
    )
    words = "The approach: heights of chaser and target over the equatorial radius, and their distance. Dotted: impulses."
    return write_png(figure, folder, "approach.png", words)


def _primer(plan: PhasingPlan, descended: Descended, folder: Path) -> FigureFile:
    """Of the last linearisation, at every instant of the approach."""
    assert plan.programme is not None
    figure, (axes,) = panels((7.6, 3.4))
    last, approach = descended.last, descended.approach
    assert isinstance(last.impulses, PhasingImpulses)
    zero, sizes = plan.programme.times_s[0], last.impulses.primer_size(last.solution, approach.times_s)
    axes.plot((approach.times_s - zero) / 3600.0, sizes, color=GREEN, linewidth=1.4, marker=".", markersize=3)
    for level in (plan.programme.times_s - zero) / 3600.0:
        axes.axvline(level, color=GREY, linewidth=0.8, linestyle=":")
    axes.axhline(1.0, color=GREY, linewidth=0.8)
    axes.set_ylim(0.0, 1.12)
    axes.set_xlabel("time after the first burn (h)")
    axes.set_ylabel("|primer|")
    words = "The primer at every instant: no impulse pays where it is below 1. Dotted: impulses."
    return write_png(figure, folder, "primer.png", words, appendix=True)


def _distance(plan: PhasingPlan, flight: Flight, folder: Path) -> FigureFile:
    """The paper's figures 3 and 4."""
    figure, axes = panels((7.6, 3.6))
    minutes = (flight.after_s - flight.after_s[0]) / 60.0
    axes[0].semilogy(minutes[1:], flight.distance_m[1:] / 1e3, color=BLUE, label="drag as planned with")
    other = plan.scenario.surprise
    if other is not None:
        forces = plan.scenario.forces_on(plan.scenario.chaser.ballistic_m2_kg)
        chaser = fast_coast([flight.end_state], flight.after_s, forces)[:, 0, :3]
        name, end_s = "target", float(flight.after_s[0])
        goal = state_at(plan.scenario, name, end_s, other.ballistic_m2_kg)
        target = fast_coast([goal], flight.after_s, plan.scenario.forces_on(other.ballistic_m2_kg))[:, 0, :3]
        apart = np.linalg.norm(chaser - target, axis=1) / 1e3
        axes[0].semilogy(minutes, apart, color=VERMILION, label="with the other drag, not planned again")
        axes[0].legend()
    axes[0].set_xlabel("time after the meeting (min)")
    axes[0].set_ylabel("distance (km)")
    figure.suptitle(f"{plan.scenario.name}: no burn after the meeting")
    return write_png(
        figure, folder, "distance.png",
        "Distance of chaser and target after the meeting if nothing burns any more (the paper's figures 3 and 4).",
    )  # fmt: skip


def _front(plan: PhasingPlan, folder: Path) -> FigureFile:
    assert plan.analysis is not None
    figure, axes = panels((7.6, 4.0))
    points = plan.analysis.front
    for name, label, colour, marker in (
        ("scheme_m_s", "four burns of the scheme", VERMILION, "s"),
        ("least_m_s", "least, generated impulses", BLUE, "o"),
    ):
        known = [
            (each.revolutions, getattr(each, name)) for each in points if getattr(each, name) is not None
        ]
        if known:
            axes[0].plot(*np.array(known).T, color=colour, marker=marker, label=label)
            for count, cost in known if name == "least_m_s" else ():
                axes[0].annotate(
                    f"{cost:.1f}",
                    (count, cost),
                    xytext=(0, -13),
                    textcoords="offset points",
                    ha="center",
                    fontsize=9,
                )
    own = plan.scenario.window.revolutions
    if plan.programme is not None and own is not None and own not in {each.revolutions for each in points}:
        axes[0].plot(
            [own],
            [plan.programme.total_m_s],
            color=GREEN,
            marker="*",
            markersize=12,
            label="this plan",
            zorder=3,
        )
    axes[0].set_xlabel("revolutions on the phasing orbit")
    axes[0].set_ylabel("Σ‖Δv‖ (m/s)")
    axes[0].set_ylim(bottom=0.0)
    axes[0].legend()
    figure.suptitle(f"{plan.scenario.name}: what another number of revolutions costs")
    return write_png(
        figure, folder, "front.png",
        "The price of speed: impulses of the paper's scheme by shooting, and the least over all instants, by the number of"
        " revolutions.",
    )  # fmt: skip


def _surprise(plan: PhasingPlan, folder: Path) -> FigureFile:
    assert plan.analysis is not None
    assert plan.analysis.surprised is not None
    found = plan.analysis.surprised
    figure, axes = panels((7.6, 3.4))
    known = [each for each in found.replans if isfinite(each.extra_m_s)]
    places = range(len(known))
    axes[0].bar(places, [each.extra_m_s for each in known], color=BLUE, width=0.55)
    for place, each in zip(places, known, strict=True):
        axes[0].annotate(
            f"+{each.extra_m_s:.2f} m/s",
            (place, each.extra_m_s),
            xytext=(0, 3),
            textcoords="offset points",
            ha="center",
        )
    axes[0].set_xticks(list(places), [f"{each.before_s / 3600.0:g} h before" for each in known])
    axes[0].set_ylabel("more Δv (m/s)")
    axes[0].margins(y=0.2)
    axes[0].grid(visible=False, axis="x")
    figure.suptitle(
        f"{plan.scenario.name}: without planning again it would miss by {found.miss_m / 1e3:.1f} km"
    )
    return write_png(
        figure, folder, "surprise.png",
        "The target's drag is not what was planned with: what planning again costs, by when the chaser learns of it.",
    )  # fmt: skip
