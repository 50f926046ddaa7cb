// The one port to the engine's memories: pieces and reads take turns where both wait. A write is followed by SETTLE clocks
// without a read or a register write, a read by its latency without a register write. While the engine runs, pieces and
// reads are taken with an error, and nothing happens.
module axi_memory_port #(
    parameter int ADDRESS_BITS = 14,
    parameter int LATENCY = contract::READ_CYCLES + 2  // from the read taken to its word
) (
    input logic clock,
    input logic reset,
    input logic open,
    input logic running,
    output logic quiet,
    input logic piece_valid,
    output logic piece_ready,
    output logic piece_take,
    input logic piece_commit,  // what is taken writes a word of any memory
    input logic storage_commit,
    input logic [ADDRESS_BITS-1:0] storage_address,
    input logic read_valid,
    output logic read_ready,
    output logic read_error,
    input logic [ADDRESS_BITS-1:0] read_address,
    output logic host_write,
    output logic host_read,
    output logic [ADDRESS_BITS-1:0] host_address
);
  localparam int SETTLE = 4;  // what rtl/harness/computer.hpp waits, too

  logic [SETTLE-1:0] settling;
  logic [LATENCY-1:0] reads;  // bit i: taken i + 1 cycles ago
  logic reads_turn, read_go;
  assign quiet = settling == '0 && reads == '0;
  assign piece_ready = open && piece_valid && !(read_valid && reads_turn);
  assign piece_take = piece_ready && !running;
  assign read_ready = open && read_valid && settling == '0 && !(piece_valid && !reads_turn);
  assign read_error = running;
  assign read_go = read_ready && !running;

  always_ff @(posedge clock) begin
    if (reset) begin
      settling <= '0;
      reads <= '0;
      reads_turn <= 1'b0;
      host_write <= 1'b0;
      host_read <= 1'b0;
    end else begin
      settling <= {settling[SETTLE-2:0], piece_commit};
      reads <= {reads[LATENCY-2:0], read_go};
      if (piece_ready) reads_turn <= 1'b1;
      else if (read_ready) reads_turn <= 1'b0;
      host_write <= storage_commit;
      host_read <= read_go;
    end
    host_address <= read_go ? read_address : storage_address;
  end
endmodule
