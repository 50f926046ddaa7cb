// A computer for one FPGA: the core PicoRV32 (picorv32.v of its authors), memory, a serial line, and the engine behind AXI.
//   0x0000_0000  memory, where the core begins      0x1000_0000  serial line and LEDs (board_registers.sv)
//   0x2000_0000  registers of the engine            0x3000_0000  memories of the engine
// An access elsewhere is answered with zero. The core takes no interrupts: the driver polls.
module board #(
    parameter int FP = 32,
    parameter int LANES = 1,
    parameter int BANKS = 4,
    parameter int ADDRESS_BITS = 11,
    parameter int CODE_BITS = 14,
    parameter int SEQUENCER = 1,
    parameter int WORDS = 49152,
    parameter IMAGE = "memory.hex",
    parameter int CLOCKS = 217  // of a bit on the serial line
) (
    input logic clock,
    input logic reset,
    input logic line_in,
    output logic line_out,
    output logic [6:0] leds,
    output logic trapped
);
  localparam int ID_BITS = 1;
  localparam int REGION_BITS = 24;
  localparam int PLACES = $clog2(WORDS);

  // The core's accesses. Kept under their names, so that a netlist is compared by them.
  (* keep *)logic valid, ready;
  (* keep *)logic [31:0] address, value, answer;
  (* keep *)logic [3:0] strobes;
  logic instruction, write;
  picorv32 #(
      .ENABLE_COUNTERS64(1),
      .BARREL_SHIFTER(1),
      .ENABLE_FAST_MUL(1),
      .ENABLE_DIV(1)
  ) core (
      .clk(clock),
      .resetn(!reset),
      .trap(trapped),
      .mem_valid(valid),
      .mem_instr(instruction),
      .mem_ready(ready),
      .mem_addr(address),
      .mem_wdata(value),
      .mem_wstrb(strobes),
      .mem_rdata(answer),
      .pcpi_wr(1'b0),
      .pcpi_rd(32'd0),
      .pcpi_wait(1'b0),
      .pcpi_ready(1'b0),
      .irq(32'd0)
  );

  // Whose access it is.
  logic of_memory, of_registers, of_lite, of_memories, elsewhere;
  assign write = strobes != '0;
  assign of_memory = valid && address[31:28] == 4'h0 && address[27:2] < 26'(WORDS);
  assign of_registers = valid && address[31:28] == 4'h1;
  assign of_lite = valid && address[31:28] == 4'h2;
  assign of_memories = valid && address[31:28] == 4'h3;
  assign elsewhere = valid && !of_memory && !of_registers && !of_lite && !of_memories;

  logic read_there;
  logic [31:0] word, registers_answer, lite_answer;
  logic [63:0] memories_answer;
  logic registers_done, lite_done, lite_refused, memories_done, memories_refused;
  always_ff @(posedge clock) read_there <= of_memory && !ready && !reset;
  assign ready = (of_memory && (write || read_there)) || registers_done || lite_done || memories_done || elsewhere;
  always_comb
    case (address[31:28])
      4'h0: answer = elsewhere ? '0 : word;
      4'h1: answer = registers_answer;
      4'h2: answer = lite_answer;
      4'h3: answer = address[2] ? memories_answer[63:32] : memories_answer[31:0];
      default: answer = '0;
    endcase

  board_memory #(
      .WORDS(WORDS),
      .IMAGE(IMAGE)
  ) memory (
      .clock(clock),
      .place(address[PLACES+1:2]),
      .write(of_memory ? strobes : 4'd0),
      .value(value),
      .word(word)
  );
  board_registers #(
      .CLOCKS(CLOCKS)
  ) registers (
      .clock(clock),
      .reset(reset),
      .wanted(of_registers),
      .write(write),
      .place(address[2]),
      .value(value),
      .done(registers_done),
      .answer(registers_answer),
      .refused(lite_refused || memories_refused),
      .leds(leds),
      .line_out(line_out),
      .line_in(line_in)
  );

  logic irq;
  logic lite_awvalid, lite_awready, lite_wvalid, lite_wready, lite_bvalid, lite_bready;
  logic lite_arvalid, lite_arready, lite_rvalid, lite_rready;
  logic awvalid, awready, wvalid, wready, bvalid, bready, arvalid, arready, rvalid, rready, rlast;
  logic [1:0] lite_bresp, lite_rresp, bresp, rresp;
  logic [ID_BITS-1:0] bid, rid;
  board_port lite (
      .clock(clock),
      .reset(reset),
      .wanted(of_lite),
      .write(write),
      .done(lite_done),
      .refused(lite_refused),
      .awvalid(lite_awvalid),
      .awready(lite_awready),
      .wvalid(lite_wvalid),
      .wready(lite_wready),
      .bvalid(lite_bvalid),
      .bready(lite_bready),
      .bresp(lite_bresp),
      .arvalid(lite_arvalid),
      .arready(lite_arready),
      .rvalid(lite_rvalid),
      .rready(lite_rready),
      .rresp(lite_rresp)
  );
  board_port memories (
      .clock(clock),
      .reset(reset),
      .wanted(of_memories),
      .write(write),
      .done(memories_done),
      .refused(memories_refused),
      .awvalid(awvalid),
      .awready(awready),
      .wvalid(wvalid),
      .wready(wready),
      .bvalid(bvalid),
      .bready(bready),
      .bresp(bresp),
      .arvalid(arvalid),
      .arready(arready),
      .rvalid(rvalid),
      .rready(rready),
      .rresp(rresp)
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
      .BANKS(BANKS),
      .ADDRESS_BITS(ADDRESS_BITS),
      .CODE_BITS(CODE_BITS),
      .SEQUENCER(SEQUENCER),
      .CHECKS(0),
      .ID_BITS(ID_BITS),
      .REGION_BITS(REGION_BITS)
  ) pl (
      .aclk(clock),
      .aresetn(!reset),
      .irq(irq),
      .s_axil_awvalid(lite_awvalid),
      .s_axil_awready(lite_awready),
      .s_axil_awaddr(address[15:0]),
      .s_axil_wvalid(lite_wvalid),
      .s_axil_wready(lite_wready),
      .s_axil_wdata(value),
      .s_axil_wstrb(strobes),
      .s_axil_bvalid(lite_bvalid),
      .s_axil_bready(lite_bready),
      .s_axil_bresp(lite_bresp),
      .s_axil_arvalid(lite_arvalid),
      .s_axil_arready(lite_arready),
      .s_axil_araddr(address[15:0]),
      .s_axil_rvalid(lite_rvalid),
      .s_axil_rready(lite_rready),
      .s_axil_rdata(lite_answer),
      .s_axil_rresp(lite_rresp),
      .s_axi_awvalid(awvalid),
      .s_axi_awready(awready),
      .s_axi_awid('0),
      .s_axi_awaddr(address[REGION_BITS+1:0]),
      .s_axi_awlen(8'd0),
      .s_axi_awsize(3'd2),
      .s_axi_awburst(2'd1),
      .s_axi_wvalid(wvalid),
      .s_axi_wready(wready),
      .s_axi_wdata({value, value}),
      .s_axi_wstrb(address[2] ? {strobes, 4'd0} : {4'd0, strobes}),
      .s_axi_wlast(1'b1),
      .s_axi_bvalid(bvalid),
      .s_axi_bready(bready),
      .s_axi_bid(bid),
      .s_axi_bresp(bresp),
      .s_axi_arvalid(arvalid),
      .s_axi_arready(arready),
      .s_axi_arid('0),
      .s_axi_araddr(address[REGION_BITS+1:0]),
      .s_axi_arlen(8'd0),
      .s_axi_arsize(3'd2),
      .s_axi_arburst(2'd1),
      .s_axi_rvalid(rvalid),
      .s_axi_rready(rready),
      .s_axi_rid(rid),
      .s_axi_rdata(memories_answer),
      .s_axi_rresp(rresp),
      .s_axi_rlast(rlast),
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
