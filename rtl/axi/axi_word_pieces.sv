// Pieces of 32 bits become words of storage, of microcode and templates: the pieces of a word come in order, the last one
// writes it. A piece out of order is an error and changes no memory. Storage words lie side by side; a line of microcode
// begins at a power of two of pieces, and pieces behind its width are taken and dropped; a template is a piece.
module axi_word_pieces #(
    parameter int REGION_BITS = 24,
    parameter int W = 64,
    parameter int ADDRESS_BITS = 14,
    parameter int CODE_BITS = 17,
    parameter int CODE_WIDTH = 285,
    parameter int CODE_PIECES = (CODE_WIDTH + 31) / 32,
    parameter int PIECES = CODE_PIECES > W / 32 ? CODE_PIECES : W / 32
) (
    input logic clock,
    input logic reset,
    input logic take,  // the piece, in this cycle
    input logic pair,  // and the one after it, of the same word
    input logic drop,  // a piece came while the engine ran, or spoilt: a word that was begun must begin again
    input logic [REGION_BITS+1:0] address,
    input logic [31:0] value,
    input logic [31:0] upper,
    output logic error,
    output logic commit,  // the piece writes a word
    output logic digested,  // it is one of microcode or templates, and is kept
    output logic digested_pair,
    output logic storage_commit,
    output logic [ADDRESS_BITS-1:0] storage_address,
    // A cycle after `take`: word, and whether it goes to microcode or templates.
    output logic [32*PIECES-1:0] word,
    output logic code_write,
    output logic [CODE_BITS-1:0] code_address,
    output logic template_write,
    output logic [contract::TEMPLATE_BITS-1:0] template_address
);
  localparam int WORD_SHIFT = $clog2(W / 8);
  localparam int LINE_SHIFT = $clog2(CODE_PIECES) + 2;
  localparam int PLACE = $clog2(PIECES) + 1;
  localparam logic [1:0] STORAGE = 2'd0;
  localparam logic [1:0] CODE = 2'd1;

  logic [1:0] region;
  logic [REGION_BITS-1:0] offset;
  logic [PLACE-1:0] place, after, last, next;
  logic [REGION_BITS+1:0] begun, this_word;  // region and address of the word whose pieces come
  logic begin_word, padding;
  assign region = address[REGION_BITS+:2];
  assign offset = address[REGION_BITS-1:0];
  always_comb begin
    case (region)
      STORAGE: begin
        place = PLACE'((offset & REGION_BITS'((1 << WORD_SHIFT) - 1)) >> 2);
        last = PLACE'(W / 32 - 1);
        this_word = address & ~(REGION_BITS + 2)'((1 << WORD_SHIFT) - 1);
      end
      CODE: begin
        place = PLACE'((offset & REGION_BITS'((1 << LINE_SHIFT) - 1)) >> 2);
        last = PLACE'(CODE_PIECES - 1);
        this_word = address & ~(REGION_BITS + 2)'((1 << LINE_SHIFT) - 1);
      end
      default: begin
        place = '0;
        last = '0;
        this_word = address;
      end
    endcase
  end
  assign begin_word = place == '0;
  assign padding = place > last;
  assign error = !begin_word && !padding && !(place == next && this_word == begun);
  assign after = place + PLACE'(1);
  assign commit = take && !error && !padding && (place == last || (pair && after == last));
  assign digested = take && !error && !padding && region != STORAGE;
  assign digested_pair = pair && after <= last;
  assign storage_commit = commit && region == STORAGE;
  assign storage_address = ADDRESS_BITS'(offset >> WORD_SHIFT);

  generate
    for (genvar i = 0; i < PIECES; i++) begin : g_piece
      always_ff @(posedge clock) begin
        if (take && place == PLACE'(i)) word[32*i+:32] <= value;
        if (take && pair && after == PLACE'(i)) word[32*i+:32] <= upper;
      end
    end
  endgenerate
  always_ff @(posedge clock) begin
    // After its last piece, and after an error, a word must begin again.
    if (reset || drop) next <= '0;
    else if (take && !padding) next <= (error || commit) ? '0 : pair ? after + PLACE'(1) : after;
    if (take && begin_word) begun <= this_word;
    code_write <= commit && region == CODE && !reset;
    template_write <= commit && region[1] && !reset;
    code_address <= CODE_BITS'(offset >> LINE_SHIFT);
    template_address <= contract::TEMPLATE_BITS'(offset >> 2);
  end
endmodule
