"""What a mission's Monte Carlo gives beside what another program draws of the same errors, for `orbsoc reproduce --full`."""

from __future__ import annotations

import numpy as np

from orbsoc.orbit.array import Array

from .mission import BROKEN, PaperRow

MEAN, P95 = 0.10, 0.15
"""Within which two samples agree, relative."""
SIGMAS = 3.0
"""Within which two shares of as many draws agree."""


def statistics_row(
    quantity: str, values: Array, unit: str, reason: str, *, p95: float, mean: float | None = None
) -> PaperRow:
    """95th percentile, and mean where one is known, of draws (runs,)."""
    rows = [("95 %", float(np.quantile(values, 0.95)), p95, P95)]
    if mean is not None:
        rows.insert(0, ("mean", float(values.mean()), mean, MEAN))
    return sampled_row(
        quantity,
        ", ".join(f"{name} {ours:.4g} {unit}" for name, ours, _, _ in rows),
        f"{reason}; another program draws {' and '.join(f'{known:g} {unit}' for _, _, known, _ in rows)}",
        ", ".join(f"±{100 * share:g} %" for *_, share in rows),
        near=all(abs(ours - known) <= share * known for _, ours, known, share in rows),
    )


def share_row(quantity: str, count: int, runs: int, known: float, reason: str) -> PaperRow:
    """A share of draws beside the one `known` of as many others; a known 0 must be met."""
    deviation = SIGMAS * float(np.sqrt(2.0 * known * (1.0 - known) / runs))
    return sampled_row(
        quantity, f"{count} of {runs}", f"{reason}; another program draws {100 * known:g} %", f"±{100 * deviation:.1f} %",
        near=abs(count / runs - known) <= deviation,
    )  # fmt: skip


def sampled_row(
    quantity: str, ours: str, reason: str, tolerance: str, *, near: bool, verdict: str = "inferred"
) -> PaperRow:
    """Of errors that the paper does not give, and what follows from them."""
    return PaperRow(
        quantity, "beyond the paper", "not printed", ours, verdict if near else BROKEN, reason, tolerance
    )
