"""The reachable domain as a product: solve it, load it, ask it.

>>> domain = orbsoc.reach.load("out/paper004_reach")  # doctest: +SKIP
>>> domain.can_reach(orbit, exact=True).verdict  # doctest: +SKIP
<Verdict.WITHIN: 'within reach'>
"""

from .asked import OrbitError
from .limits import TiltLimit
from .margin import Margin, Verdict
from .results import ReachableDomain, load
from .shortest import ShortestBurn

__all__ = ["Margin", "OrbitError", "ReachableDomain", "ShortestBurn", "TiltLimit", "Verdict", "load"]
