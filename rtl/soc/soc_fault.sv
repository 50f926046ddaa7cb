// Faults on purpose, for a simulation. `kind` says what; it comes at event `skip` (from 0) of its sort, and at the next ones, `times` of
// them or, where that is 0, all that follow:
//   1  an access to the registers is answered SLVERR       event: an answer
//   2  a burst of the memories is answered SLVERR          event: an answer's last beat
//   3  the interrupt line stays down                       event: an interrupt
//   4  the engine is reset in mid-burst                    event: a beat of a burst of several to the memories
//   5  an end of the control program becomes a loop        event: an end that is loaded
//   6  the engine's clock stops, until a restart of the PL event: the engine begins to run
module soc_fault (
    input logic clock,
    input logic reset,
    input logic tick,
    input logic [2:0] kind,
    input logic [15:0] skip,
    input logic [15:0] times,
    input logic register_answer,
    input logic memory_answer,
    input logic memory_address,
    input logic [7:0] memory_length,
    input logic memory_beat,
    input logic program_end,
    input logic interrupt,
    input logic runs,
    input logic restart,
    output logic refuse_register,
    output logic refuse_memory,
    output logic no_interrupt,
    output logic engine_reset,
    output logic endless,
    output logic stopped
);
  logic interrupt_before, runs_before, in_burst, now, happened;
  logic [15:0] seen;
  logic [ 3:0] reset_left;
  assign now = kind != 0 && seen >= skip && (times == 0 || seen - skip < times);
  assign refuse_register = now && kind == 3'd1;
  assign refuse_memory = now && kind == 3'd2;
  assign no_interrupt = now && kind == 3'd3;
  assign endless = now && kind == 3'd5;
  assign engine_reset = reset_left != 0;

  always_comb
    case (kind)
      3'd1: happened = register_answer;
      3'd2: happened = memory_answer;
      3'd3: happened = interrupt_before && !interrupt;
      3'd4: happened = memory_beat && in_burst;
      3'd5: happened = program_end;
      default: happened = runs && !runs_before;
    endcase
  always_ff @(posedge clock) begin
    interrupt_before <= interrupt;
    runs_before <= runs;
    if (memory_address) in_burst <= memory_length != 0;
    if (reset) begin
      seen <= '0;
      reset_left <= '0;
      stopped <= 1'b0;
    end else begin
      if (happened && seen != '1) seen <= seen + 1'b1;
      if (happened && now && kind == 3'd4) reset_left <= 4'd8;
      else if (tick && reset_left != 0) reset_left <= reset_left - 1'b1;
      if (happened && now && kind == 3'd6) stopped <= 1'b1;
      else if (restart) stopped <= 1'b0;
    end
  end
endmodule
