"""Chaser and target in any form of the orbit table, turned to the elements and the seconds that the mission counts in.

J2 needs the Earth's pole as z axis: with dates both bodies stand in TEME at the chaser's epoch, from which seconds count.
"""

from __future__ import annotations

from collections.abc import Mapping
from datetime import datetime, timedelta
from typing import Any

import numpy as np

from orbsoc.guidance.body import central_body
from orbsoc.guidance.orbit_input import Orbit, vehicle_complaints
from orbsoc.guidance.orbit_input.beside import read_table
from orbsoc.guidance.orbit_input.catalogue import parse_utc
from orbsoc.guidance.scenario_file import Complaint, refuse
from orbsoc.orbit import ConstantsSet, elements_from_state

OWN = ("sma_km", "ecc", "inc_deg", "raan_deg", "argp_deg", "true_anomaly_deg", "epoch_s")
BODIES = ("chaser", "target")
BESIDE = ("epoch_s", "ballistic_m2_kg", "motion")
"""Keys of a body that are none of its orbit."""


def in_own_keys(document: Mapping[str, Any]) -> dict[str, Any]:
    """The scenario with both bodies by osculating elements; as it is where they are already. Refuses what names no orbit."""
    tables = {name: document.get(name) for name in BODIES}
    if not all(isinstance(table, Mapping) for table in tables.values()):
        return dict(document)  # the fields refuse it
    given = {name: dict(table) for name, table in tables.items() if isinstance(table, Mapping)}
    other = [
        name for name, table in given.items()
        if set(table) - {*OWN, *BESIDE, "epoch_utc", "frame", "source"}
        or (table.get("epoch_utc") is not None and table.get("frame") != "TEME")
        or (table.get("epoch_utc") is not None and "epoch_s" not in table)
    ]  # fmt: skip
    if not other:
        return dict(document)
    orbits = {
        name: read_table(name, Orbit, {key: value for key, value in table.items() if key not in BESIDE})
        for name, table in given.items()
    }
    about = central_body(document).constants
    for name, orbit in orbits.items():
        orbit._about = about
        refuse(vehicle_complaints(name, orbit))
    zero = orbits["chaser"].epoch
    dated = [name for name, orbit in orbits.items() if orbit.dated]
    if len(dated) == 1:
        missing = next(name for name in BODIES if name not in dated)
        refuse(
            [
                Complaint(
                    f"{missing}.epoch_utc",
                    "nothing",
                    f"is missing; {dated[0]} has a date, so must have one too",
                )
            ]
        )
    turned = BODIES if zero is not None else other
    return {**document, **{name: _own(name, given[name], orbits[name], zero, about) for name in turned}}


def zero_utc(chaser_epoch_utc: str, chaser_epoch_s: float) -> datetime:
    """The instant from which the scenario's seconds count."""
    return parse_utc(chaser_epoch_utc) - timedelta(seconds=chaser_epoch_s)


def _own(
    name: str, table: Mapping[str, Any], orbit: Orbit, zero: datetime | None, about: ConstantsSet
) -> dict[str, Any]:
    state = orbit.vector_in("TEME" if zero else None, zero)
    found = elements_from_state(state[:3], state[3:], about)
    angles = {"inc_deg": found.inc_rad, "raan_deg": found.raan_rad, "argp_deg": found.argp_rad}
    own: dict[str, Any] = {
        "sma_km": found.sma_m / 1e3,
        "ecc": found.ecc,
        **{key: float(np.rad2deg(angle)) for key, angle in angles.items()},
        "true_anomaly_deg": float(np.rad2deg(found.true_anomaly_rad)),
    }
    if zero is not None and orbit.epoch is not None:
        if table.get("epoch_s") is not None:
            refuse(
                [
                    Complaint(
                        f"{name}.epoch_s",
                        str(table["epoch_s"]),
                        "there is a date already; must be one of the two",
                    )
                ]
            )
        own |= {
            "epoch_s": (orbit.epoch - zero).total_seconds(),
            "epoch_utc": orbit.epoch.isoformat(),
            "frame": "TEME",
        }
        own["source"] = orbit.source
    elif "epoch_s" in table:
        own["epoch_s"] = table["epoch_s"]
    return own | {key: table[key] for key in BESIDE[1:] if key in table}
