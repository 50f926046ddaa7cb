"""`orbsoc.plan`: what `orbsoc plan` does, as a call that takes a scenario in any form.

>>> run = orbsoc.plan("scenarios/rec1.toml", device="none")  # doctest: +SKIP
>>> print(run.verdict)  # doctest: +SKIP
Answer   VERIFIED     burn 56.570 s → 152.76 × 201.84 km; independent flight within 7e-12 (allowed 1e-8)
"""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .plan import plan_scenario

if TYPE_CHECKING:
    from orbsoc.guidance.mission import Mission
    from orbsoc.guidance.scenario_file import BaseScenario
    from orbsoc.report.run import PlanRun


def plan(
    scenario: BaseScenario | Mapping[str, Any] | str | PathLike[str],
    *,
    settings: Mapping[str, Any] | None = None,
    out: str | PathLike[str] | None = None,
    **options: Any,
) -> PlanRun:
    """Plan a scenario of any mission, price it, and write the folder `out` if one is given.

    `scenario`: a mission's `Scenario`, the tables of a scenario file as a dict, or the path of one. `settings` override
    its keys, {"method.nodes": 16}. `options`: device="zu9eg" ("none": no price), partition="paper", deadline_ms, exact,
    check, ps, impulses, report, as those of `orbsoc plan`. The result has `plan`, `verdict`, `budget` and `check`.

    Raises ScenarioError, `hw_model.HwModelError`, OutputFolderError, PropagationError; TypeError for what is no scenario;
    KeyboardInterrupt when interrupted.
    """
    mission, chosen = _chosen(scenario, settings)
    return plan_scenario(mission, chosen, None if out is None else Path(out), **options)[0]


def _chosen(scenario: object, settings: Mapping[str, Any] | None) -> tuple[Mission, BaseScenario]:
    """The mission and the checked scenario, whatever form it was given in."""
    from orbsoc.guidance.scenario_file import BaseScenario, nested
    from orbsoc.missions.registry import MISSIONS, load_scenario, made_scenario

    if isinstance(scenario, BaseScenario):
        changed = scenario.with_changes(**nested(settings)) if settings else scenario
        return MISSIONS[changed.mission], changed
    if isinstance(scenario, Mapping):
        return made_scenario(scenario, settings)
    if isinstance(scenario, str | PathLike):
        return load_scenario(scenario, settings)
    raise TypeError(
        f"`scenario` is of type {type(scenario).__name__}; it must be a Scenario, a dict of its tables, or a path"
    )
