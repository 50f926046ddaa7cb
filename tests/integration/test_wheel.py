"""The wheel: what is in it, and that it works in a clean environment, from another folder.

The wheel is the one `make` built (dist/); without one it is built here. The environment gets the pinned runtime
requirements and the wheel, nothing else, and is used with the repository out of sight.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tarfile
import tomllib
import venv
import zipfile
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from types import ModuleType
from typing import Any

import pytest

import hw_model
import orbsoc

ROOT = Path(__file__).resolve().parents[2]
DATA_SUFFIXES = {".c", ".svh", ".toml", ".j2", ".html", ".css", ".typed", ".pyi", ".json"}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    built = sorted((ROOT / "dist").glob("orbsoc-*.whl"))
    if not built:
        out = tmp_path_factory.mktemp("wheel")
        subprocess.run([ROOT / "scripts" / "build_wheel.sh", sys.executable, out], cwd=ROOT, check=True)
        built = sorted(out.glob("orbsoc-*.whl"))
    assert len(built) == 1, built
    return built[0]


@pytest.fixture(scope="module")
def sdist(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The one folder of a fresh source distribution, unpacked."""
    out = tmp_path_factory.mktemp("sdist")
    maturin = Path(sys.executable).with_name("maturin")
    subprocess.run([maturin, "sdist", "--out", out], cwd=ROOT, check=True)
    with tarfile.open(next(out.glob("*.tar.gz"))) as archive:
        archive.extractall(out, filter="data")
    return next(path for path in out.iterdir() if path.is_dir())


