"""The prices that the PS's work may have on a platform: operations at an assumed rate, or executed instructions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hw_model.timing.instructions import can_be_counted
from hw_model.timing.ps import PRICES

if TYPE_CHECKING:
    from hw_model.platform.platform import Platform
    from hw_model.timing.trace import Trace


def at_each_price(platform: Platform, trace: Trace) -> tuple[Platform, ...]:
    """The platform at each price that it has for the trace: without instruction counts there is one."""
    counted = all(map(can_be_counted, trace.patterns))
    return tuple(
        platform.with_value("ps.price", price)
        for price in PRICES
        if counted or price != "executed_instructions"
    )
