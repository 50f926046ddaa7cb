"""`orbsoc.export_c`."""

class FlightError(ValueError):
    """What cannot be exported, or where."""


def export_c() -> None: ...
