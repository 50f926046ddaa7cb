"""Which versions computed a result."""

from __future__ import annotations

import platform
from importlib import metadata

__version__ = "0.1.0"
"""The version of this package."""

PACKAGES = ("orbsoc", "numpy", "scipy", "clarabel", "matplotlib")


def versions() -> dict[str, str]:
    """Versions of Python and of what computes here; a package that runs from its sources says so."""
    found = {"python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = "from sources"
    return found
