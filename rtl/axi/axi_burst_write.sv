// Write channels of the AXI4 slave of 64 bits, one burst at a time: beats become pieces of 32 bits, lower half first. The
// burst as a whole is checked before its first beat. A half without strobes is left out; one with some of them, or a piece
// that is not taken, ends the burst's effect: later beats change nothing, and the answer is SLVERR.
module axi_burst_write #(
    parameter int ID_BITS = 4,
    parameter int REGION_BITS = 24,
    parameter int STORAGE_BYTES = 17,
    parameter int CODE_BYTES = 23,
    parameter int TEMPLATE_BYTES = 8
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
    // Pieces; `piece_error` comes with `piece_ready`.
    output logic piece_valid,
    input logic piece_ready,
    input logic piece_error,
    output logic [REGION_BITS+1:0] piece_address,
    output logic [31:0] piece_value
);
  localparam logic [1:0] ADDRESS = 2'd0;
  localparam logic [1:0] CHECK = 2'd1;
  localparam logic [1:0] DATA = 2'd2;
  localparam logic [1:0] ANSWER = 2'd3;

  logic [1:0] state, halves, beat_halves, kind;  // halves of the beat that are still to be written
  logic [REGION_BITS+1:0] address;  // of the beat
  logic [7:0] len, strobes, more;  // beats after the one that is expected or held
  logic [2:0] size;
  logic [63:0] data;
  logic [3:0] half_strobes;
  logic refused, check_refused, step, upper, last_beat;

  axi_burst_check #(
      .REGION_BITS(REGION_BITS),
      .STORAGE_BYTES(STORAGE_BYTES),
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
  assign wready = state == DATA && halves == '0;
  assign bvalid = state == ANSWER;
  assign bresp = refused ? 2'b10 : 2'b00;
  assign beat_halves = size[0] ? 2'b11 : address[2] ? 2'b10 : 2'b01;

  assign upper = !halves[0];
  assign half_strobes = upper ? strobes[7:4] : strobes[3:0];
  assign piece_valid = halves != '0 && half_strobes == 4'b1111 && !refused;
  assign piece_address = {address[REGION_BITS+1:3], upper, 2'b00};
  assign piece_value = upper ? data[63:32] : data[31:0];
  assign step = halves != '0 && (!piece_valid || piece_ready);

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
          else if (step) halves <= upper ? 2'b00 : {halves[1], 1'b0};
          if (step && (upper || !halves[1]) && last_beat) state <= ANSWER;
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
      more <= len;
      last_beat <= 1'b0;
    end
    if (wready) begin
      data <= wdata;
      strobes <= wstrb;
      last_beat <= more == '0;
    end
    if (step) begin
      if (half_strobes != 4'b1111 && half_strobes != '0) refused <= 1'b1;
      if (piece_valid && piece_error) refused <= 1'b1;
      if (upper || !halves[1]) begin
        address <= address + (size[0] ? (REGION_BITS + 2)'(8) : (REGION_BITS + 2)'(4));
        more <= more - 8'd1;
      end
    end
  end
endmodule
