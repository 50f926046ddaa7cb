// IEEE 754 sum or difference, rounded to nearest even: result = a + b, or a - b where `subtract`.
// Subnormals, signed zeros and infinities are exact to the standard; every NaN result is the canonical one: sign 0,
// exponent all ones, top fraction bit 1, the rest 0. One operation per cycle, LATENCY >= 6 cycles; without `enable`
// every register keeps its value.
module fp_add #(
    parameter int EXP     = 11,
    parameter int MAN     = 52,
    parameter int LATENCY = 6
) (
    input  logic               clock,
    input  logic               enable,
    input  logic               subtract,
    input  logic [EXP+MAN : 0] a,
    input  logic [EXP+MAN : 0] b,
    output logic [EXP+MAN : 0] result
);
  localparam int P = MAN + 1;  // significand with its leading bit
  localparam int S = P + 4;  // sum: carry, significand, guard, round, sticky
  localparam int ALIGN = $clog2(P + 4);
  localparam int LZ = $clog2(S + 1);
  localparam logic [EXP-1:0] ONES = '1;

  // 1: order by magnitude; a special result (NaN, infinity) travels as the larger significand with exponent ONES.
  logic a_sign, b_sign, nan, swap, special;
  logic [EXP-1:0] a_exp, b_exp, a_place, b_place, gap;
  logic [P-1:0] a_man, b_man;
  always_comb begin
    a_sign  = a[EXP+MAN];
    b_sign  = b[EXP+MAN] ^ subtract;
    a_exp   = a[EXP+MAN-1:MAN];
    b_exp   = b[EXP+MAN-1:MAN];
    special = a_exp == ONES || b_exp == ONES;
    // A NaN operand, or two infinities of unlike sign.
    nan     = (a_exp == ONES && a[MAN-1:0] != '0) || (b_exp == ONES && b[MAN-1:0] != '0) ||
              (a_exp == ONES && b_exp == ONES && a_sign != b_sign);
    a_place = a_exp | EXP'(a_exp == '0);
    b_place = b_exp | EXP'(b_exp == '0);
    a_man   = {a_exp != '0, a[MAN-1:0]};
    b_man   = {b_exp != '0, b[MAN-1:0]};
    swap    = b[EXP+MAN-1:0] > a[EXP+MAN-1:0];
    gap     = swap ? b_place - a_place : a_place - b_place;
  end

  logic sign_1, unlike_1, special_1, far_1;
  logic [EXP-1:0] exp_1;
  logic [P-1:0] large_1, small_1;
  logic [ALIGN-1:0] align_1;
  always_ff @(posedge clock) if (enable) begin
    special_1 <= special;
    unlike_1  <= a_sign != b_sign && !special;
    exp_1     <= swap ? b_place : a_place;
    small_1   <= special ? '0 : swap ? a_man : b_man;
    align_1   <= ALIGN'(gap);
    far_1     <= (gap >> ALIGN) != '0;
    sign_1    <= !nan && (swap ? b_sign : a_sign);
    large_1   <= nan ? {2'b11, (P - 2)'(0)} : swap ? b_man : a_man;
  end

  // 2: align the smaller operand.
  logic [P+2:0] aligned;
  logic lost;
  fp_shift_sticky #(
      .WIDTH(P + 3),
      .BITS (ALIGN)
  ) align (
      .value  ({small_1, 3'b000}),
      .amount (align_1),
      .shifted(aligned),
      .lost   (lost)
  );
  logic sign_2, unlike_2, special_2;
  logic [EXP-1:0] exp_2;
  logic [P-1:0] large_2;
  logic [P+2:0] small_2;
  always_ff @(posedge clock) if (enable) begin
    sign_2    <= sign_1;
    unlike_2  <= unlike_1;
    special_2 <= special_1;
    exp_2     <= exp_1;
    large_2   <= large_1;
    small_2   <= far_1 ? (P + 3)'(small_1 != '0) : aligned | (P + 3)'(lost);
  end

  // 3: add. The larger is first, so a difference is never negative; an exact zero difference is +0.
  // The lowest bit of this sum carries a one into that of a difference.
  logic [S:0] sum;
  assign sum = {1'b0, large_2, 3'b000, 1'b1} + {{1'b0, small_2} ^ {S{unlike_2}}, unlike_2};
  logic sign_3, unlike_3, special_3;
  logic [EXP-1:0] exp_3;
  logic [S-1:0] sum_3, floor_3;  // floor: where the smallest exponent has its leading one
  always_ff @(posedge clock) if (enable) begin
    sign_3    <= sign_2;
    unlike_3  <= unlike_2;
    special_3 <= special_2;
    exp_3     <= exp_2;
    sum_3     <= sum[S:1];
    floor_3   <= {1'b1, (S - 1)'(0)} >> exp_2;
  end

  // 4: normalisation shift: to the leading one, but not below the smallest exponent.
  logic [LZ-1:0] zeros;
  fp_leading_zeros #(
      .WIDTH(S)
  ) leading (
      .value(sum_3 | floor_3),
      .count(zeros)
  );
  logic sign_4, special_4;
  logic [EXP-1:0] exp_4;
  logic [ LZ-1:0] up_4;
  logic [  S-1:0] sum_4;
  always_ff @(posedge clock) if (enable) begin
    sign_4    <= sign_3 && !(unlike_3 && sum_3 == '0);
    special_4 <= special_3;
    exp_4     <= exp_3;
    sum_4     <= sum_3;
    up_4      <= zeros;
  end

  // 5: normalise.
  logic sign_5, special_5;
  logic [EXP:0] exp_5;
  logic [S-1:0] sum_5;
  always_ff @(posedge clock) if (enable) begin
    sign_5    <= sign_4;
    special_5 <= special_4;
    exp_5     <= {1'b0, exp_4} + (EXP + 1)'(1) - (EXP + 1)'(up_4);
    sum_5     <= sum_4 << up_4;
  end

  // 6: round and pack.
  logic [EXP+MAN:0] result_6;
  fp_round #(
      .EXP (EXP),
      .MAN (MAN),
      .TAIL(4)
  ) round (
      .clock  (clock),
      .enable (enable),
      .sign   (sign_5),
      .special(special_5),
      .exp    (exp_5),
      .man    (sum_5),
      .result (result_6)
  );
  fp_delay #(
      .WIDTH (EXP + MAN + 1),
      .CYCLES(LATENCY - 6)
  ) extra (
      .clock(clock),
      .enable(enable),
      .in   (result_6),
      .out  (result)
  );
endmodule
