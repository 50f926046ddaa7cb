"""What a narrower datapath on the PL does to a solve: iterations, verified residuals, and a trace to price.

Stages of the chosen modules compute with few significant bits on words of their own (`_core.MixedEngine`); statistics,
termination and every module that is not chosen stay in binary64 on the PS. The answer is verified in binary64 on the
data as given.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from orbsoc import _core
from orbsoc.conic.settings import Settings
from orbsoc.conic.verify import verify
from orbsoc.ps.driver import Driver
from orbsoc.ps.events import PsRecord
from orbsoc.ps.pl import ProgrammableLogic
from orbsoc.ps.segments import Method
from orbsoc.ps.trace import TraceRecorder
from orbsoc.solving.solver import solution_of

from .emulation import operation_latencies

if TYPE_CHECKING:
    from orbsoc.conic.problem import Problem
    from orbsoc.conic.solution import Solution

BITS = (53, 24, 20, 16, 12)
"""Significant bits that there is an arithmetic for; 53 is binary64, 24 binary32."""


@dataclass(frozen=True, slots=True, eq=False)
class NarrowRun:
    """One solve with a narrow datapath. Residuals are those of independent verification, in binary64."""

    bits: int
    modules: tuple[str, ...]
    settings: Settings
    solution: Solution
    primal_residual: float
    dual_residual: float
    gap: float
    trace: dict[str, Any]

    @property
    def worst(self) -> float:
        """The largest of residuals and gap."""
        return max(self.primal_residual, self.dual_residual, self.gap)


def narrow_settings(settings: Settings, bits: int) -> Settings:
    """Settings whose regularisation a factor of `bits` significant bits can see, with refinement to undo it.

    The static regularisation is 2 √2^(1 − bits), twice the square root of the spacing of numbers. With less, rounding
    errors swamp the pivots; with more, refinement takes too many steps, for each gains a factor of about K's smallest
    eigenvalue over the regularisation. Scanned on mission 004 with a factor of 24 bits: half of it (3.5e-4) ends between
    1e-6 and 4e-6 for refinement factors of 0.001 to 0.03; 7e-4 reaches 2e-7 to 7e-7 in one or two iterations more than
    binary64; 1e-2 fails. The tolerance stays.
    """
    if bits >= 53:
        return settings
    shift = 2.0 * 2.0 ** ((1 - bits) / 2)
    return replace(
        settings,
        static_regularization=shift,
        pivot_floor=0.01 * shift,
        dynamic_regularization=10.0 * shift,
        refinement_max=max(50, settings.refinement_max),
    )


def solve_narrow(
    problem: Problem, bits: int, modules: Sequence[str], settings: Settings | None = None
) -> NarrowRun:
    """Solve with `bits` significant bits in `modules`, scheduled by the emulated PS through the register file.

    One attempt: a stall does not restart the solve. Raises ValueError for bits or modules that do not exist, and what `orbsoc.solve` raises for wrong data.
    """
    if bits not in BITS:
        allowed = ", ".join(map(str, BITS))
        raise ValueError(f"bits = {bits}: there is no such arithmetic; allowed: {allowed}")
    chosen = narrow_settings(settings or Settings(), bits)
    narrow = () if bits == 53 else tuple(modules)
    native = _core.MixedEngine(problem, chosen, 24 if bits == 53 else bits, list(narrow))
    method = Method.from_core(_core)
    pl = ProgrammableLogic(method, native.run)
    started = time.perf_counter()
    Driver(method, native, pl, words=native.buffer_words(), record=PsRecord()).run()
    solution = solution_of(native.finish(time.perf_counter() - started))
    checked = verify(problem, solution)
    return NarrowRun(
        bits, tuple(modules), chosen, solution, checked.pres, checked.dres, checked.gap,
        _trace(problem, chosen, native, solution, bits),
    )  # fmt: skip


def _trace(
    problem: Problem, settings: Settings, native: _core.MixedEngine, solution: Solution, bits: int
) -> dict[str, Any]:
    """The record of the solve; words and units of the PL are binary32's for every narrow arithmetic."""
    datapath = "f64" if bits == 53 else "f32"
    recorder = TraceRecorder(_core, operation_latencies(datapath))
    recorder.add(problem, settings, native, solution)
    return recorder.as_dict() | {"datapath": datapath, "ps_datapath": "f64"}
