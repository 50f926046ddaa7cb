"""Platforms: those that ship, provenance of every number, and errors that say what is allowed."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import get_args

import pytest

import hw_model
from hw_model.errors import PlatformError
from hw_model.platform import rtl_latency
from hw_model.platform.parameter import Parameter, Tag
from hw_model.platform.platform import Platform, load_platform, platform_names
from tests.hw_model.tiny import platform_toml, tiny_platform


def test_the_shipped_platforms() -> None:
    assert platform_names() == [
        "fmql45t900", "k26", "mpfs250t", "ng_ultra", "rocket_soc", "vc1902", "xc7z020", "xc7z045", "zu7ev", "zu9eg",
    ]  # fmt: skip


@pytest.mark.parametrize("name", platform_names())
def test_a_shipped_platform_loads_and_every_number_has_a_source(name: str) -> None:
    platform = load_platform(name)
    assert platform.name == name
    rows = dict(platform.parameters())
    assert len(rows) == len(list(platform.parameters())) == 125
    for row in rows.values():
        assert row.tag in get_args(Tag)
        assert row.source.strip()
        assert (row.low is None) == (row.high is None)


@pytest.mark.parametrize("name", platform_names())
def test_no_platform_claims_a_measurement_but_those_of_the_rtl(name: str) -> None:
    measured = {key: row for key, row in load_platform(name).parameters() if row.tag == "measured"}
    assert {key.split("_")[0] for key in measured} == {"area.lut", "area.ff", "pl.load"}
    assert measured.pop("pl.load_bytes_per_cycle").source.startswith("rtl/axi in simulation")
    tool = "yosys 0.70 on rtl/, NG-Ultra" if name == "ng_ultra" else "yosys 0.23 on rtl/, xc7"
    assert all(row.source.startswith(tool) for row in measured.values())


def test_link_figures_of_another_part_are_assumed_there() -> None:
    at_home, borrowed = load_platform("xc7z045").link, load_platform("ng_ultra").link
    assert at_home.dma_fixed_us.tag == "sourced"
    assert borrowed.dma_fixed_us.tag == "assumed"
    assert borrowed.dma_fixed_us.source == f"borrowed from zynq7000: {at_home.dma_fixed_us.source}"
    assert borrowed.dma_fixed_us.value == at_home.dma_fixed_us.value == 1.96
    assert borrowed.cache_clean_ns_per_line == at_home.cache_clean_ns_per_line  # assumed at home already


PROTOCOL = {
    "frame_register_writes", "status_register_reads", "flags_per_register", "acknowledge_register_writes",
}  # fmt: skip
"""Link parameters that are the emulated protocol's, and no figure of a device."""


@pytest.mark.parametrize("name", ["zu9eg", "zu7ev", "k26"])
def test_zynq_ultrascale_has_a_link_of_its_own_with_a_band_around_every_figure(name: str) -> None:
    link = dict(load_platform(name).link.parameters())
    within = {
        "register_write_pl_cycles",
        "dma_fixed_pl_cycles",
        "dma_first_ns_per_byte",
        "dma_cached_ns_per_byte",
        "publish_ns",
        "first_ns",
    }  # no figure tells them from the fixed parts
    assert {link[key].value for key in within} == {0.0}
    figures = {key: row for key, row in link.items() if key not in PROTOCOL | within}
    assert len(figures) == 14
    assert link == dict(load_platform("zu9eg").link.parameters())
    for key, row in figures.items():
        assert not row.source.startswith("borrowed")
        assert row.low is not None, key
        assert row.low < row.high, key
    zynq = dict(load_platform("xc7z045").link.parameters())
    assert all(link[key] == zynq[key] for key in PROTOCOL)


@pytest.mark.parametrize("key", ["dma_to_pl_bytes_per_pl_cycle", "dma_to_ps_bytes_per_pl_cycle"])
def test_dma_of_zynq_ultrascale_is_a_zynq_7000s_on_ports_twice_as_wide(key: str) -> None:
    wide, narrow = getattr(load_platform("zu9eg").link, key), getattr(load_platform("xc7z045").link, key)
    assert wide.value == pytest.approx(2 * narrow.value, abs=0.005)
    assert wide.tag == "scaled"
    assert wide.low < narrow.value
    assert wide.high <= 16.0


