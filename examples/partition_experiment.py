# %% [markdown]
# # A partition experiment, end to end
#
# Which of the three largest modules belong in the logic, and how many lanes should it have? A rendezvous is solved once on the
# emulated computer. Its record is then priced for each choice, without solving again. All times are modelled.

# %%
from itertools import combinations

import pandas as pd

import hw_model
import orbsoc

problem = orbsoc.Problem.load("scenarios/rendezvous_lp.json")
ps = orbsoc.PsScheduler()
print(ps(problem))

# %% [markdown]
# ## One row a choice

# %%
LARGEST = ("matrix_update", "factorization", "linear_solve")
zu9eg = hw_model.load_platform("zu9eg")
rows = []
for lanes in (2, 8):
    device = zu9eg.with_value("pl.lanes", lanes)
    for size in (1, 2, 3):
        for modules in combinations(LARGEST, size):
            report = hw_model.speedup(ps.trace, device, "+".join(modules))
            rows.append(
                {
                    "in the logic": " + ".join(modules),
                    "lanes": lanes,
                    "speedup": report.speedup.nominal,
                    "low": report.speedup.low,
                    "high": report.speedup.high,
                    "link share": report.causes_picoseconds["link"] / report.makespan_picoseconds,
                }
            )
table = pd.DataFrame(rows)
table.sort_values("speedup", ascending=False).head(6).round(2)

# %% [markdown]
# ## Lanes side by side

# %%
table.pivot(index="in the logic", columns="lanes", values="speedup").round(2)

# %% [markdown]
# A band that contains 1 leaves the sign open: the model cannot say whether the logic helps.

# %%
table["open"] = (table["low"] < 1) & (table["high"] > 1)
print(f"{table['open'].sum()} of {len(table)} choices are open")
