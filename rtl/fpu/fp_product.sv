// Product of two unsigned numbers in three cycles: products of tiles, sums of the tiles of each row, sum of the rows.
// A tile is what the FPGA's multiplier block takes, 24 by 17 bits in a DSP48E; tools for others define the two macros.
`ifndef PRODUCT_WIDE
`define PRODUCT_WIDE 24
`define PRODUCT_NARROW 17
`endif
module fp_product #(
    parameter int P = 53
) (
    input  logic           clock,
    input  logic           enable,
    input  logic [  P-1:0] a,
    input  logic [  P-1:0] b,
    output logic [2*P-1:0] product
);
  localparam int WIDE = `PRODUCT_WIDE;  // of a; at least NARROW, so that two tiles away from each other do not overlap
  localparam int NARROW = `PRODUCT_NARROW;  // of b
  localparam int COLUMNS = (P + WIDE - 1) / WIDE;
  localparam int ROWS = (P + NARROW - 1) / NARROW;
  localparam int TILE = WIDE + NARROW;
  localparam int ROW = (COLUMNS + 1) * WIDE + NARROW;

  // 1: tiles.
  logic [COLUMNS*WIDE-1:0] a_wide;
  logic [ROWS*NARROW-1:0] b_wide;
  logic [ROWS*COLUMNS*TILE-1:0] tiles;
  assign a_wide = (COLUMNS * WIDE)'(a);
  assign b_wide = (ROWS * NARROW)'(b);
  generate
    for (genvar r = 0; r < ROWS; r++) begin : g_row
      for (genvar c = 0; c < COLUMNS; c++) begin : g_tile
        localparam int A = (c + 1) * WIDE <= P ? WIDE : P - c * WIDE;
        localparam int B = (r + 1) * NARROW <= P ? NARROW : P - r * NARROW;
        logic [A+B-1:0] tile;
        always_ff @(posedge clock) if (enable) tile <= a_wide[c*WIDE+:A] * b_wide[r*NARROW+:B];
        assign tiles[(r*COLUMNS+c)*TILE+:TILE] = TILE'(tile);
      end
    end
  endgenerate

  // 2: rows, the tiles of even columns and those of odd ones.
  logic [ROWS*ROW-1:0] even, odd, rows;
  always_comb begin
    even = '0;
    odd  = '0;
    for (int r = 0; r < ROWS; r++) begin
      for (int c = 0; c < COLUMNS; c++) begin
        if (c % 2 == 0) even[r*ROW+c*WIDE+:TILE] = tiles[(r*COLUMNS+c)*TILE+:TILE];
        else odd[r*ROW+c*WIDE+:TILE] = tiles[(r*COLUMNS+c)*TILE+:TILE];
      end
    end
  end
  generate
    for (genvar r = 0; r < ROWS; r++) begin : g_sum
      always_ff @(posedge clock) if (enable) rows[r*ROW+:ROW] <= even[r*ROW+:ROW] + odd[r*ROW+:ROW];
    end
  endgenerate

  // 3: carry-save additions leave two numbers, and one carry chain their sum.
  logic [2*P-1:0] kept, carried, row, sum;
  always_comb begin
    kept = (2 * P)'(rows[ROW-1:0]);
    carried = '0;
    row = '0;
    sum = '0;
    for (int r = 1; r < ROWS; r++) begin
      row = (2 * P)'(rows[r*ROW+:ROW]) << (r * NARROW);
      if (r == 1) begin
        carried = row;
      end else begin
        sum = kept ^ carried ^ row;
        carried = ((kept & carried) | (kept & row) | (carried & row)) << 1;
        kept = sum;
      end
    end
  end
  always_ff @(posedge clock) if (enable) product <= kept + carried;
endmodule
