"""Parts of a task on disk as they come, so that a task that begins again computes only what is missing.

A task whose parts follow from one another is deterministic but for its results: the first parts of a second run are answered from
the file, in order. A record is its length, its checksum and a pickle; a torn last one is dropped. Reading admits arrays and the
classes of the package that is named, nothing else.
"""

from __future__ import annotations

import io
import pickle
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, BinaryIO, TypeVar

T = TypeVar("T")

HEAD = struct.Struct("<QI")
ARRAYS = {"_reconstruct", "ndarray", "dtype", "_frombuffer", "scalar"}
"""What a pickle of NumPy arrays names."""


class Journal:
    """The results of a task's parts in `path`, to be closed. `key` says what task of what version; a file of another is begun
    anew. Without a disk that takes it the parts are computed all the same."""

    def __init__(self, path: Path, key: str, package: str) -> None:
        self._known, self._file = list[Any](), None
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with path.open("ab"):
                pass
            stream = path.open("r+b")
        except OSError:
            return
        self._file = stream
        records = _records(stream, package)
        if records and records[0] == key:
            self._known = records[:0:-1]
        else:
            stream.seek(0)
            stream.truncate()
            self._append(key)

    def part(self, compute: Callable[[], T]) -> T:
        """The next part: from the file, or computed and put there."""
        if self._known:
            found: T = self._known.pop()
            return found
        found = compute()
        self._append(found)
        return found

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def _append(self, value: Any) -> None:
        if self._file is None:
            return
        data = pickle.dumps(value, protocol=4)
        try:
            self._file.write(HEAD.pack(len(data), zlib.crc32(data)) + data)
            self._file.flush()
        except OSError:  # a full disk is reported when the shard is written
            self.close()


def _records(stream: BinaryIO, package: str) -> list[Any]:
    """All whole records; the stream is left, and cut off, behind them."""
    found: list[Any] = []
    end = 0
    while len(head := stream.read(HEAD.size)) == HEAD.size:
        size, checksum = HEAD.unpack(head)
        data = stream.read(size)
        if len(data) != size or zlib.crc32(data) != checksum:
            break
        try:
            found.append(_Reader(data, package).load())
        except (pickle.UnpicklingError, AttributeError, ImportError, TypeError):
            break
        end = stream.tell()
    stream.seek(end)
    stream.truncate()
    return found


class _Reader(pickle.Unpickler):
    """Admits arrays and the classes of one package."""

    def __init__(self, data: bytes, package: str) -> None:
        super().__init__(io.BytesIO(data))
        self._package = package

    def find_class(self, module: str, name: str) -> Any:
        own = module.startswith(f"{self._package}.") and "." not in name
        if not own and not (module.partition(".")[0] == "numpy" and name in ARRAYS):
            raise pickle.UnpicklingError(f"{module}.{name}: not in a journal of {self._package}")
        found = super().find_class(module, name)
        if own and not (isinstance(found, type) and found.__module__ == module):
            raise pickle.UnpicklingError(f"{module}.{name}: no class of {self._package}")
        return found
