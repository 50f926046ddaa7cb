"""The vehicle as it is: a dispersed case of the scenario, whose engine may fail, and its navigation."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from orbsoc.guidance.closed_loop import Sensed
from orbsoc.guidance.in_flight import ThrustLoss
from orbsoc.orbit.array import Array

from ..scenario import Scenario
from .motion import Burn, Engine, Field, flown, steps_to


@dataclass(slots=True, eq=False)
class FlyingVehicle:
    """State [r_m, v_m_s] in the axes of plans and mass at `time_s`. `samples` are those of every step, with their times."""

    time_s: float
    state: Array
    mass_kg: float
    dry_kg: float
    engine: Engine
    forces: Field
    loss: ThrustLoss | None
    sigma: Array
    """Of navigation, (6,)."""
    samples: list[tuple[float, ...]] = field(default_factory=list)
    start_kg: float = 0.0
    cutoff_s: float = 0.0
    """When it last had thrust."""

    @classmethod
    def of(cls, case: Scenario, nominal: Scenario) -> FlyingVehicle:
        """The vehicle of a dispersed case, with the field of its scenario."""
        vehicle, cycle = case.vehicle, nominal.guidance
        pole = case.eci_rotation.T @ np.array([0.0, 0.0, 1.0])
        return cls(
            time_s=0.0,
            state=case.launch_inertial(case.initial),
            mass_kg=vehicle.mass_kg,
            start_kg=vehicle.mass_kg,
            dry_kg=vehicle.dry_mass_kg,
            engine=Engine(vehicle.thrust_n, vehicle.mass_flow_kg_s),
            forces=Field.of(case.constants, pole, cycle.drag_area_m2),
            loss=nominal.event,
            sigma=np.repeat([cycle.position_m, cycle.velocity_m_s], 3),
        )

    def advance(self, programme: Burn, until_s: float) -> None:
        """Follow a programme; the engine stops where it has no propellant left."""
        loss = () if self.loss is None else (self.loss.at_s, self.loss.back_s)
        ends = [end for end in loss if self.time_s < end < until_s]
        for end in (*ends, until_s):
            self._burn(programme, end)

    def engine_now(self) -> Engine:
        """With what is left of it."""
        if self.loss is None or not self.loss.lasts(self.time_s):
            return self.engine
        kept, loss = self.engine, self.loss
        return Engine(kept.thrust_n * loss.thrust_kept, kept.flow_kg_s * loss.flow)

    def sense(self, random: np.random.Generator) -> Sensed:
        return Sensed(self.time_s, self.state + self.sigma * random.standard_normal(6))

    def _burn(self, programme: Burn, until_s: float) -> None:
        engine = self.engine_now()
        if engine.flow_kg_s > 0.0:
            empty_s = self.time_s + max(0.0, self.mass_kg - self.dry_kg) / engine.flow_kg_s
            if empty_s < until_s - 1e-9:
                if empty_s > self.time_s:
                    self._step(programme, empty_s, engine)
                engine = Engine(0.0, 0.0)
        if until_s > self.time_s:
            self._step(programme, until_s, engine)

    def _step(self, programme: Burn, until_s: float, engine: Engine) -> None:
        times, all_times = steps_to(self.time_s, until_s)
        vectors = programme.vectors(all_times).tolist()
        states = flown(self.state.tolist(), self.mass_kg, times, vectors, engine, self.forces)
        rows = zip(times, states, strict=True)
        self.samples += [(t, *state) for t, state in (rows if not self.samples else list(rows)[1:])]
        self.state = np.array(states[-1])
        self.mass_kg -= engine.flow_kg_s * (until_s - self.time_s)
        self.cutoff_s = until_s if engine.thrust_n > 0.0 else self.cutoff_s
        self.time_s = until_s
