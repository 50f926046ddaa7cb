// From the core's clock to the engine's, which is slower by a ratio and has its edges on edges of the core's: `tick` is up in the clock
// of the core that ends with one. A handshake takes place in such clocks alone, so both sides see it once. With `refuse`, answers are errors.
module soc_tick (
    input logic tick,
    input logic refuse,
    soc_axi.slave fast,
    soc_axi.master slow
);
  assign slow.awvalid = fast.awvalid;
  assign slow.awid = fast.awid;
  assign slow.awaddr = fast.awaddr;
  assign slow.awlen = fast.awlen;
  assign slow.awsize = fast.awsize;
  assign fast.awready = slow.awready && tick;
  assign slow.wvalid = fast.wvalid;
  assign slow.wdata = fast.wdata;
  assign slow.wstrb = fast.wstrb;
  assign slow.wlast = fast.wlast;
  assign fast.wready = slow.wready && tick;
  assign fast.bvalid = slow.bvalid && tick;
  assign fast.bid = slow.bid;
  assign fast.bresp = slow.bresp | {refuse, 1'b0};
  assign slow.bready = fast.bready;
  assign slow.arvalid = fast.arvalid;
  assign slow.arid = fast.arid;
  assign slow.araddr = fast.araddr;
  assign slow.arlen = fast.arlen;
  assign slow.arsize = fast.arsize;
  assign fast.arready = slow.arready && tick;
  assign fast.rvalid = slow.rvalid && tick;
  assign fast.rid = slow.rid;
  assign fast.rdata = slow.rdata;
  assign fast.rresp = slow.rresp | {refuse, 1'b0};
  assign fast.rlast = slow.rlast;
  assign slow.rready = fast.rready;
endmodule
