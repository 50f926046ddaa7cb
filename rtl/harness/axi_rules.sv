// Rules of axi_slaves.sv for a proof by SymbiYosys (axi_rules.sby): masters, engine and its answers are free, but for what
// is assumed here. Small memories; the logic does not depend on their sizes.
module axi_rules #(
    parameter int ADDRESS_BITS = 3,
    parameter int CODE_BITS = 1,
    parameter int CODE_WIDTH = 40,
    parameter int ID_BITS = 1,
    parameter int REGION_BITS = 8
) (
    input logic clock,
    input logic lite_awvalid,
    input logic [15:0] lite_awaddr,
    input logic lite_wvalid,
    input logic [31:0] lite_wdata,
    input logic [3:0] lite_wstrb,
    input logic lite_bready,
    input logic lite_arvalid,
    input logic [15:0] lite_araddr,
    input logic lite_rready,
    input logic awvalid,
    input logic [ID_BITS-1:0] awid,
    input logic [REGION_BITS+1:0] awaddr,
    input logic [7:0] awlen,
    input logic [2:0] awsize,
    input logic [1:0] awburst,
    input logic wvalid,
    input logic [63:0] wdata,
    input logic [7:0] wstrb,
    input logic wlast,
    input logic bready,
    input logic arvalid,
    input logic [ID_BITS-1:0] arid,
    input logic [REGION_BITS+1:0] araddr,
    input logic [7:0] arlen,
    input logic [2:0] arsize,
    input logic [1:0] arburst,
    input logic rready,
    input logic [31:0] answer,
    input logic [63:0] host_value,
    input logic status_busy,
    input logic irq,
    input logic busy,
    input logic [31:0] cycles
);
  localparam logic [15:0] STATUS = 16'h0010;
  localparam logic [15:0] RESET = 16'h3000;
  localparam logic [15:0] DIGEST = 16'h3014;
  localparam logic [15:0] LIMIT = 16'h3018;
  localparam logic [3:0] CYCLE_LIMIT = 4'd9;

  logic reset = 1'b1;
  always_ff @(posedge clock) reset <= 1'b0;

  logic lite_awready, lite_wready, lite_bvalid, lite_arready, lite_rvalid;
  logic awready, wready, bvalid, arready, rvalid, rlast;
  logic [1:0] lite_bresp, lite_rresp, bresp, rresp;
  logic [31:0] lite_rdata, bus_value, bus_answer;
  logic [ID_BITS-1:0] bid, rid;
  logic [63:0] rdata, host_word;
  logic engine_reset, bus_write, bus_read, host_write, host_read, code_write, template_write;
  logic [15:0] bus_address;
  logic [ADDRESS_BITS-1:0] host_address;
  logic [CODE_BITS-1:0] code_address;
  logic [CODE_WIDTH-1:0] code_word;
  logic [contract::TEMPLATE_BITS-1:0] template_address;
  logic [contract::TEMPLATE_WIDTH-1:0] template_word;
  assign bus_answer = bus_address == STATUS ? {answer[31:1], status_busy} : answer;
  logic stream_failed, base_write;
  logic [1:0] base_port;
  logic [31:0] base_value;
  assign stream_failed = 1'b0;
  axi_slaves #(
      .FP(64),
      .ADDRESS_BITS(ADDRESS_BITS),
      .CODE_BITS(CODE_BITS),
      .CODE_WIDTH(CODE_WIDTH),
      .ID_BITS(ID_BITS),
      .REGION_BITS(REGION_BITS)
  ) slaves (
      .*
  );

  // Accepted in this clock.
  logic aw, w, b, ar, r, lite_aw, lite_w, lite_b, lite_ar, lite_r;
  assign aw = awvalid && awready;
  assign w = wvalid && wready;
  assign b = bvalid && bready;
  assign ar = arvalid && arready;
  assign r = rvalid && rready;
  assign lite_aw = lite_awvalid && lite_awready;
  assign lite_w = lite_wvalid && lite_wready;
  assign lite_b = lite_bvalid && lite_bready;
  assign lite_ar = lite_arvalid && lite_arready;
  assign lite_r = lite_rvalid && lite_rready;

  // The engine runs only after a register write.
  logic running, ran, wrote;
  assign running = status_busy || busy;
  always_ff @(posedge clock) begin
    ran <= running;
    wrote <= bus_write;
    if (reset || !(ran || wrote)) assume (!running);
  end

  // VALID stays up with its payload.
  logic b_waits, r_waits, lite_b_waits, lite_r_waits, was_last;
  logic [ID_BITS-1:0] was_bid, was_rid;
  logic [1:0] was_bresp, was_rresp, was_lite_bresp;
  logic [63:0] was_rdata;
  logic [31:0] was_lite_rdata;
  always_ff @(posedge clock) begin
    b_waits <= bvalid && !bready && !reset;
    r_waits <= rvalid && !rready && !reset;
    lite_b_waits <= lite_bvalid && !lite_bready && !reset;
    lite_r_waits <= lite_rvalid && !lite_rready && !reset;
    {was_bid, was_bresp} <= {bid, bresp};
    {was_rid, was_rresp, was_rdata, was_last} <= {rid, rresp, rdata, rlast};
    was_lite_bresp <= lite_bresp;
    was_lite_rdata <= lite_rdata;
    if (!reset) begin
      if (b_waits) assert (bvalid && {was_bid, was_bresp} == {bid, bresp});
      if (r_waits) assert (rvalid && {was_rid, was_rresp, was_rdata, was_last} == {rid, rresp, rdata, rlast});
      if (lite_b_waits) assert (lite_bvalid && was_lite_bresp == lite_bresp);
      if (lite_r_waits) assert (lite_rvalid && was_lite_rdata == lite_rdata);
    end
  end

  // One B a burst, after its address and all of its beats, with its ID; as many R as the burst has beats, RLAST with the last.
  logic write_owed, read_owed;
  logic [8:0] write_beats, read_beats;  // still to come
  logic [ID_BITS-1:0] write_id, read_id;
  always_ff @(posedge clock) begin
    if (reset) {write_owed, read_owed} <= '0;
    else begin
      if (aw) {write_owed, write_beats, write_id} <= {1'b1, 9'(awlen) + 9'd1, awid};
      if (w) write_beats <= write_beats - 9'd1;
      if (b) write_owed <= 1'b0;
      if (ar) {read_owed, read_beats, read_id} <= {1'b1, 9'(arlen) + 9'd1, arid};
      if (r) read_beats <= read_beats - 9'd1;
      if (r && rlast) read_owed <= 1'b0;
      if (aw) assert (!write_owed);
      if (w) assert (write_owed && write_beats != '0);
      if (bvalid) assert (write_owed && write_beats == '0 && bid == write_id && !bresp[0]);
      if (ar) assert (!read_owed);
      if (rvalid) assert (read_owed && rid == read_id && rlast == (read_beats == 9'd1) && !rresp[0]);
    end
  end

  // Register writes: each with all strobes reaches the bus once, with its address and value, in order, before its B; the
  // wrapper's own and those without all strobes never do. The next address or data may come while a B waits.
  logic [1:0] addresses, datas;  // taken, and not answered
  logic [15:0] address_0, address_1;
  logic [31:0] value_0, value_1;
  logic whole_0, whole_1, seen, forwarded;
  assign forwarded = whole_0 && address_0 != RESET && address_0 != DIGEST && address_0 != LIMIT;
  always_ff @(posedge clock) begin
    if (reset) {addresses, datas, seen} <= '0;
    else begin
      addresses <= addresses + 2'(lite_aw) - 2'(lite_b);
      datas <= datas + 2'(lite_w) - 2'(lite_b);
      if (lite_b) address_0 <= address_1;
      if (lite_b) {value_0, whole_0} <= {value_1, whole_1};
      if (lite_aw && addresses - 2'(lite_b) == 2'd0) address_0 <= lite_awaddr;
      if (lite_aw) address_1 <= lite_awaddr;
      if (lite_w && datas - 2'(lite_b) == 2'd0) {value_0, whole_0} <= {lite_wdata, lite_wstrb == 4'b1111};
      if (lite_w) {value_1, whole_1} <= {lite_wdata, lite_wstrb == 4'b1111};
      seen <= (seen || bus_write) && !lite_b;
      assert (addresses != 2'd3 && datas != 2'd3);
      if (bus_write) assert (addresses != '0 && datas != '0 && forwarded && !seen && bus_address == address_0 && bus_value == value_0);
      if (lite_bvalid) assert (addresses != '0 && datas != '0 && (seen || bus_write) == forwarded && lite_bresp[1] != whole_0);
    end
  end

  // Register reads: each reaches the bus at most once, with its address; what the bus answered is what comes back, but for the
  // fault in STATUS once a launch was stopped. That is a read of LIMIT on the bus, which no master's reaches, behind a reset.
  logic [1:0] read_count;
  logic [15:0] read_0, read_1;
  logic read_seen, asked_read, told, was_reset;
  logic [31:0] read_answer;
  assign asked_read = bus_read && bus_address != LIMIT;
  always_ff @(posedge clock) begin
    was_reset <= engine_reset;
    if (reset) {read_count, read_seen, told} <= '0;
    else begin
      read_count <= read_count + 2'(lite_ar) - 2'(lite_r);
      if (lite_r) read_0 <= read_1;
      if (lite_ar && read_count - 2'(lite_r) == 2'd0) read_0 <= lite_araddr;
      if (lite_ar) read_1 <= lite_araddr;
      if (engine_reset || bus_read && bus_address == LIMIT) told <= !engine_reset;
      if (bus_read && bus_address == LIMIT) assert (was_reset && !engine_reset);
      read_seen <= (read_seen || asked_read) && !lite_r;
      if (asked_read) read_answer <= told && bus_address == STATUS ? {bus_answer[31:12], CYCLE_LIMIT, bus_answer[7:0]} : bus_answer;
      assert (read_count != 2'd3 && !(bus_read && bus_write));
      if (asked_read) assert (read_count != '0 && !read_seen && bus_address == read_0);
      if (lite_rvalid) assert (read_count != '0 && (!read_seen || lite_rdata == read_answer));
      if (lite_rvalid && read_0[15:5] != 11'h180) assert (read_seen);  // the wrapper's own
    end
  end

  // Memories: never while the engine runs or is reset, one access at a time; a write settles for four clocks before a read
  // or a register write, a read is over before a register write.
  logic access;
  logic [3:0] written;
  logic [4:0] asked;
  assign access = host_write || host_read || code_write || template_write;
  always_ff @(posedge clock) begin
    written <= reset ? '0 : {written[2:0], host_write || code_write || template_write};
    asked <= reset ? '0 : {asked[3:0], host_read};
    if (!reset) begin
      if (access) assert (!running && !engine_reset && !bus_write);
      assert (2'(host_write) + 2'(host_read) + 2'(code_write) + 2'(template_write) <= 2'd1);
      if (host_read) assert (written == '0);
      if (bus_write) assert (written == '0 && asked == '0);
    end
  end
endmodule
