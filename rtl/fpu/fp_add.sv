// IEEE 754 sum or difference, rounded to nearest even: result = a + b, or a - b where `subtract`.
// Subnormals, signed zeros and infinities are exact to the standard; every NaN result is the canonical one: sign 0,
// exponent all ones, top fraction bit 1, the rest 0. One operation per cycle, LATENCY >= 7 cycles; without `enable`
// every register keeps its value.
module fp_add #(
    parameter int EXP     = 11,
    parameter int MAN     = 52,
    parameter int LATENCY = 7
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
  localparam logic [EXP-1:0] ONES = {EXP{1'b1}};

  // 1: compare magnitudes; a special result (NaN, infinity) travels as the larger significand with exponent ONES.
  logic b_negative, swap;
  logic [EXP-1:0] a_exp, b_exp, a_place, b_place;
  logic a_nan, b_nan;
  always_comb begin
    b_negative = b[EXP+MAN] ^ subtract;
    a_exp      = a[EXP+MAN-1:MAN];
    b_exp      = b[EXP+MAN-1:MAN];
    a_nan      = a_exp == ONES && a[MAN-1:0] != '0;
    b_nan      = b_exp == ONES && b[MAN-1:0] != '0;
    a_place    = a_exp | EXP'(a_exp == '0);
    b_place    = b_exp | EXP'(b_exp == '0);
    swap       = b[EXP+MAN-1:0] > a[EXP+MAN-1:0];
  end

  logic a_sign_1, b_sign_1, a_full_1, b_full_1, nan_1, swap_1;
  logic [EXP-1:0] a_place_1, b_place_1, a_above_1, b_above_1;
  logic [P-1:0] a_man_1, b_man_1;
  always_ff @(posedge clock) if (enable) begin
    a_sign_1  <= a[EXP+MAN];
    b_sign_1  <= b_negative;
    a_full_1  <= a_exp == ONES;
    b_full_1  <= b_exp == ONES;
    nan_1     <= a_nan || b_nan;
    swap_1    <= swap;
    a_place_1 <= a_place;
    b_place_1 <= b_place;
    a_above_1 <= a_place - b_place;
    b_above_1 <= b_place - a_place;
    a_man_1   <= {a_exp != '0, a[MAN-1:0]};
    b_man_1   <= {b_exp != '0, b[MAN-1:0]};
  end

  // 2: order by magnitude, and move the smaller operand down by the lowest bits of its distance: three bits below the
  // significand take what they move.
  localparam int STEP = 2;
  logic special, nan;
  logic [EXP-1:0] gap;
  logic [P-1:0] smaller;
  always_comb begin
    special = a_full_1 || b_full_1;
    // A NaN operand, or two infinities of unlike sign.
    nan     = nan_1 || (a_full_1 && b_full_1 && a_sign_1 != b_sign_1);
    gap     = swap_1 ? b_above_1 : a_above_1;
    smaller = special ? '0 : swap_1 ? a_man_1 : b_man_1;
  end
  logic sign_2, unlike_2, special_2, far_2;
  logic [EXP-1:0] exp_2;
  logic [P-1:0] large_2;
  logic [P+2:0] small_2;
  logic [ALIGN-1:STEP] steps_2;
  always_ff @(posedge clock) if (enable) begin
    special_2 <= special;
    unlike_2  <= a_sign_1 != b_sign_1 && !special;
    exp_2     <= swap_1 ? b_place_1 : a_place_1;
    small_2   <= {smaller, 3'b000} >> gap[STEP-1:0];
    steps_2   <= gap[ALIGN-1:STEP];
    far_2     <= (gap >> ALIGN) != '0;
    sign_2    <= !nan && (swap_1 ? b_sign_1 : a_sign_1);
    large_2   <= nan ? {2'b11, (P - 2)'(0)} : swap_1 ? b_man_1 : a_man_1;
  end

  // 3: align the smaller operand by whole steps.
  logic [P+2:0] aligned;
  logic lost;
  fp_shift_sticky #(
      .WIDTH(P + 3),
      .BITS (ALIGN)
  ) align (
      .value  (small_2),
      .amount ({steps_2, STEP'(0)}),
      .shifted(aligned),
      .lost   (lost)
  );
  logic sign_3, unlike_3, special_3;
  logic [EXP-1:0] exp_3;
  logic [P-1:0] large_3;
  logic [P+2:0] small_3;
  always_ff @(posedge clock) if (enable) begin
    sign_3    <= sign_2;
    unlike_3  <= unlike_2;
    special_3 <= special_2;
    exp_3     <= exp_2;
    large_3   <= large_2;
    small_3   <= far_2 ? (P + 3)'(small_2 != '0) : aligned | (P + 3)'(lost);
  end

  // 4: add. The larger is first, so a difference is never negative; an exact zero difference is +0.
  // The lowest bit of this sum carries a one into that of a difference.
  logic [S:0] sum;
  assign sum = {1'b0, large_3, 3'b000, 1'b1} + {{1'b0, small_3} ^ {S{unlike_3}}, unlike_3};
  logic sign_4, unlike_4, special_4;
  logic [EXP-1:0] exp_4;
  logic [S-1:0] sum_4, floor_4;  // floor: where the smallest exponent has its leading one
  always_ff @(posedge clock) if (enable) begin
    sign_4    <= sign_3;
    unlike_4  <= unlike_3;
    special_4 <= special_3;
    exp_4     <= exp_3;
    sum_4     <= sum[S:1];
    floor_4   <= {1'b1, (S - 1)'(0)} >> exp_3;
  end

  // 5: normalisation shift: to the leading one, but not below the smallest exponent.
  logic [LZ-1:0] zeros;
  fp_leading_zeros #(
      .WIDTH(S)
  ) leading (
      .value(sum_4 | floor_4),
      .count(zeros)
  );
  logic sign_5, special_5;
  logic [EXP-1:0] exp_5;
  logic [ LZ-1:0] up_5;
  logic [  S-1:0] sum_5;
  always_ff @(posedge clock) if (enable) begin
    sign_5    <= sign_4 && !(unlike_4 && sum_4 == '0);
    special_5 <= special_4;
    exp_5     <= exp_4;
    sum_5     <= sum_4;
    up_5      <= zeros;
  end

  // 6: normalise.
  logic sign_6, special_6;
  logic [EXP:0] exp_6;
  logic [S-1:0] sum_6;
  always_ff @(posedge clock) if (enable) begin
    sign_6    <= sign_5;
    special_6 <= special_5;
    exp_6     <= {1'b0, exp_5} + (EXP + 1)'(1) - (EXP + 1)'(up_5);
    sum_6     <= sum_5 << up_5;
  end

  // 7: round and pack.
  logic [EXP+MAN:0] result_7;
  fp_round #(
      .EXP (EXP),
      .MAN (MAN),
      .TAIL(4)
  ) round (
      .clock  (clock),
      .enable (enable),
      .sign   (sign_6),
      .special(special_6),
      .exp    (exp_6),
      .man    (sum_6),
      .result (result_7)
  );
  fp_delay #(
      .WIDTH (EXP + MAN + 1),
      .CYCLES(LATENCY - 7)
  ) extra (
      .clock(clock),
      .enable(enable),
      .in   (result_7),
      .out  (result)
  );
endmodule
