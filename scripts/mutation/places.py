"""Every place of the RTL where a mutant can be made, from the syntax tree of each file, and what can be wrong there."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pyslang.parsing import Token
from pyslang.syntax import SyntaxTree

OTHER_OPERATORS = {
    "+": "-", "-": "+", "*": "+", "&": "|", "|": "&", "^": "|", "&&": "||", "||": "&&", "==": "!=", "!=": "==",
    "<": "<=", "<=": "<", ">": ">=", ">=": ">", "<<": ">>", ">>": "<<", ">>>": ">>",
}  # fmt: skip
"""What is written instead of an operator between two operands."""
EITHER_ALONE = {"+", "-", "&", "|", "^", "&&", "||", "<<", ">>"}
"""Operators of which an operand can be forgotten."""
CONSTANT = {
    "ParameterDeclaration", "ParameterDeclarationStatement", "ParameterValueAssignment", "VariableDimension", "SimpleRangeSelect",
    "EventControlWithExpression", "DataDeclaration",
}  # fmt: skip
"""What elaboration reads. An index is not among it, nor where a range of given width begins."""

WHOLE = {"SimpleSequenceExpr", "AssignmentExpression"}
"""Where a signal is all that is given on."""


@dataclass(frozen=True, slots=True)
class Mutant:
    """One thing that is wrong in one place: bytes `start` to `end` of a file of `rtl/` are `instead`."""

    file: str
    line: int
    start: int
    end: int
    kind: str
    was: str
    instead: str
    drops: bool = False
    """A statement that is left out; else an expression."""


@dataclass(frozen=True, slots=True)
class _Source:
    file: str
    text: bytes
    inputs: dict[str, frozenset[str]]
    """The input ports of each module but its clock."""

    def of(self, node: Any) -> str:
        """The text of a node in one line, without comments."""
        text = self.text[node.sourceRange.start.offset : node.sourceRange.end.offset].decode()
        return " ".join(re.sub(r"//[^\n]*", "", text).split())

    def mutant(self, node: Any, kind: str, instead: str, drops: bool = False) -> Mutant:
        start, end = node.sourceRange.start.offset, node.sourceRange.end.offset
        line = self.text.count(b"\n", 0, start) + 1
        return Mutant(self.file, line, start, end, kind, self.of(node), instead, drops)


def mutants_of(rtl: Path, files: Iterable[str]) -> dict[str, list[Mutant]]:
    """What can be wrong in each of these files."""
    trees = {}
    inputs: dict[str, frozenset[str]] = {}
    for file in files:
        text = (rtl / file).read_bytes()
        # An included file is one of its own.
        parsed = re.sub(rb"`include[^\n]*", lambda found: b" " * len(found[0]), text).decode("latin-1")
        trees[file] = text, SyntaxTree.fromText(parsed.encode("ascii", "replace").decode())
        inputs |= dict(_inputs(trees[file][1].root))
    return {
        file: list(_within(_Source(file, text, inputs), tree.root, live=False))
        for file, (text, tree) in trees.items()
    }


def _children(node: Any) -> list[Any]:
    return [child for child in node if child is not None and not isinstance(child, Token)]


def _kind(node: Any) -> str:
    return str(node.kind).rpartition(".")[2]


def _inputs(node: Any) -> Iterator[tuple[str, frozenset[str]]]:
    if _kind(node) == "ModuleDeclaration":
        header = str(node.header)
        names = re.findall(r"\binput\b[^,)]*?(\w+)\s*(?=[,)]|//)", re.sub(r"//[^\n]*", "", header) + ")")
        yield node.header.name.valueText, frozenset(names) - {"clock"}
    for child in _children(node):
        yield from _inputs(child)


def _within(source: _Source, node: Any, live: bool) -> Iterator[Mutant]:
    """The mutants of a node and all below it; `live`: it is computed while the clock runs."""
    kind = _kind(node)
    if kind in CONSTANT:
        return
    if live:
        yield from _at(source, node, kind)
    if kind == "ExpressionStatement" and _kind(node.expr) == "NonblockingAssignmentExpression":
        yield source.mutant(node, "assignment dropped", "", drops=True)
    if kind in ("IdentifierName", "IdentifierSelectName") and live and _kind(node.parent) in WHOLE:
        yield source.mutant(node, "value inverted", f"~{source.of(node)}")
    for child, alive in _below(source, node, kind, live):
        yield from _within(source, child, alive)


def _below(source: _Source, node: Any, kind: str, live: bool) -> list[tuple[Any, bool]]:
    """The children of a node in which a mutant can be, and whether they are live."""
    match kind:
        case "AssignmentExpression" | "NonblockingAssignmentExpression":
            if source.of(node.left) == "unused":  # names what is not read, for lint
                return []
            return [(node.left, False), (node.right, True)]
        case "ElementSelect":
            return [(child, live) for child in _children(node)]
        case "AscendingRangeSelect" | "DescendingRangeSelect":
            return [(node.left, live)]
        case "CastExpression":
            return [(node.right, live)]
        case "MultipleConcatenationExpression":
            return [(node.concatenation, live)]
        case "ForLoopStatement":
            return [(node.statement, False)]
        case "LoopGenerate":
            return [(node.block, False)]
        case "IfGenerate":
            return [(child, False) for child in _children(node) if child != node.condition]
        case "StandardCaseItem":
            return [(node.clause, False)]
        case "ConditionalStatement":
            rest = [node.statement, node.elseClause]
            return [(node.predicate, True), *((each, False) for each in rest if each is not None)]
        case "InvocationExpression":
            return [(node.arguments, live)] if not source.of(node).startswith("$") else []
        case "HierarchyInstantiation":
            ports = source.inputs.get(node.type.valueText, frozenset())
            return [(each.expr, True) for each in _connections(node) if each.name.valueText in ports]
        case _:
            return [(child, live) for child in _children(node)]


def _connections(node: Any) -> Iterator[Any]:
    if _kind(node) == "NamedPortConnection" and node.expr is not None:
        yield node
    for child in _children(node):
        yield from _connections(child)


def _at(source: _Source, node: Any, kind: str) -> Iterator[Mutant]:
    """What can be wrong at a live node itself."""
    text = source.of(node)
    if kind in ("IntegerLiteralExpression", "IntegerVectorExpression"):
        yield source.mutant(node, "constant off by one", f"{text} + {_one(text)}")
    elif kind == "UnbasedUnsizedLiteralExpression":
        yield source.mutant(node, "constant of other bits", "'1" if text == "'0" else "'0")
    elif kind in ("UnaryLogicalNotExpression", "UnaryBitwiseNotExpression"):
        yield source.mutant(node, "operator left out", source.of(node.operand))
    elif kind == "ConditionalExpression":
        condition, left, right = (source.of(each) for each in (node.predicate, node.left, node.right))
        yield source.mutant(node, "condition negated", f"!({condition}) ? {left} : {right}")
        yield source.mutant(node, "condition taken for true", left)
        yield source.mutant(node, "condition taken for false", right)
    elif kind == "ConditionalPredicate" and _kind(node.parent) == "ConditionalStatement":
        yield source.mutant(node, "condition negated", f"!({text})")
        yield source.mutant(node, "condition taken for true", "1'b1")
        yield source.mutant(node, "condition taken for false", "1'b0")
    elif (operator := _operator(node, kind)) in OTHER_OPERATORS:
        left, right = (
            f"({each})" if " " in each else each for each in map(source.of, (node.left, node.right))
        )
        yield source.mutant(node, "other operator", f"{left} {OTHER_OPERATORS[operator]} {right}")
        if operator in EITHER_ALONE:
            yield source.mutant(node, "operand dropped", left)
        if operator in EITHER_ALONE - {"<<", ">>"}:
            yield source.mutant(node, "operand dropped", right)


def _operator(node: Any, kind: str) -> str:
    """Of an expression with two operands."""
    binary = kind.endswith("Expression") and hasattr(node, "operatorToken") and hasattr(node, "left")
    return str(node.operatorToken.valueText) if binary else ""


def _one(literal: str) -> str:
    """A one that changes neither the sign nor the width of what it is added to."""
    return "1'b1" if "'" in literal else "1"
