// Both AXI slaves between a bus and the ports of an engine (engine.sv). docs/driver.md has the address map.
module axi_slaves #(
    parameter int FP /*verilator public*/ = 64,
    parameter int ADDRESS_BITS /*verilator public*/ = 14,
    parameter int WORDS /*verilator public*/ = 1 << ADDRESS_BITS,  // of storage
    parameter int CODE_BITS /*verilator public*/ = 17,
    parameter int CODE_WIDTH /*verilator public*/ = 285,
    parameter int ID_BITS /*verilator public*/ = 4,
    parameter int REGION_BITS /*verilator public*/ = 24,
    parameter int TEMPLATE_WIDTH /*verilator public*/ = contract::TEMPLATE_WIDTH,
    parameter logic [31:0] ENGINE_WORD = 32'd0,
    parameter logic [31:0] SIZES_WORD = 32'd0,
    parameter logic [31:0] IDENTITY_WORD = 32'd0,
    parameter int STREAM = 0  // ports of streamed microcode; then there is no memory for it
) (
    input logic clock,
    input logic reset,
    // AXI4-Lite, 32 bits: registers.
    input logic lite_awvalid,
    output logic lite_awready,
    input logic [15:0] lite_awaddr,
    input logic lite_wvalid,
    output logic lite_wready,
    input logic [31:0] lite_wdata,
    input logic [3:0] lite_wstrb,
    output logic lite_bvalid,
    input logic lite_bready,
    output logic [1:0] lite_bresp,
    input logic lite_arvalid,
    output logic lite_arready,
    input logic [15:0] lite_araddr,
    output logic lite_rvalid,
    input logic lite_rready,
    output logic [31:0] lite_rdata,
    output logic [1:0] lite_rresp,
    // AXI4, 64 bits: memories.
    input logic awvalid,
    output logic awready,
    input logic [ID_BITS-1:0] awid,
    input logic [REGION_BITS+1:0] awaddr,
    input logic [7:0] awlen,
    input logic [2:0] awsize,
    input logic [1:0] awburst,
    input logic wvalid,
    output logic wready,
    input logic [63:0] wdata,
    input logic [7:0] wstrb,
    input logic wlast,  // beats are counted
    output logic bvalid,
    input logic bready,
    output logic [ID_BITS-1:0] bid,
    output logic [1:0] bresp,
    input logic arvalid,
    output logic arready,
    input logic [ID_BITS-1:0] arid,
    input logic [REGION_BITS+1:0] araddr,
    input logic [7:0] arlen,
    input logic [2:0] arsize,
    input logic [1:0] arburst,
    output logic rvalid,
    input logic rready,
    output logic [ID_BITS-1:0] rid,
    output logic [63:0] rdata,
    output logic [1:0] rresp,
    output logic rlast,
    // The engine.
    output logic engine_reset,
    output logic bus_write,
    output logic bus_read,
    output logic [15:0] bus_address,
    output logic [31:0] bus_value,
    input logic [31:0] bus_answer,
    output logic host_write,
    output logic host_read,
    output logic [ADDRESS_BITS-1:0] host_address,
    output logic [FP-1:0] host_word,
    input logic [FP-1:0] host_value,
    output logic code_write,
    output logic [CODE_BITS-1:0] code_address,
    output logic [CODE_WIDTH-1:0] code_word,
    output logic template_write,
    output logic [contract::TEMPLATE_BITS-1:0] template_address,
    output logic [TEMPLATE_WIDTH-1:0] template_word,
    input logic irq,
    input logic busy,
    input logic [31:0] cycles,
    // Streamed microcode.
    input logic stream_failed,
    output logic base_write,
    output logic [1:0] base_port,
    output logic [31:0] base_value
);
  localparam int CODE_PIECES = (CODE_WIDTH + 31) / 32;
  localparam int PIECES = CODE_PIECES > FP / 32 ? CODE_PIECES : FP / 32;
  localparam int STORAGE_BYTES = ADDRESS_BITS + $clog2(FP / 8);
  localparam int STORAGE_END = WORDS * (FP / 8);
  localparam int CODE_BYTES = STREAM != 0 ? 0 : CODE_BITS + $clog2(CODE_PIECES) + 2;
  localparam int TEMPLATE_BYTES = contract::TEMPLATE_BITS + 2;

  generate
    if (STORAGE_BYTES > REGION_BITS || CODE_BYTES > REGION_BITS) begin : g_refused
      $error("a memory is larger than its region of addresses");
    end
  endgenerate

  logic write_wanted, write_done, read_wanted, read_done;
  logic [15:0] write_address, register_address;
  logic [31:0] write_value, register_value;
  axi_lite_slave lite (
      .clock(clock),
      .reset(reset),
      .awvalid(lite_awvalid),
      .awready(lite_awready),
      .awaddr(lite_awaddr),
      .wvalid(lite_wvalid),
      .wready(lite_wready),
      .wdata(lite_wdata),
      .wstrb(lite_wstrb),
      .bvalid(lite_bvalid),
      .bready(lite_bready),
      .bresp(lite_bresp),
      .arvalid(lite_arvalid),
      .arready(lite_arready),
      .araddr(lite_araddr),
      .rvalid(lite_rvalid),
      .rready(lite_rready),
      .rdata(lite_rdata),
      .rresp(lite_rresp),
      .write_wanted(write_wanted),
      .write_address(write_address),
      .write_value(write_value),
      .write_done(write_done),
      .read_wanted(read_wanted),
      .read_address(register_address),
      .read_value(register_value),
      .read_done(read_done)
  );

  assign base_value = write_value;
  logic quiet, open, running, clear_digest;
  logic [31:0] digest;
  axi_registers #(
      .ENGINE_WORD(ENGINE_WORD),
      .SIZES_WORD(SIZES_WORD),
      .IDENTITY_WORD(IDENTITY_WORD),
      .WORDS_WORD(WORDS == 1 << ADDRESS_BITS ? 32'd0 : 32'(WORDS)),
      .STREAM(STREAM)
  ) registers_access (
      .clock(clock),
      .reset(reset),
      .write_wanted(write_wanted),
      .write_address(write_address),
      .write_value(write_value),
      .write_done(write_done),
      .read_wanted(read_wanted),
      .read_address(register_address),
      .read_value(register_value),
      .read_done(read_done),
      .engine_reset(engine_reset),
      .bus_write(bus_write),
      .bus_read(bus_read),
      .bus_address(bus_address),
      .bus_value(bus_value),
      .bus_answer(bus_answer),
      .irq(irq),
      .busy(busy),
      .cycles(cycles),
      .digest(digest),
      .clear_digest(clear_digest),
      .stream_failed(stream_failed),
      .base_write(base_write),
      .base_port(base_port),
      .quiet(quiet),
      .open(open),
      .running(running)
  );

  logic spoilt, digested, digested_pair, piece_valid, piece_pair, piece_ready, piece_take, piece_error, piece_commit, storage_commit;
  logic [REGION_BITS+1:0] piece_address;
  logic [31:0] piece_value, piece_upper;
  logic [ADDRESS_BITS-1:0] storage_address, word_address;
  logic [32*PIECES-1:0] word;
  axi_burst_write #(
      .ID_BITS(ID_BITS),
      .REGION_BITS(REGION_BITS),
      .STORAGE_BYTES(STORAGE_BYTES),
      .STORAGE_END(STORAGE_END),
      .CODE_BYTES(CODE_BYTES),
      .TEMPLATE_BYTES(TEMPLATE_BYTES),
      .WIDE({CODE_PIECES > 1, FP == 64})
  ) writes (
      .clock(clock),
      .reset(reset),
      .awvalid(awvalid),
      .awready(awready),
      .awid(awid),
      .awaddr(awaddr),
      .awlen(awlen),
      .awsize(awsize),
      .awburst(awburst),
      .wvalid(wvalid),
      .wready(wready),
      .wdata(wdata),
      .wstrb(wstrb),
      .bvalid(bvalid),
      .bready(bready),
      .bid(bid),
      .bresp(bresp),
      .piece_valid(piece_valid),
      .piece_pair(piece_pair),
      .piece_ready(piece_ready),
      .piece_error(piece_error || running),
      .piece_address(piece_address),
      .piece_value(piece_value),
      .piece_upper(piece_upper),
      .spoilt(spoilt)
  );
  axi_word_pieces #(
      .REGION_BITS(REGION_BITS),
      .W(FP),
      .ADDRESS_BITS(ADDRESS_BITS),
      .CODE_BITS(CODE_BITS),
      .CODE_WIDTH(CODE_WIDTH)
  ) words (
      .clock(clock),
      .reset(reset),
      .take(piece_take),
      .drop(spoilt || (piece_ready && running)),
      .pair(piece_pair),
      .address(piece_address),
      .value(piece_value),
      .upper(piece_upper),
      .error(piece_error),
      .commit(piece_commit),
      .digested(digested),
      .digested_pair(digested_pair),
      .storage_commit(storage_commit),
      .storage_address(storage_address),
      .word(word),
      .code_write(code_write),
      .code_address(code_address),
      .template_write(template_write),
      .template_address(template_address)
  );
  axi_digest #(
      .CODE_BITS(CODE_BITS)
  ) digest_of_programs (
      .clock(clock),
      .reset(reset),
      .clear(clear_digest),
      .take(digested),
      .pair(digested_pair),
      .value(piece_value),
      .upper(piece_upper),
      .code_write(code_write),
      .code_address(code_address),
      .template_write(template_write),
      .template_address(template_address),
      .digest(digest)
  );
  assign host_word = word[FP-1:0];
  assign code_word = word[CODE_WIDTH-1:0];
  assign template_word = word[TEMPLATE_WIDTH-1:0];

  logic read_valid, read_ready, read_error;
  axi_burst_read #(
      .ID_BITS(ID_BITS),
      .REGION_BITS(REGION_BITS),
      .STORAGE_BYTES(STORAGE_BYTES),
      .STORAGE_END(STORAGE_END),
      .W(FP),
      .ADDRESS_BITS(ADDRESS_BITS)
  ) reads (
      .clock(clock),
      .reset(reset),
      .arvalid(arvalid),
      .arready(arready),
      .arid(arid),
      .araddr(araddr),
      .arlen(arlen),
      .arsize(arsize),
      .arburst(arburst),
      .rvalid(rvalid),
      .rready(rready),
      .rid(rid),
      .rdata(rdata),
      .rresp(rresp),
      .rlast(rlast),
      .read_valid(read_valid),
      .read_ready(read_ready),
      .read_error(read_error),
      .read_address(word_address),
      .host_value(host_value)
  );
  axi_memory_port #(
      .ADDRESS_BITS(ADDRESS_BITS)
  ) port (
      .clock(clock),
      .reset(reset),
      .open(open),
      .running(running),
      .quiet(quiet),
      .piece_valid(piece_valid),
      .piece_ready(piece_ready),
      .piece_take(piece_take),
      .piece_commit(piece_commit),
      .storage_commit(storage_commit),
      .storage_address(storage_address),
      .read_valid(read_valid),
      .read_ready(read_ready),
      .read_error(read_error),
      .read_address(word_address),
      .host_write(host_write),
      .host_read(host_read),
      .host_address(host_address)
  );
endmodule
