"""Orbital mathematics shared by the missions. SI units; angles in radians."""

from .attitude import pitch_yaw, thrust_direction
from .constants import EARTH, MARS, MOON, ConstantsSet
from .elements import Elements, at_true_anomaly, elements_from_state, state_from_elements
from .frames import LaunchFrame, eci_from_launch_inertial, rotate_state
from .propagate import PropagationError, Thruster, propagate_burn
from .units import CanonicalUnits
from .vectors import (
    angular_momentum,
    angular_momentum_jacobian,
    laplace_jacobian,
    laplace_vector,
    specific_energy,
)

__all__ = [
    "EARTH",
    "MARS",
    "MOON",
    "CanonicalUnits",
    "ConstantsSet",
    "Elements",
    "LaunchFrame",
    "PropagationError",
    "Thruster",
    "angular_momentum",
    "angular_momentum_jacobian",
    "at_true_anomaly",
    "eci_from_launch_inertial",
    "elements_from_state",
    "laplace_jacobian",
    "laplace_vector",
    "pitch_yaw",
    "propagate_burn",
    "rotate_state",
    "specific_energy",
    "state_from_elements",
    "thrust_direction",
]
