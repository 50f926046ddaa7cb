"""A zoo of small conic problems with known answers, and the rescaled twin of each.

`cases()` lists the problems, `rescaled_twins()` the same in other units; every function of the modules below that returns a
`ZooCase` is one case.
"""

from __future__ import annotations

from types import ModuleType

from tests.zoo import cone, false_claims, known, linear, quadratic
from tests.zoo.case import ZooCase
from tests.zoo.rescaled import rescaled_twin

__all__ = ["ZooCase", "cases", "rescaled_twin", "rescaled_twins"]

MODULES = (linear, quadratic, cone, known, false_claims)


def _of(module: ModuleType) -> list[ZooCase]:
    """The cases of a module: its public functions without arguments that return one."""
    found: list[ZooCase] = []
    for name, member in vars(module).items():
        own = getattr(member, "__module__", None) == module.__name__ and not name.startswith("_")
        if own and getattr(member, "__annotations__", None) == {"return": "ZooCase"}:
            found.append(member())
    return found


def cases() -> list[ZooCase]:
    """Every case, in the order of the modules."""
    return [case for module in MODULES for case in _of(module)]


def rescaled_twins() -> list[ZooCase]:
    """The rescaled twin of every case."""
    return [rescaled_twin(case) for case in cases()]
