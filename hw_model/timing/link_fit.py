"""The link preset's parameters, fitted to published measurements on some clocks and judged on the others.

Every law is linear in its parameters, so each fit is a weighted least-squares problem in closed form; the weights
make errors relative. docs/decisions/0014-link-model.md has the reasons and the result.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import link

if TYPE_CHECKING:
    from hw_model.platform.sections import Link

FIXED_NS = 1960.0
"""Fixed cost of a DMA transfer, measured separately in the same source."""


@dataclass(frozen=True, slots=True)
class Point:
    """One published measurement beside what the link model says of it."""

    quantity: str
    pl_clock_mhz: float
    measured: float
    modelled: float
    held_out: bool

    @property
    def error(self) -> float:
        """Relative error of the model."""
        return self.modelled / self.measured - 1.0


@cache
def measurements() -> dict[str, Any]:
    """The published figures, as their file has them."""
    path = Path(__file__).parent / "zynq7000_link.toml"
    return tomllib.loads(path.read_text(encoding="utf-8"))


def fit() -> dict[str, float]:
    """Link parameters from the clocks that are not held out, by name as in `[link.zynq7000]`.

    Times per access and per byte are straight lines in the PL's cycle time; DMA moves a fixed number of bytes each
    PL cycle once its fixed cost is over.
    """
    size = measurements()["size_bytes"]
    read = _line("register_read_ns", lambda ns: ns)
    write = _line("core_write_mb_s", lambda mb_s: 1000.0 / mb_s)
    back = _line("core_read_mb_s", lambda mb_s: 1000.0 / mb_s)
    posted = _fitted("register_write_ns")[1]
    return {
        "register_write_ns": float(np.mean(posted)),
        "register_read_fixed_ns": read[0],
        "register_read_pl_cycles": read[1],
        "core_write_ns_per_byte": write[0],
        "core_write_pl_cycles_per_byte": write[1],
        "core_read_ns_per_byte": back[0],
        "core_read_pl_cycles_per_byte": back[1],
        "dma_to_pl_bytes_per_pl_cycle": _per_cycle("dma_to_pl_mb_s", size),
        "dma_to_ps_bytes_per_pl_cycle": _per_cycle("dma_to_ps_mb_s", size),
    }


def judge(links: Link) -> list[Point]:
    """Every published figure beside what `links` says of it."""
    size = int(measurements()["size_bytes"])

    def rate(picoseconds: int) -> float:
        return float(size / (picoseconds * 1e-6))

    models: dict[str, Callable[[float], float]] = {
        "register_read_ns": lambda mhz: link.register_read(links, mhz) / 1000,
        "register_write_ns": lambda mhz: link.register_write(links, mhz) / 1000,
        "core_write_mb_s": lambda mhz: rate(link.core_copy(links, mhz, size, "pl")),
        "core_read_mb_s": lambda mhz: rate(link.core_copy(links, mhz, size, "ps")),
        "dma_to_pl_mb_s": lambda mhz: rate(link.dma(links, mhz, size, "pl")),
        "dma_to_ps_mb_s": lambda mhz: rate(link.dma(links, mhz, size, "ps")),
    }
    held_out = set(measurements()["held_out_mhz"])
    return [
        Point(quantity, mhz, measured, model(mhz), mhz in held_out)
        for quantity, model in models.items()
        for mhz, measured in zip(*(measurements()[quantity][key] for key in ("mhz", "value")), strict=True)
    ]


def _fitted(quantity: str) -> tuple[np.ndarray, np.ndarray]:
    """(cycle time in ns, value) at the clocks that the fit may see."""
    rows = measurements()[quantity]
    held_out = set(measurements()["held_out_mhz"])
    seen = [k for k, mhz in enumerate(rows["mhz"]) if mhz not in held_out]
    mhz, value = (np.array([rows[key][k] for k in seen], dtype=float) for key in ("mhz", "value"))
    return 1000.0 / mhz, value


def _line(quantity: str, time_of: Callable[[np.ndarray], np.ndarray]) -> tuple[float, float]:
    """(fixed part ≥ 0 in ns, PL cycles) of a time that is a straight line in the cycle time."""
    cycle_ns, value = _fitted(quantity)
    time = time_of(value)
    design = np.column_stack([np.ones_like(cycle_ns), cycle_ns]) / time[:, None]
    fixed, cycles = np.linalg.lstsq(design, np.ones_like(time), rcond=None)[0]
    if fixed < 0.0:  # no access is faster than its own cycles: a line through the origin instead
        fixed, cycles = 0.0, float(np.linalg.lstsq(design[:, 1:], np.ones_like(time), rcond=None)[0][0])
    return float(fixed), float(cycles)


def _per_cycle(quantity: str, size: int) -> float:
    """Bytes each PL cycle of a DMA transfer, its fixed cost removed."""
    cycle_ns, mb_s = _fitted(quantity)
    streaming_ns = size * 1000.0 / mb_s - FIXED_NS
    return float(np.mean(size * cycle_ns / streaming_ns))
