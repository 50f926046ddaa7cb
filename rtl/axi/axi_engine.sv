// The PL behind AXI: an engine (engine.sv) with AXI4-Lite for its registers and AXI4 for its memories. Clock, reset and
// ports have the names by which tools of the field find an interface.
module axi_engine #(
    parameter int FP /*verilator public*/ = 64,
    parameter int LANES /*verilator public*/ = 4,
    parameter int DIVIDERS /*verilator public*/ = 1,
    parameter int BANKS /*verilator public*/ = 16,
    parameter int CLUSTERS /*verilator public*/ = 1,
    parameter int ADDRESS_BITS /*verilator public*/ = 14,
    parameter int CODE_BITS /*verilator public*/ = 17,
    parameter int SEQUENCER /*verilator public*/ = 0,
    parameter int CHECKS = 1,
    parameter int RESIDENT /*verilator public*/ = 1,
    parameter int PARITY /*verilator public*/ = 0,
    parameter int ROWS = 0,  // of a bank of storage; 0: as many as an address tells apart
    parameter int DEPTH /*verilator public*/ = ROWS == 0 ? (1 << ADDRESS_BITS) / BANKS : ROWS,
    parameter int STREAM /*verilator public*/ = 0,  // ports of streamed microcode: 1, 2 or 4 with SEQUENCER 3
    parameter int BEAT /*verilator public*/ = 64,  // bits of their beats
    parameter int ID_BITS = 4,
    parameter int REGION_BITS = 24,
    parameter int PORTS = STREAM == 0 ? 1 : STREAM
) (
    input logic aclk,
    input logic aresetn,
    output logic irq,
    // AXI4-Lite: registers.
    input logic s_axil_awvalid,
    output logic s_axil_awready,
    input logic [15:0] s_axil_awaddr,
    input logic s_axil_wvalid,
    output logic s_axil_wready,
    input logic [31:0] s_axil_wdata,
    input logic [3:0] s_axil_wstrb,
    output logic s_axil_bvalid,
    input logic s_axil_bready,
    output logic [1:0] s_axil_bresp,
    input logic s_axil_arvalid,
    output logic s_axil_arready,
    input logic [15:0] s_axil_araddr,
    output logic s_axil_rvalid,
    input logic s_axil_rready,
    output logic [31:0] s_axil_rdata,
    output logic [1:0] s_axil_rresp,
    // AXI4: storage, microcode, templates.
    input logic s_axi_awvalid,
    output logic s_axi_awready,
    input logic [ID_BITS-1:0] s_axi_awid,
    input logic [REGION_BITS+1:0] s_axi_awaddr,
    input logic [7:0] s_axi_awlen,
    input logic [2:0] s_axi_awsize,
    input logic [1:0] s_axi_awburst,
    input logic s_axi_wvalid,
    output logic s_axi_wready,
    input logic [63:0] s_axi_wdata,
    input logic [7:0] s_axi_wstrb,
    input logic s_axi_wlast,
    output logic s_axi_bvalid,
    input logic s_axi_bready,
    output logic [ID_BITS-1:0] s_axi_bid,
    output logic [1:0] s_axi_bresp,
    input logic s_axi_arvalid,
    output logic s_axi_arready,
    input logic [ID_BITS-1:0] s_axi_arid,
    input logic [REGION_BITS+1:0] s_axi_araddr,
    input logic [7:0] s_axi_arlen,
    input logic [2:0] s_axi_arsize,
    input logic [1:0] s_axi_arburst,
    output logic s_axi_rvalid,
    input logic s_axi_rready,
    output logic [ID_BITS-1:0] s_axi_rid,
    output logic [63:0] s_axi_rdata,
    output logic [1:0] s_axi_rresp,
    output logic s_axi_rlast,
    // AXI4, reads alone, of streamed microcode: a slice for each port. Bursts are INCR; beats, of BEAT bits, are counted.
    output logic [PORTS-1:0] m_axi_arvalid,
    input logic [PORTS-1:0] m_axi_arready,
    output logic [32*PORTS-1:0] m_axi_araddr,
    output logic [8*PORTS-1:0] m_axi_arlen,
    output logic [3*PORTS-1:0] m_axi_arsize,
    output logic [2*PORTS-1:0] m_axi_arburst,
    input logic [PORTS-1:0] m_axi_rvalid,
    output logic [PORTS-1:0] m_axi_rready,
    input logic [BEAT*PORTS-1:0] m_axi_rdata,
    input logic [2*PORTS-1:0] m_axi_rresp,
    input logic [PORTS-1:0] m_axi_rlast
);
  // As in engine.sv, which has them as parameters so that a harness can see them.
  localparam int WIDTH = 1 + LANES * (4 * ADDRESS_BITS + 4) + DIVIDERS * (3 * ADDRESS_BITS + 2);
  localparam int ITEM_LINES = (2 + LANES * (4 * ADDRESS_BITS + 8) + DIVIDERS * (3 * ADDRESS_BITS + 2) + 95) / 96;
  localparam int FETCH = 32 << $clog2(ITEM_LINES > LANES ? ITEM_LINES : LANES);
  localparam int CODE_WIDTH  /*verilator public*/ = SEQUENCER == 1 || SEQUENCER == 3 ? FETCH : WIDTH;
  localparam int RULES  /*verilator public*/ = 8;
  localparam logic [31:0] ENGINE_WORD = {
    5'd0, DEPTH * BANKS != 1 << ADDRESS_BITS, PARITY != 0, RESIDENT != 0, 3'd0, 3'(STREAM), 2'(SEQUENCER), 8'(DIVIDERS), 1'b0, 7'(LANES)
  } | (FP == 64 ? 32'h80 : 32'h0);
  localparam logic [31:0] SIZES_WORD = {16'(CODE_WIDTH), 8'(CODE_BITS), 8'(ADDRESS_BITS)};

  localparam logic [31:0] IDENTITY_WORD /*verilator public*/ =
      axi_contract::identity(FP, LANES, DIVIDERS, BANKS, CLUSTERS, ADDRESS_BITS, DEPTH,
                             SEQUENCER == 1 ? 1 : SEQUENCER == 3 ? 1 + 2 * STREAM : 0);

  logic engine_reset, bus_write, bus_read, host_write, host_read, code_write, template_write;
  logic [15:0] bus_address;
  logic [31:0] bus_value, bus_answer;
  logic [ADDRESS_BITS-1:0] host_address;
  logic [FP-1:0] host_word, host_value;
  logic [CODE_BITS-1:0] code_address;
  logic [CODE_WIDTH-1:0] code_word;
  logic [contract::TEMPLATE_BITS-1:0] template_address;
  logic [contract::TEMPLATE_WIDTH-1:0] template_word;
  // For a harness alone.
  logic busy  /*verilator public*/;
  logic [31:0] cycles  /*verilator public*/;
  logic [7:0] running  /*verilator public*/;
  logic [RULES-1:0] violations  /*verilator public*/;
  logic fetch_wanted, stream_failed, base_write;
  logic [1:0] base_port;
  logic [31:0] base_value;
  // What the engine has for microcode: writes of its memory, or streamed lines.
  logic line_write;
  logic [CODE_WIDTH-1:0] line;

  axi_slaves #(
      .FP(FP),
      .ADDRESS_BITS(ADDRESS_BITS),
      .WORDS(DEPTH * BANKS),
      .CODE_BITS(CODE_BITS),
      .CODE_WIDTH(CODE_WIDTH),
      .ID_BITS(ID_BITS),
      .REGION_BITS(REGION_BITS),
      .ENGINE_WORD(ENGINE_WORD),
      .SIZES_WORD(SIZES_WORD),
      .IDENTITY_WORD(IDENTITY_WORD),
      .STREAM(STREAM)
  ) slaves (
      .clock(aclk),
      .reset(!aresetn),
      .lite_awvalid(s_axil_awvalid),
      .lite_awready(s_axil_awready),
      .lite_awaddr(s_axil_awaddr),
      .lite_wvalid(s_axil_wvalid),
      .lite_wready(s_axil_wready),
      .lite_wdata(s_axil_wdata),
      .lite_wstrb(s_axil_wstrb),
      .lite_bvalid(s_axil_bvalid),
      .lite_bready(s_axil_bready),
      .lite_bresp(s_axil_bresp),
      .lite_arvalid(s_axil_arvalid),
      .lite_arready(s_axil_arready),
      .lite_araddr(s_axil_araddr),
      .lite_rvalid(s_axil_rvalid),
      .lite_rready(s_axil_rready),
      .lite_rdata(s_axil_rdata),
      .lite_rresp(s_axil_rresp),
      .awvalid(s_axi_awvalid),
      .awready(s_axi_awready),
      .awid(s_axi_awid),
      .awaddr(s_axi_awaddr),
      .awlen(s_axi_awlen),
      .awsize(s_axi_awsize),
      .awburst(s_axi_awburst),
      .wvalid(s_axi_wvalid),
      .wready(s_axi_wready),
      .wdata(s_axi_wdata),
      .wstrb(s_axi_wstrb),
      .wlast(s_axi_wlast),
      .bvalid(s_axi_bvalid),
      .bready(s_axi_bready),
      .bid(s_axi_bid),
      .bresp(s_axi_bresp),
      .arvalid(s_axi_arvalid),
      .arready(s_axi_arready),
      .arid(s_axi_arid),
      .araddr(s_axi_araddr),
      .arlen(s_axi_arlen),
      .arsize(s_axi_arsize),
      .arburst(s_axi_arburst),
      .rvalid(s_axi_rvalid),
      .rready(s_axi_rready),
      .rid(s_axi_rid),
      .rdata(s_axi_rdata),
      .rresp(s_axi_rresp),
      .rlast(s_axi_rlast),
      .engine_reset(engine_reset),
      .bus_write(bus_write),
      .bus_read(bus_read),
      .bus_address(bus_address),
      .bus_value(bus_value),
      .bus_answer(bus_answer),
      .host_write(host_write),
      .host_read(host_read),
      .host_address(host_address),
      .host_word(host_word),
      .host_value(host_value),
      .code_write(code_write),
      .code_address(code_address),
      .code_word(code_word),
      .template_write(template_write),
      .template_address(template_address),
      .template_word(template_word),
      .irq(irq),
      .busy(busy),
      .cycles(cycles),
      .stream_failed(stream_failed),
      .base_write(base_write),
      .base_port(base_port),
      .base_value(base_value)
  );

  generate
    if ((STREAM != 0) != (SEQUENCER == 3)) begin : g_refused
      $error("SEQUENCER 3 has ports of streamed microcode, and no other has");
    end
    if (STREAM != 0) begin : g_stream
      axi_stream #(
          .PORTS(PORTS),
          .FETCH(FETCH),
          .BEAT(BEAT),
          .CODE_BITS(CODE_BITS)
      ) stream (
          .clock(aclk),
          .reset(!aresetn),
          .base_write(base_write),
          .base_port(base_port),
          .base_value(base_value),
          .bus_write(bus_write),
          .bus_address(bus_address),
          .bus_value(bus_value),
          .busy(busy),
          .running(running),
          .there(line_write),
          .line(line),
          .taken(fetch_wanted),
          .failed(stream_failed),
          .arvalid(m_axi_arvalid),
          .arready(m_axi_arready),
          .araddr(m_axi_araddr),
          .arlen(m_axi_arlen),
          .rvalid(m_axi_rvalid),
          .rdata(m_axi_rdata),
          .rresp(m_axi_rresp)
      );
      assign m_axi_rready = '1;
    end else begin : g_no_stream
      assign line_write = code_write;
      assign line = code_word;
      assign stream_failed = 1'b0;
      assign m_axi_arvalid = '0;
      assign m_axi_araddr = '0;
      assign m_axi_arlen = '0;
      assign m_axi_rready = '0;
    end
  endgenerate
  assign m_axi_arsize = {PORTS{3'($clog2(BEAT / 8))}};
  assign m_axi_arburst = {PORTS{2'b01}};

  engine #(
      .FP(FP),
      .LANES(LANES),
      .DIVIDERS(DIVIDERS),
      .BANKS(BANKS),
      .CLUSTERS(CLUSTERS),
      .ADDRESS_BITS(ADDRESS_BITS),
      .CODE_BITS(CODE_BITS),
      .SEQUENCER(SEQUENCER),
      .CHECKS(CHECKS),
      .RESIDENT(RESIDENT),
      .PARITY(PARITY),
      .ROWS(ROWS)
  ) pl (
      .clock(aclk),
      .reset(engine_reset),
      .bus_write(bus_write),
      .bus_read(bus_read),
      .bus_address(bus_address),
      .bus_value(bus_value),
      .bus_answer(bus_answer),
      .irq(irq),
      .host_write(host_write),
      .host_read(host_read),
      .host_address(host_address),
      .host_word(host_word),
      .host_value(host_value),
      .code_write(line_write),
      .code_address(code_address),
      .code_word(line),
      .template_write(template_write),
      .template_address(template_address),
      .template_word(template_word),
      .fetch_valid(1'b1),
      .fetch_wanted(fetch_wanted),
      .busy(busy),
      .cycles(cycles),
      .running(running),
      .violations(violations)
  );
endmodule
