// Write channels of the AXI4 slave of 64 bits, one burst at a time: beats become pieces of 32 bits, lower half first. Both
// halves of a beat go together where they belong to one word, so that a beat takes a clock. The burst as a whole is checked
// before its first beat. A half without strobes is left out; one with some of them, or a piece that is not taken, ends the
// burst's effect: later beats change nothing, and the answer is SLVERR.
module axi_burst_write #(
    parameter int ID_BITS = 4,
    parameter int REGION_BITS = 24,
    parameter int STORAGE_BYTES = 17,
    parameter int STORAGE_END = 1 << STORAGE_BYTES,
    parameter int CODE_BYTES = 23,
    parameter int TEMPLATE_BYTES = 8,
    parameter logic [1:0] WIDE = 2'b11  // words of storage, lines of microcode: whether an aligned pair of pieces is in one
) (
    input logic clock,
    input logic reset,
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
    output logic bvalid,
    input logic bready,
    output logic [ID_BITS-1:0] bid,
    output logic [1:0] bresp,
    // Pieces, one or two at a time; `piece_error` comes with `piece_ready`.
    output logic piece_valid,
    output logic piece_pair,  // with the next one
    input logic piece_ready,
    input logic piece_error,
    output logic [REGION_BITS+1:0] piece_address,
    output logic [31:0] piece_value,
    output logic [31:0] piece_upper,
    output logic spoilt  // a half with some of its strobes
);
  localparam logic [1:0] ADDRESS = 2'd0;
  localparam logic [1:0] CHECK = 2'd1;
  localparam logic [1:0] DATA = 2'd2;
  localparam logic [1:0] ANSWER = 2'd3;

  logic [1:0] state, halves, beat_halves, kind;  // halves of the beat that are still to be written
  logic [REGION_BITS+1:0] address, address_after;  // of the beat, and of the next
  logic [7:0] len, strobes, more;  // beats after the one that is expected
  logic [2:0] size;
  logic [63:0] data;
  logic [3:0] half_strobes;
  logic refused, check_refused, step, ends, upper, last_beat, wide, upper_only;

  axi_burst_check #(
      .REGION_BITS(REGION_BITS),
      .STORAGE_BYTES(STORAGE_BYTES),
      .STORAGE_END(STORAGE_END),
      .CODE_BYTES(CODE_BYTES),
      .TEMPLATE_BYTES(TEMPLATE_BYTES)
  ) check (
      .address(address),
      .len(len),
      .size(size),
      .burst(kind),
      .refused(check_refused)
  );

  assign awready = state == ADDRESS;
  assign wready = state == DATA && (halves == '0 || (ends && !last_beat));
  assign bvalid = state == ANSWER;
  assign bresp = refused ? 2'b10 : 2'b00;
  assign address_after = address + (size[0] ? (REGION_BITS + 2)'(8) : (REGION_BITS + 2)'(4));
  assign upper_only = ends ? address_after[2] : address[2];
  assign beat_halves = size[0] ? 2'b11 : upper_only ? 2'b10 : 2'b01;

  assign upper = !halves[0];
  assign half_strobes = upper ? strobes[7:4] : strobes[3:0];
  assign piece_valid = halves != '0 && half_strobes == 4'b1111 && !refused;
  assign piece_pair = wide && halves == 2'b11 && strobes == '1;
  assign piece_address = {address[REGION_BITS+1:3], upper, 2'b00};
  assign piece_value = upper ? data[63:32] : data[31:0];
  assign piece_upper = data[63:32];
  assign step = halves != '0 && (!piece_valid || piece_ready);
  assign spoilt = step && !refused && half_strobes != 4'b1111 && half_strobes != '0;
  assign ends = step && (upper || !halves[1] || piece_pair);

  always_ff @(posedge clock) begin
    if (reset) begin
      state  <= ADDRESS;
      halves <= '0;
    end else begin
      case (state)
        ADDRESS: if (awvalid) state <= CHECK;
        CHECK: state <= DATA;
        DATA: begin
          if (wready && wvalid) halves <= beat_halves;
          else if (step) halves <= ends ? 2'b00 : 2'b10;
          if (ends && last_beat) state <= ANSWER;
        end
        default: if (bready) state <= ADDRESS;
      endcase
    end
    if (awready) begin
      bid <= awid;
      address <= awaddr;
      len <= awlen;
      size <= awsize;
      kind <= awburst;
    end
    if (state == CHECK) begin
      refused <= check_refused;
      wide <= !address[REGION_BITS+1] && WIDE[address[REGION_BITS]];
      more <= len;
      last_beat <= 1'b0;
    end
    if (wready) begin
      data <= wdata;
      strobes <= wstrb;
      last_beat <= more == '0;
      if (wvalid) more <= more - 8'd1;
    end
    if (spoilt || (step && piece_valid && piece_error)) refused <= 1'b1;
    if (ends) address <= address_after;
  end
endmodule
