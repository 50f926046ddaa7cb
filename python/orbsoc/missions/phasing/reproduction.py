"""`orbsoc reproduce 003`."""

from pathlib import Path

from orbsoc.guidance.mission import PaperRow


def reproduce(scenarios: Path) -> tuple[PaperRow, ...]:
    return ()
