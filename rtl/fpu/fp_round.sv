// Rounds to nearest even and packs, one cycle. `man` is the significand (leading bit on top; clear for a subnormal,
// which has exp 1) and TAIL >= 2 bits below it, the last of them sticky. exp may be one past the largest finite one.
// A special result (NaN, infinity) is packed unchanged.
module fp_round #(
    parameter int EXP  = 11,
    parameter int MAN  = 52,
    parameter int TAIL = 2
) (
    input  logic                clock,
    input  logic                enable,
    input  logic                sign,
    input  logic                special,
    input  logic [       EXP:0] exp,
    input  logic [MAN+TAIL : 0] man,
    output logic [EXP+MAN : 0]  result
);
  localparam logic [EXP-1:0] ONES = {EXP{1'b1}};

  logic up;
  logic [EXP+MAN-1:0] packed_man;
  always_comb begin
    up = man[TAIL-1] && (man[TAIL] || man[TAIL-2:0] != '0) && !special;
    // The carry of the significand moves into the exponent, up to infinity.
    packed_man = {man[MAN+TAIL] ? exp[EXP-1:0] : EXP'(0), man[MAN+TAIL-1:TAIL]} + (EXP + MAN)'(up);
    if (exp >= {1'b0, ONES} && man[MAN+TAIL] && !special) packed_man = {ONES, MAN'(0)};
  end
  always_ff @(posedge clock) if (enable) result <= {sign, packed_man};
endmodule
