"""The name that was perhaps meant."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


def nearest(name: str, known: Iterable[str]) -> str:
    """The known name that is most like `name`, without regard to case; empty where none is.

    >>> nearest("pasive-safety", ["passive_safety", "phasing"])
    'passive_safety'
    """
    plain = {_plain(each): each for each in known}
    found = get_close_matches(_plain(name), plain, n=1, cutoff=0.5)
    return plain[found[0]] if found else ""


def did_you_mean(name: object, known: Iterable[str]) -> str:
    """` Did you mean …?`, to be put after a sentence; empty where no known name is like it."""
    found = nearest(name, known) if isinstance(name, str) else ""
    return f" Did you mean {found}?" if found else ""


def _plain(name: str) -> str:
    return name.lower().replace("-", "_").replace(" ", "_")
