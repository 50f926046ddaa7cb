"""Engine failures, hold points, scans, dispersed flights, and the launch of every server."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest

from orbsoc.missions.platform_launch.model.launch import LaunchError
from orbsoc.missions.platform_launch.model.transfer import Transfers, in_plane, programme
from orbsoc.missions.platform_launch.search.sequence import Sequencer
from orbsoc.missions.platform_launch.verification.audits import cut_burns, dispersed, hold_points, pointing
from tests.missions.platform_launch.data import launched, paper

STATE, MOTION = paper().separation().state, paper().motion
BEST = Transfers.of(MOTION, paper().longest_s).best(in_plane(STATE))
PLANNED = programme(MOTION, in_plane(STATE), BEST.time_s)


def test_an_engine_failure_within_the_first_impulse_stays_clear_and_without_the_last_does_not() -> None:
    first, last = cut_burns(paper(), STATE, PLANNED)
    assert first.by_fraction_m[[0, 25, 50, 75, 90]] == pytest.approx(
        [113.1, 104.4, 90.9, 65.7, 35.8], abs=0.06
    )
    assert last.missed_m < 0.2


def test_a_hold_point_keeps_its_distance_and_has_its_price() -> None:
    for found in hold_points(MOTION, STATE, "squares", 50.0, paper().longest_s):
        plan = programme(MOTION, in_plane(STATE - found.ahead_m * np.eye(6)[1]), found.time_s)
        state = STATE.copy()
        state[3:] += plan.dv_m_s[0]
        arrival = MOTION.transition(found.time_s, 0.0) @ state
        assert arrival[:3] == pytest.approx([0.0, found.ahead_m, 0.0], abs=1e-7)
        assert found.cost == pytest.approx(float((plan.dv_m_s**2).sum()))
        assert found.price == pytest.approx(found.cost - BEST.cost)
        later = [MOTION.transition(t, 0.0) @ arrival for t in np.linspace(0.0, 3.0 * MOTION.period_s, 3001)]
        nearest = np.linalg.norm(np.array(later)[:, :3], axis=1).min()
        assert found.nearest_m == pytest.approx(nearest, abs=0.05)
        assert nearest > 15.0


def test_the_best_yaw_bias_and_the_best_phase() -> None:
    """At 0 and 180° a launch costs 0.615; a sample every 30° hides that it costs less ten degrees on."""
    bias, phase = pointing(launched())
    assert (bias.best_deg, bias.best_cost) == (
        pytest.approx(18.65, abs=5e-3),
        pytest.approx(0.46852, abs=5e-6),
    )
    assert bias.best_time_s == pytest.approx(893.6, abs=0.1)
    by_phase = dict(zip(phase.samples_deg.tolist(), phase.costs.tolist(), strict=True))
    assert by_phase[0.0] == pytest.approx(0.615, abs=5e-4)
    assert by_phase[180.0] == pytest.approx(by_phase[0.0])
    assert by_phase[90.0] == pytest.approx(1.90, abs=5e-3)
    assert (phase.best_deg, phase.best_cost) == (
        pytest.approx(9.53, abs=0.05),
        pytest.approx(0.4937, abs=5e-5),
    )


def test_dispersed_flights() -> None:
    """Beside other draws: means within 10 %, 95th percentiles within 15 %."""
    scenario = paper().with_changes(uncertainty={"runs": 400, "seed": 7}, rendezvous={"longest_orbits": 1.0})
    found = dispersed(scenario, PLANNED, BEST.time_s)
    assert float(found.miss_m.mean()) == pytest.approx(20.2, rel=0.10)
    assert float(np.quantile(found.miss_m, 0.95)) == pytest.approx(40.6, rel=0.15)
    assert float(np.quantile(found.costs, 0.95)) == pytest.approx(0.6423, rel=0.02)
    assert 880.0 < found.times_s.min() < 910.0
    assert 945.0 < found.times_s.max() < 980.0
    again = dispersed(scenario, PLANNED, BEST.time_s)
    np.testing.assert_array_equal(again.miss_m, found.miss_m)


def test_all_servers_in_sequence() -> None:
    sequencer = Sequencer(launched(rendezvous={"longest_orbits": 1.0}))
    given = sequencer.order(((1, 2), (3, 2), (2, 2), (1, 1), (3, 1), (2, 1)))
    assert given.costs == pytest.approx([0.6151, 0.9829, 0.7624, 1.2864, 2.5341, 1.5601], abs=5.1e-5)
    found = sequencer.sequence()
    assert found is not None
    assert found.orders == 90
    assert found.best.slots == ((1, 2), (2, 2), (1, 1), (2, 1), (3, 2), (3, 1))
    assert (found.best.total, found.worst.total) == pytest.approx((7.5822, 8.2363), abs=5.1e-5)


def test_no_order_is_better_than_the_best() -> None:
    """Of a rack of four, every order priced by itself."""
    platform = {"columns": 2, "rows": 2, "inertia_kg_m2": 400.0}
    sequencer = Sequencer(launched(platform=platform, rendezvous={"longest_orbits": 1.0}))
    totals = []
    for slots in permutations(sequencer.scenario.rack.servers()):
        try:
            totals.append(sequencer.order(slots).total)
        except LaunchError:
            continue
    found = sequencer.sequence()
    assert found is not None
    assert found.orders == len(totals) == 6
    assert (found.best.total, found.worst.total) == pytest.approx((min(totals), max(totals)))


def test_a_longer_search_finds_a_cheaper_launch() -> None:
    """Of the launch of column 3, row 1 without its neighbours: the least is not in the first orbit."""
    without = {"missing": [[1, 2], [3, 2], [2, 2], [1, 1]]}
    scenario = launched(slot=[3, 1], platform=without)
    state = in_plane(scenario.separation().state)
    short, long = (Transfers.of(MOTION, orbits * MOTION.period_s).best(state) for orbits in (1.0, 5.0))
    assert short.cost == pytest.approx(2.5341, abs=5.1e-5)
    assert long.cost < 0.97 * short.cost
    assert long.time_s > MOTION.period_s


def test_a_rack_of_many_columns_has_too_many_orders() -> None:
    assert Sequencer(launched(platform={"columns": 8, "rows": 2})).sequence() is None
