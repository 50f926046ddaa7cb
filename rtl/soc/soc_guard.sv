// Between masters and a slave that may fail. A slave that lets a transfer wait for PATIENCE clocks is cut off: what is open and what
// comes is answered SLVERR and zeros, and its late answers are swallowed, until `restart` has been up, which resets the slave, and has fallen.
// `refused` tells of each answer of an error that goes up. Masters have one burst of each direction open at a time.
module soc_guard #(
    parameter int PATIENCE = 4096
) (
    input logic clock,
    input logic reset,
    input logic restart,
    output logic cut,
    output logic refused,
    soc_axi.slave above,
    soc_axi.master below
);
  localparam logic [1:0] SLVERR = 2'd2;
  localparam int BITS = $clog2(PATIENCE);

  // Of a burst: its address is taken; all of its beats are.
  logic write_open, write_sent, read_open;
  logic [7:0] write_id, read_id, read_left;
  logic aw, w, b, ar, r;
  assign aw = above.awvalid && above.awready;
  assign w = above.wvalid && above.wready;
  assign b = above.bvalid && above.bready;
  assign ar = above.arvalid && above.arready;
  assign r = above.rvalid && above.rready;
  assign refused = (b && above.bresp != 0) || (r && above.rresp != 0);

  assign below.awvalid = above.awvalid && !cut;
  assign below.awid = above.awid;
  assign below.awaddr = above.awaddr;
  assign below.awlen = above.awlen;
  assign below.awsize = above.awsize;
  assign above.awready = cut ? !write_open : below.awready;
  assign below.wvalid = above.wvalid && !cut;
  assign below.wdata = above.wdata;
  assign below.wstrb = above.wstrb;
  assign below.wlast = above.wlast;
  assign above.wready = cut ? write_open && !write_sent : below.wready;
  assign below.bready = above.bready || cut;
  assign above.bvalid = cut ? write_open && write_sent : below.bvalid;
  assign above.bid = cut ? write_id : below.bid;
  assign above.bresp = cut ? SLVERR : below.bresp;
  assign below.arvalid = above.arvalid && !cut;
  assign below.arid = above.arid;
  assign below.araddr = above.araddr;
  assign below.arlen = above.arlen;
  assign below.arsize = above.arsize;
  assign above.arready = cut ? !read_open : below.arready;
  assign below.rready = above.rready || cut;
  assign above.rvalid = cut ? read_open : below.rvalid;
  assign above.rid = cut ? read_id : below.rid;
  assign above.rdata = cut ? '0 : below.rdata;
  assign above.rresp = cut ? SLVERR : below.rresp;
  assign above.rlast = cut ? read_left == 0 : below.rlast;

  logic waits, restarted;
  logic [BITS-1:0] waited;
  assign waits = above.awvalid || above.arvalid || write_open || read_open;
  always_ff @(posedge clock) begin
    if (aw) write_id <= above.awid;
    if (ar) read_id <= above.arid;
    if (ar) read_left <= above.arlen;
    else if (r) read_left <= read_left - 1'b1;
    waited <= !waits || cut || aw || w || b || ar || r ? '0 : waited + 1'b1;
    if (reset) begin
      write_open <= 1'b0;
      write_sent <= 1'b0;
      read_open <= 1'b0;
      {cut, restarted} <= 2'b00;
    end else begin
      if (aw) write_open <= 1'b1;
      else if (b) write_open <= 1'b0;
      if (w && above.wlast) write_sent <= 1'b1;
      else if (b) write_sent <= 1'b0;
      if (ar) read_open <= 1'b1;
      else if (r && above.rlast) read_open <= 1'b0;
      if (restart) {cut, restarted} <= 2'b11;
      else if (waited == BITS'(PATIENCE - 1)) {cut, restarted} <= 2'b10;
      else if (restarted && !waits) cut <= 1'b0;
    end
  end
endmodule
