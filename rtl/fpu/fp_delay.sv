// CYCLES registers in a row; none is a wire.
module fp_delay #(
    parameter int WIDTH  = 64,
    parameter int CYCLES = 0
) (
    input  logic             clock,
    input  logic             enable,
    input  logic [WIDTH-1:0] in,
    output logic [WIDTH-1:0] out
);
  generate
    if (CYCLES == 0) begin : g_wire
      assign out = in;
      logic unused;
      assign unused = &{1'b0, clock, enable};
    end else begin : g_registers
      logic [WIDTH*CYCLES-1:0] row;
      if (CYCLES == 1) begin : g_one
        always_ff @(posedge clock) if (enable) row <= in;
      end else begin : g_more
        always_ff @(posedge clock) if (enable) row <= {row[WIDTH*(CYCLES-1)-1:0], in};
      end
      assign out = row[WIDTH*CYCLES-1-:WIDTH];
    end
  endgenerate
endmodule
