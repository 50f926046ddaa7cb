"""The factors of the search: what each is, and the page with its measurement. Canonical units where none is named.

PLAN is `docs/plan.md`, MISSIONS is `docs/measurements/insertion-missions.md`.
"""

from __future__ import annotations

import numpy as np

from orbsoc.guidance.scp import Rules

# grids and penalties: MISSIONS, "What made the difference"
GROWTH = 1.5
"""Factor by which the grid grows when the propagation does not confirm a plan."""
FIRM = 100.0
"""Factor on the weight of the slack where a start already meets the terminal rows: the penalty is exact only above the rows'
multipliers, and those of a short burn, which moves the vehicle little, reach 1e4."""
SLACK_LEFT = 1e-5
"""Total slack of a sequence that ended short of convergence, but near enough to be corrected in flight."""
GAIN = 10.0
"""Scale of the unknowns GAIN · (S − Ŝ) of the largest orbit. S_H is flat in the thrust directions: at S_H ≈ 1 a relative gap of
1e-10 leaves them 1e-4 rad apart between two solvers. Measured from the reference the cost tends to 0, its gap becomes absolute,
and the scale sharpens it: |ΔL|/μ on rec1 and rec2 went from 5e-9 to 5e-10."""

COLD_STEP = 1e-2
"""Longest step of the flight of a cold start, canonical."""

# laws that are flown onto the orbit: MISSIONS, "What made the difference"
REACHED = 1e-8
"""Of the five conditions, within which a law shows the way."""
MISS = 1e-10
"""Of the conditions, within which a correction ends."""
LEFT = 0.98
"""Of the propellant, that a law burns where its free duration wants more than there is."""
NEARLY_ALL = 0.999
"""Of the vehicle's mass, that a flight may burn."""
LONGER = (1.05, 1.15, 1.3)
"""Factors on the duration of an impulse's burn, at which a law with more room to shift the vehicle is corrected."""
MOST_FLOWN = 2
"""Starts that reach the target orbit, after which others would lead to the same burn."""
SHARES = np.array([1.0, 0.7, 0.5, 0.35, 0.2, 0.1, 0.03, 0.01])
"""Of a Gauss–Newton step; all are tried at once, and the one with the smallest next step is taken (Deuflhard's natural level
function: it does not depend on how the conditions are scaled, and those of a short burn are badly so)."""
ROUGHNESS = 0.3
"""By how much more a coefficient of a law weighs than that of one degree lower."""
LONGEST_STEP = 0.5
"""Of a coefficient or of the logarithm of the duration, in one step."""
STEP = 1e-6
"""Of the finite differences, canonical and of a law of unit size."""
MOST_STEPS = 48
"""Of a flight in a correction."""

# laws that turn smoothly: PLAN, "How the burn is sought"
SAMPLES = 401
"""Of a law, to see how it turns between nodes."""
REVERSES = 0.02
"""max‖u‖ − 1 between nodes, from which on finer grids are not worth the trouble: the thrust reverses."""
WORTH_A_LAW = 1e-3
"""Share by which a verified burn may be longer than a converged sequence's before a smooth law is tried beside it."""
SMOOTHED = 6
"""Coefficients that are kept of thrust that reverses faster than a grid follows."""
TOO_LONG = 2e-5
"""By how much the interpolant of unit vectors may be longer, of a law that a grid follows; a fifth of what is verified."""
TURNS, DEGREE = 12, 4
"""Most steps towards the smoothest law of a duration, and its degree: enough to spread a turn over the burn."""
LENGTHENED, SHORTENED = 0.02, (0.02, 5e-3, 1e-3, 3e-4)
"""Shares of its duration by which a law is lengthened until a grid follows it, and shortened as long as one does."""
SHORTENED_TO_COMPARE = SHORTENED[:1]
"""… where burns from many ignitions are compared."""
MOST_LONGER, MOST_SHORTER = 12, 60
MADE_UNIT = 4
"""How often a corrected interpolant is replaced by that of its directions."""

# about the fastest turn that a grid follows: PLAN, "How fast the thrust may turn"
FIRST, FASTER = 2.5, 1.25
"""Factors on the smooth law's fastest turn, and on the last bound that a burn was found with."""
COARSE, FEWEST_NODES = 0.375, 6
"""Nodes of the sequence, in those of the finest grid, which needs the others to follow what is drawn between them; and no fewer."""
CLOSE = 1.015
"""Ratio of a bound that fails to one that leads to a plan, from which on others save some 0.01 % of the burn at most."""
MOST_TRIED, MOST_IDLE = 10, 3
"""Bounds, and how many more than the first may fail: the last of them is then 12 % above the smooth law's turn."""
QUICK_RULES = Rules(step_tol=1e-5, tighten_below=1e-3, max_iterations=20)
"""The flight's correction does what is left: 17 iterations at 16 °/s end within 1e-5 of the burn that 30 lead to."""
QUICK_STEPS = 96
"""Of a flight in that correction; with the usual 48 a turn of a tenth of the burn ends 1e-8 beside its orbit."""

# within a bound on the attitude rate: PLAN, "How fast the thrust may turn"
CONES_PER_NODE = 4
"""Bounded points; between them the interpolant turns at most 8 % faster, and some 0.1 % where its rate is at the bound."""
FIRST_PRICE, HIGHEST_PRICE = 2.0, 32.0
"""Of thrust that is missing, as multiples of what it is worth."""
LOOSE = 1e-4
"""1 − |u| at a node, from which on the relaxation is not tight."""
MARGIN = 1e-4
"""Share of the bound that the convex problem keeps free, for what its interpolant turns faster between the cones."""
ROUNDS = 4
"""In which the bound of the convex problem is lowered by what the flown attitude exceeds the true one."""
TOO_FAST = 1.05
"""Of the bound; an attitude that turns faster still was not stopped by the interpolant."""
WORTH_A_GRID = 1e-3
"""Share of the burn that a finer grid has to save, before the next one is tried."""

# when to burn: PLAN, "When to burn"
PER_BURN = 4.0
"""Ignition times that are ranked in the time that an impulsive burn takes: what changes over a burn is not stepped over."""
FEWEST_TIMES, MOST_TIMES = 90, 2000
"""Ranked ignition times."""
FLOWN_TIMES = 8
"""Local minima of the ranking, at which a law is flown."""
WITHOUT_PERIOD_S = 7200.0
"""Latest ignition by default on a first orbit that never returns."""
LOOKS = 4001
"""Of a coast whose perigee is too low."""
OBLATE_M = 50e3
"""By which J2 lowers a perigee at most, and more."""
LEAST_SHARE = 0.01
"""Of the burn, that a later ignition has to save to be worth a word."""
SAME_SHARE = 1e-4
"""Of the burn, that is not worth a revolution more of coast."""
GOLDEN = 0.5 * (3.0 - np.sqrt(5.0))
CLOSE_ENOUGH_S = 1.0
"""Of the ignition: the shortest burn is flat there."""
