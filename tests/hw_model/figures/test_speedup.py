"""Figures are drawn from reports and say that they are modelled."""

from __future__ import annotations

from pathlib import Path

import pytest

from hw_model.errors import HwModelError
from hw_model.figures.speedup import module_figure, speedup_figure
from hw_model.platform.platform import platform_names
from hw_model.report.speedup import speedup
from tests.hw_model.synthetic import synthetic_trace

TRACE = synthetic_trace(iterations=3)
PNG = b"\x89PNG\r\n\x1a\n"


def test_a_bar_per_report_with_its_band(tmp_path: Path) -> None:
    reports = [speedup(TRACE, device, "paper") for device in ("zu9eg", "fmql45t900", "zu9eg")]
    figure = speedup_figure(reports, tmp_path / "speedup.png")
    assert (tmp_path / "speedup.png").read_bytes().startswith(PNG)
    [axes] = figure.axes
    [bars] = [group for group in axes.containers if hasattr(group, "patches") and len(group.patches) == 1][:1]
    assert bars.patches[0].get_height() == reports[0].speedup.nominal
    heights = [patch.get_height() for patch in axes.patches]
    # Grouped by device, in order of first appearance.
    assert heights == [reports[k].speedup.nominal for k in (0, 2, 1)]
    assert "Modelled" in axes.get_title()
    assert axes.get_ylim()[1] > max(report.speedup.high for report in reports)


def test_a_bar_whose_engine_does_not_fit_is_an_outline_and_says_so() -> None:
    reports = [speedup(TRACE, device, "paper") for device in ("zu9eg", "xc7z020")]
    [axes] = speedup_figure(reports, fits=[True, False]).axes
    assert [patch.get_hatch() for patch in axes.patches] == [None, "///"]
    assert ["does not fit" in text.get_text() for text in axes.texts] == [False, True]
    [plain] = speedup_figure(reports).axes
    assert not any("does not fit" in text.get_text() for text in plain.texts)


def test_many_devices_take_rows_of_one_scale() -> None:
    devices = platform_names()
    axes = speedup_figure([speedup(TRACE, device, "paper") for device in devices]).axes
    rows = [[label.get_text().splitlines()[0] for label in row.get_xticklabels()] for row in axes]
    assert [name for row in rows for name in row] == devices
    assert len(rows) > 1
    assert max(map(len, rows)) - min(map(len, rows)) <= 1
    assert len({row.get_ylim() for row in axes}) == 1


def test_module_bars_have_the_length_of_the_modules(tmp_path: Path) -> None:
    report = speedup(TRACE, "zu9eg", "paper")
    figure = module_figure(report, tmp_path / "modules.png")
    assert (tmp_path / "modules.png").read_bytes().startswith(PNG)
    [axes] = figure.axes
    total = sum(patch.get_width() for patch in axes.patches)
    expected = sum(row.picoseconds + row.baseline_picoseconds for row in report.modules) / 1e9
    assert total == pytest.approx(expected, rel=1e-12)
    assert "Modelled" in axes.get_title()
    assert "modelled" in axes.get_xlabel()


def test_what_cannot_be_compared_is_refused() -> None:
    with pytest.raises(HwModelError, match="`reports` is empty"):
        speedup_figure([])
    mixed = [speedup(TRACE, "zu9eg", "paper", baseline=base) for base in ("all_ps", "factor_only")]
    with pytest.raises(HwModelError, match="different baselines: all_ps, factor_only"):
        speedup_figure(mixed)
