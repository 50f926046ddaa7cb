"""A problem with too much microcode for block RAM, not for what may hold it: one as large as the phasing mission's with 181 nodes."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from hw_model import load_partition, load_platform, parse_trace
from hw_model.area.budget import budget
from orbsoc.conic.problem import Cones, Problem
from orbsoc.conic.solution import Status
from orbsoc.hw.emulation import PsScheduler
from orbsoc.hw.exact_cycles import exact_cycles

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
