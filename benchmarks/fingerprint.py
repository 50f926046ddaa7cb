"""Which build of orbsoc a result belongs to."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

import orbsoc


@cache
def fingerprint() -> str:
    """Twelve digits of the installed package's files, the compiled core included."""
    digest = hashlib.sha256()
    package = Path(orbsoc.__file__).parent
    for path in sorted([*package.rglob("*.py"), *package.glob("_core*")]):
        digest.update(str(path.relative_to(package)).encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()[:12]