def crates(folder: Path) -> dict[str, dict[str, Any]]:
    """The workspace members of a source tree by name, as cargo reads them; fails if cargo cannot."""
    command = ["cargo", "metadata", "--no-deps", "--format-version", "1"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return {package["name"]: package for package in json.loads(done.stdout)["packages"]}


def extension_crates(members: Mapping[str, dict[str, Any]]) -> set[str]:
    """The members that the extension is built from: orbsoc-py and what it depends on in the workspace."""
    found: set[str] = set()
    waiting = ["orbsoc-py"]
    while waiting:
        name = waiting.pop()
        found.add(name)
        needs = {need["name"] for need in members[name]["dependencies"] if "path" in need}
        waiting += needs - found
    return found


def names_in(wheel: Path) -> set[PurePosixPath]:
    with zipfile.ZipFile(wheel) as archive:
        return {PurePosixPath(name) for name in archive.namelist()}


def package_files() -> set[PurePosixPath]:
    """What both packages are made of, as paths inside a wheel."""
    found: set[PurePosixPath] = set()
    for base, package in ((ROOT / "python", "orbsoc"), (ROOT, "hw_model")):
        for path in (base / package).rglob("*"):
            if path.suffix in DATA_SUFFIXES | {".py"}:
                found.add(PurePosixPath(path.relative_to(base).as_posix()))
    scenarios = PurePosixPath("orbsoc/scenarios")  # a link: `rglob` does not look into it
    return found - {scenarios} | {scenarios / path.name for path in (ROOT / "scenarios").glob("*.toml")}


def test_the_wheel_holds_both_packages_with_their_data_and_nothing_else(wheel: Path) -> None:
    names = names_in(wheel)
    extension = {name for name in names if name.suffix == ".so"}
    metadata = {name for name in names if name.parts[0].endswith(".dist-info")}
    assert [name.parent for name in extension] == [PurePosixPath("orbsoc")]
    assert names - extension - metadata == package_files()
    assert PurePosixPath("hw_model/platform/platforms/zu9eg.toml") in names
    assert PurePosixPath("hw_model/platform/partitions/paper.toml") in names
    assert PurePosixPath("orbsoc/scenarios/rec1.toml") in names
    assert PurePosixPath("orbsoc/py.typed") in names
    assert PurePosixPath("orbsoc/_core.pyi") in names


@pytest.mark.skipif("PYTHONPATH" in os.environ, reason="`make check` tests the sources")
@pytest.mark.parametrize("package", [orbsoc, hw_model, orbsoc._core], ids=lambda package: package.__name__)
def test_what_is_tested_is_installed(package: ModuleType) -> None:
    """`make check` leaves an extension beside the sources: without its path neither is imported."""
    assert package.__file__ is not None
    assert not any(Path(package.__file__).is_relative_to(ROOT / name) for name in ("python", "hw_model"))


@pytest.mark.parametrize("processor", ["x86_64", "aarch64"])
def test_the_wheel_is_built_with_the_flags_that_cargo_is_configured_with(
    tmp_path: Path, processor: str
) -> None:
    (tmp_path / "python").symlink_to(sys.executable)
    maturin = tmp_path / "maturin"
    maturin.write_text('#!/bin/sh\necho "$RUSTFLAGS;$*"\n', encoding="utf-8")
    maturin.chmod(0o755)
    target = f"{processor}-unknown-linux-gnu"
    done = subprocess.run(
        [ROOT / "scripts" / "build_wheel.sh", tmp_path / "python", tmp_path, target],
        cwd=ROOT,
        env={**os.environ, "RUSTFLAGS": "-C opt-level=3"},
        capture_output=True,
        text=True,
        check=True,
    )
    targets = tomllib.loads((ROOT / ".cargo" / "config.toml").read_text(encoding="utf-8"))["target"]
    configured = targets.get(f'cfg(target_arch = "{processor}")', {"rustflags": []})["rustflags"]
    assert bool(configured) == (processor == "x86_64")
    flags, _, arguments = done.stdout.partition(";")
    assert flags.split()[:-1] == ["-C", "opt-level=3", *configured]
    assert f"--target {target}" in arguments


def test_the_extension_names_no_folder_of_the_machine_that_built_it(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        (extension,) = [archive.read(name) for name in archive.namelist() if name.endswith(".so")]
    cargo_home = os.environ.get("CARGO_HOME", str(Path.home() / ".cargo"))
    assert b"cargo/registry/src/" in extension, "panic messages say where in a dependency they arose"
    for folder in (str(ROOT), str(Path.home()), cargo_home):
        assert f"{folder}/".encode() not in extension


def test_the_source_distribution_holds_what_a_build_needs(sdist: Path) -> None:
    names = {PurePosixPath(p.relative_to(sdist).as_posix()) for p in sdist.rglob("*") if p.is_file()}
    here = {PurePosixPath("python") / p if p.parts[0] == "orbsoc" else p for p in package_files()}
    members = crates(ROOT)
    folders = [Path(members[name]["manifest_path"]).parent for name in extension_crates(members)]
    sources = [path for folder in folders for path in (folder / "Cargo.toml", *folder.glob("src/**/*.rs"))]
    rust = {PurePosixPath(path.relative_to(ROOT).as_posix()) for path in sources}
    top = ("pyproject.toml", "Cargo.toml", "Cargo.lock", "LICENSE", ".cargo/config.toml")
    manifests = {PurePosixPath(name) for name in top}
    parameters = {PurePosixPath("rtl") / path.name for path in (ROOT / "rtl").glob("*.svh")}
    driver = {PurePosixPath("rtl/driver") / path.name for path in (ROOT / "rtl" / "driver").iterdir()}
    library = {PurePosixPath("flight") / path.name for path in (ROOT / "flight").glob("*.[ch]")}
    library |= {PurePosixPath("flight/missions") / path.name for path in (ROOT / "flight/missions").iterdir()}
    assert here | rust | manifests | parameters | driver | library <= names
    foreign = [name for name in names if name.suffix in (".pyc", ".so") or name.parts[0] in ("tests", "rtl")]
    assert set(foreign) == parameters | driver


def test_the_workspace_of_the_source_distribution_is_the_extension_alone(sdist: Path) -> None:
    assert (
        set(crates(sdist))
        == extension_crates(crates(ROOT))
        == {"orbsoc", "orbsoc-hw", "orbsoc-orbit", "orbsoc-py"}
    )


@pytest.fixture(scope="module")
def clean(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """bin/ of an environment with the pinned requirements and the wheel."""
    folder = tmp_path_factory.mktemp("clean")
    venv.create(folder, with_pip=True)
    pip = [folder / "bin" / "python", "-m", "pip", "--disable-pip-version-check", "install", "--quiet"]
    subprocess.run([*pip, "-r", ROOT / "requirements" / "runtime.txt"], check=True, cwd=folder)
    subprocess.run([*pip, "--no-deps", wheel], check=True, cwd=folder)
    return folder / "bin"


def run(command: list[str | Path], folder: Path) -> str:
    """Standard output of a command in another folder, with no variable that leads back here."""
    environment = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_pinned_requirements_are_complete(clean: Path, tmp_path: Path) -> None:
    assert "No broken requirements found." in run([clean / "python", "-m", "pip", "check"], tmp_path)


SOLVE = """
import hw_model, orbsoc
# min x0 + 2 x1 on x0 + x1 = 1, x >= 0, and ||(x0, x1)|| <= 3: x = (1, 0)
problem = orbsoc.Problem(
    c=[1.0, 2.0], A=[[1.0, 1.0]], b=[1.0],
    G=[[-1.0, 0.0], [0.0, -1.0], [0.0, 0.0], [-1.0, 0.0], [0.0, -1.0]], h=[0.0, 0.0, 3.0, 0.0, 0.0],
    cones=orbsoc.Cones(l=2, q=[3]),
)
solution = orbsoc.solve(problem)
assert solution.status is orbsoc.Status.SOLVED, solution
assert abs(solution.objective - 1.0) < 1e-7, solution.objective
ps = orbsoc.PsScheduler()
assert ps(problem).objective == solution.objective
report = hw_model.speedup(ps.trace, "zu9eg", "paper")
print(orbsoc.__file__, hw_model.__file__)
"""


@pytest.fixture(scope="module")
def alone(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """bin/ of an environment with the wheel and what it asks for without an extra, at the pinned versions."""
    folder = tmp_path_factory.mktemp("alone")
    venv.create(folder, with_pip=True)
    pip = [folder / "bin" / "python", "-m", "pip", "--disable-pip-version-check", "install", "--quiet"]
    subprocess.run([*pip, "-c", ROOT / "requirements" / "runtime.txt", wheel], check=True, cwd=folder)
    return folder / "bin"


def test_the_wheel_alone_solves_with_three_packages(alone: Path, tmp_path: Path) -> None:
    solve, _, _ = SOLVE.partition("ps = ")
    run([alone / "python", "-c", solve.replace("import hw_model, orbsoc", "import orbsoc")], tmp_path)
    listed = json.loads(run([alone / "python", "-m", "pip", "list", "--format", "json"], tmp_path))
    assert {package["name"].lower() for package in listed} - {"pip", "setuptools", "cffi", "pycparser"} == {
        "orbsoc",
        "numpy",
        "scipy",
        "clarabel",
    }, "Clarabel brings cffi"


def test_the_command_of_the_wheel_alone_says_what_to_install(alone: Path, tmp_path: Path) -> None:
    done = subprocess.run(
        [alone / "orbsoc", "plan"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (
        2,
        "orbsoc: error: typer is not installed; pip install 'orbsoc[missions]'\n",
    )


def test_an_installed_wheel_solves_and_models_from_another_folder(clean: Path, tmp_path: Path) -> None:
    places = run([clean / "python", "-c", SOLVE], tmp_path).split()
    assert [Path(place).is_relative_to(clean.parent) for place in places] == [True, True]


@pytest.mark.parametrize("command", [["orbsoc"], ["python", "-m", "orbsoc"]])
def test_the_command_line_answers_from_another_folder(
    command: list[str], clean: Path, tmp_path: Path
) -> None:
    text = run([clean / command[0], *command[1:], "--help"], tmp_path)
    assert "plan" in text
