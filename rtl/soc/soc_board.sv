// What a board has beside memory: a boot ROM that jumps to memory, a console, the exit code, and the registers of the DMA.
//   0x1000_0000  ROM            0x1100_0000  console, a byte a write      0x1100_0008  exit code: the run ends
//   0x1100_0010  first descriptor's address      0x1100_0018  descriptors to do; a write starts them
//   0x1100_0020  STATUS of the DMA: bit 0 busy, bit 1 a bus refused; a write clears bit 1 and the interrupt
//   0x1100_0028  clocks in which the engine was busy, since reset
//   0x1100_0030  a write resets the PL and joins its ports again; bit 0 that goes on, bit 1 registers cut off, bit 2 memories
//   0x1100_0038  bit 0: an access to the PL was answered with an error; a write clears it and the interrupt
module soc_board (
    input logic clock,
    input logic reset,
    soc_axi.slave bus,
    output logic console_valid,
    output logic [7:0] console_byte,
    output logic exit_valid,
    output logic [31:0] exit_code,
    output logic [31:0] descriptor,
    output logic [15:0] descriptors,
    output logic start,
    output logic clear,
    input logic busy,
    input logic refused,
    input logic [63:0] engine_clocks,
    output logic restart,
    input logic [2:0] pl_state,
    output logic bus_error_clear,
    input logic bus_error
);
  // li t0, 1; slli t0, t0, 31; jr t0
  localparam logic [63:0] JUMP = 64'h01f2_9293_0010_0293, TO_MEMORY = 64'h0000_0000_0002_8067;

  logic write, on_board;
  logic [31:0] write_address, read_address;
  logic [63:0] write_word, read_word;
  logic [7:0] write_bytes;
  logic [7:0] place;
  assign on_board = write && write_address[31:8] == 24'h11_0000;
  assign place = write_address[7:0];
  assign console_valid = on_board && place == 8'h00;
  assign console_byte = write_word[7:0];
  assign exit_valid = on_board && place == 8'h08;
  assign exit_code = write_word[31:0];
  assign start = on_board && place == 8'h18;
  assign descriptors = write_word[15:0];
  assign clear = on_board && place == 8'h20;
  assign restart = on_board && place == 8'h30;
  assign bus_error_clear = on_board && place == 8'h38;
  always_ff @(posedge clock) if (on_board && place == 8'h10) descriptor <= write_word[31:0];

  always_comb
    if (read_address[31:24] != 8'h11) read_word = read_address[3] ? TO_MEMORY : JUMP;
    else
      case (read_address[4:3])
        2'd0: read_word = {62'd0, refused, busy};
        2'd1: read_word = engine_clocks;
        2'd2: read_word = {61'd0, pl_state};
        default: read_word = {63'd0, bus_error};
      endcase
  soc_port port (
      .clock(clock),
      .reset(reset),
      .latency(16'd0),
      .bus(bus),
      .write(write),
      .write_address(write_address),
      .write_word(write_word),
      .write_bytes(write_bytes),
      .write_refused(write_address[31:24] != 8'h11),
      .read_address(read_address),
      .read_word(read_word),
      .read_refused(1'b0)
  );
endmodule
