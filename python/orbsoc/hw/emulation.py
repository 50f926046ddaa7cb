"""The emulated computer with the hardware model's unit latencies, so that its traces can be priced."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from orbsoc import _core
from orbsoc.conic.settings import Settings
from orbsoc.ps import scheduler
from orbsoc.ps.registers import WORD_MASK
from orbsoc.ps.trace import Latencies, method_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from hw_model.timing.control_program import ControlProgram
    from orbsoc.conic.problem import Problem
    from orbsoc.ps.program import BusyClocks

    from .schedules import Engine

LATENCY_PRESETS = ("orbsoc_rtl", "vendor_ip")
"""Families of floating-point units whose critical paths a trace carries; their numbers are hw_model's."""


def operation_latencies(datapath: str = "f64") -> dict[str, dict[str, int]]:
    """Cycles of every operation code, for each preset; what critical paths are measured in.

    Arithmetic takes its unit's latency from hw_model's presets; c ± a·b is a multiplication and then an
    addition. Assumed: sign changes, copies, selections and comparisons (of the words, as integers) take 1 cycle.
    """
    from hw_model.platform.presets import preset  # loaded only when a trace is made

    one_cycle = dict.fromkeys(("move", "neg", "abs", "min", "max", "compare", "and", "select"), 1)
    out = {}
    for name in LATENCY_PRESETS:
        units = preset("latency", name)[datapath]
        add, mul, div, sqrt = (
            int(units[f"{unit}_cycles"]["value"]) for unit in ("add", "mul", "div", "sqrt")
        )
        both = mul + add
        arithmetic = {"mul": mul, "add": add, "sub": add, "mul_add": both, "mul_sub": both, "div": div}
        out[name] = {**one_cycle, **arithmetic, "sqrt": sqrt}
    return out


def resident_program(*, joined: bool = True) -> ControlProgram:
    """The control program of the solver's step lists; with `joined`, an iteration's stages share streams."""
    from hw_model.timing.control_program import control_program  # loaded only when it is asked for
    from hw_model.timing.trace import Method

    return control_program(Method.model_validate(method_of(_core)), joined=joined)


def _clocks_on(engine: Engine, program: ControlProgram | None) -> Callable[[Problem, Settings], BusyClocks]:
    from .busy_clocks import busy_clocks  # loaded only when it is asked for

    streams = () if program is None else program.streams
    return lambda problem, settings: busy_clocks(problem, settings, engine, streams=streams)


class PsScheduler(scheduler.PsScheduler):
    """Python plays the PS: a callable that solves stage by stage through the register file of an emulated PL.

    The answer has the bits of `orbsoc.solve`. `settings` and `overrides` (fields of `Settings`) are the default of
    every call; a call's own come before them. `latencies` (preset → operation → cycles) replaces
    `operation_latencies()` in the trace. `every_ordering`: the order of elimination of every solve, whatever its own
    settings say. With `resident`, the emulated PL has all seven modules and runs whole attempts by itself, an iteration's
    stages as streams; the PS only starts them, and restarts. `limit_clocks` of an `engine`, 1 to 2³² − 1: the PL stops a launch that is busy
    for more of its clocks, and the solve raises `CycleLimit`.

    >>> from orbsoc import Cones, Problem
    >>> ps = PsScheduler(tol=1e-9)
    >>> ps(Problem(c=[1.0], G=[[-1.0]], h=[-2.0], cones=Cones(l=1))).status.name
    'SOLVED'
    >>> len(ps.trace["solves"])
    1
    """

    def __init__(
        self,
        settings: Settings | None = None,
        *,
        latencies: Latencies | None = None,
        every_ordering: str | None = None,
        resident: bool = False,
        engine: Engine | None = None,
        limit_clocks: int | None = None,
        **overrides: Any,
    ) -> None:
        if (engine is None) != (limit_clocks is None):
            raise ValueError(f"limit_clocks = {limit_clocks} with engine = {engine}: give both, or neither")
        if limit_clocks is not None and not (
            isinstance(limit_clocks, int) and 1 <= limit_clocks <= WORD_MASK
        ):
            raise ValueError(
                f"limit_clocks = {limit_clocks}: allowed is a whole number from 1 to {WORD_MASK}"
            )
        program = resident_program() if resident else None
        super().__init__(
            settings,
            latencies=operation_latencies() if latencies is None else latencies,
            every_ordering=every_ordering,
            program=program,
            busy_clocks=None if engine is None else _clocks_on(engine, program),
            limit_clocks=limit_clocks,
            **overrides,
        )
