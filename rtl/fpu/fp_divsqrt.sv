// IEEE 754 quotient a / b, or square root of a where `root`, rounded to nearest even. Specials and NaN as in fp_add.
// Not pipelined: `start` takes the operands, the result is valid CYCLES cycles later for one cycle, and the next
// `start` may come CYCLES cycles after the last. Without `enable` every register keeps its value.
// Two result digits per cycle by restoring subtraction:
// CYCLES >= 2 (unpack) + ceil((MAN + 3) / 2) (digits) + 2 (round).
module fp_divsqrt #(
    parameter int EXP    = 11,
    parameter int MAN    = 52,
    parameter int CYCLES = 32
) (
    input  logic               clock,
    input  logic               enable,
    input  logic               reset,
    input  logic               start,
    input  logic               root,
    input  logic [EXP+MAN : 0] a,
    input  logic [EXP+MAN : 0] b,
    output logic [EXP+MAN : 0] result
);
  localparam int P = MAN + 1;
  localparam int STEPS = (MAN + 4) / 2;
  localparam int N = 2 * STEPS;  // digits: P, guard, one to normalise, and padding
  localparam int X = EXP + 2;
  localparam int LZ = $clog2(P + 1);
  localparam int DOWN = $clog2(P + 3);
  localparam logic [EXP-1:0] ONES = '1;
  localparam logic signed [X-1:0] INFINITE = X'((1 << EXP) - 1);
  localparam logic signed [X-1:0] BIAS = X'((1 << (EXP - 1)) - 1);

  // One-hot shift register: the cycle of the operation in flight.
  logic [STEPS+1:0] token;
  always_ff @(posedge clock) begin
    if (reset) token <= '0;
    else if (enable) token <= {token[STEPS:0], start};
  end

  // 1: take the operands.
  logic root_1;
  logic [EXP+MAN:0] a_1, b_1;
  always_ff @(posedge clock) begin
    if (enable && start) begin
      root_1 <= root;
      a_1    <= a;
      b_1    <= b;
    end
  end

  // 2: unpack, move the leading ones up, find special results.
  logic nan, a_inf, b_inf, a_zero, b_zero, infinite, zero;
  logic [EXP-1:0] a_exp, b_exp;
  logic [P-1:0] a_raw, b_raw, a_man, b_man;
  logic [LZ-1:0] a_zeros, b_zeros;
  logic [EXP-1:0] a_field, b_field;
  logic signed [X-1:0] a_place, b_place, a_power;
  assign a_exp = a_1[EXP+MAN-1:MAN];
  assign b_exp = b_1[EXP+MAN-1:MAN];
  assign a_raw = {a_exp != '0, a_1[MAN-1:0]};
  assign b_raw = {b_exp != '0, b_1[MAN-1:0]};
  fp_leading_zeros #(
      .WIDTH(P)
  ) a_leading (
      .value(a_raw),
      .count(a_zeros)
  );
  fp_leading_zeros #(
      .WIDTH(P)
  ) b_leading (
      .value(b_raw),
      .count(b_zeros)
  );
  always_comb begin
    a_inf    = a_exp == ONES && a_1[MAN-1:0] == '0;
    b_inf    = b_exp == ONES && b_1[MAN-1:0] == '0;
    a_zero   = a_1[EXP+MAN-1:0] == '0;
    b_zero   = b_1[EXP+MAN-1:0] == '0;
    // A NaN operand, a root of a negative number, infinity by infinity, zero by zero.
    nan      = (a_exp == ONES && !a_inf) ||
               (root_1 ? a_1[EXP+MAN] && !a_zero : (b_exp == ONES && !b_inf) || (a_inf && b_inf) || (a_zero && b_zero));
    infinite = root_1 ? a_inf : a_inf || b_zero;
    zero     = root_1 ? a_zero : a_zero || b_inf;
    a_field  = a_exp | EXP'(a_exp == '0);
    b_field  = b_exp | EXP'(b_exp == '0);
    a_place  = X'(a_field) - X'(a_zeros);
    b_place  = X'(b_field) - X'(b_zeros);
    a_man    = a_raw << a_zeros;
    b_man    = b_raw << b_zeros;
    a_power  = a_place - BIAS;
  end
  logic sign_2, special_2, root_2;
  logic signed [X-1:0] exp_2;  // of the digit before the point
  logic [1:0] fixed_2;  // special result: not zero, NaN
  logic [P-1:0] divisor_2;
  always_ff @(posedge clock) begin
    if (enable && token[0]) begin
      root_2    <= root_1;
      divisor_2 <= b_man;
      exp_2     <= root_1 ? (a_power >>> 1) + BIAS : a_place - b_place + BIAS;
      special_2 <= nan || infinite || zero;
      fixed_2   <= {nan || infinite, nan};
      sign_2    <= !nan && (a_1[EXP+MAN] ^ (b_1[EXP+MAN] && !root_1));
    end
  end

  // 3 ... : digits q_1 q_2 ... of (a/2)/b or of sqrt(a/4), both below one. With the remainder w scaled by 2^j,
  //   division: try 2w - b;   root: try 2w - (2 Q + 2^-j), where Q are the digits so far and j is the next digit.
  // Fixed point with N fraction bits and three integer bits.
  logic [N+2:0] rest, rest_a, rest_c, rest_next;
  logic [N+1:0] rest_b;  // below the divisor or twice the root, so its top bit would be zero
  logic [N-1:0] digits, digits_a, digits_b, place, place_half;
  logic [N+2:0] take_a, take_b, dividend;
  logic digit_a, digit_b;
  always_comb begin
    // a/2 or, as exponents of roots must be even, a/4 or 2a/4; a_man has its point after the leading one.
    dividend = (N + 3)'(a_man) << (N - MAN - 2);
    if (!root_1 || a_power[0]) dividend = dividend << 1;
  end
  always_comb begin
    place_half = place >> 1;
    take_a     = root_2 ? {2'b00, digits, 1'b0} | {3'b000, place} : {2'b00, divisor_2, {(N - MAN) {1'b0}}};
    rest_a     = {rest[N+1:0], 1'b0};
    digit_a    = rest_a >= take_a;
    rest_b     = (N + 2)'(digit_a ? rest_a - take_a : rest_a);
    digits_a   = digit_a ? digits | place : digits;
    take_b     = root_2 ? {2'b00, digits_a, 1'b0} | {3'b000, place_half} : {2'b00, divisor_2, {(N - MAN) {1'b0}}};
    rest_c     = {rest_b, 1'b0};
    digit_b    = rest_c >= take_b;
    rest_next  = digit_b ? rest_c - take_b : rest_c;
    digits_b   = digit_b ? digits_a | place_half : digits_a;
  end
  always_ff @(posedge clock) begin
    if (enable && token[0]) begin
      rest   <= dividend;
      digits <= '0;
      place  <= {1'b1, (N - 1)'(0)};
    end else if (enable) begin
      rest   <= rest_next;
      digits <= digits_b;
      place  <= place >> 2;
    end
  end

  // Last but one: normalise, move down to a subnormal.
  logic low;
  logic signed [X-1:0] exp_last;
  logic [N-1:0] normal;
  logic [P+1:0] lowered;
  logic [DOWN-1:0] down;
  logic lost;
  always_comb begin
    low      = !digits[N-1];  // a quotient below one
    normal   = low ? {digits[N-2:0], 1'b0} : digits;
    exp_last = exp_2 - X'(low);
    down     = (exp_last >= 1) ? '0 : (exp_last < -X'(P)) ? DOWN'(P + 2) : DOWN'(X'(1) - exp_last);
  end
  fp_shift_sticky #(
      .WIDTH(P + 2),
      .BITS (DOWN)
  ) lower (
      .value  (normal[N-1-:P+2]),
      .amount (down),
      .shifted(lowered),
      .lost   (lost)
  );
  logic [P+2:0] man_last;
  logic [EXP:0] exp_round;
  always_ff @(posedge clock) begin
    if (enable && token[STEPS+1]) begin
      if (special_2) begin
        man_last  <= {fixed_2, (P + 1)'(0)};
        exp_round <= fixed_2[1] ? {1'b0, ONES} : '0;
      end else begin
        man_last  <= {lowered, lost || rest != '0 || (normal << (P + 2)) != '0};
        exp_round <= (exp_last >= INFINITE) ? {1'b0, ONES} : (exp_last >= 1) ? exp_last[EXP:0] : (EXP + 1)'(1);
      end
    end
  end

  // Last: round and pack. The inputs stay, and so would the result; it is read once.
  logic [EXP+MAN:0] result_last;
  fp_round #(
      .EXP (EXP),
      .MAN (MAN),
      .TAIL(3)
  ) round (
      .clock  (clock),
      .enable (enable),
      .sign   (sign_2),
      .special(special_2),
      .exp    (exp_round),
      .man    (man_last),
      .result (result_last)
  );
  fp_delay #(
      .WIDTH (EXP + MAN + 1),
      .CYCLES(CYCLES - STEPS - 4)
  ) extra (
      .clock(clock),
      .enable(enable),
      .in   (result_last),
      .out  (result)
  );
endmodule
