// WIDTH bits of the buffer of compressed microcode, four lines in a ring, from a place on: first its line, then its bit.
module compressed_view #(
    parameter int WIDTH = 38,
    parameter int FETCH = 128,
    parameter int BIT   = $clog2(FETCH)
) (
    input  logic [4*FETCH-1:0] buffer,
    input  logic [    BIT+1:0] place,
    output logic [  WIDTH-1:0] view
);
  logic [WIDTH+FETCH-2:0] lines;
  window #(
      .WIDTH(WIDTH + FETCH - 1),
      .BITS (2),
      .STEP (FETCH)
  ) its_lines (
      .row ((WIDTH + 4 * FETCH - 1)'({buffer, buffer})),
      .from(place[BIT+:2]),
      .view(lines)
  );
  window #(
      .WIDTH(WIDTH),
      .BITS (BIT)
  ) its_bits (
      .row (lines),
      .from(place[BIT-1:0]),
      .view(view)
  );
endmodule
