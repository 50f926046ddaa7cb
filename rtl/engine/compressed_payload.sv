// The payload of an item of compressed microcode to a flat word, in five cycles: the lines that it lies in, its bits, those
// of each lane and of the dividers, each field, its address.
module compressed_payload #(
    parameter int LANES = 4,
    parameter int DIVIDERS = 1,
    parameter int ADDRESS_BITS = 14,
    parameter int FETCH = 128,
    parameter int SHORT = contract::SHORT_BITS,
    parameter int TEMPLATE_WIDTH = contract::TEMPLATE_WIDTH,
    parameter int PAYLOAD = LANES * 4 * ADDRESS_BITS + DIVIDERS * 3 * ADDRESS_BITS,
    parameter int FILL = $clog2(PAYLOAD + 1),
    parameter int AT = $clog2(FETCH) + 2,
    parameter int WIDTH = 1 + LANES * (4 * ADDRESS_BITS + 4) + DIVIDERS * (3 * ADDRESS_BITS + 2)
) (
    input logic clock,
    input logic reset,
    input logic start,
    input logic valid,
    input logic last,
    input logic [FETCH*4-1:0] buffer,
    input logic [AT-1:0] place,
    input logic [LANES*TEMPLATE_WIDTH-1:0] used,
    input logic [(LANES+1)*FILL-1:0] first,
    input logic [2*DIVIDERS-1:0] divider_op,
    output logic [WIDTH-1:0] word
);
  `include "engine/operations.svh"

  localparam int A = ADDRESS_BITS;
  localparam int LANE = 4 * A + 4;
  localparam int DIVIDER = 3 * A + 2;
  localparam int BIT = $clog2(FETCH);
  localparam logic [1:0] SAME = 2'd0;

  logic [5:2] valids, lasts;
  logic valid_5, last_5;
  always_ff @(posedge clock) begin
    valids <= reset ? '0 : {valids[4:2], valid};
    lasts  <= {lasts[4:2], last};
  end
  assign valid_5 = valids[5];
  assign last_5  = lasts[5];
  logic [LANES*TEMPLATE_WIDTH-1:0] used_2, used_3, used_4, used_5;
  logic [2*DIVIDERS-1:0] divider_op_2, divider_op_3, divider_op_4;
  logic [(LANES+1)*FILL-1:0] first_2, first_3;
  always_ff @(posedge clock) begin
    {used_2, used_3, used_4, used_5} <= {used, used_2, used_3, used_4};
    {divider_op_2, divider_op_3, divider_op_4} <= {divider_op, divider_op_2, divider_op_3};
    {first_2, first_3} <= {first, first_2};
  end

  // 1: the lines in which it lies.
  logic [PAYLOAD+FETCH-2:0] lines, lines_2;
  logic [BIT-1:0] place_2;
  window #(
      .WIDTH(PAYLOAD + FETCH - 1),
      .BITS (2),
      .STEP (FETCH),
      .ROW  (PAYLOAD + 4 * FETCH - 1)
  ) its_lines (
      .row ((PAYLOAD + 4 * FETCH - 1)'({buffer, buffer})),
      .from(place[BIT+:2]),
      .view(lines)
  );
  always_ff @(posedge clock) begin
    lines_2 <= lines;
    place_2 <= place[BIT-1:0];
  end

  // 2: its bits.
  logic [PAYLOAD-1:0] bits, payload_3;
  window #(
      .WIDTH(PAYLOAD),
      .BITS (BIT)
  ) its_bits (
      .row (lines_2),
      .from(place_2),
      .view(bits)
  );
  always_ff @(posedge clock) payload_3 <= bits;

  // 3: a shift for each lane, and one for the dividers.
  logic [LANES*4*A-1:0] lane_4;
  logic [3*A*DIVIDERS-1:0] divider_4;
  always_ff @(posedge clock) begin
    for (int l = 0; l < LANES; l++) lane_4[4*A*l+:4*A] <= (4 * A)'(payload_3 >> first_3[FILL*l+:FILL]);
    divider_4 <= (3 * A * DIVIDERS)'(payload_3 >> first_3[FILL*LANES+:FILL]);
  end

  // 4: a choice for each field.
  logic [WIDTH-1:0] divided_4, divided_5;
  logic [LANES*4*A-1:0] field_4, field_5;
  logic [4*A-1:0] lane_left;
  logic [3*A*DIVIDERS-1:0] divider_left;
  always_comb begin
    field_4 = '0;
    lane_left = '0;
    for (int l = 0; l < LANES; l++) begin
      lane_left = lane_4[4*A*l+:4*A];
      for (int f = 0; f < 4; f++) begin
        field_4[(4*l+f)*A+:A] = lane_left[A-1:0];
        if (used_4[TEMPLATE_WIDTH*l+4+2*f+:2] == 2'd2) lane_left = lane_left >> SHORT;
        if (used_4[TEMPLATE_WIDTH*l+4+2*f+:2] == 2'd3) lane_left = lane_left >> A;
      end
    end
    divided_4 = '0;
    divider_left = divider_4;
    for (int d = 0; d < DIVIDERS; d++) begin
      if (divider_op_4[2*d+:2] != DIVIDER_NOP) begin
        divided_4[1+LANES*LANE+d*DIVIDER+:A] = divider_left[A-1:0];
        divider_left = divider_left >> A;
        if (divider_op_4[2*d+:2] == DIVIDER_DIV) begin
          divided_4[1+LANES*LANE+d*DIVIDER+A+:A] = divider_left[A-1:0];
          divider_left = divider_left >> A;
        end
        divided_4[1+LANES*LANE+d*DIVIDER+2*A+:A] = divider_left[A-1:0];
        divider_left = divider_left >> A;
        divided_4[1+LANES*LANE+d*DIVIDER+3*A+:2] = divider_op_4[2*d+:2];
      end
    end
  end

  always_ff @(posedge clock) begin
    divided_5 <= divided_4;
    field_5   <= field_4;
  end

  // 5: addresses, from those kept.
  logic [LANES*4*A-1:0] kept, kept_next, step, step_next;  // last address and step of each field a, b, c, destination
  logic [WIDTH-1:0] made;
  logic [3:0] op;
  logic [1:0] mode;
  logic [A-1:0] at;
  always_comb begin
    kept_next = kept;
    step_next = step;
    made = divided_5;
    made[0] = last_5;
    op = OP_NOP;
    mode = SAME;
    at = '0;
    for (int l = 0; l < LANES; l++) begin
      op = used_5[TEMPLATE_WIDTH*l+:4];
      for (int f = 0; f < 4; f++) begin
        mode = used_5[TEMPLATE_WIDTH*l+4+2*f+:2];
        at   = kept[(4*l+f)*A+:A];
        case (mode)
          2'd0: if (f == 3) at = kept_next[(4*l+2)*A+:A];
          2'd1: at = at + step[(4*l+f)*A+:A];
          2'd2: begin
            step_next[(4*l+f)*A+:A] = {{(A - SHORT) {field_5[(4*l+f)*A+SHORT-1]}}, field_5[(4*l+f)*A+:SHORT]};
            at = at + step_next[(4*l+f)*A+:A];
          end
          default: at = field_5[(4*l+f)*A+:A];
        endcase
        if (op != OP_NOP) begin
          kept_next[(4*l+f)*A+:A] = at;
          if ((f != 1 || reads_b(op)) && (f != 2 || reads_c(op))) made[1+l*LANE+f*A+:A] = at;
        end
      end
      made[1+l*LANE+4*A+:4] = op;
    end
  end

  always_ff @(posedge clock) begin
    if (start) begin
      kept <= '0;
      step <= '0;
    end else if (valid_5) begin
      kept <= kept_next;
      step <= step_next;
    end
    word <= valid_5 ? made : '0;
  end
endmodule
