// Two masters to one slave, a burst of each direction at a time; the first master goes first.
module soc_share (
    input logic clock,
    input logic reset,
    soc_axi.slave first,
    soc_axi.slave second,
    soc_axi.master below
);
  logic write_open, write_second, read_open, read_second;

  assign below.awvalid = write_open && (write_second ? second.awvalid : first.awvalid);
  assign below.awid = write_second ? second.awid : first.awid;
  assign below.awaddr = write_second ? second.awaddr : first.awaddr;
  assign below.awlen = write_second ? second.awlen : first.awlen;
  assign below.awsize = write_second ? second.awsize : first.awsize;
  assign below.wvalid = write_open && (write_second ? second.wvalid : first.wvalid);
  assign below.wdata = write_second ? second.wdata : first.wdata;
  assign below.wstrb = write_second ? second.wstrb : first.wstrb;
  assign below.wlast = write_second ? second.wlast : first.wlast;
  assign below.bready = write_open && (write_second ? second.bready : first.bready);
  assign first.awready = write_open && !write_second && below.awready;
  assign first.wready = write_open && !write_second && below.wready;
  assign first.bvalid = write_open && !write_second && below.bvalid;
  assign second.awready = write_open && write_second && below.awready;
  assign second.wready = write_open && write_second && below.wready;
  assign second.bvalid = write_open && write_second && below.bvalid;
  assign first.bid = below.bid;
  assign first.bresp = below.bresp;
  assign second.bid = below.bid;
  assign second.bresp = below.bresp;

  assign below.arvalid = read_open && (read_second ? second.arvalid : first.arvalid);
  assign below.arid = read_second ? second.arid : first.arid;
  assign below.araddr = read_second ? second.araddr : first.araddr;
  assign below.arlen = read_second ? second.arlen : first.arlen;
  assign below.arsize = read_second ? second.arsize : first.arsize;
  assign below.rready = read_open && (read_second ? second.rready : first.rready);
  assign first.arready = read_open && !read_second && below.arready;
  assign first.rvalid = read_open && !read_second && below.rvalid;
  assign second.arready = read_open && read_second && below.arready;
  assign second.rvalid = read_open && read_second && below.rvalid;
  assign first.rid = below.rid;
  assign first.rdata = below.rdata;
  assign first.rresp = below.rresp;
  assign first.rlast = below.rlast;
  assign second.rid = below.rid;
  assign second.rdata = below.rdata;
  assign second.rresp = below.rresp;
  assign second.rlast = below.rlast;

  always_ff @(posedge clock) begin
    if (reset) write_open <= 1'b0;
    else if (!write_open) begin
      write_open <= first.awvalid || second.awvalid;
      write_second <= !first.awvalid;
    end else if (below.bvalid && below.bready) write_open <= 1'b0;
    if (reset) read_open <= 1'b0;
    else if (!read_open) begin
      read_open <= first.arvalid || second.arvalid;
      read_second <= !first.arvalid;
    end else if (below.rvalid && below.rready && below.rlast) read_open <= 1'b0;
  end
endmodule
