"""Tutorials and how-to pages say what is true: their commands and code run in order, and print what stands below them.

A page runs in a folder of its own beside the shipped scenarios. In a `text` block … stands for anything, and numbers are near (tests/printed.py).
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.printed import shows

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES = sorted([*DOCS.glob("tutorials/*.md"), *DOCS.glob("how-to/*.md"), DOCS / "index.md"])
FENCE = re.compile(r"^```(\w+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
RUN = {"sh", "python"}
SHOWN = {"toml", "c"}
"""Languages of blocks that are parts of a file; `toml` is read by the commands below it."""
PROGRESS = re.compile(r"^planning.*\n?", re.MULTILINE)


def run_shell(code: str, folder: Path) -> str:
    binary = folder / ".bin" / "orbsoc"
    if not binary.exists():
        binary.parent.mkdir()
        binary.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m orbsoc "$@"\n')
        binary.chmod(0o755)
    path = os.pathsep.join([str(binary.parent), str(Path(sys.executable).parent), os.environ["PATH"]])
    done = subprocess.run(
        ["bash", "-e", "-o", "pipefail"], input=f"exec 2>&1\n{code}", cwd=folder, capture_output=True, text=True, timeout=600,
        env=os.environ | {"PATH": path, "COLUMNS": "100", "TERM": "dumb"}, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
    return PROGRESS.sub("", done.stdout)


def run_python(code: str, page: Path, names: dict[str, object]) -> str:
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(code, str(page), "exec"), names)
    return printed.getvalue()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(DOCS)))
def test_a_page_does_what_it_shows(page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scenarios").symlink_to(ROOT / "scenarios")
    text = page.read_text(encoding="utf-8")
    blocks = FENCE.findall(text)
    assert text.count("\n```") - text.count("```{") - text.count("\n```\n") == len(blocks), "an odd fence"
    names: dict[str, object] = {"__name__": "__main__"}
    printed = ""
    for language, code in blocks:
        if language == "sh":
            printed = run_shell(code, tmp_path)
        elif language == "python":
            printed = run_python(code, page, names)
        elif language == "toml":
            named = re.match(r"# (\S+\.toml)\n", code)
            assert named, "a toml block begins with the name of its file"
            (tmp_path / named[1]).write_text(code, encoding="utf-8")
        elif language == "text":
            assert shows(code, printed), f"{page.name} shows\n{code}\nbut it is\n{printed}"
        else:
            assert language in SHOWN, language
