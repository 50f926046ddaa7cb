// Streamed microcode: the lines of the segment that runs, from memory, to the decoder of the engine. Port p has the p-th part
// of each line, FETCH / PORTS bits; the parts of line 0 lie at its BASE, those of the others behind it. Which lines are a
// segment's, the table of segments says, whose writes are seen here as well. Behind the last one the decoder, which looks
// ahead, is given anything.
module axi_stream #(
    parameter int PORTS = 1,
    parameter int FETCH = 128,
    parameter int BEAT = 64,
    parameter int CODE_BITS = 17,
    parameter int SEGMENTS = 64
) (
    input logic clock,
    input logic reset,
    // Where the ports' lines lie; a word of the table of segments.
    input logic base_write,
    input logic [1:0] base_port,
    input logic [31:0] base_value,
    input logic bus_write,
    input logic [15:0] bus_address,
    input logic [31:0] bus_value,
    // The engine.
    input logic busy,
    input logic [7:0] running,
    output logic there,
    output logic [FETCH-1:0] line,
    input logic taken,
    output logic failed,  // memory has answered with an error: no line comes any more
    // AXI4 read channels, a slice for each port.
    output logic [PORTS-1:0] arvalid,
    input logic [PORTS-1:0] arready,
    output logic [32*PORTS-1:0] araddr,
    output logic [8*PORTS-1:0] arlen,
    input logic [PORTS-1:0] rvalid,
    input logic [BEAT*PORTS-1:0] rdata,
    input logic [2*PORTS-1:0] rresp
);
  localparam logic [15:0] TABLE = 16'h1000;
  localparam logic [15:0] TABLE_END = TABLE + 16'(64 * SEGMENTS);
  localparam logic [3:0] START = 4'd1;
  localparam logic [3:0] LINES = 4'd8;
  localparam int PICK = $clog2(SEGMENTS);
  localparam int PART = FETCH / PORTS;

  generate
    if (PART % BEAT != 0 || (PORTS != 1 && PORTS != 2 && PORTS != 4)) begin : g_refused
      $error("1, 2 or 4 ports, and a part of a line is a beat or more");
    end
  endgenerate

  // The table, and its row of the segment that runs, or is the next to.
  (* ram_style = "distributed" *)
  logic [CODE_BITS-1:0] starts[0:SEGMENTS-1];
  (* ram_style = "distributed" *)
  logic [CODE_BITS-1:0] counts[0:SEGMENTS-1];
  logic [15:0] into_table;
  logic [CODE_BITS-1:0] first, lines, left;
  logic in_table, was_busy, begins, rest, spent;
  logic [PORTS-1:0] has, errors;
  assign into_table = bus_address - TABLE;
  assign in_table = bus_write && bus_address >= TABLE && bus_address < TABLE_END;
  assign begins = busy && !was_busy;
  assign rest = reset || !busy;
  assign there = (&has || spent) && !failed;
  always_ff @(posedge clock) begin
    if (in_table && into_table[5:2] == START) starts[into_table[6+:PICK]] <= bus_value[CODE_BITS-1:0];
    if (in_table && into_table[5:2] == LINES) counts[into_table[6+:PICK]] <= bus_value[CODE_BITS-1:0];
    first <= starts[running[PICK-1:0]];
    lines <= counts[running[PICK-1:0]];
    was_busy <= !rest;
    failed <= !rest && (failed || errors != '0);
    if (begins) begin
      left <= lines;
      spent <= 1'b0;
    end else if (taken && !spent) begin
      left <= left - CODE_BITS'(1);
      spent <= left == CODE_BITS'(1);
    end
  end

  generate
    for (genvar p = 0; p < PORTS; p++) begin : g_port
      logic [31:0] base;
      always_ff @(posedge clock) if (base_write && base_port == 2'(p)) base <= base_value;
      axi_stream_port #(
          .PART(PART),
          .BEAT(BEAT),
          .CODE_BITS(CODE_BITS)
      ) port (
          .clock(clock),
          .reset(reset),
          .rest(rest),
          .begins(begins),
          .first(first),
          .lines(lines),
          .base(base),
          .arvalid(arvalid[p]),
          .arready(arready[p]),
          .araddr(araddr[32*p+:32]),
          .arlen(arlen[8*p+:8]),
          .rvalid(rvalid[p]),
          .rdata(rdata[BEAT*p+:BEAT]),
          .rerror(rresp[2*p+1]),
          .there(has[p]),
          .part(line[PART*p+:PART]),
          .taken(taken && !spent),
          .failed(errors[p])
      );
    end
  endgenerate
endmodule
