"""The reachable domain as a product: solve it, load it, ask it.

>>> domain = orbsoc.reach.load("out/paper004_reach")  # doctest: +SKIP
>>> domain.can_reach(orbit, exact=True).verdict  # doctest: +SKIP
<Verdict.WITHIN: 'within reach'>
"""

from .missions.reachable_domain.search.query.margin import Margin, OrbitError, Verdict
from .missions.reachable_domain.search.query.results import ReachableDomain, load
from .missions.reachable_domain.search.query.shortest_burn import ShortestBurn
from .missions.reachable_domain.search.query.tilt_limit import TiltLimit

__all__ = ["Margin", "OrbitError", "ReachableDomain", "ShortestBurn", "TiltLimit", "Verdict", "load"]
