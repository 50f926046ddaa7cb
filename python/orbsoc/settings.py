"""Solver settings: one frozen record, the same names as the Rust `Settings`."""

from __future__ import annotations

from dataclasses import dataclass, fields


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """What a solve may spend and how exact it must be.

    `tol` is the relative tolerance of docs/algorithm.md's status table (primal and dual
    residual, gap); `tol_inaccurate` the one at which `SOLVED_INACCURATE` is reported.
    """

    tol: float = 1e-8
    tol_inaccurate: float = 1e-5
    max_iterations: int = 100
    max_time_s: float = float("inf")
    verbose: bool = False
    static_regularization: float = 1e-8
    pivot_floor: float = 1e-13
    dynamic_regularization: float = 2e-7
    refinement_tol: float = 1e-12
    refinement_share: float = 1e-3
    refinement_max: int = 10
    step_fraction: float = 0.99
    ruiz_passes: int = 4

    def __post_init__(self) -> None:
        for name in ("tol", "tol_inaccurate", "max_time_s"):
            value = getattr(self, name)
            if not value > 0.0:
                raise ValueError(f"settings: {name} = {value!r} must be a positive number")
        if self.max_iterations < 1:
            raise ValueError(f"settings: max_iterations = {self.max_iterations!r} must be at least 1")

    def __str__(self) -> str:
        return "\n".join(f"{f.name:<18} {getattr(self, f.name)}" for f in fields(self))
