// One port of streamed microcode: an AXI4 read master, and the parts of lines that it has read. It asks in bursts of up to
// BURST beats, none across a multiple of that, as soon as there is room for all of one. Beats come in the order in which
// they were asked for (one ID), and are always taken. At rest nothing is kept: beats that are still to come are dropped,
// and the next segment waits for them.
module axi_stream_port #(
    parameter int PART = 64,
    parameter int BEAT = 64,
    parameter int CODE_BITS = 17,
    parameter int ROWS = contract::STREAM_ROWS,
    parameter int BURST = contract::STREAM_BURST
) (
    input logic clock,
    input logic reset,  // of the bus
    input logic rest,  // no segment runs
    input logic begins,  // one does from this cycle on: its first line and their number, where line 0 lies
    input logic [CODE_BITS-1:0] first,
    input logic [CODE_BITS-1:0] lines,
    input logic [31:0] base,
    output logic arvalid,
    input logic arready,
    output logic [31:0] araddr,
    output logic [7:0] arlen,
    input logic rvalid,
    input logic [BEAT-1:0] rdata,
    input logic rerror,
    output logic there,
    output logic [PART-1:0] part,
    input logic taken,
    output logic failed  // a beat of this segment came with an error, in this cycle
);
  localparam int BEATS = PART / BEAT;  // of a part
  localparam int PARTS = BURST / BEATS;  // of a burst
  localparam int SHIFT = $clog2(PART / 8);
  localparam int IN_BURST = $clog2(PARTS);
  localparam int ROW = $clog2(ROWS);
  localparam int COUNT = $clog2(ROWS * BEATS) + 1;

  // Bursts.
  logic [31:0] at;
  logic [CODE_BITS-1:0] left;  // parts
  logic [IN_BURST:0] whole, count;
  logic [ROW:0] claimed;  // parts that were asked for and not yet read out
  logic [COUNT-1:0] pending, stale, pending_next;  // beats to come; of these to be dropped
  logic ask, move;
  assign whole = (IN_BURST + 1)'(PARTS) - {1'b0, at[SHIFT+:IN_BURST]};
  assign count = left < CODE_BITS'(whole) ? (IN_BURST + 1)'(left) : whole;
  assign ask = !rest && left != '0 && (!arvalid || arready) && stale == '0 && claimed <= (ROW + 1)'(ROWS - PARTS);
  assign pending_next = pending + (ask ? COUNT'(count) * COUNT'(BEATS) : '0) - COUNT'(rvalid);
  always_ff @(posedge clock) begin
    if (reset) begin
      arvalid <= 1'b0;
      pending <= '0;
      stale <= '0;
    end else begin
      if (ask) arvalid <= 1'b1;
      else if (arready) arvalid <= 1'b0;
      pending <= pending_next;
      if (rest) stale <= pending_next;
      else if (rvalid && stale != '0) stale <= stale - COUNT'(1);
    end
    if (begins) begin
      at <= base + (32'(first) << SHIFT);
      left <= lines;
    end else if (ask) begin
      at <= at + (32'(count) << SHIFT);
      left <= left - CODE_BITS'(count);
    end
    if (rest) begin
      left <= '0;
      claimed <= '0;
    end else begin
      claimed <= claimed + (ask ? (ROW + 1)'(count) : '0) - (ROW + 1)'(move);
    end
    if (ask) begin
      araddr <= at;
      arlen <= 8'(count) * 8'(BEATS) - 8'd1;
    end
  end

  // Beats become parts.
  logic fresh, completes;
  logic [PART-1:0] arrived;
  assign fresh = rvalid && stale == '0;
  assign failed = fresh && rerror && !rest;
  generate
    if (BEATS == 1) begin : g_whole
      assign completes = fresh;
      assign arrived = rdata;
    end else begin : g_beats
      logic [$clog2(BEATS)-1:0] beat;
      logic [PART-BEAT-1:0] earlier;
      always_ff @(posedge clock) begin
        if (rest) beat <= '0;
        else if (fresh) beat <= beat + ($clog2(BEATS))'(1);
        if (fresh) earlier <= (PART - BEAT)'({rdata, earlier} >> BEAT);
      end
      assign completes = fresh && beat == '1;
      assign arrived = {rdata, earlier};
    end
  endgenerate

  // Parts, and the next one in a register.
  logic [PART-1:0] parts[0:ROWS-1];
  logic [ROW:0] written, read;
  assign move = written != read && (!there || taken);
  always_ff @(posedge clock) begin
    if (completes) parts[written[ROW-1:0]] <= arrived;
    if (move) part <= parts[read[ROW-1:0]];
    if (rest) begin
      written <= '0;
      read <= '0;
      there <= 1'b0;
    end else begin
      if (completes) written <= written + (ROW + 1)'(1);
      if (move) read <= read + (ROW + 1)'(1);
      there <= move || (there && !taken);
    end
  end
endmodule
