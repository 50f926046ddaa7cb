"""Draw docs/figures/pl-engine, pl-registers and pl-clusters, .svg and .png: the PL as blocks, what the PS sees of it, and
lanes and banks in clusters.

`python scripts/draw_pl.py` needs matplotlib and orbsoc, whose register map it draws.
"""

from __future__ import annotations

from drawing import BLUE, CARD, GREEN, INK, LINE, ORANGE, PURPLE, SOFT, TEAL, arrow, box, canvas, save, text
from matplotlib.axes import Axes

from orbsoc.ps.registers import Register

ACCESS = {Register.STATUS: "read", Register.DATA_VALID: "read"}
FIELDS: dict[Register, tuple[tuple[int, int, str], ...]] = {
    Register.MODULE: ((0, 31, "0 PS, 1–7 the modules of the PL"),),
    Register.SEGMENT: ((0, 31, "number of the stage"),),
    Register.SEQUENCE: ((0, 31, "launch counter"),),
    Register.CONTROL: ((0, 31, "1 START, 2 PUBLISH, 3 ATTEMPT"),),
    Register.STATUS: (
        (0, 0, "BUSY"), (1, 1, "DONE"), (2, 2, "ARMED"), (4, 5, "OUTCOME"), (8, 11, "FAULT"),
        (16, 23, "SEGMENT"), (24, 31, "SEQUENCE"),
    ),
    Register.IRQ_ACK: ((0, 31, "SEQUENCE of the launch whose interrupt is taken"),),
    Register.STOP: ((0, 0, "STOP"),),
    Register.DATA_VALID: ((0, 31, "one flag a buffer, 32 a word"),),
}  # fmt: skip
"""First and last bit of each field."""


def main() -> None:
    engine()
    registers()
    clusters()


def engine() -> None:
    """Blocks of the engine, and the way of one operation through them."""
    figure, axes = canvas(1040, 470)
    heading(
        axes,
        "The PL engine: a static schedule, so nothing waits that the schedule did not plan",
        "one microcode word a cycle starts at most one operation in every lane and divider",
    )
    box(axes, (816, 222, 210, 206), "#f6eefa", "#c19ad4", radius=8, dashed=True)
    for place, face, edge, title, lines, color in (
        ((24, 92, 120, 330), "#fdf1e8", "#e0a376", "PS", "schedules stages|moves buffers|takes interrupts", ORANGE),
        ((196, 92, 150, 120), CARD, LINE, "Registers", "frame of a launch|status, flags|interrupt", BLUE),
        ((196, 262, 150, 160), CARD, LINE, "Microcode", "segments, one a stage|flat, or compressed|behind a decoder", BLUE),
        ((386, 262, 120, 160), CARD, LINE, "Sequencer", "reads a word|a cycle; decides|nothing", BLUE),
        ((546, 92, 210, 120), CARD, LINE, "Banks", "word w in bank w mod BANKS|three replicas: operands a, b, c|one write port, in all three", TEAL),
        ((826, 232, 190, 100), CARD, LINE, "Lanes", "multiply, then add|or compare, select, move|one result a cycle", PURPLE),
        ((826, 342, 190, 80), CARD, LINE, "Dividers", "divide, square root|IEEE-exact", PURPLE),
    ):  # fmt: skip
        box(axes, place, face, edge, band=color)
        left, top, width, _ = place
        text(axes, (left + width / 2, top + 30), title, 12.5, color, weight="bold")
        for k, line in enumerate(lines.split("|")):
            text(axes, (left + width / 2, top + 52 + 17 * k), line, 9.2)
    for place, line in (
        ((546, 262, 120, 160), "issue|register"),
        ((690, 262, 96, 70), "operand|registers"),
        ((690, 352, 96, 70), "result|registers"),
    ):
        box(axes, place, "#eef3fa", "#a9bfdc", radius=6)
        for k, word in enumerate(line.split("|")):
            text(axes, (place[0] + place[2] / 2, place[1] + place[3] / 2 - 4 + 16 * k), word, 9.4)
    for start, end in (
        ((144, 130), (196, 130)), ((196, 180), (144, 180)), ((346, 342), (386, 342)), ((506, 342), (546, 342)),
        ((270, 212), (270, 262)), ((606, 262), (606, 212)), ((738, 212), (738, 262)), ((786, 290), (816, 290)),
        ((816, 390), (786, 390)), ((690, 372), (676, 372)),
    ):  # fmt: skip
        arrow(axes, start, end)
    axes.plot((676, 676), (372, 232), color=INK, linewidth=1.2)
    arrow(axes, (676, 232), (676, 212))
    axes.plot((84, 84), (422, 444), color=GREEN, linewidth=1.2)
    axes.plot((84, 1030), (444, 444), color=GREEN, linewidth=1.2)
    axes.plot((1030, 1030), (444, 150), color=GREEN, linewidth=1.2)
    arrow(axes, (1030, 150), (756, 150), GREEN)
    for place, words, color in (
        ((170, 122), "launch", SOFT), ((170, 172), "interrupt", SOFT), ((313, 240), "START", SOFT),
        ((598, 240), "address crossbar", SOFT), ((772, 240), "data crossbar", SOFT),
        ((670, 226), "write", SOFT), ((560, 458), "buffers, by DMA or by a core, between segments", GREEN),
    ):  # fmt: skip
        text(
            axes, place, words, 8.4, color, at="right" if words in ("write", "address crossbar") else "center"
        )
    save(figure, "pl-engine")


