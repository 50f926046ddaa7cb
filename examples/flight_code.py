# %% [markdown]
# # From a problem to C99
#
# For the engineer of the flight software. The solver is exported for one pattern, compiled here, and compared bit by bit.

# %%
import subprocess
import tempfile
from pathlib import Path

import orbsoc

problem = orbsoc.Problem.load("scenarios/rendezvous_lp.json")
folder = Path(tempfile.mkdtemp()) / "c"
files = orbsoc.export_c(problem, folder)
print(len(files), "files, among them", ", ".join(sorted(path.name for path in files if path.suffix == ".md")))

# %% [markdown]
# ## Compile, and run its self-test
#
# The self-test solves the recorded problem, cold and warm, and compares every bit with the host's answer.

# %%
sources = [*sorted(map(str, (folder / "flight").glob("*.c"))), "pattern.c", "selftest.c"]
flags = [
    "-std=c99",
    "-O1",
    "-ffp-contract=off",
    "-DORBSOC_FP=64",
    "-DORBSOC_INDEX_BITS=16",
    "-Iflight",
    "-I.",
]
subprocess.run(["cc", *flags, *sources, "-lm", "-o", "selftest"], cwd=folder, check=True)
print(subprocess.run(["./selftest"], cwd=folder, capture_output=True, text=True, check=True).stdout)

# %% [markdown]
# ## What it needs on board

# %%
print((folder / "BOUNDS.md").read_text(encoding="utf-8"))
