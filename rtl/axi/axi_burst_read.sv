// Read channels of the AXI4 slave of 64 bits, one burst at a time: up to eight beats of storage under way, so that a burst
// goes on while the master takes its beats. Storage of 64 bits: the whole word in each beat, of which a beat of 4 bytes
// takes a half. Storage of 32 bits: two words a beat of 8 bytes. Microcode and templates cannot be read: SLVERR.
module axi_burst_read #(
    parameter int ID_BITS = 4,
    parameter int REGION_BITS = 24,
    parameter int STORAGE_BYTES = 17,
    parameter int STORAGE_END = 1 << STORAGE_BYTES,
    parameter int W = 64,
    parameter int ADDRESS_BITS = 14,
    parameter int LATENCY = contract::READ_CYCLES + 2
) (
    input logic clock,
    input logic reset,
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
    // Words of storage; `read_error` comes with `read_ready`.
    output logic read_valid,
    input logic read_ready,
    input logic read_error,
    output logic [ADDRESS_BITS-1:0] read_address,
    input logic [W-1:0] host_value  // LATENCY cycles after the read was taken
);
  localparam int DEPTH_BITS = 3;
  localparam int WORD_SHIFT = $clog2(W / 8);
  localparam logic [1:0] ADDRESS = 2'd0;
  localparam logic [1:0] CHECK = 2'd1;
  localparam logic [1:0] READ = 2'd2;
  localparam logic [1:0] DRAIN = 2'd3;

  logic [1:0] state, kind;
  logic [REGION_BITS+1:0] address;
  logic [7:0] len, more;
  logic [2:0] size;
  logic refused, check_refused, failed, credit, step, completes, final_step, half, wide;
  logic [DEPTH_BITS:0] under_way;  // beats that were asked for and not yet taken

  axi_burst_check #(
      .REGION_BITS(REGION_BITS),
      .STORAGE_BYTES(STORAGE_BYTES),
      .STORAGE_END(STORAGE_END),
      .CODE_BYTES(0),
      .TEMPLATE_BYTES(0)
  ) check (
      .address(address),
      .len(len),
      .size(size),
      .burst(kind),
      .refused(check_refused)
  );

  // One word a step; two steps a beat where a beat has two words.
  assign arready = state == ADDRESS;
  assign credit = !under_way[DEPTH_BITS];
  assign read_valid = state == READ && credit && !refused;
  assign read_address = ADDRESS_BITS'(address[REGION_BITS-1:0] >> WORD_SHIFT);
  assign step = (read_valid && read_ready) || (state == READ && credit && refused);
  assign failed = refused || read_error;
  assign wide = W == 32 && size[0];
  assign completes = !wide || half;
  assign final_step = step && completes && more == '0;

  always_ff @(posedge clock) begin
    if (reset) begin
      state <= ADDRESS;
      under_way <= '0;
    end else begin
      case (state)
        ADDRESS: if (arvalid) state <= CHECK;
        CHECK: state <= READ;
        READ: if (final_step) state <= DRAIN;
        default: if (under_way == '0) state <= ADDRESS;
      endcase
      under_way <= under_way + (DEPTH_BITS + 1)'(step && completes) - (DEPTH_BITS + 1)'(rvalid && rready);
    end
    if (arready) begin
      rid <= arid;
      address <= araddr;
      len <= arlen;
      size <= arsize;
      kind <= arburst;
    end
    if (state == CHECK) begin
      refused <= check_refused || address[REGION_BITS+:2] != 2'd0;
      more <= len;
      half <= 1'b0;
    end
    if (step) begin
      refused <= failed;
      half <= wide && !half;
      address <= address + ((W == 64 && size[0]) ? (REGION_BITS + 2)'(8) : (REGION_BITS + 2)'(4));
      if (completes) more <= more - 8'd1;
    end
  end

  // What each step asked for, as long as its word is under way; then its beat, until the master takes it.
  logic [LATENCY-1:0] arriving, complete, wrong, ending;
  logic [64+1:0] beats[0:(1<<DEPTH_BITS)-1];
  logic [DEPTH_BITS:0] written, taken;
  logic [W-1:0] first;
  logic [63:0] arrived;
  logic push;
  generate
    if (W == 64) begin : g_whole
      assign arrived = host_value;
    end else begin : g_halves
      assign arrived = {host_value, wide ? first : host_value};
    end
  endgenerate
  assign push = arriving[LATENCY-1] && complete[LATENCY-1];
  assign rvalid = written != taken;
  assign {rlast, rresp[1], rdata} = beats[taken[DEPTH_BITS-1:0]];
  assign rresp[0] = 1'b0;
  always_ff @(posedge clock) begin
    if (reset) begin
      arriving <= '0;
      written <= '0;
      taken <= '0;
    end else begin
      arriving <= {arriving[LATENCY-2:0], step};
      if (push) written <= written + (DEPTH_BITS + 1)'(1);
      if (rvalid && rready) taken <= taken + (DEPTH_BITS + 1)'(1);
    end
    complete <= {complete[LATENCY-2:0], completes};
    wrong <= {wrong[LATENCY-2:0], failed};
    ending <= {ending[LATENCY-2:0], final_step};
    if (arriving[LATENCY-1]) first <= host_value;
    if (push) beats[written[DEPTH_BITS-1:0]] <= {ending[LATENCY-1], wrong[LATENCY-1], wrong[LATENCY-1] ? 64'd0 : arrived};
  end
endmodule
