"""The reachable domain as a product: solve it, load it, ask it.

>>> domain = orbsoc.reach.load("out/paper004_reach")  # doctest: +SKIP
>>> domain.can_reach(orbit).words  # doctest: +SKIP
'within reach: the plane lies 4.1 degrees (± 0.01) inside the edge at its perigee height, …'
"""

from .limits import TiltLimit
from .margin import Margin
from .results import ReachableDomain, load

__all__ = ["Margin", "ReachableDomain", "TiltLimit", "load"]
