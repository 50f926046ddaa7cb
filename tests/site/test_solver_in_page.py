"""The solver in the page, in headless Chromium from `file://`: the bits of the native solver."""

from __future__ import annotations

import html
import json
import os
import re
import shutil
import subprocess
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import orbsoc
from benchmarks.guidance import powered_descent, quadrotor, rendezvous
from benchmarks.statistics import lasso, portfolio, small_lp
from docs.extensions import page_solver

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGE = (DOCS / "solver-in-the-page.md").read_text(encoding="utf-8")
DEMONSTRATION = re.search(r"^```\{raw\} html\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)[1]  # type: ignore[index]
PYTHON = re.search(r"^```python\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE)[1]  # type: ignore[index]
LARGEST_KB = int(re.search(r"at most (\d+) kB", PAGE)[1])  # type: ignore[index]


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the scripts of the page."""
    missing = page_solver.lacking() or (
        shutil.which("chromium") is None and "no chromium: apt-get install chromium"
    )
    if missing:
        if "ORBSOC_REQUIRE_PAGE" in os.environ:
            pytest.fail(missing)
        pytest.skip(missing)
    folder = tmp_path_factory.mktemp("site")
    shutil.copytree(DOCS / "static", folder / "_static", ignore=shutil.ignore_patterns("solver.js"))
    module = page_solver.compiled()
    assert len(module) <= LARGEST_KB * 1000
    (folder / "_static" / "solver.js").write_text(page_solver.script(module))
    return folder


def shown(site: Path, body: str, script: str) -> Any:
    """What a page finds: the value of the `script`, an expression, with `body` above it."""
    page = site / "page.html"
    page.write_text(f'<meta charset="utf-8">{body}<script>document.title = JSON.stringify({script})</script>')
    profile = f"--user-data-dir={site / 'profile'}"
    options = [
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--disable-dev-shm-usage",
        profile,
        "--dump-dom",
    ]
    done = subprocess.run(
        ["chromium", *options, page.as_uri()], capture_output=True, text=True, timeout=300, check=True
    )
    title = re.search(r"<title>(.*?)</title>", done.stdout, re.DOTALL)
    assert title, done.stdout[-2000:] + done.stderr[-2000:]
    return json.loads(html.unescape(title[1]))


def bits(solution: orbsoc.Solution) -> str:
    """FNV-1a over the bits of x, y, z and s."""
    words = np.concatenate([solution.x, solution.y, solution.z, solution.s]).view(np.uint64).tolist()
    return f"{reduce(lambda found, word: (found ^ word) * 0x100000001B3 % 2**64, words, 0xCBF29CE484222325):016x}"


def held_out() -> list[orbsoc.Problem]:
    """Fifty problems of seeds that nothing else uses: guidance, statistics, and two without a solution."""
    seeds = range(9000, 9008)
    found = [make(nodes, seed) for make, nodes in ((rendezvous, 12), (quadrotor, 8), (powered_descent, 12)) for seed in seeds]  # fmt: skip
    found += [make(size, seed) for make, size in ((portfolio, 20), (lasso, 6)) for seed in seeds]
    found += [small_lp(12, seed, rows=40) for seed in seeds]
    ball = orbsoc.Cones(l=1, q=[3])
    G = [[1.0, 0.0], [0.0, 0.0], [-1.0, 0.0], [0.0, -1.0]]
    return [
        *found,
        orbsoc.Problem(c=[1.0, 0.0], G=G, h=[-2.0, 1.0, 0.0, 0.0], cones=ball),  # no point: x₁ ≤ −2 in the unit ball
        orbsoc.Problem(c=[1.0, 1.0], G=[[1.0, 0.0], [0.0, 1.0]], h=[0.0, np.inf], cones=orbsoc.Cones(l=2)),  # no bound
    ]  # fmt: skip


def test_fifty_problems_have_the_bits_of_the_native_solver(site: Path, tmp_path: Path) -> None:
    problems = held_out()
    assert len(problems) == 50
    texts = []
    for number, problem in enumerate(problems):
        problem.save(tmp_path / f"{number}.json")
        texts.append((tmp_path / f"{number}.json").read_text())
    scripts = "".join(f'<script src="_static/{name}.js"></script>' for name in ("solver", "conic"))
    body = f"{scripts}<script>const problems = [{','.join(texts)}];</script>"
    found = shown(
        site, body, "problems.map(p => { const a = conic.solve(p); return [a.status, conic.bits(a)]; })"
    )
    answers = [orbsoc.solve(problem) for problem in problems]
    assert found == [[answer.status.name, bits(answer)] for answer in answers]
    assert {answer.status.name for answer in answers} >= {"SOLVED", "PRIMAL_INFEASIBLE", "DUAL_INFEASIBLE"}


MOVES = """(() => {
  const found = [], root = document.getElementById("rendezvous");
  for (const [radial, along, revolutions, impulses, largest] of [
      [-10, -120, 1.35, 12, 60], [25, 80, 0.6, 2, 60], [-30, 0, 2.8, 24, 5], [40, 200, 0.4, 8, 1], [0, 0, 1, 6, 60]]) {
    for (const [name, value] of Object.entries({ radial, along, revolutions, impulses, largest }))
      root.querySelector(`[name=${name}]`).value = value;
    found.push(solveRendezvous());
  }
  return found;
})()"""


def test_a_plan_ends_at_the_station_and_its_hash_is_the_native_one(
    site: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    found = shown(site, DEMONSTRATION, MOVES)
    for plan in found:
        Path("rendezvous.json").write_text(json.dumps(plan["problem"]))
        exec(PYTHON, {})
        assert capsys.readouterr().out.strip() == plan["bits"]
    assert [plan["status"] for plan in found] == ["SOLVED", "SOLVED", "SOLVED", "PRIMAL_INFEASIBLE", "SOLVED"]
    for plan in found:
        if plan["status"] == "SOLVED":
            assert np.abs(plan["end"]).max() < 1e-4  # km and m/s


def test_a_problem_that_is_wrong_is_told(site: Path) -> None:
    scripts = "".join(f'<script src="_static/{name}.js"></script>' for name in ("solver", "conic"))
    wrong = '{"n": 1, "p": 0, "m": 1, "c": [1], "b": [], "h": [1], "cones": {"l": 2, "q": []}}'
    said = shown(
        site, scripts, f"(() => {{ try {{ conic.solve({wrong}); }} catch (e) {{ return e.message; }} }})()"
    )
    assert "cones" in said
