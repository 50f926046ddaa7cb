"""A target orbit, given whole or with elements left free: both answer to the same names."""

from __future__ import annotations

from .free_target import FreeTarget
from .target_orbit import TargetOrbit

AnyTarget = TargetOrbit | FreeTarget
