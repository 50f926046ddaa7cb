"""Wrong inputs of every command: one line on standard error, exit code 2, and the line says what is allowed."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from orbsoc.commands.app import app

SCENARIOS = Path(__file__).resolve().parents[2] / "scenarios"
MISSIONS = (
    "reachable_domain, reachable_insertion, passive_safety, fly_around, phasing, platform_launch, approach"
)
DEVICES = "fmql45t900, k26, mpfs250t, ng_ultra, rocket_soc, vc1902, xc7z020, xc7z045, zu7ev, zu9eg"
PARTITIONS = "all_ps, factor_only, paper, paper_streams, resident"

WRONG = [
    # a command line that does not parse
    ("plan", "SCENARIO.toml", "scenario file, TOML"),
    ("plan rec1.toml --sett a=1", "--sett", "--set"),
    ("plan rec1.toml --check clara", "'clarabel'"),
    ("plan rec1.toml --cases two", "--cases", "valid integer"),
    ("plann", "'plann'", "'plan'"),
    ("--vers", "--version"),
    ("hw budge", "'budge'", "'budget'"),
    ("hw explain rendezvous_lp.json zu9eg", "'B'"),
    ("plan rec1_dry.toml --set event.at_s=30", "event.at_s", "`orbsoc fly`"),
    ("fly rec1.toml --runs 0", "greater than or equal to 1"),
    ("fly paper004_reach.toml", "mission = 'reachable_domain'", "reachable_insertion"),
    ("fly station_vbar.toml", "uncertainty: is missing", "errors of navigation and engine"),
    ("fly rec1_dry.toml --set event.at_s=60", "event.at_s = 60", "must be below 56.57"),
    ("fly rec1_dry.toml --set event.thrust_kept=1", "event.thrust_kept", "below 1"),
    ("fly rec1.toml --slower 0", "--slower", "positive"),
    ("fly rec1.toml --workers 2", "--workers", "--runs"),
    ("reach kick_stage_reach.toml --threads 0", "greater than or equal to 1"),
    ("solve rendezvous_lp.json --max-time-s no", "--max-time-s", "valid number"),
    # files
    ("plan rec11.toml", "no such file", "rec1.toml"),
    ("plan rendezvous_lp.json", "not TOML", "`orbsoc solve`"),
    ("solve rec1.toml", "not JSON", "`orbsoc plan`"),
    ("solve nowhere.json", "No such file"),
    ("hw budget nowhere.toml", "no such file", "TOML"),
    ("hw calibrate rendezvous_lp.json nowhere.csv", "nowhere.csv: cannot be read"),
    # options
    ("plan rec1.toml --device zu9", DEVICES),
    ("plan rec1.toml --partition papr", PARTITIONS),
    ("plan rec1.toml --device none --deadline-ms 50", "--device none"),
    ("plan rec1.toml --deadline-ms -1", "positive"),
    ("plan rec1.toml --problem min_tim", "'min_time' or 'max_energy'"),
    ("plan rec1.toml --seed 1", "--cases N"),
    ("plan rec1.toml --cases 2 --device none", "name one, or leave it out"),
    ("plan rec1.toml --impulses no.csv", "passive_safety, fly_around, phasing, approach"),
    ("plan rec1.toml --set method.nodes", "KEY=VALUE"),
    # keys of scenarios
    ("plan rec1.toml --set method.node=12", "max_iterations, max_nodes, nodes, slack_weight", "nodes?"),
    ("plan rec1.toml --set thrust_n=12", "vehicle.thrust_n?"),
    ("plan paper001_fewest.toml --set tolerance=2", "tolerance_m?"),
    ("plan rec1.toml --set mission=phasin", MISSIONS, "phasing?"),
    ("plan rec1.toml --set name=", "at least 1 character"),
    ("reach rec1.toml", "'reachable_domain'"),
    # values of scenarios
    ("plan rec1.toml --set method.nodes=0", "a whole number from 2 to 128", "default 12"),
    ("plan rec1.toml --set vehicle.preset=leros", "leros_1c", "orekit_apogee", "leros_1c?"),
    ("plan rec1.toml --set launch_site.preset=kouru", "baikonur", "xichang", "kourou?"),
    *(
        (
            f"plan {name}.toml --set body.name=moon",
            "body.name = 'moon'",
            "about the Earth alone; must be 'earth'",
        )
        for name in ("paper000_1", "paper001_equal", "paper002", "paper004_reach")
    ),
    ("plan rec1.toml --set body.name=moon", "launch_site: is the Earth's; leave it out"),
    ("plan paper003_socp.toml --set body.name=moon", "'drag' is of the Earth's air"),
    ("plan rec1.toml --set body.name=sun", "'earth', 'moon', 'mars' or 'own'"),
    ("plan rec1.toml --set axes=ecii", "'launch_inertial', 'eci' or 'velocity'"),
    ("plan rec1.toml --set vehicle.mass_kg=nan", "a number above 0 and at most 1e+08"),
    ("plan rec1.toml --set vehicle.mass_kg=heavy", "a number above 0 and at most 1e+08"),
    ("plan rec1.toml --set vehicle.dry_mass_kg=90000", "below vehicle.mass_kg = 84507"),
    ("plan paper000_1.toml --set condition=shrt", "'short', 'beyond' or 'none'"),
    ("plan paper000_1.toml --set keep_out_m=-1", "from 0 to 50000"),
    ("plan paper000_1.toml --set capture.z_m=10", "at least 40"),
    ("plan paper000_1.toml --set impulses.count=1", "from 2 to 64"),
    ("plan paper001_fewest.toml --set impulses=most", "'fewest', 'adaptive', 'equal'", "1 to 400"),
    ("plan paper001_fewest.toml --set ellipse.direction=2", "1 or -1"),
    ("plan paper002.toml --set slot=[9,9]", "3 columns and 2 rows"),
    ("plan paper002.toml --set rendezvous.duration_s=never", "'free'", "up to 1e+06"),
    ("plan paper002.toml --set rendezvous.impulses=3", "2 or 'generated'"),
    ("plan paper003_socp.toml --set scheme=scp", "'paper' or 'socp'"),
    ("plan paper003_socp.toml --set chaser.ecc=1.5", "at least 0 and below 1"),
    ("plan paper003_socp.toml --set window.revolutions=0", "from 1 to 500"),
    ("plan kick_stage_reach.toml --set perigee.condition=most", "'at_least' or 'equal'"),
    ("plan kick_stage_reach.toml --set grid.raan_deg.step=0", "a number above 0"),
    ("reach kick_stage_reach.toml --ephemeris 1", "three numbers: inclination (deg), node (deg), perigee"),
    # names
    ("reach kick_stage_reach.toml --device zu9", DEVICES),
    ("reproduce 009", "all, 000, 001, 002, 003, 004"),
    ("reproduce fly-around", "fly_around?"),
    ("reproduce 000 --scenarios nowhere", "no such folder"),
    ("new", "MISSION", MISSIONS),
    ("new phasin", MISSIONS, "phasing?"),
    ("new phasing --like rec1", "is a scenario of reachable_insertion", "paper003_socp"),
    ("new phasing --like paper3_socp", "no such scenario", "paper003_socp?"),
    ("new fly_around --out rec1.toml", "exists", "--out"),
    ("list scenario", "missions, scenarios, vehicles, sites, devices, partitions", "scenarios?"),
    # settings and hardware
    ("solve rendezvous_lp.json --tol 0", "positive"),
    ("solve rendezvous_lp.json --max-iterations 0", "at least 1, at most 100000"),
    ("hw budget rendezvous_lp.json --device zu9", DEVICES),
    ("hw budget rendezvous_lp.json --partition papr", PARTITIONS),
    ("hw budget rendezvous_lp.json --set pl.lane=8", "pl.lanes"),
    ("hw budget rendezvous_lp.json --set pl.lanes=many", "valid integer"),
    ("hw budget rendezvous_lp.json --ordering any", "amd, nested_dissection, automatic"),
    ("hw run rendezvous_lp.json --fp 16", "64 or 32"),
    ("hw run rendezvous_lp.json --lanes 0", "greater than or equal to 1"),
    ("hw partition rendezvous_lp.json --lanes a", "numbers joined by commas"),
    ("hw design rendezvous_lp.json --device zu9", DEVICES),
    ("hw trace rendezvous_lp.json --device zu9", DEVICES),
    ("hw precision rendezvous_lp.json --device zu9", DEVICES),
    ("hw sweep rendezvous_lp.json", "not a TOML file"),
]


@pytest.mark.parametrize("row", WRONG, ids=lambda row: row[0])
def test_a_wrong_input_is_told_in_one_line_with_what_is_allowed(
    row: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    command, *allowed = row
    arguments = [
        str(SCENARIOS / word) if (SCENARIOS / word).is_file() or word == "rec11.toml" else word
        for word in command.split()
    ]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    [line] = result.stderr.splitlines()
    assert line.startswith("orbsoc: error: ")
    for words in allowed:
        assert words in line
    assert list(tmp_path.iterdir()) == []


MISSING = {
    "rec1": {
        "problem": "must be 'min_time' or 'max_energy'",
        "vehicle.mass_kg": "must be a number above 0 and at most 1e+08 (kg, mass at ignition)",
        "vehicle.mass_flow_kg_s": "or give vehicle.isp_s or a preset",
        "vehicle": "must be a table",
    },
    "paper000_1": {
        "condition": "must be 'short', 'beyond' or 'none'",
        "duration_s": "must be a number above 0 and at most 1e+06 (s)",
        "start.x_m": "must be a number from -50000 to 50000 (m)",
    },
    "paper002": {"slot": "must be a list of 2, each a whole number from 1 to 20"},
    "kick_stage_reach": {"grid": "must be a table with inclination_deg, raan_deg, perigee_height_km"},
}


@pytest.mark.parametrize(("name", "key"), [(name, key) for name, keys in MISSING.items() for key in keys])
def test_a_missing_key_says_that_it_has_no_default_and_what_it_may_be(
    name: str, key: str, tmp_path: Path
) -> None:
    from orbsoc.guidance.scenario_template import toml_value
    from orbsoc.guidance.shipped import shipped_scenarios

    document = shipped_scenarios()[name].document()
    table, _, last = key.rpartition(".")
    del (document[table] if table else document)[last]
    path = tmp_path / "missing.toml"
    path.write_text("\n".join(f"{each} = {toml_value(value)}" for each, value in document.items()))
    result = CliRunner().invoke(app, ["plan", str(path)])
    assert result.exit_code == 2
    [line] = result.stderr.splitlines()
    assert f"{key}: is missing and has no default; must be " in line
    assert MISSING[name][key] in line


def test_a_command_line_that_does_not_parse_is_one_object_with_json(monkeypatch: pytest.MonkeyPatch) -> None:
    arguments = ["plan", "rec1.toml", "--cases", "two", "--json"]
    monkeypatch.setattr("sys.argv", ["orbsoc", *arguments])
    result = CliRunner().invoke(app, arguments)
    assert json.loads(result.stdout)["exit_code"] == 2


def test_there_are_more_than_sixty_wrong_inputs_over_all_commands() -> None:
    commands = {row[0].split()[0] for row in WRONG}
    registered = {info.name or info.callback.__name__ for info in app.registered_commands if info.callback}
    assert len(WRONG) >= 60
    assert commands >= registered - {"schema"} | {"hw"}  # schema's are told by test_cli_plan.py
