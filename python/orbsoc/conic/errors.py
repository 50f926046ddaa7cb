"""What raises when the input is not a problem (a solve that fails is a status, never an exception)."""

from __future__ import annotations


class ProblemError(ValueError):
    """The data of a problem are not a problem; the message names the argument and its value."""


class SettingsError(ValueError):
    """A setting is out of its range; the message names it and what is allowed."""


class FileError(ValueError):
    """A file does not hold what its schema says; the message names the file, the field and its value."""
