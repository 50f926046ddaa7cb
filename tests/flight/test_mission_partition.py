"""A whole mission with its modules on the PL: the plan of the core, bit for bit, and after trouble as well."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import orbsoc
from hw_model import load_partition
from orbsoc.conic.settings import Settings
from orbsoc.hw.schedules import Engine
from orbsoc.missions.reachable_insertion import load_scenario
from orbsoc.missions.reachable_insertion.on_board import on_board
from tests.flight.c_library import ROOT, need
from tests.flight.c_mission import CMission
from tests.flight.stand_in import StandIn, hooked

NODES = 4
"""A grid too coarse for the usual limits: a stand-in runs every stage in Python."""


@pytest.mark.parametrize("partition", ["paper", "resident"])
def test_a_plan_on_the_device_has_the_bits_of_the_core(partition: str, tmp_path: Path) -> None:
    need("gcc")
    limits = {"thrust_excess": 0.1, "angular_momentum_rel": 1e-3, "laplace_rel": 1e-3}
    changes = {"method": {"nodes": NODES, "max_nodes": NODES}, "verification": limits}
    scenario = load_scenario(ROOT / "scenarios" / "rec1.toml").with_changes(**changes)
    mission, split = on_board(scenario, orbsoc.solve), load_partition(partition)
    engine, folder = Engine(lanes=2, banks=8), tmp_path / "c"
    orbsoc.export_c(mission.problem, folder, partition=split, engine=engine, mission=mission)
    own = [
        *(folder / "driver").glob("*.c"),
        folder / "pl_program.c",
        ROOT / "tests" / "flight" / "pl_harness.c",
    ]
    beside = [f"-I{folder}/driver", "-DORBSOC_EXTERNAL_ACCESS", *map(str, own)]
    on_core = CMission(folder, tmp_path / "core.so")
    on_device = CMission(folder, tmp_path / "device.so", beside=beside)
    pl = StandIn(mission.problem, Settings(), engine, split)
    kept = hooked(on_device.library, lambda: pl)
    assert on_device.library.pl_attach(on_device.solver, 50, 400) == 0
    start = mission.plans[0].start_si
    wanted = on_core.plan(start)
    found = on_device.plan(start)
    assert (found.exit, found.objections) == ("CONVERGED", 0)
    assert on_device.library.pl_place(on_device.solver) == 1, "on the device"
    assert pl.ran > 0
    assert found.bits == wanted.bits
    np.testing.assert_array_equal(found.controls, mission.plans[0].controls)

    def silent(device: StandIn, _stage: str) -> None:
        device.silent = True

    pl.trouble = silent
    assert on_device.plan(start).bits == wanted.bits
    assert on_device.library.pl_place(on_device.solver) == 3, "fell back"
    assert len(kept) == 2
