# %% [markdown]
# # Solve, update, prove
#
# For the user of the solver. A portfolio with a bound on its risk: state it, solve it for many bounds, and read a proof
# where there is no answer.

# %%
import numpy as np

import orbsoc

rng = np.random.default_rng(7)
returns = rng.normal(0.05, 0.03, 8)
factor = rng.normal(0.0, 0.1, (8, 8))  # risk is the norm of factor @ weights

model = orbsoc.ConicBuilder()
weights, risk = model.variable("weights", 8), model.variable("risk")
model.cost(weights, -returns)
model.equality([(weights, np.ones((1, 8)))], [1.0], name="all is invested")
model.bounds(weights, 0.0, 0.4, name="no more than 40 % in one")
model.norm([(weights, factor)], np.zeros(8), bound=risk, name="risk")
model.bounds(risk, -np.inf, 0.15, name="largest risk")
problem = model.build()
print(problem)

# %%
answer = orbsoc.solve(problem)
print(answer.status.name, answer.iterations, "iterations")
print("weights", np.round(answer.x[weights.index], 3))
print("worst residual below 1e-7:", orbsoc.verify(problem, answer).worst < 1e-7)

# %% [markdown]
# ## A front of sixteen problems at once
#
# One pattern, sixteen right-hand sides: a batch shares the analysis. Each row has the bits of its own solve.

# %%
row = int(np.flatnonzero(problem.h == 0.15)[0])
bounds = np.linspace(0.02, 0.2, 16)
h = np.tile(problem.h, (16, 1))
h[:, row] = bounds
batch = orbsoc.solve_batch(problem, h=h)
for bound, status, x in zip(bounds[::3], batch.status[::3], batch.x[::3], strict=True):
    gained = f"{returns @ x[weights.index]:.4f}" if status.name == "SOLVED" else "–"
    print(f"risk ≤ {bound:.3f}  {status.name:17} return {gained}")

# %% [markdown]
# ## Why there is none
#
# A status of infeasibility is a proof. The builder names the rows that contradict each other.

# %%
model.bounds(risk, -np.inf, 0.001, name="far too little risk")
print(model.why(orbsoc.solve(model.build())))
