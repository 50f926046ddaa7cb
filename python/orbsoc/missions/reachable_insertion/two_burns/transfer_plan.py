"""What was planned of two burns, as data: every attempt, the transfer that counts, and what its flight says."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain

import numpy as np

from orbsoc.guidance.mission import PlanStatus
from orbsoc.guidance.scp import Iteration
from orbsoc.orbit import CanonicalUnits, Elements

from ..model.proof import Proof
from ..scenario import Scenario
from ..targets.target import Target
from .limits import SHORTEST
from .search import Attempt
from .transfer import Transfer
from .verification import Verification

NOTHING = 10.0 * SHORTEST
"""Canonical burn up to which one of two burns came out as nothing."""


@dataclass(frozen=True, slots=True)
class PlannedBurn:
    """One burn: when it begins, counted from the scenario's state, how long it takes, and what it gives and costs."""

    ignition_s: float
    duration_s: float
    delta_v_m_s: float
    propellant_kg: float


@dataclass(frozen=True, slots=True, eq=False)
class TransferPlan:
    """Two burns with a coast between them; `best` is to be flown only when `status` is VERIFIED.

    `best` is None where nothing was tried: of a proof, and of an interrupted search.
    """

    scenario: Scenario
    target: Target
    status: PlanStatus
    message: str
    attempts: tuple[Attempt, ...]
    best: Attempt | None
    verification: Verification | None
    proof: Proof | None = None

    @property
    def subproblems(self) -> tuple[Iteration, ...]:
        """Every conic problem solved, over all attempts."""
        return tuple(chain.from_iterable(each.outcome.iterations for each in self.attempts))

    @property
    def transfer(self) -> Transfer | None:
        return None if self.best is None else self.best.transfer

    @property
    def burns(self) -> tuple[PlannedBurn, ...]:
        """The burns in their order; empty where nothing was tried."""
        if self.transfer is None:
            return ()
        time_s, vehicle = CanonicalUnits.of(self.scenario.constants).time_s, self.scenario.vehicle
        now_s, mass_kg = 0.0, vehicle.mass_kg
        found = []
        for coast, duration in zip(self.transfer.coasts, self.transfer.durations, strict=True):
            ignition_s, duration_s = now_s + float(coast) * time_s, float(duration) * time_s
            spent_kg = vehicle.mass_flow_kg_s * duration_s
            delta_v = (
                vehicle.thrust_n / vehicle.mass_flow_kg_s * float(np.log(mass_kg / (mass_kg - spent_kg)))
            )
            found.append(PlannedBurn(ignition_s, duration_s, delta_v, spent_kg))
            now_s, mass_kg = ignition_s + duration_s, mass_kg - spent_kg
        return tuple(found)

    @property
    def time_of_flight_s(self) -> float:
        """All burns together, as of a plan with one burn."""
        return sum(each.duration_s for each in self.burns)

    @property
    def propellant_kg(self) -> float:
        return self.scenario.vehicle.mass_flow_kg_s * self.time_of_flight_s

    @property
    def delta_v_m_s(self) -> float:
        return sum(each.delta_v_m_s for each in self.burns)

    @property
    def ignition_s(self) -> float:
        """Coast on the first orbit before the first burn."""
        return self.burns[0].ignition_s if self.burns else 0.0

    @property
    def coast_s(self) -> float:
        """Between the burns."""
        if not self.burns:
            return 0.0
        first, second = self.burns
        return second.ignition_s - first.ignition_s - first.duration_s

    @property
    def total_time_s(self) -> float:
        """From the scenario's state to the last cut-off."""
        return self.burns[-1].ignition_s + self.burns[-1].duration_s if self.burns else 0.0

    @property
    def one_is_enough(self) -> bool:
        """Whether one of the burns came out as nothing."""
        return self.transfer is not None and bool(self.transfer.durations.min() <= NOTHING)

    @property
    def orbit(self) -> Elements | None:
        """The planned orbit, ECI; None where no transfer was flown."""
        return None if self.verification is None else self.verification.planned_orbit
