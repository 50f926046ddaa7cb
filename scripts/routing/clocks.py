"""What follows from the record: the table of docs/rtl.md and the PL clocks of devices that no open tool routes."""

from __future__ import annotations

import json
import re
from typing import Any

from hw_model.platform.shape_clock import clock_law
from scripts.record_synthesis import FORMATS, ROOT
from scripts.routing.modules import UNFINISHED_MIN

RECORD = ROOT / "hw_model" / "platform" / "route.json"
PAGE = ROOT / "docs" / "rtl.md"
DEVICES = ROOT / "hw_model" / "platform" / "platforms"
PUBLISHED_MHZ = {"zu9eg": 714, "zu7ev": 714, "k26": 714, "xc7z045": 416, "fmql45t900": 416, "xc7z020": 238}
"""The clock of `picorv32_axi` that its authors print for the vendor's part with a device's logic: Kintex UltraScale+ -2 and
Kintex-7 -2 by Vivado 2017.3 (README of the package that is routed here), Artix-7 -1 by Vivado 2015.1 (README of 2016). The
FMQL45T900's logic is taken as an XC7Z045's."""


NEWER = ("zu9eg", "zu7ev", "k26")
"""Devices a generation of the vendor's logic after its slowest printed one, Artix-7 -1."""

CLOCK = re.compile(r"^clock_mhz = \{ value = [\d.]+, low = [\d.]+, high = [\d.]+,", re.MULTILINE)
"""The numbers of a clock in a device's file, which says how they follow."""


def scaled_clock_mhz(device: str, rows: list[dict[str, Any]]) -> tuple[int, int, int]:
    """The PL clock of a device, and its band, from the worst seeds of the engines and of PicoRV32 on the ECP5.

    High: the engines' clock times PicoRV32's gain from the ECP5 to the device. Low: no gain, as an engine has more wires
    than that core; on a NEWER device the gain of the generation before. Value: the root of the gain.
    """
    worst = {
        module: min(row["mhz"] for row in rows if row["part"] == "ecp5_85_8" and row["module"] == module)
        for module in ("engine", "picorv32_axi")
    }
    engine, core = worst["engine"], worst["picorv32_axi"]
    gain = PUBLISHED_MHZ[device] / core
    low = engine * PUBLISHED_MHZ["xc7z020"] / core if device in NEWER else engine
    return round(low), round(engine * gain**0.5), round(engine * gain)


def derived_clocks_mhz(slowest: int, zu9eg: tuple[int, int, int]) -> dict[str, tuple[int, int, int]]:
    """Clocks and bands of parts whose clock no author of PicoRV32 prints, from the slowest engine's and a ZU9EG's (their files say how).

    Versal: MicroBlaze's clocks on it and on UltraScale+ (UG984). NG-Ultra: from a third of the slowest engine's up to it. PolarFire: 40
    to 28 nm either way.
    """
    low, _, high = (mhz * 456 / 661 for mhz in zu9eg)
    return {
        "vc1902": (round(low), round((slowest * high) ** 0.5), round(high)),
        "ng_ultra": (round(slowest / 3), round(slowest / 3**0.5), slowest),
        "mpfs250t": (round(slowest * 28 / 40), slowest, round(slowest * 40 / 28)),
    }


def write_clocks(rows: list[dict[str, Any]]) -> None:
    """The PL clocks of the devices, into their files."""
    scaled = {device: scaled_clock_mhz(device, rows) for device in PUBLISHED_MHZ}
    derived = derived_clocks_mhz(scaled["xc7z045"][0], scaled["zu9eg"])
    for device, (low, value, high) in (scaled | derived).items():
        path = DEVICES / f"{device}.toml"
        before, pl, after = path.read_text().partition("[pl]\n")
        numbers = f"clock_mhz = {{ value = {value}.0, low = {low}.0, high = {high}.0,"
        path.write_text(before + pl + CLOCK.sub(numbers, after, count=1))


def key_of(row: dict[str, Any]) -> tuple[str, str, str, int]:
    """What a row is about."""
    return row["part"], row["module"], row["parameters"], row["seed"]


def write(rows: list[dict[str, Any]]) -> None:
    """The record, a row a line."""
    lines = ",\n".join(json.dumps(row) for row in rows)
    RECORD.write_text(f'{{"schema": "orbsoc.route/1", "rows": [\n{lines}\n]}}\n')


def with_table(page: str) -> str:
    """The page with the table between its two marks renewed."""
    first, last = "<!-- clocks -->\n", "<!-- end of clocks -->\n"
    before, rest = page.split(first)
    _, after = rest.split(last)
    return f"{before}{first}\n{table()}\n{last}{after}"


def table() -> str:
    """Clocks as Markdown: worst and best of the seeds, the worst one's critical path; and the clocks scaled from them."""
    lines = [
        "| part | module | seeds | MHz, worst | best | LUT | FF | DSP | BRAM | critical path, share of routing |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    rows = json.loads(RECORD.read_text())["rows"]
    for part, module, parameters in dict.fromkeys(key_of(row)[:3] for row in rows):
        of = [row for row in rows if key_of(row)[:3] == (part, module, parameters)]
        worst = min(of, key=lambda row: row["mhz"])
        best = max(row["mhz"] for row in of)
        lines.append(
            f"| {part} | `{module}` {FORMATS.get(parameters, parameters)} | {len(of)} | {worst['mhz']} | {best}"
            f" | {worst['lut']} | {worst['ff']} | {worst['dsp']} | {worst['bram']}"
            f" | `{worst['from']}` to `{worst['to']}`, {100 * worst['routing']:.0f} % |"
        )
    lines += [
        f"| ecp5_85_8 | `engine` {parameters} | 1 | not finished in {minutes} minutes | | | | | | |"
        for parameters, minutes in UNFINISHED_MIN.items()
    ]
    if any(row["module"] == "engine" for row in rows):
        lines += shapes()
        lines += ["", "| device | PL clock scaled to it, MHz | low | high |", "|---|--:|--:|--:|"]
        for device in PUBLISHED_MHZ:
            low, value, high = scaled_clock_mhz(device, rows)
            lines.append(f"| `{device}` | {value} | {low} | {high} |")
    return "\n".join(lines) + "\n"


def shapes() -> list[str]:
    """The law of the clock by shape, beside the engines that it is fitted to."""
    law = clock_law(RECORD)
    lines = [
        "",
        "| engine on the ECP5 | mean of its seeds, MHz | by the law | without it |",
        "|---|--:|--:|--:|",
    ]
    for shape, mhz in law.shapes.items():
        try:
            left_out = f"{law.without(shape).mhz(shape):.1f}"
        except ValueError:
            left_out = ""
        lines.append(f"| {shape.words} | {mhz:.1f} | {law.mhz(shape):.1f} | {left_out} |")
    return lines
