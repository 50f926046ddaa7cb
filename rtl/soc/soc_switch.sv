// One master to PARTS slaves by address: a burst of each direction at a time. An address of no part goes to part 0.
module soc_switch #(
    parameter int PARTS = 2,
    parameter logic [31:0] MASK = 32'hfc00_0000,
    parameter logic [PARTS-1:0][31:0] BASES = '0
) (
    input logic clock,
    input logic reset,
    soc_axi.slave above,
    soc_axi.master below[PARTS]
);
  localparam int BITS = $clog2(PARTS);
  function automatic logic [BITS-1:0] part_of(input logic [31:0] address);
    part_of = '0;
    for (int k = 0; k < PARTS; ++k) if ((address & MASK) == BASES[k]) part_of = BITS'(k);
  endfunction

  logic write_open, read_open;
  logic [BITS-1:0] write_part, read_part;
  logic [PARTS-1:0] awready, wready, bvalid, arready, rvalid, rlast;
  logic [7:0] bid[PARTS], rid[PARTS];
  logic [1:0] bresp[PARTS], rresp[PARTS];
  logic [63:0] rdata[PARTS];
  logic write_sent, read_sent;

  for (genvar k = 0; k < PARTS; ++k) begin : g_part
    wire writes = write_open && write_part == BITS'(k);
    wire reads = read_open && read_part == BITS'(k);
    assign below[k].awvalid = writes && !write_sent;
    assign below[k].awid = above.awid;
    assign below[k].awaddr = above.awaddr;
    assign below[k].awlen = above.awlen;
    assign below[k].awsize = above.awsize;
    assign below[k].wvalid = writes && write_sent && above.wvalid;
    assign below[k].wdata = above.wdata;
    assign below[k].wstrb = above.wstrb;
    assign below[k].wlast = above.wlast;
    assign below[k].bready = writes && above.bready;
    assign below[k].arvalid = reads && !read_sent;
    assign below[k].arid = above.arid;
    assign below[k].araddr = above.araddr;
    assign below[k].arlen = above.arlen;
    assign below[k].arsize = above.arsize;
    assign below[k].rready = reads && above.rready;
    assign awready[k] = below[k].awready;
    assign wready[k] = below[k].wready;
    assign bvalid[k] = below[k].bvalid;
    assign bid[k] = below[k].bid;
    assign bresp[k] = below[k].bresp;
    assign arready[k] = below[k].arready;
    assign rvalid[k] = below[k].rvalid;
    assign rid[k] = below[k].rid;
    assign rdata[k] = below[k].rdata;
    assign rresp[k] = below[k].rresp;
    assign rlast[k] = below[k].rlast;
  end

  // The address is held by the master until its ready, which comes when the part has taken it.
  assign above.awready = write_open && !write_sent && awready[write_part];
  assign above.wready = write_open && write_sent && wready[write_part];
  assign above.bvalid = write_open && bvalid[write_part];
  assign above.bid = bid[write_part];
  assign above.bresp = bresp[write_part];
  assign above.arready = read_open && !read_sent && arready[read_part];
  assign above.rvalid = read_open && rvalid[read_part];
  assign above.rid = rid[read_part];
  assign above.rdata = rdata[read_part];
  assign above.rresp = rresp[read_part];
  assign above.rlast = rlast[read_part];
  always_ff @(posedge clock) begin
    if (reset) write_open <= 1'b0;
    else if (!write_open) begin
      write_open <= above.awvalid;
      write_part <= part_of(above.awaddr);
      write_sent <= 1'b0;
    end else begin
      if (above.awready) write_sent <= 1'b1;
      if (above.bvalid && above.bready) write_open <= 1'b0;
    end
    if (reset) read_open <= 1'b0;
    else if (!read_open) begin
      read_open <= above.arvalid;
      read_part <= part_of(above.araddr);
      read_sent <= 1'b0;
    end else begin
      if (above.arready) read_sent <= 1'b1;
      if (above.rvalid && above.rready && above.rlast) read_open <= 1'b0;
    end
  end
endmodule
