# %% [markdown]
# # Move a module into the logic
#
# For the hardware engineer. One solve is recorded on the emulated computer. Then it is priced for each partition, without
# solving again. All times are modelled.

# %%
import matplotlib.pyplot as plt

import hw_model
import orbsoc

problem = orbsoc.Problem.load("scenarios/rendezvous_lp.json")
ps = orbsoc.PsScheduler()
emulated, native = ps(problem), orbsoc.solve(problem)
print(emulated.status.name, "with the bits of the native solve:", emulated.x.tobytes() == native.x.tobytes())

# %% [markdown]
# ## From one module to all seven
#
# `paper` launches six modules one by one; `resident` has all seven, and the logic runs whole attempts by itself.

# %%
PARTITIONS = ("factorization", "factorization+linear_solve", "paper", "resident")
reports = [hw_model.speedup(ps.trace, "zu9eg", partition) for partition in PARTITIONS]
for partition, report in zip(PARTITIONS, reports, strict=True):
    print(f"{partition:27} {report.makespan_ms.nominal:.3f} ms, {report.speedup.nominal:.2f} times one core")

# %% [markdown]
# ## Where the time goes

# %%
figure, axes = plt.subplots(figsize=(7, 3), layout="constrained")
causes = [
    cause for cause in reports[0].causes_picoseconds if any(r.causes_picoseconds[cause] for r in reports)
]
left = [0.0] * len(reports)
for cause in causes:
    times = [report.causes_picoseconds[cause] / 1e9 for report in reports]
    axes.barh(PARTITIONS, times, left=left, label=cause)
    left = [sum(pair) for pair in zip(left, times, strict=True)]
axes.set_xlabel("modelled time (ms)")
figure.legend(loc="outside lower center", ncols=4, fontsize=8)
