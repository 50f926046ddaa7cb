"""What an attempt of the search may be said to be."""

from __future__ import annotations

import enum


class Claim(enum.Enum):
    """The claim on an attempt; none of them says that no burn is better."""

    BEST_FOUND = "the end of a sequence of convex problems: a local optimum of its start"
    NOTHING_TO_BURN = "the vehicle is on its target orbit: no burn is shorter than 0 s"
    SMOOTH_TURN = "a law that turns smoothly, shortened: the shortest burn turns faster than the grid follows"
    FAST_TURN = "about as fast a turn as the finest grid follows: the shortest burn turns faster"
