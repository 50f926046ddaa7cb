"""Random problems built backwards from their answer: an optimal pair, a Farkas certificate, or a falling ray."""

from __future__ import annotations

import numpy as np

from orbsoc.conic.problem import Cones, Problem
from tests.zoo.case import Array, ZooCase, infeasible, solvable, unbounded


def _unit(rng: np.random.Generator, size: int) -> Array:
    v = rng.normal(size=size)
    return v / np.linalg.norm(v)


def _interior(rng: np.random.Generator, cones: Cones) -> Array:
    """A point well inside K."""
    out = np.empty(cones.m)
    out[: cones.l] = rng.uniform(0.5, 2.0, cones.l)
    for rows in cones.second_order():
        size = rows.stop - rows.start
        out[rows.start] = rng.uniform(1.0, 2.0)
        out[rows.start + 1 : rows.stop] = 0.5 * _unit(rng, size - 1) if size > 1 else 0.0
    return out


def complementary_pair(rng: np.random.Generator, cones: Cones, modes: str) -> tuple[Array, Array]:
    """(s, z) ∈ K × K with sᵀz = 0, strictly complementary.

    `modes` names what each second-order cone does in turn: "b" both on the boundary, "s" s inside and z = 0, "z" z
    inside and s = 0 (the apex). R₊ rows are active with probability ½; a cone of size 1 cannot be "b".
    """
    s, z = _interior(rng, cones), _interior(rng, cones)
    active = rng.random(cones.l) < 0.5
    s[: cones.l][active] = 0.0
    z[: cones.l][~active] = 0.0
    for k, rows in enumerate(cones.second_order()):
        mode = modes[k % len(modes)]
        if mode == "s":
            z[rows] = 0.0
        elif mode == "z":
            s[rows] = 0.0
        else:
            u = _unit(rng, rows.stop - rows.start - 1)
            s[rows] = rng.uniform(0.5, 2.0) * np.concatenate([[1.0], u])
            z[rows] = rng.uniform(0.5, 2.0) * np.concatenate([[1.0], -u])
    return s, z


def _matrix(rng: np.random.Generator, rows: int, columns: int, density: float) -> Array:
    return rng.normal(size=(rows, columns)) * (rng.random((rows, columns)) < density)


def optimal_pair(
    name: str,
    seed: int,
    n: int,
    p: int,
    cones: Cones,
    *,
    modes: str = "b",
    rank: int = 0,
    density: float = 0.6,
) -> ZooCase:
    """A problem with a chosen optimal pair; P has the given rank."""
    rng = np.random.default_rng(seed)
    A, G = _matrix(rng, p, n, density), _matrix(rng, cones.m, n, density)
    factor = _matrix(rng, rank, n, density)
    P = factor.T @ factor
    x, y = rng.normal(size=n), rng.normal(size=p)
    s, z = complementary_pair(rng, cones, modes)
    c = -P @ x - A.T @ y - G.T @ z
    problem = Problem(P=P if rank else None, c=c, A=A, b=A @ x, G=G, h=G @ x + s, cones=cones)
    return solvable(name, problem, 0.5 * x @ P @ x + c @ x)


def farkas(name: str, seed: int, n: int, p: int, cones: Cones, *, rank: int = 0) -> ZooCase:
    """A problem with Aᵀy + Gᵀz = 0, bᵀy + hᵀz = −1 for some y and z inside K."""
    rng = np.random.default_rng(seed)
    A, G = _matrix(rng, p, n, 0.6), _matrix(rng, cones.m, n, 0.6)
    b, h = rng.normal(size=p), rng.normal(size=cones.m)
    y, z = rng.normal(size=p), _interior(rng, cones)
    last = cones.m - 1 if not cones.q else cones.l  # a row whose multiplier is well above zero
    G[last] = 0.0
    G[last] = -(A.T @ y + G.T @ z) / z[last]
    h[last] = 0.0
    h[last] = -(1.0 + b @ y + h @ z) / z[last]
    factor = _matrix(rng, rank, n, 0.6)
    P = factor.T @ factor if rank else None
    return infeasible(name, Problem(P=P, c=rng.normal(size=n), A=A, b=b, G=G, h=h, cones=cones))


