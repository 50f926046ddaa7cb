// Single beats of the core to the AXI4-Lite port of the engine: 32 bits, whose half of a beat the address says. With `endless`,
// an end of the control program (attempt.sv) becomes a jump to itself.
module soc_lite (
    input logic clock,
    input logic reset,
    input logic endless,
    output logic program_end,
    soc_axi.slave bus,
    output logic awvalid,
    input logic awready,
    output logic [15:0] awaddr,
    output logic wvalid,
    input logic wready,
    output logic [31:0] wdata,
    output logic [3:0] wstrb,
    input logic bvalid,
    output logic bready,
    input logic [1:0] bresp,
    output logic arvalid,
    input logic arready,
    output logic [15:0] araddr,
    input logic rvalid,
    output logic rready,
    input logic [31:0] rdata,
    input logic [1:0] rresp
);
  localparam logic [31:0] IF = 32'd2;
  logic upper;
  logic [15:0] address;
  logic [31:0] word;
  assign word = upper ? bus.wdata[63:32] : bus.wdata[31:0];
  // Instructions are pairs of words from 0x2000 on.
  assign program_end = address[15:10] == 6'h08 && !upper && word[1:0] == 2'd0;
  assign awvalid = bus.awvalid;
  assign awaddr = bus.awaddr[15:0];
  assign bus.awready = awready;
  assign wvalid = bus.wvalid;
  assign wdata = endless && program_end ? {8'd0, 1'b0, address[9:3], 16'd0} | IF : word;
  assign wstrb = upper ? bus.wstrb[7:4] : bus.wstrb[3:0];
  assign bus.wready = wready;
  assign bus.bvalid = bvalid;
  assign bus.bresp = bresp;
  assign bready = bus.bready;
  assign arvalid = bus.arvalid;
  assign araddr = bus.araddr[15:0];
  assign bus.arready = arready;
  assign bus.rvalid = rvalid;
  assign bus.rdata = {rdata, rdata};
  assign bus.rresp = rresp;
  assign bus.rlast = 1'b1;
  assign rready = bus.rready;
  always_ff @(posedge clock) begin
    if (bus.awvalid && awready) begin
      bus.bid <= bus.awid;
      upper <= bus.awaddr[2];
      address <= bus.awaddr[15:0];
    end
    if (bus.arvalid && arready) bus.rid <= bus.arid;
    if (reset) upper <= 1'b0;
  end
endmodule
