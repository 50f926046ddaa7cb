// Divide and square-root unit: the next operation may come INTERVAL cycles after the last. Timing as in lane.sv.
module divider #(
    parameter int EXP = 11,
    parameter int MAN = 52,
    parameter int CYCLES = EXP == 11 ? contract::F64_DIV_CYCLES : contract::F32_DIV_CYCLES,
    parameter int INTERVAL = EXP == 11 ? contract::F64_DIV_INTERVAL_CYCLES : contract::F32_DIV_INTERVAL_CYCLES,
    parameter int READ = contract::READ_CYCLES,
    parameter int ADDRESS_BITS = 14
) (
    input logic clock,
    input logic reset,
    input logic enable,
    input logic [1:0] op,
    input logic [ADDRESS_BITS-1:0] destination,
    input logic [EXP+MAN:0] a,
    input logic [EXP+MAN:0] b,
    output logic result_valid,
    output logic [ADDRESS_BITS-1:0] result_address,
    output logic [EXP+MAN:0] result,
    // Destinations in flight: bit and address i of the operation whose result comes READ + CYCLES - 1 - i cycles later.
    output logic [READ+CYCLES-1:0] flight_valid,
    output logic [(READ+CYCLES)*ADDRESS_BITS-1:0] flight_address,
    output logic conflict
);
  `include "engine/operations.svh"

  localparam int A = ADDRESS_BITS;
  localparam int COUNT = $clog2(INTERVAL + 1);
  localparam int STAGES = READ + CYCLES;

  logic [READ-1:0] root;
  logic [COUNT-1:0] held;  // cycles until the unit is free
  logic start;
  assign start = flight_valid[READ-1];
  always_ff @(posedge clock) begin
    if (reset) begin
      flight_valid <= '0;
      held <= '0;
    end else if (enable) begin
      flight_valid <= {flight_valid[STAGES-2:0], op != DIVIDER_NOP};
      if (start) held <= COUNT'(INTERVAL - 1);
      else if (held != '0) held <= held - COUNT'(1);
    end
    if (enable) begin
      root <= {root[READ-2:0], op == DIVIDER_SQRT};
      flight_address <= {flight_address[(STAGES-1)*A-1:0], destination};
    end
  end

  fp_divsqrt #(
      .EXP(EXP),
      .MAN(MAN),
      .CYCLES(CYCLES),
      .INTERVAL(INTERVAL)
  ) unit (
      .clock(clock),
      .reset(reset),
      .enable(enable),
      .start(start),
      .root(root[READ-1]),
      .a(a),
      .b(b),
      .result(result)
  );
  assign conflict = enable && start && held != '0;
  assign result_valid = flight_valid[STAGES-1];
  assign result_address = flight_address[(STAGES-1)*A+:A];
endmodule
