# %% [markdown]
# # Fly it: a loop through the computer
#
# The engine loses 40 % of its thrust in flight. Guidance plans again, and an answer is flown when the modelled computer has it, not
# before.

# %%
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import pandas as pd

folder = Path(tempfile.mkdtemp()) / "flight"
command = [
    sys.executable,
    "-m",
    "orbsoc",
    "fly",
    "scenarios/rec1_dry.toml",
    "--partition",
    "resident",
    "--no-report",
]
done = subprocess.run([*command, "--out", str(folder)], capture_output=True, text=True, check=True)
print(done.stdout.split("written to")[0])

# %% [markdown]
# ## Every trigger of guidance
#
# Each row is one re-plan: why it began, how long the computer took, and what became of the answer.

# %%
cycles = pd.read_csv(folder / "cycles.csv")
cycles[["at_s", "cause", "fate", "computed_ms", "solves", "iterations"]].head(8).round(3)

# %%
print(cycles.groupby("fate")["computed_ms"].describe()[["count", "mean", "max"]].round(2))

# %% [markdown]
# ## What guidance decided when the thrust was lost

# %%
flight = json.loads((folder / "flight.json").read_text(encoding="utf-8"))
for decision in flight["decisions"]:
    print(decision)
