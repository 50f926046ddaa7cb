"""The launch of all servers, one after the other: in the order that costs least, and in the one that costs most.

A server can leave when none stands above it. Each launch is from the same state and pushes as hard; what differs is the
mass, the centre and the inertia of what is left. The cost of a launch depends on what is gone, not on the order in which
it went, so that the best order follows by dynamic programming over the sets of servers that are gone.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from math import prod

from ..model.launch import LaunchError
from ..model.rack import Rack, Slot
from ..model.separation import separated
from ..model.transfer import Transfers, in_plane
from ..scenario import Scenario

MOST_STATES = 1024
"""Sets of servers gone, up to which the orders are compared."""


@dataclass(frozen=True, slots=True)
class Order:
    """Servers in the order of their launches, and the cost of each."""

    slots: tuple[Slot, ...]
    costs: tuple[float, ...]
    total: float


@dataclass(frozen=True, slots=True)
class Sequence:
    """Of all admissible orders, the best and the worst."""

    orders: int
    best: Order
    worst: Order


class Sequencer:
    """Costs of launches by rack and slot, each computed once."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        transfers = Transfers.of(scenario.motion, scenario.longest_s)
        platform = scenario.platform_state()

        @cache
        def cost(rack: Rack, slot: Slot) -> float:
            pair = scenario.pair(rack, slot)
            found = separated(pair, rack.stroke_m(slot), None, platform)
            return transfers.best(in_plane(found.state), scenario.rendezvous.cost).cost

        self.cost = cost

    def order(self, slots: tuple[Slot, ...]) -> Order:
        """A given order, priced. Raises LaunchError for a server that is not there or cannot leave then."""
        rack, costs = self.scenario.rack, []
        for slot in slots:
            if slot not in rack.ready():
                raise LaunchError(f"slot = {list(slot)}: its server is gone, or another stands above it")
            costs.append(self.cost(rack, slot))
            rack = rack.without(slot)
        return Order(slots, tuple(costs), sum(costs))

    def sequence(self) -> Sequence | None:
        """The best and the worst of all orders; None where there are too many sets of servers to compare, or none left.

        Raises LaunchError where a server cannot be launched.
        """
        rack = self.scenario.rack
        heights = [sum(slot[0] == column for slot in rack.servers()) for column in range(1, rack.columns + 1)]
        if not any(heights) or prod(each + 1 for each in heights) > MOST_STATES:
            return None

        @cache
        def count(rack: Rack) -> int:
            ready = rack.ready()
            return sum(count(rack.without(slot)) for slot in ready) if ready else 1

        @cache
        def extreme(rack: Rack, sign: float) -> tuple[float, tuple[Slot, ...]]:
            options = []
            for slot in rack.ready():
                rest, slots = extreme(rack.without(slot), sign)
                options.append((rest + sign * self.cost(rack, slot), (slot, *slots)))
            return min(options, default=(0.0, ()))

        best, worst = (self.order(extreme(rack, sign)[1]) for sign in (1.0, -1.0))
        return Sequence(count(rack), best, worst)
