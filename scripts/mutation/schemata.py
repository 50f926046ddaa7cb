"""A copy of the RTL with many mutants in it, of which the environment variable ORBSOC_MUTANT turns one on as a model begins.

0, or no such variable, is the RTL as it is.
"""

from __future__ import annotations

import random
import shutil
from collections.abc import Iterable
from pathlib import Path

from scripts.mutation.places import Mutant

VARIABLE = "ORBSOC_MUTANT"
CHOSEN = f'  int mutant = $c32("std::getenv(\\"{VARIABLE}\\") ? std::atoi(std::getenv(\\"{VARIABLE}\\")) : 0");\nendpackage'


def drawn(of_files: dict[str, list[Mutant]], seed: int, count: int, least: int = 3) -> list[Mutant]:
    """`count` mutants, at most one in a place; at least `least` of every file that has as many places."""
    draw = random.Random(seed)
    places: dict[tuple[str, int, int], list[Mutant]] = {}
    for file in sorted(of_files):
        for mutant in of_files[file]:
            places.setdefault((file, mutant.start, mutant.end), []).append(mutant)
    chosen: list[tuple[str, int, int]] = []
    for file in sorted(of_files):
        own = [place for place in places if place[0] == file]
        chosen += draw.sample(own, min(least, len(own)))
    rest = [place for place in places if place not in set(chosen)]
    chosen += draw.sample(rest, min(len(rest), max(0, count - len(chosen))))
    return [draw.choice(places[place]) for place in sorted(chosen)]


def with_all(text: bytes, mutants: Iterable[tuple[int, Mutant]]) -> bytes:
    """The text of a file with these mutants by number; each is off unless its number is chosen. Lines stay where they are."""
    pieces: list[tuple[tuple[int, int, int, int], str]] = []
    for number, mutant in mutants:
        if mutant.drops:
            before, after = f"begin if (contract::mutant != {number}) ", " end"
        else:
            before, after = f"(contract::mutant == {number} ? ({mutant.instead}) : (", "))"
        length = mutant.end - mutant.start  # the longer begins first and ends last
        pieces.append(((mutant.start, 1, -length, number), before))
        pieces.append(((mutant.end, 0, length, -number), after))
    written, at = b"", 0
    for (place, *_), piece in sorted(pieces):
        written, at = written + text[at:place] + piece.encode(), place
    return written + text[at:]


def write_schemata(rtl: Path, copy: Path, mutants: dict[int, Mutant]) -> None:
    """The RTL with all mutants in it, into the folder `copy`."""
    shutil.copytree(rtl, copy)
    for file in {mutant.file for mutant in mutants.values()}:
        own = [(number, mutant) for number, mutant in mutants.items() if mutant.file == file]
        (copy / file).write_bytes(with_all((rtl / file).read_bytes(), own))
    _replace(copy / "contract.sv", "endpackage", CHOSEN)
    _replace(copy / "build.sh", "-Wall -Wno-UNUSED", "-Wno-fatal")  # a choice widens what it chooses from


def write_alone(rtl: Path, copy: Path, mutant: Mutant) -> None:
    """The RTL with one mutant that is always on: elaboration reads what it changes."""
    shutil.copytree(rtl, copy)
    text = (rtl / mutant.file).read_bytes()
    instead = "" if mutant.drops else f"({mutant.instead})"
    (copy / mutant.file).write_bytes(text[: mutant.start] + instead.encode() + text[mutant.end :])
    _replace(copy / "build.sh", "-Wall -Wno-UNUSED", "-Wno-fatal")


def _replace(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    if text.count(old) != 1:
        raise ValueError(f"{path.name}: {old!r} is there {text.count(old)} times, not once")
    path.write_text(text.replace(old, new))
