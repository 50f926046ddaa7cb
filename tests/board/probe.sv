// Some of every cell that the board's computer is made of, and registers between.
module probe (
    input logic clk_25mhz,
    input logic [3:0] chosen,
    output logic [3:0] out
);
  logic [63:0] state = 64'h123456789abcdef1;
  always_ff @(posedge clk_25mhz) state <= {state[62:0], state[63] ^ state[62] ^ state[60] ^ state[59]};

  // Block memory: 16384 of 1 bit, 2048 of 9, 1024 of 18, 512 of 36 with four enables, one port and two.
  logic bits[0:16383];
  logic [8:0] bytes[0:2047];
  logic [17:0] halves[0:1023];
  logic [31:0] words[0:511], given[0:511];
  logic bit_found;
  logic [8:0] byte_found;
  logic [17:0] half_found;
  logic [31:0] word_found, given_found;
  initial for (int k = 0; k < 512; ++k) given[k] = k * 32'h9e3779b1;
  always_ff @(posedge clk_25mhz) begin
    if (state[0]) bits[state[23:10]] <= state[1];
    bit_found <= bits[state[37:24]];
    if (state[2]) bytes[state[50:40]] <= state[11:3];
    if (state[5]) byte_found <= bytes[state[34:24]];
    if (state[3]) halves[state[49:40]] <= state[30:13];
    else half_found <= halves[state[49:40]];
    for (int k = 0; k < 4; ++k) if (state[4+k]) words[state[20:12]][8*k+:8] <= state[32+8*k+:8];
    word_found <= words[state[60:52]];
    if (state[9:8] == 2'd0) given[state[33:25]] <= state[41:10];
    given_found <= given[state[18:10]];
  end

  // Memory in logic, a product with signs and one without, sums, a wide choice, registers with reset and enable.
  logic [7:0] few[0:15], few_found;
  assign few_found = few[state[19:16]];
  logic [35:0] product, bare;
  logic [39:0] sum;
  logic wide, kept;
  logic held = 1;  // as a register that is set begins
  always_ff @(posedge clk_25mhz) begin
    if (state[7]) few[state[15:12]] <= state[63:56];
    product <= 36'($signed(state[17:0]) * $signed(state[45:28]));
    bare <= state[17:0] * state[63:46];
    sum <= sum + state[39:0] - (state[0] ? 40'(few_found) : 40'(word_found));
    wide <= state[state[5:0]] ^ few_found[state[10:8]];
    if (state[6:4] == 3'd0) held <= 1'b1;
    else if (state[3]) held <= state[9] ^ held;
    if (state[8]) kept <= state[10];
  end

  logic [255:0] all;
  assign all = {bit_found, byte_found, half_found, word_found, given_found, few_found, product, bare, sum, wide, held, kept};
  logic [3:0] turned;
  always_ff @(posedge clk_25mhz) begin
    turned <= {^all, all[{chosen, state[3:0]}], all[{state[12:9], chosen}], wide ^ held ^ kept};
    out <= turned;
  end
endmodule
