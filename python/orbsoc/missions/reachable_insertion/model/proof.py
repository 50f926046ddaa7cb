"""Bounds that no burn escapes, whatever its steering: the proofs behind INFEASIBLE.

With r ≥ R on the whole burn (it may not pass below the ground), Δv = ∫F/m dt over the longest burn T:
- w = √(v² + 2μ/R − 2μ/r) obeys |ẇ| ≤ F/m, for d(v²/2 − μ/r)/dt = (F/m) u·v and v ≤ w: the energy that a burn can end with
  lies between those of w₀ ± Δv; coasts leave w alone, so that the same holds of several burns. With J2 a coast keeps
  v²/2 − μ/r + U, and U lies within −μJ₂/2R and μJ₂/R: w² changes by 3μJ₂/R at most;
- |H_f − H₀| ≤ r_max Δv, for dH/dt = (F/m) r × u, with r_max from r̈ ≤ v_t²/r − μ/r² + F/m and v ≤ w₀ + Δv.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orbsoc.guidance.powered_flight import Burn

from ..targets.target import Target

GROUND = 1.0
"""Canonical radius that no burn may pass below."""


def oblate_coast(j2: float) -> float:
    """By how much a coast with J2 above the ground can change w², canonical."""
    return 3.0 * abs(j2) * (1.0 + 1e-9)


@dataclass(frozen=True, slots=True)
class Proof:
    """A quantity that the target needs more of than any burn gives; both are canonical speeds."""

    what: str
    needed: float
    available: float


def proof_of_infeasibility(
    burn: Burn, target: Target, duration: float, *, coasts: bool = False, drift: float = 0.0
) -> Proof | None:
    """Why no burn of at most `duration` ends on the target; None for no proof.

    With `coasts` it is a proof for several burns of that duration together, with coasts before and between them that change w² by
    `drift` at most, all together: w ↦ √(w² + drift) lifts a small w most, so that all of it may be added to the smaller of both ends.
    """
    if burn.flow * duration > 1.0 - 1e-9:  # a vehicle without dry mass has no bound
        return None
    r, v = burn.start[:3], burn.start[3:]
    radius = float(np.linalg.norm(r))
    delta_v = -burn.acceleration / burn.flow * float(np.log1p(-burn.flow * duration))
    has = delta_v * (1.0 + 1e-6) + 1e-9  # so that rounding proves nothing
    first = float(np.sqrt(max(0.0, float(v @ v) + 2.0 / GROUND - 2.0 / radius)))
    fastest = first + delta_v
    lift = max(0.25 * fastest**4, fastest**2 / GROUND - 1.0 / GROUND**2, 0.0)
    climb = max(0.0, float(r @ v) / radius) * duration + 0.5 * lift * duration**2 + delta_v * duration
    highest = radius + min(climb, fastest * duration)
    h = np.cross(r, v)
    needed = target.momentum_gap(h)
    if not coasts and needed > highest * has:
        return Proof("turning and changing the angular momentum", needed / highest, delta_v)
    energy = target.energy
    if energy is not None:
        last = float(np.sqrt(max(0.0, 2.0 * (energy + 1.0 / GROUND))))
        needed = max(last, first) - float(np.sqrt(min(last, first) ** 2 + drift))
        if needed > has:
            return Proof("changing the energy", needed, delta_v)
    return None
