"""Records of arrays with one row a point."""

from __future__ import annotations

from typing import Any, ClassVar, Self

from orbsoc.orbit.array import Flags, Index

Rows = Index | Flags | slice


class Batch:
    """Base of dataclasses whose every field is an array, or such a record, of one row a point."""

    __slots__ = ()
    __dataclass_fields__: ClassVar[dict[str, Any]]

    def __getitem__(self, which: Rows) -> Self:
        return type(self)(*(getattr(self, name)[which] for name in self.__dataclass_fields__))

    def put(self, which: Rows, other: Self) -> None:
        """Overwrite rows, in place."""
        for name in self.__dataclass_fields__:
            getattr(self, name)[which] = getattr(other, name)

    def copy(self) -> Self:
        """A record with arrays of its own."""
        return type(self)(*(getattr(self, name).copy() for name in self.__dataclass_fields__))
