"""What counts as the same text, and what does not."""

from __future__ import annotations

import pytest

from tests.printed import near, shows


def test_an_expected_text_is_taken_literally_but_for_its_dots() -> None:
    assert shows("a (1.5) … c\n", "a (1.5) b\nb c\n")
    assert not shows("a (1.5) … c\n", "a (1x5) b c\n")
    assert not shows("a", "a b")


@pytest.mark.parametrize(
    ("shown", "printed", "same"),
    [
        ("16.3", "16.4", True), ("16.3", "17.0", False), ("27.9", "28", True), ("4", "5", False), ("120", "121", False),
        ("1270460", "1271000", True), ("1270460", "1370000", False), ("5e-13", "4e-13", True), ("5e-13", "4e-11", False),
        ("0.007", "0.008", True), ("0.007", "0.009", False), ("5e-13", "4e-3", False), ("0", "0", True),
    ],
)  # fmt: skip
def test_numbers_are_near_and_counts_are_equal(shown: str, printed: str, same: bool) -> None:
    assert near(shown, printed) is same
    assert shows(f"worst {shown} of 50 ms", f"worst {printed} of 50 ms\n") is same
