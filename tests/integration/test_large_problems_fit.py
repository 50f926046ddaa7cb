"""Problems with too much microcode for block RAM, not for what may hold it: one as large as the phasing mission's with 181 nodes, and
an MPC of 40 steps."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse

from hw_model import load_partition, load_platform, parse_trace, speedup
from hw_model.area.budget import budget
from orbsoc.conic.problem import Cones, Problem
from orbsoc.conic.settings import Settings
from orbsoc.conic.solution import Status
from orbsoc.hw.emulation import PsScheduler
from orbsoc.hw.exact_cycles import exact_cycles
from scripts.write_mpc_problem import in_three_axes

NODES = 181
STREAMED = {"pl.microcode_memory": "streamed", "pl.storage_depth": "exact"}
ULTRA_RAM = {"pl.storage_memory": "ultra_ram"}


def impulses(seed: int) -> Problem:
    """Least sum of the sizes of 181 velocity changes of which six linear functions are given."""
    effects = np.random.default_rng(seed).standard_normal((6, 3 * NODES))
    changes = np.zeros(3 * NODES)
    changes[:3], changes[-3:] = 1.0, -1.0
    order = np.arange(4 * NODES).reshape(NODES, 4)  # rows of a cone: its size, its change
    columns = np.column_stack([np.arange(NODES), NODES + np.arange(3 * NODES).reshape(NODES, 3)])
    G = sparse.csc_array((-np.ones(4 * NODES), (order.ravel(), columns.ravel())))
    A = sparse.hstack([sparse.csc_array((6, NODES)), sparse.csc_array(effects)], format="csc")
    c = np.concatenate([np.ones(NODES), np.zeros(3 * NODES)])
    return Problem(c=c, A=A, b=effects @ changes, G=G, h=np.zeros(4 * NODES), cones=Cones(q=[4] * NODES))


def test_181_impulses_fit_both_ultrascale_parts_with_streamed_microcode() -> None:
    scheduler = PsScheduler()
    assert scheduler(impulses(0)).status is Status.SOLVED
    trace = parse_trace(scheduler.trace)
    cycles = exact_cycles(scheduler.patterns, settings=scheduler.pattern_settings)
    paper = load_partition("paper")
    for device, settings in (("zu9eg", STREAMED), ("zu7ev", STREAMED | ULTRA_RAM)):
        platform = load_platform(device)
        assert not budget(trace, platform, paper, cycles).fits
        assert budget(trace, platform.with_values(settings), paper, cycles).fits


def test_control_of_40_steps_fits_with_streamed_microcode_at_the_setting_of_its_time() -> None:
    scheduler = PsScheduler()
    found = scheduler(in_three_axes(40), Settings(ordering="nested_dissection"))
    assert found.status is Status.SOLVED
    trace, resident = parse_trace(scheduler.trace), load_partition("resident")
    cycles = exact_cycles(scheduler.patterns, settings=scheduler.pattern_settings)
    wide = {"pl.lanes": 16, "pl.dividers": 4, "pl.clusters": 8, "pl.banks": 32, "pl.stream_ports": 4}
    for shape, microcode, time_ms in ((wide, 8, 1.935), ({}, 2, 4.288)):
        platform = load_platform("zu9eg").with_values(shape)
        assert not budget(trace, platform, resident, cycles).fits
        streamed = platform.with_values(
            {"pl.microcode_memory": "streamed", "pl.stream_bytes_per_cycle": 16.0}
        )
        held = budget(trace, streamed, resident, cycles)
        assert held.fits
        assert held.microcode_bram36 == microcode
        made = speedup(trace, streamed, "resident", cycles=cycles).makespan_ms.nominal
        assert made == pytest.approx(time_ms, abs=5e-4)
