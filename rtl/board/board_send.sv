// A serial line out: a byte is a start bit, eight bits from the lowest on, and a stop bit, each of CLOCKS clocks.
module board_send #(
    parameter int CLOCKS = 217
) (
    input logic clock,
    input logic reset,
    input logic start,  // taken while ready
    input logic [7:0] value,
    output logic ready,
    output logic line
);
  localparam int BITS = $clog2(CLOCKS);
  logic [9:0] bits;  // still to be sent; all ones but for zeros to come
  logic [3:0] left;
  logic [BITS-1:0] count;
  assign ready = left == '0;
  assign line = bits[0];

  always_ff @(posedge clock) begin
    if (reset) begin
      bits <= '1;
      left <= '0;
      count <= '0;
    end else if (ready) begin
      if (start) begin
        bits <= {1'b1, value, 1'b0};
        left <= 4'd10;
      end
      count <= '0;
    end else if (count == BITS'(CLOCKS - 1)) begin
      bits <= {1'b1, bits[9:1]};
      left <= left - 4'd1;
      count <= '0;
    end else count <= count + BITS'(1);
  end
endmodule
