# %% [markdown]
# # My own vehicle, from a dictionary to a verdict
#
# For the engineer who plans manoeuvres. A shipped scenario is changed in Python, planned, and judged.

# %%
import matplotlib.pyplot as plt
import numpy as np

import orbsoc
from orbsoc.guidance.scenario_file import read_toml

mine = read_toml("scenarios/rec1.toml")
mine["name"] = "my_insertion"
mine["vehicle"] |= {"mass_kg": 0.9 * mine["vehicle"]["mass_kg"]}
run = orbsoc.plan(mine, device="zu9eg", partition="resident", deadline_ms=50)
print(run.verdict)

# %% [markdown]
# Each line of the verdict is an object with a word. The exit code of `orbsoc plan` is 0 where no word is bad.

# %%
for line in run.verdict.lines:
    print(f"{line.question.name:9} {line.word.name}")

# %% [markdown]
# ## A weaker engine
#
# The plan of each thrust is flown by an integrator that the optimiser does not use; only that makes it *verified*.

# %%
thrusts, burns = (0.9, 1.0, 1.1), []
full = mine["vehicle"]["thrust_n"]
for share in thrusts:
    mine["vehicle"]["thrust_n"] = share * full
    plan = orbsoc.plan(mine, device="none").plan
    burns.append(plan.time_of_flight_s)
    print(f"{share:.0%} of the thrust  {plan.time_of_flight_s:6.2f} s  {plan.status.value}")

# %%
figure, axes = plt.subplots(figsize=(6, 3), layout="constrained")
axes.plot(100 * np.array(thrusts), burns, "o-")
axes.set(xlabel="thrust (%)", ylabel="burn (s)")
