"""Motion of a chaser relative to a target. State [r_m, v_m_s] in the target's frame (R, T, N): R outward, T along the
motion, N along the angular momentum, turning with the target; N, R, T are −y, −z, x of the nadir-pointing LVLH frame."""

from .clohessy_wiltshire import ClohessyWiltshire
from .drift import DriftEllipse
from .local_frame import LVLH, absolute_state, local_frame, relative_state
from .motion import LinearMotion
from .reference import AlongReference
from .tabulated import Tabulated
from .yamanaka_ankersen import YamanakaAnkersen

__all__ = [
    "LVLH",
    "AlongReference",
    "ClohessyWiltshire",
    "DriftEllipse",
    "LinearMotion",
    "Tabulated",
    "YamanakaAnkersen",
    "absolute_state",
    "local_frame",
    "relative_state",
]
