"""Who may use whom: the dependency rules of the architecture, read off the sources.

Python: imports by `ast`, wherever in a file they stand. Rust: `crate::` and `super::` paths of the code, unit
tests and comments left out, and the manifests of the workspace.
"""

from __future__ import annotations

import ast
import re
import tomllib
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = {"orbsoc": ROOT / "python" / "orbsoc", "hw_model": ROOT / "hw_model"}
CRATE = ROOT / "rust" / "orbsoc" / "src"
HARDWARE = ROOT / "rust" / "orbsoc-hw" / "src"
ORBIT = ROOT / "rust" / "orbsoc-orbit" / "src"

# ---- Python ----

MAY_USE = {
    "hw_model.errors": "",
    "hw_model.vocabulary": "",
    "hw_model.platform": "errors vocabulary",
    "hw_model.timing": "errors vocabulary platform",
    "hw_model.area": "errors vocabulary platform timing",
    "hw_model.energy": "errors vocabulary platform timing area",
    "hw_model.report": "errors vocabulary platform timing area energy",
    "hw_model.figures": "errors vocabulary platform timing area energy report",
    "orbsoc.files": "",
    "orbsoc.orbit": "",
    "orbsoc.conic": "files _core",
    "orbsoc.sweep": "files",
    "orbsoc.solving": "files conic _core",
    "orbsoc.interfaces": "files conic solving",
    "orbsoc.ps": "files conic solving _core",
    "orbsoc.guidance": "files conic solving orbit",
    "orbsoc.missions": "files conic solving orbit sweep guidance",
    "orbsoc.reach": "missions",
    "orbsoc.accuracy": "conic solving orbit guidance missions.registry",
    "orbsoc.report": "files guidance hw",
    "orbsoc.hw": "files conic solving ps guidance missions.registry hw_model _core",
    "orbsoc.rtl": "files conic solving ps guidance missions.registry hw hw_model _core",
    "orbsoc.flight": "conic ps hw rtl hw_model _core",
    "orbsoc.soc": "conic ps missions.registry hw rtl flight hw_model _core",
    "orbsoc.fly": "files conic solving ps guidance missions.registry sweep hw hw_model _core",
    "orbsoc.commands": "accuracy files orbit conic solving ps guidance missions.registry sweep interfaces report hw rtl flight soc fly hw_model",
    "orbsoc.__main__": "files commands",
}
"""Each package and the packages that it may use, besides itself."""

EXTRA = {
    "orbsoc.commands.reach": "missions.reachable_domain reach",
    "orbsoc.orbit.perturbations.compiled": "_core",
}
"""The one command that belongs to a mission, and the one module of orbital mechanics that is compiled."""

PYTHON_FILES = sorted(path for folder in PACKAGES.values() for path in folder.rglob("*.py"))


def module_of(path: Path) -> str:
    """Dotted name of a file of one of the packages."""
    package = next(name for name, folder in PACKAGES.items() if path.is_relative_to(folder))
    parts = path.relative_to(PACKAGES[package]).with_suffix("").parts
    return ".".join((package, *parts)).removesuffix(".__init__")


MODULES = {module_of(path): path for path in PYTHON_FILES}


def imports_of(source: str, module: str, *, is_package: bool = False) -> set[str]:
    """Absolute names of everything a module imports from this repository; `from a import b` gives a.b."""
    package = module.split(".") if is_package else module.split(".")[:-1]
    found: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            origin = ".".join((*base, *(node.module or "").split("."))).strip(".")
            found |= {f"{origin}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Call) and ast.unparse(node.func) in (
            "import_module",
            "importlib.import_module",
        ):
            found |= {arg.value for arg in node.args[:1] if isinstance(arg, ast.Constant)}
    return {name for name in found if name.split(".")[0] in PACKAGES}


def within(name: str, modules: set[str]) -> bool:
    """Whether `name` is one of the modules or lies in one."""
    return any(name == module or name.startswith(f"{module}.") for module in modules)


def violations(module: str, imported: set[str]) -> set[str]:
    """The imports that a module may not have; `import hw_model` counts as all of it, `import orbsoc` as nothing."""
    package = ".".join(module.split(".")[:2])
    if package not in MAY_USE:
        return set() if module in PACKAGES else imported
    words = f"{MAY_USE[package]} {EXTRA.get(module, '')}".split()
    root = package.split(".")[0]
    allowed = {package} | {word if word == "hw_model" else f"{root}.{word}" for word in words}
    return {name for name in imported if name not in {"orbsoc", root} and not within(name, allowed)}


@pytest.mark.parametrize("path", PYTHON_FILES, ids=module_of)
def test_python_imports_point_the_allowed_way(path: Path) -> None:
    module = module_of(path)
    imported = imports_of(path.read_text(encoding="utf-8"), module, is_package=path.name == "__init__.py")
    assert violations(module, imported) == set()