def test_parts_with_a_link_measured_in_part_borrow_the_rest() -> None:
    versal, polarfire = load_platform("vc1902").link, load_platform("mpfs250t").link
    assert versal.register_write_ns.tag == "sourced"
    assert versal.ddr_efficiency.source.startswith("borrowed from zynq_ultrascale: ")
    assert polarfire.dma_to_pl_bytes_per_pl_cycle.tag == "sourced"
    assert polarfire.register_write_ns.source.startswith("borrowed from zynq7000: ")
    assert {versal.ddr_efficiency.tag, polarfire.register_write_ns.tag} == {"assumed"}


def test_parts_of_one_logic_have_one_clock_and_versals_follows_by_a_published_ratio() -> None:
    zu9eg, k26, versal = (load_platform(name).pl.clock_mhz for name in ("zu9eg", "k26", "vc1902"))
    assert k26 == zu9eg
    assert zu9eg.low is not None
    assert zu9eg.high is not None
    slowest = load_platform("xc7z020").pl.clock_mhz.low
    assert slowest is not None
    low, high = (end * 456 / 661 for end in (zu9eg.low, zu9eg.high))  # MicroBlaze, UG984
    assert (versal.low, versal.value, versal.high) == (
        round(low), round((slowest * high) ** 0.5), round(high),
    )  # fmt: skip


def test_parts_that_no_open_tool_routes_are_as_fast_as_the_slowest_engine_on_record_or_less() -> None:
    slowest = load_platform("xc7z020").pl.clock_mhz.low
    ultra, polarfire = (load_platform(name).pl.clock_mhz for name in ("ng_ultra", "mpfs250t"))
    assert slowest is not None
    assert (ultra.low, ultra.high) == (round(slowest / 3), slowest)
    assert (polarfire.low, polarfire.value, polarfire.high) == (
        round(slowest * 28 / 40), slowest, round(slowest * 40 / 28),
    )  # fmt: skip
    assert {ultra.tag, polarfire.tag} == {"assumed"}


def test_block_and_ultra_ram_of_the_parts() -> None:
    held = {name: load_platform(name).resources for name in platform_names()}
    assert {name: row.uram.value for name, row in held.items() if row.uram.value} == {
        "k26": 64, "vc1902": 463, "zu7ev": 96,
    }  # fmt: skip
    assert {held[name].uram.tag for name in ("k26", "vc1902", "zu7ev")} == {"sourced"}
    k26 = held["k26"]
    assert (k26.lut.value, k26.ff.value, k26.dsp.value, k26.bram36.value) == (117_120, 234_240, 1_248, 144)


