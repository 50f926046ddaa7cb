"""Draw docs/figures/architecture.svg and .png: mission, problem, solver on PS and PL, cycles, verdict.

`python scripts/draw_architecture.py` needs matplotlib only. The picture has its own light ground, for dark pages too.
"""

from __future__ import annotations

from drawing import (
    BLUE,
    CARD,
    GREEN,
    INDIGO,
    INK,
    LINE,
    ORANGE,
    PURPLE,
    RED,
    SOFT,
    TEAL,
    arrow,
    box,
    canvas,
    save,
    text,
)  # fmt: skip
from matplotlib.axes import Axes

WIDTH, HEIGHT = 1040, 452
VERDICTS = {"PASS": GREEN, "MARGINAL": ORANGE, "FAIL": RED}
MISSION = "vehicle, orbit, burn|as data, SI units||collocation and|sequential convex|programming"
PROBLEM = "min  ½ xᵀPx + cᵀx|Ax = b,  Gx + s = h|s in R₊ × cones||LP, QP and SOCP,|from anywhere"
CYCLES = "static schedules,|microcode, area||DMA, interrupts,|cache, jitter,|worst case"
CARDS = (
    (24, 158, TEAL, "Mission", MISSION, "missions/  guidance/"),
    (220, 158, BLUE, "Conic problem", PROBLEM, "conic/"),
    (782, 120, RED, "Cycles", CYCLES, "orbsoc-hw/|hw_model/"),
    (938, 82, GREEN, "Verdict", "|PASS|MARGINAL|FAIL||and why", "report/"),
)
"""Left edge, width, colour, title, lines, and the folders where it lives."""
STAGES = ("residuals", "scaling", "factorize", "solve", "step")
PS = "schedules stages|statistics|decisions||processor cores;|Python plays it"
PL = ("matrix update", "matrix scaling", "factorization", "linear solve", "cone operations", "line search")


def main() -> None:
    figure, axes = canvas(WIDTH, HEIGHT)
    question = "Can this spacecraft re-plan its orbit on this chip, before this deadline?"
    text(axes, (24, 30), question, 14.5, weight="bold", at="left")
    answer = "A mission becomes conic problems; their solves run in stages on a processor (PS) and programmable logic (PL)"
    text(axes, (24, 52), f"{answer}, and are timed.", 10, SOFT, at="left")
    for card in CARDS:
        _card(axes, *card)
    _solver(axes, 416, 78, 328, 350)
    for left, right in ((182, 220), (378, 416), (744, 782), (902, 938)):
        arrow(axes, (left + 2, 249), (right - 2, 249))
    axes.plot((416, 103), (400, 400), color=SOFT, linewidth=1.2, solid_capstyle="projecting")
    arrow(axes, (103, 400), (103, 357), SOFT)
    text(axes, (262, 391), "solution, verified on the problem's own data", 9.5, SOFT)
    text(axes, (262, 417), "next subproblem of the sequence, until it converges", 9.5, SOFT)
    save(figure, "architecture")


def _card(axes: Axes, left: float, width: float, color: str, title: str, lines: str, folder: str) -> None:
    box(axes, (left, 143, width, 212), CARD, LINE, band=color)
    text(axes, (left + width / 2, 177), title, 13, color, weight="bold")
    for k, line in enumerate(lines.split("|")):
        weight = "bold" if line in VERDICTS else "normal"
        text(axes, (left + width / 2, 205 + 18 * k), line, 10, VERDICTS.get(line, INK), weight=weight)
    for k, line in enumerate(reversed(folder.split("|"))):
        text(axes, (left + width / 2, 343 - 15 * k), line, 9, SOFT, mono=True)


def _solver(axes: Axes, left: float, top: float, width: float, height: float) -> None:
    """The solver's list of stages, above the computer that runs them."""
    middle, right = left + width / 2, left + width
    box(axes, (left, top, width, height), CARD, LINE, band=INDIGO)
    text(axes, (left + 16, top + 32), "Interior-point solver", 13, weight="bold", at="left")
    text(axes, (right - 16, top + 32), "rust/orbsoc", 9, SOFT, at="right", mono=True)
    for k, stage in enumerate(STAGES):
        box(axes, (left + 16 + 60.4 * k, top + 50, 54.4, 26), "#eceef8", "#aab1dd", radius=5)
        text(axes, (left + 43.2 + 60.4 * k, top + 67), stage, 9, INDIGO)
    text(
        axes, (middle, top + 96), "one list of stages: scalar, SIMD lanes, or PS + PL, to the bit", 9.5, SOFT
    )
    arrow(axes, (middle - 26, top + 132), (middle - 26, top + 104))
    arrow(axes, (middle + 26, top + 104), (middle + 26, top + 132))

    box(axes, (left + 10, top + 136, width - 20, height - 146), "#faf8f4", LINE, radius=9, dashed=True)
    text(axes, (left + 22, top + 156), "Emulated computer", 10.5, weight="bold", at="left")
    text(axes, (right - 22, top + 156), "ps/   rtl/", 9, SOFT, at="right", mono=True)
    y, tall = top + 170, height - 190
    box(axes, (left + 20, y, 98, tall), "#fdf1e8", "#e0a376", radius=7)
    text(axes, (left + 69, y + 24), "PS", 13, ORANGE, weight="bold")
    for k, line in enumerate(PS.split("|")):
        text(axes, (left + 69, y + 48 + 18 * k), line, 9, INK if k < 4 else SOFT)
    box(axes, (left + 172, y, 136, tall), "#f6eefa", "#c19ad4", radius=7)
    text(axes, (left + 240, y + 24), "PL", 13, PURPLE, weight="bold")
    for k, module in enumerate(PL):
        box(axes, (left + 182, y + 34 + 18.6 * k, 116, 15.6), CARD, "#d8bfe4", radius=4)
        text(axes, (left + 240, y + 45.3 + 18.6 * k), module, 8.6)
    text(axes, (left + 240, y + tall - 5), "RTL: equal cycles and bits", 7.4, SOFT)
    arrow(axes, (left + 119, y + 56), (left + 171, y + 56))
    arrow(axes, (left + 171, y + 108), (left + 119, y + 108))
    for below, crossing in ((46, "registers"), (76, "buffers"), (98, "interrupt")):
        text(axes, (left + 145, y + below), crossing, 8, SOFT)


if __name__ == "__main__":
    main()