def test_no_python_files_import_each_other_in_a_circle() -> None:
    uses = {
        module: {
            name if name in MODULES else name.rpartition(".")[0]
            for name in imports_of(
                path.read_text(encoding="utf-8"), module, is_package=path.name == "__init__.py"
            )
        }
        & (set(MODULES) - set(PACKAGES) - {module})
        for module, path in MODULES.items()
    }
    TopologicalSorter(uses).prepare()  # raises CycleError, which names the circle


@pytest.mark.parametrize(
    ("module", "source", "found"),
    [
        ("orbsoc.missions.a.plan", "from orbsoc import _core", {"orbsoc._core"}),
        (
            "orbsoc.missions.a.plan",
            "from ...ps.scheduler import PsScheduler",
            {"orbsoc.ps.scheduler.PsScheduler"},
        ),
        ("orbsoc.missions.a.plan", "def f():\n    import hw_model", {"hw_model"}),
        (
            "orbsoc.missions.a.plan",
            "from orbsoc.conic.builder import ConicBuilder\nfrom .model import Burn",
            set(),
        ),
        ("orbsoc.ps.scheduler", "from orbsoc.guidance import scp", {"orbsoc.guidance.scp"}),
        ("orbsoc.solving.solver", "from orbsoc.commands import app", {"orbsoc.commands.app"}),
        ("orbsoc.hw.workload", "import orbsoc.missions.a", {"orbsoc.missions.a"}),
        ("orbsoc.somewhere", "import orbsoc.files", {"orbsoc.files"}),
        ("hw_model.timing.trace", "import orbsoc.conic.problem", {"orbsoc.conic.problem"}),
        ("hw_model.report.report", "import_module('orbsoc.missions')", {"orbsoc.missions"}),
        ("hw_model.platform.platform", "from hw_model.report import usage", {"hw_model.report.usage"}),
        ("orbsoc.commands.app", "import hw_model, orbsoc.missions.registry, orbsoc.report.page", set()),
    ],
)
def test_the_python_check_finds_what_it_must(module: str, source: str, found: set[str]) -> None:
    assert violations(module, imports_of(source, module)) == found


# ---- Rust ----

RUST_PACKAGES = {
    CRATE: ["error", "symbolic", "problem", "real", "kkt", "kernels", "outcome", "method", "batch"],
    HARDWARE: ["error", "machine", "stream", "schedule", "microcode", "program", "replay"],
    ORBIT: ["field", "extrapolation", "coast"],
}
"""Of each crate the packages, lowest first: each may use those before it, and no other."""

HARDWARE_WORDS = re.compile(
    r"\b(?:\w*(?:register|partition(?!_point)|cycles|microcode)\w*|(?:irq|axi)(?:_\w+)?)\b", re.IGNORECASE
)
COUNTING = CRATE / "real" / "counted.rs"
"""Measures critical paths in the latencies it is given, and may call them cycles."""
SOURCES = [
    (crate, path)
    for crate in RUST_PACKAGES
    for path in sorted(crate.rglob("*.rs"))
    if path.name != "lib.rs" and path.parent != crate / "tests"
]
RUST_FILES = [path for crate, path in SOURCES if crate == CRATE]


def code_of(source: str) -> str:
    """A Rust source without unit tests and comments."""
    body = source.split("#[cfg(test)]")[0]
    return re.sub(r"//[^\n]*|/\*.*?\*/", "", body, flags=re.DOTALL)


def rust_package_of(path: Path, crate: Path) -> str:
    """First path element below the crate: a kernel's is `kernels`."""
    return path.relative_to(crate).with_suffix("").parts[0]


def expanded(tree: str) -> list[str]:
    """The paths of a use tree: `a::{b::C, d::{E, F}}` gives three."""
    head, brace, inner = tree.partition("{")
    parts = re.split(r",(?![^{]*\})", inner.removesuffix("}")) if brace else []
    return [head + path for part in parts if part for path in expanded(part)] or [tree]


def used_by(source: str, path: Path, crate: Path) -> set[str]:
    """What a Rust file names by `crate::…` and `super::…`, as package::file::item from the crate's root."""
    here = path.relative_to(crate).with_suffix("").parts
    here = here[:-1] if here[-1] in ("mod", "lib") else here
    code = code_of(source)
    found = {"::".join((*here, child)) for child in re.findall(r"\bmod (\w+);", code)}
    use = r"\buse\s+((?:crate|super)\b[^;]*);"
    trees = [re.sub(r"\s", "", tree) for tree in re.findall(use, code)]
    paths = re.findall(r"\b(?:crate|super)(?:::\w+)+", re.sub(use, "", code))
    for name in (*paths, *(path for tree in trees for path in expanded(tree))):
        parts = name.removesuffix("::self").split("::")
        up = parts.count("super")
        found.add("::".join((*(here[: len(here) - up] if up else ()), *parts[max(up, 1) :])))
    return found


def file_of(name: str, crate: Path) -> Path | None:
    """The file that a name stands in: the longest path of folders and a file that it begins with."""
    parts = name.split("::")
    for length in range(len(parts), 0, -1):
        stem = crate.joinpath(*parts[:length])
        for path in (stem.with_suffix(".rs"), stem / "mod.rs"):
            if path.is_file():
                return path
    return None