def registers() -> None:
    """The register map, with the bits of each word."""
    figure, axes = canvas(1040, 92 + 44 * len(Register))
    heading(axes, "What the PS sees of the PL: 32-bit words at byte addresses")
    left, width = 268, 748
    for bit in (31, 24, 16, 8, 0):
        text(axes, (left + width * (31.5 - bit) / 32, 62), str(bit), 8.6, SOFT)
    for k, register in enumerate(Register):
        top = 72 + 44 * k
        text(axes, (24, top + 22), f"0x{register:02X}", 10, SOFT, at="left", mono=True)
        text(axes, (82, top + 22), register.name, 10.5, BLUE, weight="bold", at="left")
        text(axes, (250, top + 22), ACCESS.get(register, "write"), 9, SOFT, at="right")
        box(axes, (left, top + 2, width, 32), "#ece9e1", LINE, radius=3)
        for first, last, name in FIELDS[register]:
            _field(axes, left + width * (31 - last) / 32, top + 2, width * (last - first + 1) / 32, name)
    save(figure, "pl-registers")


def clusters() -> None:
    """Two of several clusters, and the network between them."""
    figure, axes = canvas(1040, 400)
    heading(
        axes,
        "Clusters: own banks, own lanes, one word a cycle between",
        "from each replica of a cluster one word a cycle goes to lanes of others, from each cluster one result to banks of others",
    )
    for left, name in ((24, "cluster 0"), (694, "cluster 1 … CLUSTERS − 1")):
        box(axes, (left, 76, 322, 300), "#fbfaf7", LINE, radius=8, dashed=True)
        text(axes, (left + 161, 100), name, 11, weight="bold")
        for top, face, title, line, color in (
            (116, CARD, "Banks", "words w with w mod CLUSTERS = cluster", TEAL),
            (206, "#eef3fa", "Crossbars", "own banks and imports to own units", BLUE),
            (296, CARD, "Lanes, dividers", "LANES / CLUSTERS, some with a divider", PURPLE),
        ):
            box(axes, (left + 22, top, 278, 64), face, LINE, band=color)
            text(axes, (left + 161, top + 28), title, 12, color, weight="bold")
            text(axes, (left + 161, top + 48), line, 9.2)
        for x, start, end in ((60, 180, 206), (60, 270, 296), (262, 296, 270), (262, 206, 180)):
            arrow(axes, (left + x, start), (left + x, end))
    box(axes, (420, 116, 200, 244), "#f6eefa", "#c19ad4", radius=8)
    text(axes, (520, 142), "Network", 12.5, PURPLE, weight="bold")
    for k, line in enumerate(
        ("an OR of one word from each cluster:", "three replicas to read,", "one way to write")
    ):
        text(axes, (520, 164 + 17 * k), line, 9.2)
    for y, words in ((234, "words read elsewhere"), (316, "results for other banks")):
        arrow(axes, (326, y), (420, y), GREEN)
        arrow(axes, (620, y), (714, y), GREEN)
        arrow(axes, (714, y + 18), (620, y + 18), GREEN)
        arrow(axes, (420, y + 18), (326, y + 18), GREEN)
        text(axes, (520, y + 12), words, 9.2, GREEN)
    save(figure, "pl-clusters")


def heading(axes: Axes, title: str, line: str = "") -> None:
    """What a picture shows, and a line below."""
    text(axes, (24, 32), title, 14, weight="bold", at="left")
    text(axes, (24, 54), line, 10, SOFT, at="left")


def _field(axes: Axes, left: float, top: float, width: float, name: str) -> None:
    box(axes, (left, top, width, 32), CARD, "#a9bfdc", radius=3)
    narrow = width < 60
    text(
        axes, (left + width / 2, top + 20), name, 5.0 if narrow and len(name) > 4 else 6.0 if narrow else 9.2
    )


if __name__ == "__main__":
    main()
