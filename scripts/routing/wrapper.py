"""A module between registers, so that every path counts and few pins are needed."""

from __future__ import annotations

from typing import Any


def wrapper(module: str, given: dict[str, str], ports: dict[str, Any], clock: str) -> str:
    """A module between registers: inputs shifted in and held, outputs caught and shifted out, on four pins."""
    widths = {
        direction: {
            name: len(port["bits"])
            for name, port in ports.items()
            if port["direction"] == direction and name != clock
        }
        for direction in ("input", "output")
    }
    wires = [f".{clock}(clock)"]
    for direction, row in (("input", "given"), ("output", "made")):
        at = 0
        for name, width in widths[direction].items():
            wires.append(f".{name}({row}[{at}+:{width}])")
            at += width
    inside, outside = (sum(widths[direction].values()) for direction in ("input", "output"))
    chosen = ", ".join(f".{name}({value})" for name, value in given.items())
    return f"""module routed (input logic clock, input logic in, input logic take, output logic out);
  logic [{inside - 1}:0] held, given;
  logic [{outside - 1}:0] made, caught, row;
  {module} #({chosen}) unit ({", ".join(wires)});
  always_ff @(posedge clock) begin
    held <= {{held[{inside - 2}:0], in}};
    if (take) given <= held;
    caught <= made;
    row <= take ? caught : row << 1;
  end
  assign out = row[{outside - 1}];
endmodule
"""
