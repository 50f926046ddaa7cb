"""Messages are read back by an independent reader, number by number."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from orbsoc.guidance.ccsds import InertialManoeuvre, Subject, oem, opm
from orbsoc.orbit import Elements, state_from_elements

STATE = np.concatenate(state_from_elements(Elements(7.0e6, 0.01, 0.9, 0.4, 0.3, 0.2)))
SUBJECT = Subject("a chaser", "the node", "the first state", datetime(2026, 2, 3, 4, 5, 6, tzinfo=UTC))


def test_an_ephemeris_and_a_state_with_manoeuvres_come_back(tmp_path: Path) -> None:
    ndm_io = pytest.importorskip("ccsds_ndm.ndm_io", reason="the independent reader is not installed").NdmIo
    (tmp_path / "a.oem").write_text(oem(SUBJECT, [0.0, 60.5], [STATE, 1.01 * STATE], comment="two states"))
    burns = [InertialManoeuvre(30.0, (0.1, -0.2, 0.3)), InertialManoeuvre(50.0, (0.0, 0.0, 1e-6))]
    (tmp_path / "a.opm").write_text(opm(SUBJECT, 0.0, STATE, mass_kg=120.5, manoeuvres=burns))
    segment = ndm_io().from_path(tmp_path / "a.oem").body.segment[0]
    assert segment.metadata.object_name == "a chaser"
    assert segment.metadata.stop_time == "2026-02-03T04:06:06.500000"
    last = segment.data.state_vector[1]
    read = [float(getattr(last, name).value) for name in ("x", "y", "z", "x_dot", "y_dot", "z_dot")]
    assert read == pytest.approx(1.01 * STATE / 1e3, abs=1e-8)
    data = ndm_io().from_path(tmp_path / "a.opm").body.segment.data
    assert float(data.spacecraft_parameters.mass.value) == 120.5
    assert float(data.keplerian_elements.eccentricity) == pytest.approx(0.01, abs=1e-11)
    found = [
        [1e3 * float(getattr(each, f"man_dv_{k}").value) for k in (1, 2, 3)]
        for each in data.maneuver_parameters
    ]
    assert found == [pytest.approx(each.dv_m_s, abs=1e-9) for each in burns]
    assert data.maneuver_parameters[0].man_epoch_ignition == "2026-02-03T04:05:36.000000"
    assert data.maneuver_parameters[0].man_ref_frame == "SCENARIO_ECI"


def test_a_date_that_is_not_given_is_told() -> None:
    text = opm(Subject("a", "the node", "ignition"), 0.0, STATE)
    assert "COMMENT Times count from ignition; the scenario gives no date" in text
    assert "MASS" not in text
    assert "Times count" not in opm(SUBJECT, 0.0, STATE)
