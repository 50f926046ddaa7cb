// AXI4 of 64 bits as the computer's parts speak it: INCR bursts, one ID width for all.
interface soc_axi #(
    parameter int ID_BITS = 8
);
  logic awvalid, awready, wvalid, wready, wlast, bvalid, bready, arvalid, arready, rvalid, rready, rlast;
  logic [ID_BITS-1:0] awid, bid, arid, rid;
  logic [31:0] awaddr, araddr;
  logic [7:0] awlen, arlen, wstrb;
  logic [2:0] awsize, arsize;
  logic [63:0] wdata, rdata;
  logic [1:0] bresp, rresp;

  modport master(
      output awvalid, awid, awaddr, awlen, awsize, wvalid, wdata, wstrb, wlast, bready, arvalid, arid, araddr, arlen, arsize, rready,
      input awready, wready, bvalid, bid, bresp, arready, rvalid, rid, rdata, rresp, rlast
  );
  modport slave(
      input awvalid, awid, awaddr, awlen, awsize, wvalid, wdata, wstrb, wlast, bready, arvalid, arid, araddr, arlen, arsize, rready,
      output awready, wready, bvalid, bid, bresp, arready, rvalid, rid, rdata, rresp, rlast
  );
endinterface
