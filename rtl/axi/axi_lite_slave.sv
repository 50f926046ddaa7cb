// AXI4-Lite slave of 32 bits: one write and one read at a time. AW and W come in any order; a write without all of its
// strobes is answered SLVERR and goes no further.
module axi_lite_slave (
    input logic clock,
    input logic reset,
    input logic awvalid,
    output logic awready,
    input logic [15:0] awaddr,
    input logic wvalid,
    output logic wready,
    input logic [31:0] wdata,
    input logic [3:0] wstrb,
    output logic bvalid,
    input logic bready,
    output logic [1:0] bresp,
    input logic arvalid,
    output logic arready,
    input logic [15:0] araddr,
    output logic rvalid,
    input logic rready,
    output logic [31:0] rdata,
    output logic [1:0] rresp,
    // The access that waits, until it is done.
    output logic write_wanted,
    output logic [15:0] write_address,
    output logic [31:0] write_value,
    input logic write_done,
    output logic read_wanted,
    output logic [15:0] read_address,
    input logic [31:0] read_value,
    input logic read_done
);
  localparam logic [1:0] OKAY = 2'b00;
  localparam logic [1:0] SLVERR = 2'b10;

  logic have_address, have_data, have_read, whole;
  logic both, answered;
  assign awready = !have_address;
  assign wready = !have_data;
  assign arready = !have_read;
  assign both = have_address && have_data && !bvalid;
  assign write_wanted = both && whole;
  assign answered = write_done || (both && !whole);
  assign read_wanted = have_read && !rvalid;
  assign rresp = OKAY;

  always_ff @(posedge clock) begin
    if (reset) begin
      have_address <= 1'b0;
      have_data <= 1'b0;
      bvalid <= 1'b0;
    end else begin
      if (answered) have_address <= 1'b0;
      else if (awvalid) have_address <= 1'b1;
      if (answered) have_data <= 1'b0;
      else if (wvalid) have_data <= 1'b1;
      if (answered) bvalid <= 1'b1;
      else if (bready) bvalid <= 1'b0;
    end
    if (awready) write_address <= awaddr;
    if (wready) write_value <= wdata;
    if (wready) whole <= wstrb == 4'b1111;
    if (answered) bresp <= whole ? OKAY : SLVERR;
  end
  always_ff @(posedge clock) begin
    if (reset) begin
      have_read <= 1'b0;
      rvalid <= 1'b0;
    end else begin
      if (read_done) have_read <= 1'b0;
      else if (arvalid) have_read <= 1'b1;
      if (read_done) rvalid <= 1'b1;
      else if (rready) rvalid <= 1'b0;
    end
    if (arready) read_address <= araddr;
    if (read_done) rdata <= read_value;
  end
endmodule