@pytest.mark.parametrize(
    ("crate", "path"), SOURCES, ids=lambda path: path.relative_to(ROOT / "rust").as_posix()
)
def test_rust_packages_use_those_before_them(crate: Path, path: Path) -> None:
    package = rust_package_of(path, crate)
    allowed = {*RUST_PACKAGES[crate][: RUST_PACKAGES[crate].index(package) + 1]}
    used = {name.split("::")[0] for name in used_by(path.read_text(encoding="utf-8"), path, crate)}
    assert used - allowed == set()


@pytest.mark.parametrize("crate", RUST_PACKAGES, ids=lambda crate: crate.parent.name)
def test_no_rust_files_use_each_other_in_a_circle(crate: Path) -> None:
    uses = {
        path: {file_of(name, crate) for name in used_by(path.read_text(encoding="utf-8"), path, crate)}
        - {path, None}
        for owner, path in SOURCES
        if owner == crate
    }
    while free := {path for path, used in uses.items() if not used & uses.keys()}:
        uses = {path: used for path, used in uses.items() if path not in free}
    assert {str(path.relative_to(crate)) for path in uses} == set()


@pytest.mark.parametrize(
    "path", [p for p in RUST_FILES if p != COUNTING], ids=lambda path: str(path.relative_to(CRATE))
)
def test_the_solver_knows_nothing_of_registers_and_partitions(path: Path) -> None:
    assert HARDWARE_WORDS.findall(code_of(path.read_text(encoding="utf-8"))) == []


@pytest.mark.parametrize("path", sorted((CRATE / "kernels").rglob("*.rs")), ids=lambda path: path.name)
def test_kernels_use_no_crate_that_computes_for_them(path: Path) -> None:
    assert re.findall(r"\b(?:faer|pulp|nalgebra|pyo3)::", code_of(path.read_text(encoding="utf-8"))) == []


@pytest.mark.parametrize(
    ("source", "file", "used"),
    [
        ("use crate::real::Real;", "kernels/statistics.rs", {"real::Real"}),
        (
            "use crate::{method::engine::Engine, real::{Mask, Real}, error};",
            "kernels/statistics.rs",
            {"method::engine::Engine", "real::Mask", "real::Real", "error"},
        ),
        (
            "fn f(x: &crate::method::workspace::Buffer) {}",
            "kernels/statistics.rs",
            {"method::workspace::Buffer"},
        ),
        (
            "use super::reduce::{dot, norm2};",
            "kernels/statistics.rs",
            {"kernels::reduce::dot", "kernels::reduce::norm2"},
        ),
        ("use super::reduce::{self};", "kernels/statistics.rs", {"kernels::reduce"}),
        ("use super::super::reduce;", "kernels/supernodal/panel.rs", {"kernels::reduce"}),
        ("mod lanes;\npub use lanes::Lanes;", "real/mod.rs", {"real::lanes"}),
        (
            "// use crate::method\n/* crate::kkt */\n#[cfg(test)]\nuse crate::method;",
            "kernels/statistics.rs",
            set(),
        ),
    ],
)
def test_the_rust_check_finds_what_it_must(source: str, file: str, used: set[str]) -> None:
    assert used_by(source, CRATE / file, CRATE) == used


def test_a_name_is_found_in_its_file() -> None:
    assert file_of("kernels::reduce::dot", CRATE) == CRATE / "kernels" / "reduce.rs"
    assert file_of("real::Real", CRATE) == CRATE / "real" / "mod.rs"
    assert file_of("Error", CRATE) is None


def test_the_words_of_the_hardware_are_found() -> None:
    code = "let irq_ack = 1; struct RegisterFile; MaxIterations; rows.partition_point(f); n_cycles"
    assert HARDWARE_WORDS.findall(code) == ["irq_ack", "RegisterFile", "n_cycles"]


def test_every_layer_has_sources_to_check() -> None:
    packages = {".".join(module.split(".")[:2]) for module in MODULES} - set(PACKAGES)
    assert packages == set(MAY_USE)
    for crate, names in RUST_PACKAGES.items():
        assert set(names) == {rust_package_of(path, crate) for owner, path in SOURCES if owner == crate}


def test_crates_depend_downwards_only() -> None:
    dependencies = {
        path.parent.name: set(tomllib.loads(path.read_text())["dependencies"])
        for path in ROOT.glob("rust/*/Cargo.toml")
    }
    assert {"orbsoc", "orbsoc-py"} <= set(dependencies)
    allowed = {
        "orbsoc": set(),
        "orbsoc-hw": {"orbsoc"},
        "orbsoc-orbit": set(),
        "orbsoc-py": {"orbsoc", "orbsoc-hw", "orbsoc-orbit"},
        "orbsoc-bench": {"orbsoc", "orbsoc-hw"},
        "orbsoc-wasm": {"orbsoc"},
    }
    for name, found in dependencies.items():
        assert {crate for crate in found if crate.startswith("orbsoc")} <= allowed[name], name
        assert name == "orbsoc-py" or not {"pyo3", "numpy"} & found, name
