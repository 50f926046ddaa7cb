// The computer on a ULX3S with an LFE5U-85F: its pins (ulx3s.lpf), and the reset. The core begins 16 clocks after the
// bitstream is loaded, and again when the button is released.
module ulx3s #(
    parameter IMAGE = "memory.hex",
    parameter int CLOCKS = 217  // of a bit on the serial line: 115200 a second
) (
    input logic clk_25mhz,
    input logic btn_pwr_n,  // low while pressed
    input logic ftdi_txd,
    output logic ftdi_rxd,
    output logic wifi_gpio0,  // high: the module for radio leaves the FPGA alone
    output logic [7:0] led
);
  logic [2:0] pressed = '1;
  logic [3:0] waited = '0;
  logic reset = 1'b1;
  always_ff @(posedge clk_25mhz) begin
    pressed <= {pressed[1:0], !btn_pwr_n};
    waited  <= pressed[2] ? '0 : waited == '1 ? '1 : waited + 4'd1;
    reset   <= waited != '1;
  end
  assign wifi_gpio0 = 1'b1;

  board #(
      .IMAGE(IMAGE),
      .CLOCKS(CLOCKS)
  ) computer (
      .clock(clk_25mhz),
      .reset(reset),
      .line_in(ftdi_txd),
      .line_out(ftdi_rxd),
      .leds(led[6:0]),
      .trapped(led[7])
  );
endmodule