def test_what_another_logic_holds_is_converted_to_six_inputs_and_25_x_18() -> None:
    polarfire = load_platform("mpfs250t").resources
    left = 254_000 - 29_232 - 28_224  # logic elements that no LSRAM or math block takes
    assert polarfire.ff.value == left
    assert polarfire.lut.value == left * 961 // 1282
    assert polarfire.dsp.value == 784 * (3 * 4) // (4 * 4)
    assert polarfire.bram36.value == 812 // 2
    assert {polarfire.lut.tag, polarfire.ff.tag, polarfire.dsp.tag, polarfire.bram36.tag} == {"scaled"}
    ng_ultra = load_platform("ng_ultra").resources
    assert (ng_ultra.ff.value, ng_ultra.bram36.value) == (1316 * 384, 672 * 2 // 3)


def test_the_pipelines_of_both_arm_cores_are_those_on_record() -> None:
    record = json.loads((Path(hw_model.__file__).parent / "timing" / "instructions.json").read_text())
    for core, device in (("cortex-a53", "zu9eg"), ("cortex-a72", "vc1902")):
        row, ps = record["pipeline"][core], load_platform(device).ps
        cycles = ps.cycles_per_instruction
        halfway = (row["issue"] * row["repeated"]) ** 0.5
        assert cycles.high == pytest.approx(row["once"], rel=0.03)
        if core == "cortex-a53":  # in order, as the core that was counted in RTL
            assert cycles.low == pytest.approx(halfway, rel=0.01)
            assert cycles.value == pytest.approx((cycles.low * cycles.high) ** 0.5, rel=0.01)
        else:
            assert cycles.low == pytest.approx(row["issue"], rel=0.03)
            assert cycles.value == pytest.approx(halfway, rel=0.01)
        assert ps.instruction_factor.tag == "executed"


def test_figures_of_the_devices() -> None:
    zu9eg, fmql, zynq = load_platform("zu9eg"), load_platform("fmql45t900"), load_platform("xc7z020")
    assert (zu9eg.ps.core, fmql.ps.core, zynq.ps.core) == ("Arm Cortex-A53", "Arm Cortex-A7", "Arm Cortex-A9")
    assert (zu9eg.ps.div_f64_cycles.value, zu9eg.ps.sqrt_f64_cycles.value) == (33, 32)
    assert [getattr(zynq.resources, name).value for name in ("lut", "ff", "dsp", "bram36")] == [
        53_200, 106_400, 220, 140,
    ]  # fmt: skip
    units = zu9eg.pl.latencies
    assert [getattr(units.f64, f"{unit}_cycles").value for unit in ("add", "mul", "div", "sqrt")] == [
        7,
        8,
        35,
        35,
    ]
    assert [getattr(units.f32, f"{unit}_cycles").value for unit in ("add", "mul", "div", "sqrt")] == [
        7,
        8,
        20,
        20,
    ]
    assert (units.f64.div_interval_cycles.value, units.f32.sqrt_interval_cycles.value) == (4, 4)
    vendor = zu9eg.with_value("pl.latency_preset", "vendor_ip").pl.latencies
    assert [getattr(vendor.f64, f"{unit}_cycles").value for unit in ("add", "mul", "div", "sqrt")] == [
        15,
        16,
        57,
        57,
    ]
    assert (vendor.f32.add_cycles.value, vendor.f32.mul_cycles.value) == (12, 9)


def test_the_engines_latencies_are_read_from_the_file_that_the_rtl_includes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rtl = (Path(__file__).resolve().parents[3] / "rtl" / "latency.svh").read_text(encoding="utf-8")
    assert (Path(rtl_latency.__file__).parent / "latency.svh").read_text(encoding="utf-8") == rtl
    monkeypatch.setattr(rtl_latency, "__file__", str(tmp_path / "rtl_latency.py"))
    slower = re.sub(r"F64_(DIV_INTERVAL|DIV|MUL)_CYCLES = \d+", r"F64_\1_CYCLES = 99", rtl)
    (tmp_path / "latency.svh").write_text(slower, encoding="utf-8")
    read = rtl_latency.rtl_latencies()["f64"]
    assert {name for name, entry in read.items() if entry["value"] == 99} == {
        "mul_cycles", "div_cycles", "div_interval_cycles",
    }  # fmt: skip
    (tmp_path / "latency.svh").write_text(rtl.replace("F32_SQRT_CYCLES", "F32_ROOT_CYCLES"), encoding="utf-8")
    with pytest.raises(PlatformError, match="`F32_SQRT_CYCLES` is missing"):
        rtl_latency.rtl_latencies()


def test_corners_move_every_band_and_nothing_else() -> None:
    platform = load_platform("fmql45t900")
    slow, fast = platform.corner("slow", "fast"), platform.corner("fast", "slow")
    assert (slow.ps.clock_mhz.value, fast.ps.clock_mhz.value) == (800.0, 1000.0)
    assert (slow.ps.flop_per_cycle.value, fast.ps.flop_per_cycle.value) == (0.12, 0.30)
    assert (slow.runtime.interrupt_entry_us.value, fast.runtime.interrupt_entry_us.value) == (0.5, 1.0)
    assert (slow.pl.overlap_exponent.value, fast.pl.overlap_exponent.value) == (4.0, 2.0)
    for corner in (slow, fast, platform.corner("nominal", "nominal")):
        for (_, row), (_, was) in zip(corner.parameters(), platform.parameters(), strict=True):
            assert row.value == was.value or (was.low is not None and row.value in (was.low, was.high))
    assert platform.corner("nominal", "nominal") == platform


def test_a_value_can_be_set_for_one_run() -> None:
    platform = load_platform("zu9eg")
    changed = platform.with_value("pl.lanes", 8)
    assert (platform.pl.lanes.value, changed.pl.lanes.value) == (4, 8)
    assert (changed.pl.lanes.tag, changed.pl.lanes.source) == ("assumed", "set for this run (was 4)")
    assert changed.with_value("ps.clock_mhz", 1200.0).ps.clock_mhz.low is None


@pytest.mark.parametrize(
    ("key", "value", "says"),
    [
        ("pl.lane", 8, r"`pl\.lane` is not a parameter; allowed: ps\.cores, ps\.clock_mhz, "),
        ("pl.latencies.f64.add_cycles", 8, r"is not a parameter"),
        ("pl.lanes", 0, r"`pl\.lanes` = 0: input should be greater than or equal to 1"),
        ("pl.banks", 3, r"`pl\.banks`: 3 is no power of two"),
        ("pl.lanes", 4.5, r"`pl\.lanes` = 4\.5: input should be a valid integer"),
        ("pl.lanes", True, r"`pl\.lanes` = True: input should be a valid integer"),
        (
            "pl.clock_mhz",
            0.0,
            r"`pl\.clock_mhz` = 0\.0: input should be greater than or equal to 0\.001",
        ),
        (
            "pl.clock_mhz",
            1e-300,
            r"`pl\.clock_mhz` = 1e-300: input should be greater than or equal to",
        ),
        (
            "link.register_write_ns",
            1e18,
            r"`link\.register_write_ns` = 1e\+18: input should be less than",
        ),
        (
            "link.frame_register_writes",
            2**63,
            r"`link\.frame_register_writes` = 9\d+: input should be less",
        ),
        ("ps.flop_per_cycle", 1e-300, r"`ps\.flop_per_cycle` = 1e-300: input should be greater than"),
        (
            "pl.clock_mhz",
            1e6,
            r"`pl\.clock_mhz` = 1000000\.0: input should be less than or equal to 1000",
        ),
        (
            "ps.clock_mhz",
            -1.0,
            r"`ps\.clock_mhz` = -1\.0: input should be greater than or equal to 0\.001",
        ),
        ("ps.clock_mhz", float("nan"), r"`ps\.clock_mhz` = nan: input should be"),
        (
            "link.register_write_ns",
            -59.0,
            r"`link\.register_write_ns` = -59\.0: input should be greater than",
        ),
        (
            "link.dma_fixed_us",
            float("inf"),
            r"`link\.dma_fixed_us` = inf: input should be a finite number",
        ),
        (
            "link.ddr_efficiency",
            1.5,
            r"`link\.ddr_efficiency` = 1\.5: input should be less than or equal to 1",
        ),
        ("pl.microcode_format", "zip", r"`pl\.microcode_format` = 'zip': .*flat\|compressed"),
        (
            "pl.latency_preset",
            "fast",
            r"`latency` preset 'fast' is not known; allowed: orbsoc_rtl, vendor_ip",
        ),
    ],
)
def test_an_impossible_value_is_refused_by_name(key: str, value: float | int | str, says: str) -> None:
    with pytest.raises(
        PlatformError, match=f"platform zu9eg: .*{says}" if "not a param" not in says else says
    ):
        load_platform("zu9eg").with_value(key, value)


def entry(value: str, tag: str = "assumed", rest: str = "") -> str:
    return f'{{ value = {value}, tag = "{tag}", source = "test"{rest} }}'


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"pl_lanes": entry("-2")}, r"`pl\.lanes` = -2: input should be greater than or equal to 1"),
        (
            {"pl_clock_mhz": entry("-100.0")},
            r"`pl\.clock_mhz` = -100\.0: input should be greater than or equal to 0\.001",
        ),
        ({"ps_div_f64_cycles": entry("-1")}, r"`ps\.div_f64_cycles` = -1"),
        (
            {"pl_lanes": entry("2", tag="guessed")},
            r"`pl\.lanes\.tag` = 'guessed': .*'sourced', 'measured', 'routed', 'executed', 'counted', 'scaled' or 'assumed'",
        ),
        ({"pl_lanes": '{ value = 2, tag = "assumed" }'}, r"`pl\.lanes\.source` is missing"),
        ({"pl_lanes": '{ value = 2, tag = "assumed", source = "" }'}, r"`pl\.lanes\.source` = ''"),
        (
            {"pl_lanes": entry("2", rest=", unit = 1")},
            r"`pl\.lanes\.unit` = 1 is not a known key; allowed here: value, ",
        ),
        ({"pl_lanes": "2"}, r"`pl\.lanes` = 2"),
        (
            {"pl_lanes": entry("2", rest=", low = 1")},
            r"`pl\.lanes`: low = 1, value = 2, high = None: a band needs both",
        ),
        (
            {"pl_lanes": entry("2", rest=", low = 3, high = 4")},
            r"`pl\.lanes`: low = 3, value = 2, high = 4: .*low ≤ value ≤ high",
        ),
        ({"link_ddr_efficiency": entry("0.0")}, r"`link\.ddr_efficiency` = 0\.0"),
    ],
)
def test_a_bad_entry_of_a_file_is_refused_by_name(tmp_path: Path, change: dict[str, str], says: str) -> None:
    with pytest.raises(PlatformError, match=rf"platform paper_computer\.toml: {says}"):
        tiny_platform(tmp_path, **change)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("[pl]", "[pl]\nturbo = 1", r"`pl\.turbo` = 1 is not a known key; allowed here: clock_mhz, lanes, "),
        (
            "[resources]",
            "[gpu]\n[resources]",
            r"`gpu` = \{\} is not a known key; allowed here: name, description, ps",
        ),
        ('core = "paper core"', "", r"`ps\.core` is missing; required here: core, cores, "),
        (
            'core = "paper core"',
            'core = "c"\npreset = "z80"',
            r"`ps` preset 'z80' is not known; allowed: cortex_a53, ",
        ),
        ('core = "paper core"', 'core = "c"\nborrowed = true', r"`ps\.borrowed` = True needs `ps\.preset`"),
        ('latency_preset = "orbsoc_rtl"', 'latency_preset = "x"', r"`latency` preset 'x' is not known"),
        ('latency_preset = "orbsoc_rtl"', "", r"`pl\.latency_preset` is missing"),
        (
            "[pl]",
            "[pl]\n[pl.latencies]\n[pl.rest]",
            r"`pl\.latencies` cannot be given; name a `pl\.latency_preset`",
        ),
        ("[ps]", "[ps", r"not a TOML file"),
        (
            '[ps]\ncore = "paper core"',
            '[ps]\npreset = "cortex_a53"\nborrowed = 1',
            r"`ps\.borrowed` = 1: allowed are",
        ),
    ],
)
def test_a_bad_file_is_refused_by_name(tmp_path: Path, old: str, new: str, says: str) -> None:
    text = platform_toml()
    assert old in text
    path = tmp_path / "bad.toml"
    if "[pl.latencies]" in new:
        new = 'latency_preset = "orbsoc_rtl"\nlatencies = 3'
        old = 'latency_preset = "orbsoc_rtl"'
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(PlatformError, match=rf"platform bad\.toml: .*{says}"):
        load_platform(path)


def test_an_unknown_name_lists_the_known_ones() -> None:
    known = "fmql45t900, k26, mpfs250t, ng_ultra, rocket_soc, vc1902, xc7z020, xc7z045, zu7ev, zu9eg"
    with pytest.raises(PlatformError, match=f"platform 'zu9' is not known; known: {known}, or the path"):
        load_platform("zu9")


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(PlatformError, match=r"platform none\.toml: cannot be read"):
        load_platform(tmp_path / "none.toml")


def test_a_file_may_override_a_preset(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    text = platform_toml().replace('core = "paper core"', 'preset = "cortex_a7"')
    path.write_text(text, encoding="utf-8")
    platform = load_platform(str(path))
    assert platform.ps.core == "Arm Cortex-A7"
    assert platform.ps.flop_per_cycle == Parameter[float](value=0.5, tag="assumed", source="round")


def test_a_platform_cannot_be_changed_in_place(tmp_path: Path) -> None:
    platform: Platform = tiny_platform(tmp_path)
    with pytest.raises(ValueError, match="frozen"):
        platform.pl.lanes.value = 3
