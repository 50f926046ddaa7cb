"""Files that are written whole or not at all."""

from __future__ import annotations

import os
import stat
import threading
from pathlib import Path


def write_atomically(path: str | os.PathLike[str], content: str | bytes, *, durable: bool = False) -> None:
    """Write `content` (text as UTF-8) beside `path`, then rename; raises OSError, and then leaves what was there.

    A link stays one, a file keeps its mode, and what is no file (a pipe, a device) is written to. With `durable` the
    content is on the disk before the rename.
    """
    target = Path(os.path.realpath(path))
    data = content.encode() if isinstance(content, str) else content
    if target.exists() and not target.is_file():
        target.write_bytes(data)
        return
    beside = target.with_name(f".{target.name}.{os.getpid()}.{threading.get_ident()}")
    try:
        with beside.open("wb") as stream:
            stream.write(data)
            if durable:
                stream.flush()
                os.fsync(stream.fileno())
        if target.exists():
            beside.chmod(stat.S_IMODE(target.stat().st_mode))
        beside.replace(target)
    except BaseException:
        beside.unlink(missing_ok=True)
        raise
