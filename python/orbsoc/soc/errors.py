"""What the simulated computer refuses."""

from __future__ import annotations

from orbsoc.rtl.validation import RtlError


class SocError(RtlError):
    """A computer that does not build, or a run that does not end as it should."""
