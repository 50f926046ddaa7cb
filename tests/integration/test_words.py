"""Sources and texts use the words of docs/glossary.md, not those that it replaced.

Names, comments and docstrings count; other strings, and the code in texts, may say what they like.
"""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FOLDERS = ("python", "hw_model", "rust", "rtl", "flight", "benchmarks", "scripts", "tests", "docs")
SUFFIXES = {".py", ".pyi", ".rs", ".sv", ".svh", ".hpp", ".cpp", ".c", ".h", ".core", ".sh", ".toml", ".md"}
EXEMPT = {ROOT / "docs" / "glossary.md"}
"""Lists the old words beside the new ones."""
OLD = re.compile(
    r"\b(walk\w*|stretch\w*|abreast|desks?|crews?|seat\w*|ragged|doubt\w*|habits?|urgency|heirs?|whoever|nobody|somebody"
    r"|so\s+(?:many|few))\b",
    re.IGNORECASE,
)
LIBRARY = re.compile(r"\b(?:os|ast|pkgutil)\.walk\w*")
"""Calls of Python's own library."""
LITERAL = re.compile(r'r(#*)".*?"\1|"(?:\\.|[^"\\\n])*"', re.DOTALL)
CODE = re.compile(r"```.*?```|`[^`]*`", re.DOTALL)


def python_text(source: str) -> str:
    """A Python source whose strings are blank, docstrings apart."""
    lines = source.encode().splitlines(keepends=True)
    starts = [0]
    for line in lines:
        starts.append(starts[-1] + len(line))
    text = bytearray(source.encode())
    tree = ast.parse(source)
    stated = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        is_text = isinstance(node, ast.JoinedStr) or (
            isinstance(node, ast.Constant) and isinstance(node.value, str)
        )
        if is_text and id(node) not in stated and node.end_lineno and node.end_col_offset is not None:
            first = starts[node.lineno - 1] + node.col_offset
            last = starts[node.end_lineno - 1] + node.end_col_offset
            text[first:last] = re.sub(rb"[^\n]", b" ", text[first:last])
    return text.decode()


def old_words(source: str, suffix: str) -> list[str]:
    """`line: word` of each old word in a source of this kind."""
    if suffix in (".py", ".pyi"):
        text = LIBRARY.sub("", python_text(source))
    else:
        pattern = CODE if suffix == ".md" else LITERAL
        text = pattern.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), source)
    words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|_", " ", text)
    return [f"{words.count(chr(10), 0, found.start()) + 1}: {found[0]}" for found in OLD.finditer(words)]


FILES = sorted(
    path
    for folder in FOLDERS
    for path in (ROOT / folder).rglob("*")
    if path.suffix in SUFFIXES and path not in EXEMPT
)
FILES += [*ROOT.glob("*.md"), *ROOT.glob("*.toml"), ROOT / "Makefile"]


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_no_old_word_is_in_a_source(path: Path) -> None:
    assert old_words(path.read_text(encoding="utf-8"), path.suffix) == []


@pytest.mark.parametrize(
    ("source", "suffix", "found"),
    [
        ("def second_walk(): ...", ".py", ["1: walk"]),
        ('x = "walk"\nfor node in ast.walk(tree): ...  # whoever', ".py", ["2: whoever"]),
        ('def f():\n    """So\n    many."""', ".py", ["2: So\n    many"]),
        ('x = f"a {desk} walk"', ".py", []),
        ("class LaneSeats: ...", ".py", ["1: Seats"]),
        ('let walked = "walk"; // doubtful', ".rs", ["1: walked", "1: doubtful"]),
        ('let text = r#"a "walk" here"#;', ".rs", []),
        ("A walk, as `walk` says.\n```\nwalk\n```\n", ".md", ["1: walk"]),
        ("sidewalk, habitat, heirloom, so much", ".md", []),
    ],
)
def test_the_check_finds_what_it_must(source: str, suffix: str, found: list[str]) -> None:
    assert old_words(source, suffix) == found
