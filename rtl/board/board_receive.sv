// A serial line in, of what board_send makes: each bit is looked at in its middle. A byte without its stop bit is dropped;
// one that comes before the last was taken replaces it.
module board_receive #(
    parameter int CLOCKS = 217
) (
    input logic clock,
    input logic reset,
    input logic line,
    input logic take,
    output logic there,
    output logic [7:0] value
);
  localparam int BITS = $clog2(CLOCKS);
  logic [2:0] steady;  // two registers against a change of the line at the clock's edge
  logic busy;
  logic [BITS-1:0] count;
  logic [3:0] left;
  logic [8:0] bits;

  always_ff @(posedge clock) begin
    steady <= {steady[1:0], line};
    if (reset) begin
      busy <= 1'b0;
      there <= 1'b0;
      steady <= '1;
    end else begin
      if (take) there <= 1'b0;
      if (!busy) begin
        busy <= !steady[2];
        count <= BITS'(CLOCKS / 2);
        left <= 4'd9;
      end else if (count != '0) count <= count - BITS'(1);
      else begin
        count <= BITS'(CLOCKS - 1);
        bits <= {steady[2], bits[8:1]};
        left <= left - 4'd1;
        if (left == 4'd9 && steady[2]) busy <= 1'b0;  // no start bit
        if (left == '0) begin
          busy <= 1'b0;
          if (steady[2]) begin
            there <= 1'b1;
            value <= bits[8:1];
          end
        end
      end
    end
  end
endmodule
