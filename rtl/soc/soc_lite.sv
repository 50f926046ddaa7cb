// Single beats of the core to the AXI4-Lite port of the engine: 32 bits, whose half of a beat the address says.
module soc_lite (
    input logic clock,
    input logic reset,
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
  logic upper;
  assign awvalid = bus.awvalid;
  assign awaddr = bus.awaddr[15:0];
  assign bus.awready = awready;
  assign wvalid = bus.wvalid;
  assign wdata = upper ? bus.wdata[63:32] : bus.wdata[31:0];
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
    end
    if (bus.arvalid && arready) bus.rid <= bus.arid;
    if (reset) upper <= 1'b0;
  end
endmodule
