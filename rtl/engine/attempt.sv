// Resident control: runs the control program of an attempt, from its entry to its end, without the PS.
// An instruction is two words of the table at PROGRAM (registers.sv): +0 op (bits 1:0), whether the stop bit counts as
// the flag (2), segment (15:8), target (23:16); +4 address of the flag. Op 0 ends the attempt, 1 runs a segment,
// 2 jumps if the flag is not zero, 3 unless it is not. A segment costs RUN_CYCLES beside its busy ones, a branch FLAG_CYCLES.
module attempt #(
    parameter int INSTRUCTIONS = 128,
    parameter int ADDRESS_BITS = 14,
    parameter int W = 64,
    parameter int PC = $clog2(INSTRUCTIONS)
) (
    input logic clock,
    input logic reset,
    input logic program_write,
    input logic [PC:0] program_address,  // of a word: instruction, and which of its two
    input logic [31:0] program_word,
    input logic launch,
    input logic [PC-1:0] entry,
    input logic stop,  // asked for by the PS
    input logic halt,  // a fault
    input logic ended,  // the segment's last busy cycle
    output logic run,
    output logic [7:0] segment,
    output logic finished,
    output logic flag_read,
    output logic [ADDRESS_BITS-1:0] flag_address,
    input logic [W-1:0] flag_word  // READ_CYCLES + 1 cycles after the read
);
  localparam logic [1:0] END = 2'd0;
  localparam logic [1:0] RUN = 2'd1;
  localparam logic [1:0] IF = 2'd2;

  localparam logic [2:0] IDLE = 3'd0;
  localparam logic [2:0] FETCH = 3'd1;
  localparam logic [2:0] ACT = 3'd2;
  localparam logic [2:0] BUSY = 3'd3;
  localparam logic [2:0] FLAG = 3'd4;
  localparam logic [2:0] LAST_WAIT = 3'(contract::READ_CYCLES);

  logic [23:0] code[0:INSTRUCTIONS-1];
  logic [ADDRESS_BITS-1:0] code_flag[0:INSTRUCTIONS-1];
  logic [23:0] instruction;
  logic [PC-1:0] pc;
  logic [2:0] state;
  logic [2:0] waited;
  logic [1:0] op;
  logic raised, taken;

  assign op = instruction[1:0];
  assign segment = instruction[15:8];
  assign run = state == ACT && op == RUN;
  assign finished = state == ACT && op == END;
  assign flag_read = state == ACT && op[1];
  assign raised = flag_word[W-2:0] != '0 || (instruction[2] && stop);
  assign taken = raised == (op == IF);

  always_ff @(posedge clock) begin
    if (program_write && !program_address[0]) code[program_address[PC:1]] <= program_word[23:0];
    if (program_write && program_address[0]) code_flag[program_address[PC:1]] <= program_word[ADDRESS_BITS-1:0];
    instruction <= state == FETCH ? code[pc] : instruction;
    flag_address <= state == FETCH ? code_flag[pc] : flag_address;
  end
  always_ff @(posedge clock) begin
    waited <= state == FLAG ? waited + 3'd1 : '0;
    if (reset || halt) begin
      state <= IDLE;
      pc <= '0;
    end else begin
      case (state)
        IDLE: begin
          if (launch) state <= FETCH;
          pc <= entry;
        end
        FETCH: begin
          state <= ACT;
          pc <= pc + PC'(1);
        end
        ACT: state <= op == END ? IDLE : op == RUN ? BUSY : FLAG;
        BUSY: if (ended) state <= FETCH;
        default: begin
          if (waited == LAST_WAIT) begin
            state <= FETCH;
            if (taken) pc <= instruction[16+:PC];
          end
        end
      endcase
    end
  end
endmodule
