// Memory of the core in block RAM: 32 bits, bytes written one by one, a clock from address to word. It begins with the words
// of the file IMAGE, as $readmemh takes them.
module board_memory #(
    parameter int WORDS = 49152,
    parameter IMAGE = "memory.hex"
) (
    input logic clock,
    input logic [$clog2(WORDS)-1:0] place,
    input logic [3:0] write,
    input logic [31:0] value,
    output logic [31:0] word
);
  logic [31:0] words[0:WORDS-1];
  initial $readmemh(IMAGE, words);
  always_ff @(posedge clock) begin
    for (int k = 0; k < 4; ++k) if (write[k]) words[place][8*k+:8] <= value[8*k+:8];
    if (write == '0) word <= words[place];
  end
endmodule
