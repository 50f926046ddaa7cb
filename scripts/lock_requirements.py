"""Write requirements/*.txt: exact pins for the whole closure of what pyproject.toml asks for (`make lock`).

Each lock is what pip resolves in an empty environment. `runtime` is orbsoc with its extras `missions` and `hw`. `test`, `bench`, `docs` and `route` are resolved under the runtime pins
and list only what they add, so the GPL peer of the `bench` extra cannot reach the runtime or the test lock. The
`cvxpy` and `reach` extras are in the test lock: what they bring is tested.
"""

from __future__ import annotations

import subprocess
import tempfile
import tomllib
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LOCKS = ROOT / "requirements"
SOURCE_ONLY = "oem"
"""Has no wheel of the release that is tested with."""


def resolve(wanted: list[str], constraints: Path | None) -> list[str]:
    """Pins `name==version` of everything pip installs for `wanted` in an empty environment."""
    with tempfile.TemporaryDirectory() as folder:
        venv.create(folder, with_pip=True)
        pip = [f"{folder}/bin/python", "-m", "pip", "--disable-pip-version-check"]
        under = ["-c", str(constraints)] if constraints else []
        subprocess.run(
            [
                *pip,
                "install",
                "--quiet",
                "--only-binary=:all:",
                f"--no-binary={SOURCE_ONLY}",
                *under,
                *wanted,
            ],
            check=True,
        )
        frozen = subprocess.run([*pip, "freeze"], check=True, capture_output=True, text=True).stdout
    return frozen.split()


def write(name: str, wanted: list[str], base: Path | None = None) -> Path:
    """Resolve `wanted` on top of the lock `base` and write requirements/<name>.txt."""
    path = LOCKS / f"{name}.txt"
    already = set(base.read_text().split()) if base else set()
    pins = [pin for pin in resolve(wanted, base) if pin not in already]
    include = [f"-r {base.name}"] if base else []
    path.write_text(
        "\n".join(["# Written by `make lock`; edit pyproject.toml instead.", *include, *pins, ""])
    )
    return path


def main() -> None:
    """Renew all six locks."""
    manifest = tomllib.loads((ROOT / "pyproject.toml").read_text())
    extras = manifest["project"]["optional-dependencies"]
    write("build", manifest["build-system"]["requires"])
    wanted = [*manifest["project"]["dependencies"], *extras["missions"], *extras["hw"]]
    runtime = write("runtime", list(dict.fromkeys(wanted)))
    write("test", extras["test"] + extras["cvxpy"] + extras["reach"], base=runtime)
    write("bench", extras["bench"], base=runtime)
    write("route", extras["route"], base=runtime)
    write("docs", extras["docs"], base=runtime)


if __name__ == "__main__":
    main()
