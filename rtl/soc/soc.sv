// A whole computer: a Rocket core (RV64GC, third party), memory, the engine behind AXI, one DMA, a console. The engine's clock is the
// core's divided by a ratio: the harness gives both, and `next_tick` where the clock of the core after the next edge ends with an edge of
// the engine's; it stops the engine's while `pl_stopped`. Inputs are registered: a simulator works out anew, at each edge, all that
// depends on an input without a register between, which was much of the core.
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
    input logic next_tick,
    input logic reset_input,
    input logic [15:0] latency,
    input logic [2:0] fault,
    input logic [15:0] fault_skip,
    input logic [15:0] fault_times,
    output logic pl_stopped,
    output logic pl_busy,
    output logic [7:0] pl_running,
    output logic console_valid,
    output logic [7:0] console_byte,
    output logic exit_valid,
    output logic [31:0] exit_code
);
  logic reset, pl_edge;
  logic [2:0] kind;
  logic [15:0] skip, times;
  wire tick = pl_edge && !pl_stopped;
  always_ff @(posedge clock) begin
    reset <= reset_input;
    pl_edge <= next_tick;
    kind <= fault;
    skip <= fault_skip;
    times <= fault_times;
  end
  soc_axi main (), device (), coherent ();

  logic pl_irq, dma_irq, bus_error, no_interrupt;
  soc_core core (
      .clock(clock),
      .reset(reset),
      .interrupts({5'd0, bus_error, dma_irq, pl_irq && !no_interrupt}),
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

  assign pl_busy = engine.busy;
  assign pl_running = engine.running;
  logic [63:0] engine_clocks;
  always_ff @(posedge clock)
    if (reset) engine_clocks <= '0;
    else if (tick && engine.busy) engine_clocks <= engine_clocks + 1'b1;

  logic [31:0] descriptor;
  logic [15:0] descriptors;
  logic dma_start, dma_clear, dma_busy, dma_refused;
  logic restart, registers_cut, memories_cut, registers_refused, memories_refused, bus_error_clear;
  logic [3:0] restart_left;
  wire restarting = restart_left != 0;
  always_ff @(posedge clock) begin
    if (reset) restart_left <= '0;
    else if (restart) restart_left <= 4'd8;
    else if (tick && restarting) restart_left <= restart_left - 1'b1;
    if (reset) bus_error <= 1'b0;
    else if (registers_refused || memories_refused) bus_error <= 1'b1;
    else if (bus_error_clear) bus_error <= 1'b0;
  end
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
      .engine_clocks(engine_clocks),
      .restart(restart),
      .pl_state({memories_cut, registers_cut, restarting}),
      .bus_error_clear(bus_error_clear),
      .bus_error(bus_error)
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
  soc_axi guarded_words (), guarded_lite ();
  soc_guard words_guard (
      .clock(clock),
      .reset(reset),
      .restart(restarting),
      .cut(memories_cut),
      .refused(memories_refused),
      .above(shared),
      .below(guarded_words)
  );
  soc_guard lite_guard (
      .clock(clock),
      .reset(reset),
      .restart(restarting),
      .cut(registers_cut),
      .refused(registers_refused),
      .above(parts[1]),
      .below(guarded_lite)
  );
  logic refuse_register, refuse_memory, engine_reset, endless, program_end;
  soc_tick words_tick (
      .tick(tick),
      .refuse(refuse_memory),
      .fast(guarded_words),
      .slow(words)
  );
  soc_tick lite_tick (
      .tick(tick),
      .refuse(refuse_register),
      .fast(guarded_lite),
      .slow(lite)
  );
  soc_fault faults (
      .clock(clock),
      .reset(reset),
      .tick(tick),
      .kind(kind),
      .skip(skip),
      .times(times),
      .register_answer((guarded_lite.bvalid && guarded_lite.bready) || (guarded_lite.rvalid && guarded_lite.rready)),
      .memory_answer((guarded_words.bvalid && guarded_words.bready) || (guarded_words.rvalid && guarded_words.rready && guarded_words.rlast)),
      .memory_address(guarded_words.awvalid && guarded_words.awready),
      .memory_length(guarded_words.awlen),
      .memory_beat(guarded_words.wvalid && guarded_words.wready),
      .program_end(program_end && guarded_lite.wvalid && guarded_lite.wready),
      .interrupt(pl_irq),
      .runs(engine.busy),
      .restart(restart),
      .refuse_register(refuse_register),
      .refuse_memory(refuse_memory),
      .no_interrupt(no_interrupt),
      .engine_reset(engine_reset),
      .endless(endless),
      .stopped(pl_stopped)
  );

  logic awvalid, awready, wvalid, wready, bvalid, bready, arvalid, arready, rvalid, rready;
  logic [15:0] awaddr, araddr;
  logic [31:0] wdata, rdata;
  logic [3:0] wstrb;
  logic [1:0] bresp, rresp;
  soc_lite registers (
      .clock(pl_clock),
      .reset(reset),
      .endless(endless),
      .program_end(program_end),
      .bus(lite),
      .*
  );
  // No streamed microcode.
  logic no_arvalid, no_rready;
  logic [31:0] no_araddr;
  logic [7:0] no_arlen;
  logic [2:0] no_arsize;
  logic [1:0] no_arburst;
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
      .aresetn(!(reset || restarting || engine_reset)),
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
      .s_axi_rlast(words.rlast),
      .m_axi_arvalid(no_arvalid),
      .m_axi_arready('0),
      .m_axi_araddr(no_araddr),
      .m_axi_arlen(no_arlen),
      .m_axi_arsize(no_arsize),
      .m_axi_arburst(no_arburst),
      .m_axi_rvalid('0),
      .m_axi_rready(no_rready),
      .m_axi_rdata('0),
      .m_axi_rresp('0),
      .m_axi_rlast('0)
  );
endmodule
