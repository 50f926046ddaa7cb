// A whole computer: a Rocket core (RV64GC, third party), memory, the engine behind AXI, one DMA, a console. The engine's clock is the
// core's divided by a ratio: the harness gives both, and `tick` in the clock of the core that ends with an edge of the engine's.
module soc #(
    parameter int FP /*verilator public*/ = 64,
    parameter int LANES /*verilator public*/ = 4,
    parameter int DIVIDERS /*verilator public*/ = 1,
    parameter int BANKS /*verilator public*/ = 16,
    parameter int CLUSTERS /*verilator public*/ = 1,
    parameter int ADDRESS_BITS /*verilator public*/ = 14,
    parameter int CODE_BITS /*verilator public*/ = 17,
    parameter int SEQUENCER /*verilator public*/ = 0,
    parameter int RESIDENT /*verilator public*/ = 1,
    parameter int BYTE_BITS = 25
) (
    input logic clock,
    input logic pl_clock,
    input logic tick,
    input logic reset,
    input logic [15:0] latency,
    output logic console_valid,
    output logic [7:0] console_byte,
    output logic exit_valid,
    output logic [31:0] exit_code
);
  soc_axi main (), device (), coherent ();

  logic pl_irq, dma_irq;
  soc_core core (
      .clock(clock),
      .reset(reset),
      .interrupts({6'd0, dma_irq, pl_irq}),
      .main(main),
      .device(device),
      .coherent(coherent)
  );
  soc_memory #(
      .BYTE_BITS(BYTE_BITS)
  ) memory (
      .clock(clock),
      .reset(reset),
      .latency(latency),
      .bus(main)
  );

  soc_axi parts[3] ();
  soc_switch #(
      .PARTS(3),
      .BASES({32'h3000_0000, 32'h2000_0000, 32'h1000_0000})
  ) switch (
      .clock(clock),
      .reset(reset),
      .above(device),
      .below(parts)
  );

  logic [63:0] engine_clocks;
  always_ff @(posedge clock)
    if (reset) engine_clocks <= '0;
    else if (tick && engine.busy) engine_clocks <= engine_clocks + 1'b1;

  logic [31:0] descriptor;
  logic [15:0] descriptors;
  logic dma_start, dma_clear, dma_busy, dma_refused;
  soc_board board (
      .clock(clock),
      .reset(reset),
      .bus(parts[0]),
      .console_valid(console_valid),
      .console_byte(console_byte),
      .exit_valid(exit_valid),
      .exit_code(exit_code),
      .descriptor(descriptor),
      .descriptors(descriptors),
      .start(dma_start),
      .clear(dma_clear),
      .busy(dma_busy),
      .refused(dma_refused),
      .engine_clocks(engine_clocks)
  );
  soc_axi moved (), shared (), words (), lite ();
  soc_dma dma (
      .clock(clock),
      .reset(reset),
      .first(descriptor),
      .count(descriptors),
      .start(dma_start),
      .clear(dma_clear),
      .busy(dma_busy),
      .refused(dma_refused),
      .irq(dma_irq),
      .memory(coherent),
      .engine(moved)
  );
  soc_share share (
      .clock(clock),
      .reset(reset),
      .first(moved),
      .second(parts[2]),
      .below(shared)
  );
  soc_tick words_tick (
      .tick(tick),
      .fast(shared),
      .slow(words)
  );
  soc_tick lite_tick (
      .tick(tick),
      .fast(parts[1]),
      .slow(lite)
  );

  logic awvalid, awready, wvalid, wready, bvalid, bready, arvalid, arready, rvalid, rready;
  logic [15:0] awaddr, araddr;
  logic [31:0] wdata, rdata;
  logic [3:0] wstrb;
  logic [1:0] bresp, rresp;
  soc_lite registers (
      .clock(pl_clock),
      .reset(reset),
      .bus(lite),
      .*
  );
  axi_engine #(
      .FP(FP),
      .LANES(LANES),
      .DIVIDERS(DIVIDERS),
      .BANKS(BANKS),
      .CLUSTERS(CLUSTERS),
      .ADDRESS_BITS(ADDRESS_BITS),
      .CODE_BITS(CODE_BITS),
      .SEQUENCER(SEQUENCER),
      .RESIDENT(RESIDENT),
      .ID_BITS(8)
  ) engine (
      .aclk(pl_clock),
      .aresetn(!reset),
      .irq(pl_irq),
      .s_axil_awvalid(awvalid),
      .s_axil_awready(awready),
      .s_axil_awaddr(awaddr),
      .s_axil_wvalid(wvalid),
      .s_axil_wready(wready),
      .s_axil_wdata(wdata),
      .s_axil_wstrb(wstrb),
      .s_axil_bvalid(bvalid),
      .s_axil_bready(bready),
      .s_axil_bresp(bresp),
      .s_axil_arvalid(arvalid),
      .s_axil_arready(arready),
      .s_axil_araddr(araddr),
      .s_axil_rvalid(rvalid),
      .s_axil_rready(rready),
      .s_axil_rdata(rdata),
      .s_axil_rresp(rresp),
      .s_axi_awvalid(words.awvalid),
      .s_axi_awready(words.awready),
      .s_axi_awid(words.awid),
      .s_axi_awaddr(words.awaddr[25:0]),
      .s_axi_awlen(words.awlen),
      .s_axi_awsize(words.awsize),
      .s_axi_awburst(2'd1),
      .s_axi_wvalid(words.wvalid),
      .s_axi_wready(words.wready),
      .s_axi_wdata(words.wdata),
      .s_axi_wstrb(words.wstrb),
      .s_axi_wlast(words.wlast),
      .s_axi_bvalid(words.bvalid),
      .s_axi_bready(words.bready),
      .s_axi_bid(words.bid),
      .s_axi_bresp(words.bresp),
      .s_axi_arvalid(words.arvalid),
      .s_axi_arready(words.arready),
      .s_axi_arid(words.arid),
      .s_axi_araddr(words.araddr[25:0]),
      .s_axi_arlen(words.arlen),
      .s_axi_arsize(words.arsize),
      .s_axi_arburst(2'd1),
      .s_axi_rvalid(words.rvalid),
      .s_axi_rready(words.rready),
      .s_axi_rid(words.rid),
      .s_axi_rdata(words.rdata),
      .s_axi_rresp(words.rresp),
      .s_axi_rlast(words.rlast)
  );
endmodule
