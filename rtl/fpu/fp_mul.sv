// IEEE 754 product, rounded to nearest even: result = a * b. Specials and NaN as in fp_add.
// One operation per cycle, LATENCY >= 8 cycles.
module fp_mul #(
    parameter int EXP     = 11,
    parameter int MAN     = 52,
    parameter int LATENCY = 8
) (
    input  logic               clock,
    input  logic               enable,
    input  logic [EXP+MAN : 0] a,
    input  logic [EXP+MAN : 0] b,
    output logic [EXP+MAN : 0] result
);
  localparam int P = MAN + 1;
  localparam int X = EXP + 2;  // signed exponents, with room for the sum of two
  localparam int LZ = $clog2(P + 1);
  localparam int DOWN = $clog2(P + 3);
  localparam int TAIL = 3;
  localparam logic [EXP-1:0] ONES = {EXP{1'b1}};
  localparam logic signed [X-1:0] INFINITE = X'((1 << EXP) - 1);
  localparam logic signed [X-1:0] BIAS = X'((1 << (EXP - 1)) - 1);

  // 1: unpack; a special result travels as its significand times one, with exponent ONES.
  logic nan, special;
  logic [EXP-1:0] a_exp, b_exp, a_place, b_place;
  always_comb begin
    a_exp   = a[EXP+MAN-1:MAN];
    b_exp   = b[EXP+MAN-1:MAN];
    a_place = a_exp | EXP'(a_exp == '0);
    b_place = b_exp | EXP'(b_exp == '0);
    special = a_exp == ONES || b_exp == ONES;
    // A NaN operand, or zero times infinity.
    nan     = (a_exp == ONES && a[MAN-1:0] != '0) || (b_exp == ONES && b[MAN-1:0] != '0) ||
              (special && (a[EXP+MAN-1:0] == '0 || b[EXP+MAN-1:0] == '0));
  end
  logic sign_1, special_1, tiny_1, b_tiny_1;
  logic signed [X-1:0] exp_1;
  logic [P-1:0] a_1, b_1;
  always_ff @(posedge clock) if (enable) begin
    special_1 <= special;
    b_tiny_1  <= b_exp == '0;
    tiny_1    <= (a_exp == '0 || b_exp == '0) && !special;
    b_1       <= special ? {1'b1, MAN'(0)} : {b_exp != '0, b[MAN-1:0]};
    a_1       <= special ? {1'b1, nan, (P - 2)'(0)} : {a_exp != '0, a[MAN-1:0]};
    exp_1     <= special ? INFINITE : X'(a_place) + X'(b_place) - BIAS;
    sign_1    <= !nan && (a[EXP+MAN] ^ b[EXP+MAN]);
  end

  // 2, 3, 4: multiply. Meanwhile the normalisation shift: up for the product of a subnormal, down for a product that
  // becomes subnormal. (Of two subnormals, only the sticky bit remains for any shift.)
  logic [2*P-1:0] product_4;
  fp_product #(
      .P(P)
  ) multiply (
      .clock  (clock),
      .enable (enable),
      .a      (a_1),
      .b      (b_1),
      .product(product_4)
  );
  logic [LZ-1:0] zeros;
  fp_leading_zeros #(
      .WIDTH(P)
  ) leading (
      .value(b_tiny_1 ? b_1 : a_1),
      .count(zeros)
  );
  logic sign_2, special_2;
  logic signed [X-1:0] exp_2;
  logic [LZ-1:0] zeros_2;
  always_ff @(posedge clock) if (enable) begin
    sign_2    <= sign_1;
    special_2 <= special_1;
    exp_2     <= exp_1;
    zeros_2   <= tiny_1 ? zeros : '0;
  end

  logic sign_3, special_3;
  logic signed [X-1:0] normal_3;  // the exponent once the leading one is in place
  logic [LZ-1:0] zeros_3, up_most_3;
  logic [DOWN-1:0] down_3;
  always_ff @(posedge clock) if (enable) begin
    sign_3    <= sign_2;
    special_3 <= special_2;
    zeros_3   <= zeros_2;
    normal_3  <= exp_2 - X'(zeros_2);
    up_most_3 <= (exp_2 >= 1) ? LZ'(exp_2 - X'(1)) : '0;
    down_3    <= (exp_2 >= 1) ? '0 : (exp_2 < -X'(P + 1)) ? DOWN'(P + 2) : DOWN'(X'(1) - exp_2);
  end

  logic sign_4, special_4, over_4;
  logic [EXP-1:0] exp_4;
  logic [LZ-1:0] up_4;
  logic [DOWN-1:0] down_4;
  always_ff @(posedge clock) if (enable) begin
    sign_4    <= sign_3;
    special_4 <= special_3;
    over_4    <= normal_3 > INFINITE;
    exp_4     <= (normal_3 >= 1) ? normal_3[EXP-1:0] : EXP'(1);
    up_4      <= (normal_3 >= 1) ? zeros_3 : up_most_3;
    down_4    <= down_3;
  end

  // 5: move up.
  logic sign_5, special_5, over_5;
  logic [EXP-1:0] exp_5;
  logic [DOWN-1:0] down_5;
  logic [2*P-1:0] product_5;
  always_ff @(posedge clock) if (enable) begin
    sign_5    <= sign_4;
    special_5 <= special_4;
    over_5    <= over_4;
    exp_5     <= exp_4;
    down_5    <= down_4;
    product_5 <= product_4 << up_4;
  end

  // 6: move down by whole steps. The product of two significands is in [1, 4): one of 2 and more moves down by one place,
  // unless it moves down anyway.
  localparam int STEP = 3;  // bits of a distance within a step
  logic above_5, lost_5;
  logic [P+TAIL:0] stepped;
  assign above_5 = product_5[2*P-1] && down_5 == '0;
  fp_shift_sticky #(
      .WIDTH(P + TAIL + 1),
      .BITS (DOWN)
  ) step_down (
      .value  (product_5[2*P-1:P-TAIL-1]),
      .amount ({down_5[DOWN-1:STEP], STEP'(0)}),
      .shifted(stepped),
      .lost   (lost_5)
  );
  logic sign_6, special_6, over_6, above_6, rest_6;
  logic [EXP-1:0] exp_6;
  logic [STEP-1:0] down_6;
  logic [P+TAIL:0] man_6;
  always_ff @(posedge clock) if (enable) begin
    sign_6    <= sign_5;
    special_6 <= special_5;
    over_6    <= over_5;
    exp_6     <= exp_5;
    above_6   <= above_5;
    down_6    <= down_5[STEP-1:0] | STEP'(above_5);
    man_6     <= stepped;
    rest_6    <= lost_5 || product_5[P-TAIL-2:0] != '0;
  end

  // 7: move down by the rest; the lowest bit is sticky. The highest is zero now.
  logic lost_6;
  logic [P+TAIL:0] lowered;
  fp_shift_sticky #(
      .WIDTH(P + TAIL + 1),
      .BITS (STEP)
  ) lower (
      .value  (man_6),
      .amount (down_6),
      .shifted(lowered),
      .lost   (lost_6)
  );
  logic sign_7, special_7;
  logic [EXP:0] exp_7;
  logic [P+TAIL-1:0] man_7;
  always_ff @(posedge clock) if (enable) begin
    sign_7    <= sign_6;
    special_7 <= special_6;
    exp_7     <= over_6 ? {1'b0, ONES} : {1'b0, exp_6} + (EXP + 1)'(above_6);
    man_7     <= lowered[P+TAIL-1:0] | (P + TAIL)'(lost_6 || rest_6);
  end

  // 8: round and pack.
  logic [EXP+MAN:0] result_8;
  fp_round #(
      .EXP (EXP),
      .MAN (MAN),
      .TAIL(TAIL)
  ) round (
      .clock  (clock),
      .enable (enable),
      .sign   (sign_7),
      .special(special_7),
      .exp    (exp_7),
      .man    (man_7),
      .result (result_8)
  );
  fp_delay #(
      .WIDTH (EXP + MAN + 1),
      .CYCLES(LATENCY - 8)
  ) extra (
      .clock(clock),
      .enable(enable),
      .in   (result_8),
      .out  (result)
  );
endmodule