def falling_ray(name: str, seed: int, n: int, p: int, cones: Cones, *, rank: int = 0) -> ZooCase:
    """A feasible problem with a ray: Px = 0, Ax = 0, −Gx inside K, cᵀx = −1."""
    rng = np.random.default_rng(seed)
    ray, start = _unit(rng, n), rng.normal(size=n)
    across = np.eye(n) - np.outer(ray, ray)
    A = _matrix(rng, p, n, 1.0) @ across
    G = _matrix(rng, cones.m, n, 1.0) @ across - np.outer(_interior(rng, cones), ray)
    factor = _matrix(rng, rank, n, 1.0) @ across
    P = factor.T @ factor if rank else None
    c = rng.normal(size=n) @ across - ray
    h = G @ start + _interior(rng, cones)
    return unbounded(name, Problem(P=P, c=c, A=A, b=A @ start, G=G, h=h, cones=cones))


def lp_small() -> ZooCase:
    return optimal_pair("known_lp_small", 101, 4, 1, Cones(l=8))


def lp_medium() -> ZooCase:
    return optimal_pair("known_lp_medium", 102, 30, 8, Cones(l=60), density=0.3)


def lp_tall() -> ZooCase:
    """16 variables and 128 inequalities, the shape of the small LPs of the speed table."""
    return optimal_pair("known_lp_tall", 103, 16, 0, Cones(l=128), density=1.0)


def lp_few_rows() -> ZooCase:
    """Fewer rows than variables: many solutions."""
    return optimal_pair("known_lp_few_rows", 104, 12, 2, Cones(l=6))


def qp_full_rank() -> ZooCase:
    return optimal_pair("known_qp_full_rank", 105, 10, 3, Cones(l=15), rank=14)


def qp_low_rank() -> ZooCase:
    return optimal_pair("known_qp_low_rank", 106, 20, 4, Cones(l=30), rank=3)


def qp_equalities_only() -> ZooCase:
    return optimal_pair("known_qp_equalities_only", 107, 12, 5, Cones(), rank=12)


def socp_one_cone() -> ZooCase:
    return optimal_pair("known_socp_one_cone", 108, 5, 1, Cones(q=[6]))


def socp_sizes() -> ZooCase:
    return optimal_pair("known_socp_sizes", 109, 12, 2, Cones(l=5, q=[2, 3, 4, 5, 6]))


def socp_all_modes() -> ZooCase:
    """Cones on the boundary, slack, and at their apex, in turn."""
    return optimal_pair("known_socp_all_modes", 110, 15, 3, Cones(l=4, q=[3] * 9), modes="bsz")


def socp_apexes() -> ZooCase:
    return optimal_pair("known_socp_apexes", 111, 14, 2, Cones(q=[3, 4, 5, 3]), modes="z")


def socp_slack_cones() -> ZooCase:
    return optimal_pair("known_socp_slack_cones", 112, 8, 2, Cones(l=12, q=[4, 4, 6]), modes="s")


def socp_cones_of_size_1() -> ZooCase:
    return optimal_pair("known_socp_cones_of_size_1", 113, 6, 1, Cones(l=3, q=[1, 1, 1, 1, 1]), modes="sz")


def socp_cone_of_300() -> ZooCase:
    return optimal_pair("known_socp_cone_of_300", 114, 20, 3, Cones(l=5, q=[300]), density=0.2)


def socp_sixty_cones() -> ZooCase:
    return optimal_pair(
        "known_socp_sixty_cones", 115, 60, 20, Cones(l=20, q=[3] * 60), modes="bbs", density=0.1
    )


def socp_quadratic() -> ZooCase:
    return optimal_pair("known_socp_quadratic", 116, 18, 4, Cones(l=8, q=[4, 7, 3]), modes="bz", rank=9)


def lp_farkas() -> ZooCase:
    return farkas("known_lp_farkas", 201, 8, 2, Cones(l=14))


def qp_farkas() -> ZooCase:
    return farkas("known_qp_farkas", 202, 8, 2, Cones(l=14), rank=8)


def socp_farkas() -> ZooCase:
    return farkas("known_socp_farkas", 203, 10, 3, Cones(l=4, q=[3, 4, 8]))


def lp_ray() -> ZooCase:
    return falling_ray("known_lp_ray", 301, 8, 2, Cones(l=12))


def qp_ray() -> ZooCase:
    return falling_ray("known_qp_ray", 302, 8, 2, Cones(l=12), rank=4)


def socp_ray() -> ZooCase:
    return falling_ray("known_socp_ray", 303, 10, 2, Cones(l=3, q=[3, 5, 7]))
