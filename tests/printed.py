"""What a page shows against what a command prints: words alike, and numbers as near as two processors are.

The last bits of a plan depend on the processor: NumPy takes the widest vectors that it finds. An iteration then refines once more or less, and a
modelled time moves by some thousandths: 16.3 ms by 6. So counts below 1000 are equal, numbers agree to 1 %, or to a unit of the last digit that is
shown, and what is below 1e-6, a residual, to a factor of ten. A plan's own figures move less: a test of these gives its own `relative`.
"""

from __future__ import annotations

import math
import re

NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e[-+]?\d+)?")
RELATIVE, RESIDUAL, COUNT = 0.01, 1e-6, 1000


def shows(shown: str, printed: str, relative: float = RELATIVE) -> bool:
    """Whether `printed` is what `shown` says; … stands for anything."""
    parts = []
    for part in shown.rstrip().split("…"):
        words = [re.escape(words) for words in NUMBER.split(part)]
        parts.append(f"({NUMBER.pattern})".join(words))
    found = re.compile(".*".join(parts) + r"\s*", re.DOTALL).fullmatch(printed)
    pairs = [] if found is None else zip(NUMBER.findall(shown.rstrip()), found.groups(), strict=True)
    return found is not None and all(near(*pair, relative) for pair in pairs)


def near(shown: str, printed: str, relative: float = RELATIVE) -> bool:
    """Whether two numbers, as text, are one."""
    one, other = float(shown), float(printed)
    if shown.isdigit() and printed.isdigit() and max(one, other) < COUNT:
        return one == other
    if 0.0 < one < RESIDUAL and 0.0 < other < RESIDUAL:
        return abs(math.log10(one / other)) <= 1.0
    digits = len(shown.partition("e")[0].partition(".")[2])
    unit = 10.0**-digits if "e" not in shown else 0.0
    return abs(one - other) <= max(relative * abs(one), 1.001 * unit)
