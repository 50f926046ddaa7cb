"""Records of arrays with one row a point."""

from __future__ import annotations

from dataclasses import field
from typing import Any, ClassVar, Self

import numpy as np

from orbsoc.orbit.array import Flags, Index

Rows = Index | Flags | slice


def column(fill: Any = np.nan, *shape: int, dtype: Any = np.float64) -> Any:
    """A field of a batch: what stands in a row of which nothing is known yet, the shape of a row, and the type."""
    return field(metadata={"fill": fill, "shape": shape, "dtype": dtype})


class Batch:
    """Base of dataclasses whose every field is an array, or such a record, of one row a point."""

    __slots__ = ()
    __dataclass_fields__: ClassVar[dict[str, Any]]

    @classmethod
    def blank(cls, count: int, **known: Any) -> Self:
        """Rows of which nothing is known but the fields that are given: the others are made as `column` says."""
        made = {
            name: np.full((count, *about["shape"]), about["fill"], about["dtype"])
            for name, about in ((each.name, each.metadata) for each in cls.__dataclass_fields__.values())
            if name not in known
        }
        return cls(**known, **made)

    def __getitem__(self, which: Rows) -> Self:
        return type(self)(*(getattr(self, name)[which] for name in self.__dataclass_fields__))

    def put(self, which: Rows, other: Self) -> None:
        """Overwrite rows, in place."""
        for name in self.__dataclass_fields__:
            mine = getattr(self, name)
            if isinstance(mine, Batch):
                mine.put(which, getattr(other, name))
            else:
                mine[which] = getattr(other, name)

    def copy(self) -> Self:
        """A record with arrays of its own."""
        return type(self)(*(getattr(self, name).copy() for name in self.__dataclass_fields__))
