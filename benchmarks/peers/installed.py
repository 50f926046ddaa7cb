"""Peers that may not be installed."""

from __future__ import annotations

import importlib
from importlib.metadata import PackageNotFoundError, version
from typing import Any


class MissingSolver(ImportError):
    """A peer that is not installed; `make bench` installs them all."""


def module(name: str) -> tuple[Any, str]:
    """A peer's module, and the version of its distribution."""
    try:
        return importlib.import_module(name), version(name)
    except (ImportError, PackageNotFoundError):
        raise MissingSolver(f"{name} is not installed (`make bench` installs it): left out") from None
