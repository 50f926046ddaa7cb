// What the board has beside memory and engine, by the offset in its region:
//   0x0  write: a byte to the serial line, which waits until it can be taken; read: bit 8 a byte came, bits 0 to 7 it, and it is taken
//   0x4  write: seven LEDs; read: bit 0 the engine's ports have refused an access since reset
module board_registers #(
    parameter int CLOCKS = 217
) (
    input logic clock,
    input logic reset,
    input logic wanted,
    input logic write,
    input logic place,
    input logic [31:0] value,
    output logic done,
    output logic [31:0] answer,
    input logic refused,
    output logic [6:0] leds,
    output logic line_out,
    input logic line_in
);
  logic ready, there, bus_error;
  logic [7:0] came;
  assign done   = wanted && (!write || place || ready);
  assign answer = place ? {31'd0, bus_error} : {23'd0, there, came};
  board_send #(
      .CLOCKS(CLOCKS)
  ) send (
      .clock(clock),
      .reset(reset),
      .start(wanted && write && !place),
      .value(value[7:0]),
      .ready(ready),
      .line(line_out)
  );
  board_receive #(
      .CLOCKS(CLOCKS)
  ) receive (
      .clock(clock),
      .reset(reset),
      .line(line_in),
      .take(wanted && !write && !place),
      .there(there),
      .value(came)
  );
  always_ff @(posedge clock) begin
    if (reset) begin
      leds <= '0;
      bus_error <= 1'b0;
    end else begin
      if (wanted && write && place) leds <= value[6:0];
      if (refused) bus_error <= 1'b1;
    end
  end
endmodule
