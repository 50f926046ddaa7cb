// IEEE 754 quotient a / b, or square root of a where `root`, rounded to nearest even. Specials and NaN as in fp_add.
// `start` takes the operands, at most once in INTERVAL cycles; the result is valid CYCLES cycles later for one cycle.
// Without `enable` every register keeps its value.
// Two result bits a cycle by restoring subtraction of one of three multiples. SLOTS digit recurrences take turns:
// CYCLES >= 3 (unpack, load) + ceil((MAN + 3) / 2) (digits) + 4 (collect, normalise, round).
module fp_divsqrt #(
    parameter int EXP      = 11,
    parameter int MAN      = 52,
    parameter int CYCLES   = 35,
    parameter int INTERVAL = 4
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
  localparam int N = 2 * STEPS;  // result bits: P, guard, one to normalise, and padding
  localparam int SLOTS = (STEPS + INTERVAL) / INTERVAL;  // a slot is taken for a load and STEPS steps
  localparam int X = EXP + 2;
  localparam int LZ = $clog2(P + 1);
  localparam int DOWN = $clog2(P + 3);
  localparam logic [EXP-1:0] ONES = {EXP{1'b1}};
  localparam logic signed [X-1:0] INFINITE = X'((1 << EXP) - 1);
  localparam logic signed [X-1:0] BIAS = X'((1 << (EXP - 1)) - 1);

  // Where operations are: bit i, i + 1 cycles after the start.
  logic [STEPS+2:0] token;
  always_ff @(posedge clock) begin
    if (reset) token <= '0;
    else if (enable) token <= {token[STEPS+1:0], start};
  end

  // 1: unpack, count leading zeros, find special results.
  logic nan, a_inf, b_inf, a_zero, b_zero, infinite, zero;
  logic [EXP-1:0] a_exp, b_exp;
  logic [P-1:0] a_raw, b_raw;
  logic [LZ-1:0] a_zeros, b_zeros;
  assign a_exp = a[EXP+MAN-1:MAN];
  assign b_exp = b[EXP+MAN-1:MAN];
  assign a_raw = {a_exp != '0, a[MAN-1:0]};
  assign b_raw = {b_exp != '0, b[MAN-1:0]};
  fp_leading_zeros #(
      .WIDTH(P)
  ) a_leading (
      .value({1'b0, a[MAN-1:0]}),
      .count(a_zeros)
  );
  fp_leading_zeros #(
      .WIDTH(P)
  ) b_leading (
      .value({1'b0, b[MAN-1:0]}),
      .count(b_zeros)
  );
  always_comb begin
    a_inf    = a_exp == ONES && a[MAN-1:0] == '0;
    b_inf    = b_exp == ONES && b[MAN-1:0] == '0;
    a_zero   = a[EXP+MAN-1:0] == '0;
    b_zero   = b[EXP+MAN-1:0] == '0;
    // A NaN operand, a root of a negative number, infinity by infinity, zero by zero.
    nan      = (a_exp == ONES && !a_inf) ||
               (root ? a[EXP+MAN] && !a_zero : (b_exp == ONES && !b_inf) || (a_inf && b_inf) || (a_zero && b_zero));
    infinite = root ? a_inf : a_inf || b_zero;
    zero     = root ? a_zero : a_zero || b_inf;
  end
  logic root_1, sign_1, special_1;
  logic [1:0] fixed_1;  // special result: not zero, NaN
  logic [EXP-1:0] a_field_1, b_field_1;
  logic [LZ-1:0] a_zeros_1, b_zeros_1;
  logic [P-1:0] a_1, b_1;
  always_ff @(posedge clock) if (enable) begin
    root_1    <= root;
    sign_1    <= !nan && (a[EXP+MAN] ^ (b[EXP+MAN] && !root));
    special_1 <= nan || infinite || zero;
    fixed_1   <= {nan || infinite, nan};
    a_field_1 <= a_exp | EXP'(a_exp == '0);
    b_field_1 <= b_exp | EXP'(b_exp == '0);
    a_zeros_1 <= (a_exp != '0) ? '0 : a_zeros;
    b_zeros_1 <= (b_exp != '0) ? '0 : b_zeros;
    a_1       <= a_raw;
    b_1       <= b_raw;
  end

  // 2: move the leading ones up.
  logic root_2, sign_2, special_2;
  logic [1:0] fixed_2;
  logic signed [X-1:0] a_place_2, b_place_2;
  logic [P-1:0] a_2, b_2;
  always_ff @(posedge clock) if (enable) begin
    root_2    <= root_1;
    sign_2    <= sign_1;
    special_2 <= special_1;
    fixed_2   <= fixed_1;
    a_place_2 <= X'(a_field_1) - X'(a_zeros_1);
    b_place_2 <= X'(b_field_1) - X'(b_zeros_1);
    a_2       <= a_1 << a_zeros_1;
    b_2       <= b_1 << b_zeros_1;
  end

  // 3: load a slot; the exponent is that of the digit before the point.
  // Division is of a/2 by b; a root is of a/4 or, as exponents of roots must be even, of a/2: both below one.
  logic signed [X-1:0] power, exp_3;
  logic [N-1:0] radicand;
  always_comb begin
    power    = a_place_2 - BIAS;
    exp_3    = root_2 ? (power >>> 1) + BIAS : a_place_2 - b_place_2 + BIAS;
    radicand = power[0] ? N'(a_2) << (N - MAN - 1) : N'(a_2) << (N - MAN - 2);
  end

  // 4 ... : digits. All numbers are integers. A remainder w is followed by one of 4 w - q D, q = 0 ... 3, in division
  // by D; in a root with digits Q so far, and f the next four bits of the radicand, by one of 16 w + f - q (8 Q + q).
  // Held are D or Q (bits above the lowest three: `once`), and the quotient or the rest of the radicand (`moving`). Three
  // times D is D + 2 D; for q = 3 a root takes 24 Q + 9 = (8 Q + 1) + (16 Q + 8). A carry-save addition takes both away.
  logic [SLOTS-1:0] load, turn, collect, collect_next;  // whose turn it is, one hot
  logic [SLOTS*N-1:0] found;
  logic [SLOTS-1:0] inexact;
  logic [SLOTS*(X+4)-1:0] kept;  // exponent, sign and special result
  assign turn = token[1] ? SLOTS'({load, load} >> (SLOTS - 1)) : load;
  assign collect_next = token[STEPS+2] ? SLOTS'({collect, collect} >> (SLOTS - 1)) : collect;
  always_ff @(posedge clock) begin
    if (reset) begin
      load <= SLOTS'(1);
      collect <= SLOTS'(1);
    end else if (enable) begin
      load <= turn;
      collect <= collect_next;
    end
  end
  generate
    for (genvar s = 0; s < SLOTS; s++) begin : g_slot
      logic is_root, is_quotient, loads;  // one register for both would drive twice the wires
      logic [N:0] w, below_2;
      logic [N-1:0] once, moving;
      logic [2:0] low;  // of D
      logic [3:0] low_2, low_3;  // of 2 D, alone and beside D
      logic [N+2:0] next;
      logic [N+3:0] one, two, kept_3, carried_3, less_1, less_2, less_3;
      logic [1:0] q;
      logic [X+3:0] aside;
      always_ff @(posedge clock) begin
        if (reset) loads <= 1'b0;
        else if (enable) loads <= token[0] && turn[s];
      end
      always_comb begin
        next = is_quotient ? {w, 2'b00} : {w[N-2:0], moving[N-1:N-4]};
        one = ~{1'b0, once, low};
        two = ~{once, low_3};
        kept_3 = {1'b0, next} ^ one ^ two;
        carried_3 = ({1'b0, next} & one) | ({1'b0, next} & two) | (one & two);
        less_1 = {1'b0, next} - {1'b0, once, low};
        less_2 = {1'b0, next} - {once, low_2};
        less_3 = kept_3 - ~{carried_3[N+2:0], 1'b1};
        // Each sign chooses for itself: the digit comes later. While a slot loads, the remainder comes in where that of
        // digit 0 would.
        below_2 = loads ? (root_2 ? '0 : (N + 1)'(a_2)) : less_1[N+3] ? next[N:0] : less_1[N:0];
        q = {!less_2[N+3], less_2[N+3] ? !less_1[N+3] : !less_3[N+3]};
      end
      always_ff @(posedge clock) if (enable) begin
        w <= (less_2[N+3] || loads) ? below_2 : less_3[N+3] ? less_2[N:0] : less_3[N:0];
        moving <= loads ? (root_2 ? radicand : '0) : is_root ? moving << 4 : {moving[N-3:0], q};
        if (loads) begin
          is_root <= root_2;
          is_quotient <= !root_2;
          low <= root_2 ? 3'b001 : {b_2[1:0], 1'b0};
          low_2 <= root_2 ? 4'b0100 : {b_2[1:0], 2'b00};
          low_3 <= root_2 ? 4'b1000 : {b_2[1:0], 2'b00};
          once <= root_2 ? '0 : N'(b_2[P-1:2]);
          aside <= {exp_3, sign_2, special_2, fixed_2};
        end else if (is_root) begin
          once <= {once[N-3:0], q};
        end
      end
      assign found[s*N+:N] = is_root ? once : moving;
      assign inexact[s] = w != '0;
      assign kept[s*(X+4)+:X+4] = aside;
    end
  endgenerate

  // Collect the digits of the slot whose turn it is; its exponent comes a cycle before. A result below the normal range moves
  // down by what the exponent alone says: there, whether the quotient is below one makes no difference.
  logic [N-1:0] digits, digits_c;
  logic [X+3:0] aside, aside_b;
  logic [3:0] aside_c;
  logic signed [X-1:0] exp_b, below_b;
  logic [DOWN-1:0] down_c;
  logic [EXP:0] exp_c, below_c;  // the result's exponent, and that of a quotient below one
  logic rest_c, subnormal_c;
  always_comb begin
    digits = '0;
    aside  = '0;
    for (int s = 0; s < SLOTS; s++) begin
      digits = digits | ({N{collect[s]}} & found[s*N+:N]);
      aside  = aside | ({(X + 4) {collect_next[s]}} & kept[s*(X+4)+:X+4]);
    end
  end
  assign exp_b = $signed(aside_b[X+3:4]);
  assign below_b = exp_b - X'(1);
  always_ff @(posedge clock) if (enable) begin
    aside_b     <= aside;
    digits_c    <= digits;
    aside_c     <= aside_b[3:0];
    exp_c       <= (exp_b >= INFINITE) ? {1'b0, ONES} : (exp_b >= 1) ? exp_b[EXP:0] : (EXP + 1)'(1);
    below_c     <= (exp_b > INFINITE) ? {1'b0, ONES} : (exp_b > 1) ? below_b[EXP:0] : (EXP + 1)'(1);
    rest_c      <= (collect & inexact) != '0;
    subnormal_c <= exp_b <= 1;
    down_c      <= (exp_b >= 1) ? '0 : (exp_b < -X'(P)) ? DOWN'(P + 2) : DOWN'(X'(1) - exp_b);
  end

  // Normalise, or move down by whole steps.
  localparam int STEP = 3;  // bits of a distance within a step
  logic low_c, sign_n, special_n, rest_n, lost_c;
  logic [1:0] fixed_n;
  logic [N-1:0] normal, stepped, normal_n;
  logic [STEP-1:0] down_n;
  logic [EXP:0] exp_n;
  assign low_c  = !digits_c[N-1];  // a quotient below one
  assign normal = (low_c && !subnormal_c) ? {digits_c[N-2:0], 1'b0} : digits_c;
  fp_shift_sticky #(
      .WIDTH(N),
      .BITS (DOWN)
  ) step_down (
      .value  (normal),
      .amount ({down_c[DOWN-1:STEP], STEP'(0)}),
      .shifted(stepped),
      .lost   (lost_c)
  );
  always_ff @(posedge clock) if (enable) begin
    {sign_n, special_n, fixed_n} <= aside_c;
    rest_n   <= rest_c || lost_c;
    normal_n <= stepped;
    down_n   <= down_c[STEP-1:0];
    exp_n    <= low_c ? below_c : exp_c;
  end

  // Move down by the rest.
  logic lost, sign_l, special_l;
  logic [P+1:0] lowered;
  logic [P+2:0] man_l;
  logic [EXP:0] exp_l;
  fp_shift_sticky #(
      .WIDTH(P + 2),
      .BITS (STEP)
  ) lower (
      .value  (normal_n[N-1-:P+2]),
      .amount (down_n),
      .shifted(lowered),
      .lost   (lost)
  );
  always_ff @(posedge clock) if (enable) begin
    sign_l    <= sign_n;
    special_l <= special_n;
    man_l     <= special_n ? {fixed_n, (P + 1)'(0)} : {lowered, lost || rest_n || (normal_n << (P + 2)) != '0};
    exp_l     <= !special_n ? exp_n : fixed_n[1] ? {1'b0, ONES} : '0;
  end

  // Round and pack.
  logic [EXP+MAN:0] result_last;
  fp_round #(
      .EXP (EXP),
      .MAN (MAN),
      .TAIL(3)
  ) round (
      .clock  (clock),
      .enable (enable),
      .sign   (sign_l),
      .special(special_l),
      .exp    (exp_l),
      .man    (man_l),
      .result (result_last)
  );
  fp_delay #(
      .WIDTH (EXP + MAN + 1),
      .CYCLES(CYCLES - STEPS - 7)
  ) extra (
      .clock(clock),
      .enable(enable),
      .in   (result_last),
      .out  (result)
  );
endmodule
