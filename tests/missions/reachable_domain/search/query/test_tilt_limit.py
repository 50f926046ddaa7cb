"""The boundary as a function: its interpolation, and the error that it states."""

from __future__ import annotations

import numpy as np
import pytest

from orbsoc.reach import TiltLimit


def curve(azimuth_deg: np.ndarray, height_km: np.ndarray) -> np.ndarray:
    """A smooth edge to interpolate."""
    beta = np.deg2rad(azimuth_deg)
    return 10.0 + 4.0 * np.cos(2.0 * beta) + np.sin(4.0 * beta) - 2e-3 * height_km - 4e-6 * height_km**2


def limit(azimuths: int) -> TiltLimit:
    beta, height = np.arange(azimuths) * 360.0 / azimuths, np.arange(100.0, 501.0, 100.0)
    table = curve(beta[:, None], height[None, :])
    return TiltLimit(beta, height, table, np.full(table.shape, 1e-4))


@pytest.mark.parametrize("azimuths", [16, 32, 64])
def test_the_stated_interpolation_error_covers_the_true_one(azimuths: int) -> None:
    draw = np.random.default_rng(azimuths)
    beta, height = draw.uniform(-360.0, 720.0, 200), draw.uniform(100.0, 500.0, 200)
    found = limit(azimuths)
    assert (np.abs(found(beta, height) - curve(beta, height)) <= found.error_deg(beta, height)).all()
    assert np.isnan(found(10.0, 90.0))


def boundary_of(found: TiltLimit) -> dict[str, np.ndarray]:
    """The columns that make a limit."""
    beta, height = np.meshgrid(found.azimuth_deg, found.height_km, indexing="ij")
    columns = {
        "azimuth_deg": beta,
        "perigee_bound_km": height,
        "tilt_deg": found.table,
        "tilt_change_deg": found.change,
    }
    return {name: values.ravel().copy() for name, values in columns.items()}


@pytest.mark.parametrize("azimuth", [0, 13])
def test_a_hole_in_the_boundary_is_bridged_and_its_error_stated(azimuth: int) -> None:
    whole = limit(32)
    columns = boundary_of(whole)
    columns["tilt_deg"][5 * azimuth + 2] = np.nan
    bridged = TiltLimit.of(columns)
    miss = abs(bridged.table[azimuth, 2] - whole.table[azimuth, 2])
    assert 0.0 < miss < 0.1
    assert miss <= bridged.change[azimuth, 2] <= bridged.error_deg(whole.azimuth_deg[azimuth], 300.0)


def test_a_height_with_many_holes_has_no_edge_and_the_others_keep_theirs() -> None:
    whole = limit(16)
    columns = boundary_of(whole)
    columns["tilt_deg"][::5][:3] = np.nan
    found = TiltLimit.of(columns)
    lowest, second = whole.height_km[:2]
    assert not found.covers(lowest)
    assert np.isnan(found(10.0, lowest))
    assert found(10.0, second) == pytest.approx(whole(10.0, second), abs=1e-12)
    columns["tilt_deg"][:] = np.nan
    assert np.isnan(TiltLimit.of(columns)(10.0, second))
