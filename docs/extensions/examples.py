"""The notebooks of examples/ as pages with their outputs, run while the site is built.

A notebook is a Python file in Jupytext's percent format: a cell begins at `# %%`, one of text at `# %% [markdown]`. What one gives is
kept in `out/examples` under a hash of its file and of the sources, and made anew when either changes.
"""

from __future__ import annotations

import ast
import contextlib
import io
import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
NAMES = ("my_vehicle", "solve_cones", "move_a_module", "partition_experiment", "flight_code", "closed_loop")
"""Notebooks in their order on the site."""
INDEX = """# Examples

Notebooks that you can open as they are: Python files of the folder `examples/` in percent format, which VS Code, PyCharm and Spyder
run cell by cell, and Jupyter with Jupytext. Each takes seconds. They were run while this site was built, and a test runs them.

```{{toctree}}
:maxdepth: 1

{pages}
```
"""


@dataclass(frozen=True)
class Cell:
    """A cell of text, or of code."""

    is_text: bool
    source: str


@dataclass(frozen=True)
class Output:
    """What a cell of code gives: what it prints, its last expression (HTML where it has that), and its figures (PNG)."""

    printed: str
    html: str
    figures: tuple[bytes, ...]


def cells_of(path: Path) -> Iterator[Cell]:
    """The cells of a notebook, in order."""
    parts = re.split(r"^# %%(.*)\n", path.read_text(encoding="utf-8"), flags=re.MULTILINE)
    for mark, source in zip(parts[1::2], parts[2::2], strict=True):
        is_text = mark.strip() == "[markdown]"
        yield Cell(
            is_text, re.sub(r"^# ?", "", source, flags=re.MULTILINE).strip() if is_text else source.strip()
        )


def run_cell(source: str, names: dict[str, Any]) -> Output:
    """Run code in the namespace of the cells before it."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    tree, printed, html = ast.parse(source), io.StringIO(), ""
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, "<cell>", "exec"), names)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), "<cell>", "eval"), names)
            if hasattr(value, "to_html"):
                html = value.to_html(border=0, classes="docutils")
            elif value is not None and not pyplot.get_fignums():
                printed.write(f"{value!r}\n")
    figures = []
    for number in pyplot.get_fignums():
        file = io.BytesIO()
        pyplot.figure(number).savefig(file, format="png", dpi=120)
        figures.append(file.getvalue())
    pyplot.close("all")
    return Output(printed.getvalue(), html, tuple(figures))


def page_of(path: Path) -> tuple[str, dict[str, bytes]]:
    """A notebook as Markdown with its outputs, run now; and the figures by file name."""
    parts, figures = [], {}
    names: dict[str, Any] = {"__name__": "__main__"}
    for cell in cells_of(path):
        if cell.is_text:
            parts.append(cell.source)
            continue
        output = run_cell(cell.source, names)
        parts.append(f"```python\n{cell.source}\n```")
        if output.printed:
            parts.append(f"```text\n{output.printed.rstrip()}\n```")
        if output.html:
            parts.append(f"```{{raw}} html\n{output.html}\n```")
        for picture in output.figures:
            name = f"{path.stem}-{len(figures)}.png"
            figures[name] = picture
            parts.append(f"![What the cell above draws]({name})")
    parts.append(f"The file is `examples/{path.name}`.")
    return "\n\n".join(parts) + "\n", figures


def made(path: Path) -> Path:
    """The folder of a notebook's page and figures, made now or kept."""
    from gallery import digest

    kept = ROOT / "out" / "examples"
    folder = kept / f"{path.stem}-{digest(path)}"
    if not folder.exists():
        kept.mkdir(parents=True, exist_ok=True)
        here = Path.cwd()
        os.chdir(ROOT)
        try:
            page, figures = page_of(path)
        finally:
            os.chdir(here)
        place = Path(tempfile.mkdtemp(dir=kept))
        (place / f"{path.stem}.md").write_text(page, encoding="utf-8")
        for name, picture in figures.items():
            (place / name).write_bytes(picture)
        place.replace(folder)
    return folder


def write_pages(app: Any) -> None:
    """A page a notebook in examples/, and their index."""
    from generated import write_changed

    target = Path(app.srcdir) / "examples"
    for name in NAMES:
        folder = made(ROOT / "examples" / f"{name}.py")
        write_changed(target / f"{name}.md", (folder / f"{name}.md").read_text(encoding="utf-8"))
        for picture in folder.glob("*.png"):
            shutil.copy2(picture, target / picture.name)
    write_changed(target / "index.md", INDEX.format(pages="\n".join(NAMES)))


def setup(app: Any) -> dict[str, Any]:
    app.connect("builder-inited", write_pages)
    return {"parallel_read_safe": True}
