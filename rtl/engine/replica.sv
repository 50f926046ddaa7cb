// One read replica of the storage: BANKS memories with one read and one write port each, and the crossbars from the
// units' addresses to the banks and from the banks' words to the units' operand registers, both as one-hot ORs.
// With EXPORT one more port reads a word for the units of other clusters; what they read there comes in as `imported`.
// Address at cycle t: row registers t + 1, block memories t + 2, their output registers t + 3, operand registers t + 4.
module replica #(
    parameter int UNITS = 5,
    parameter int BANKS = 16,
    parameter int ADDRESS_BITS = 14,
    parameter int WIDTH = 64,
    parameter int EXPORT = 0,
    parameter int PORTS = UNITS + EXPORT,
    parameter int ROW = ADDRESS_BITS - $clog2(BANKS),
    parameter int ROWS = 1 << ROW
) (
    input logic clock,
    input logic enable,
    input logic [PORTS-1:0] read,
    input logic [PORTS*ADDRESS_BITS-1:0] address,
    input logic [UNITS*WIDTH-1:0] imported,
    input logic [BANKS-1:0] write,
    input logic [BANKS*ROW-1:0] write_row,
    input logic [BANKS*WIDTH-1:0] write_word,
    output logic [UNITS*WIDTH-1:0] operand,
    output logic [WIDTH-1:0] exported,
    output logic conflict
);
  localparam int A = ADDRESS_BITS;
  localparam int PICK = $clog2(BANKS);

  // For each bank the OR of the rows of the units that address it.
  logic [PORTS*BANKS-1:0] pick;  // port u reads bank b
  logic [BANKS*ROW-1:0] rows;
  logic clash;
  always_comb begin
    rows  = '0;
    clash = 1'b0;
    for (int u = 0; u < PORTS; u++) begin
      for (int b = 0; b < BANKS; b++) begin
        pick[u*BANKS+b] = read[u] && address[u*A+:PICK] == PICK'(b);
        rows[b*ROW+:ROW] = rows[b*ROW+:ROW] | ({ROW{pick[u*BANKS+b]}} & address[u*A+PICK+:ROW]);
      end
    end
    // Read conflict: an address differs from the OR of its bank. (If one row has all the ones of the other, only the
    // other address differs.)
    for (int u = 0; u < PORTS; u++) begin
      for (int b = 0; b < BANKS; b++) begin
        if (pick[u*BANKS+b] && rows[b*ROW+:ROW] != address[u*A+PICK+:ROW]) clash = 1'b1;
      end
    end
  end
  assign conflict = enable && clash;

  logic [PORTS*BANKS-1:0] pick_1, pick_2, pick_3;
  logic [BANKS*ROW-1:0] rows_1;
  logic [BANKS*WIDTH-1:0] words_3;
  always_ff @(posedge clock) begin
    if (enable) begin
      pick_1 <= pick;
      pick_2 <= pick_1;
      pick_3 <= pick_2;
      rows_1 <= rows;
    end
  end

  generate
    for (genvar b = 0; b < BANKS; b++) begin : g_bank
      bank #(
          .ROW  (ROW),
          .WIDTH(WIDTH),
          .ROWS (ROWS)
      ) memory (
          .clock(clock),
          .enable(enable),
          .read_row(rows_1[b*ROW+:ROW]),
          .read_word(words_3[b*WIDTH+:WIDTH]),
          .write(write[b]),
          .write_row(write_row[b*ROW+:ROW]),
          .write_word(write_word[b*WIDTH+:WIDTH])
      );
    end
  endgenerate

  logic [PORTS*WIDTH-1:0] gathered;
  always_comb begin
    gathered = '0;
    for (int u = 0; u < PORTS; u++) begin
      for (int b = 0; b < BANKS; b++) begin
        gathered[u*WIDTH+:WIDTH] =
            gathered[u*WIDTH+:WIDTH] | ({WIDTH{pick_3[u*BANKS+b]}} & words_3[b*WIDTH+:WIDTH]);
      end
    end
  end
  always_ff @(posedge clock) if (enable) operand <= gathered[UNITS*WIDTH-1:0] | imported;
  assign exported = EXPORT != 0 ? gathered[(PORTS-1)*WIDTH+:WIDTH] : '0;
endmodule
