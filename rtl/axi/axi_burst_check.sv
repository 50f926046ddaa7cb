// Whether a burst is refused before anything of it is done: it must be INCR, of 4 or 8 bytes a beat, aligned, and lie in
// one memory. Memory m of 0 storage, 1 microcode, 2 templates begins at m << REGION_BITS and has 2^BYTES bytes,
// storage no more than STORAGE_END; an engine whose microcode is streamed has CODE_BYTES = 0, and none.
module axi_burst_check #(
    parameter int REGION_BITS = 24,
    parameter int STORAGE_BYTES = 17,
    parameter int STORAGE_END = 1 << STORAGE_BYTES,
    parameter int CODE_BYTES = 23,
    parameter int TEMPLATE_BYTES = 8
) (
    input logic [REGION_BITS+1:0] address,
    input logic [7:0] len,
    input logic [2:0] size,
    input logic [1:0] burst,
    output logic refused
);
  localparam logic [1:0] INCR = 2'b01;

  logic [1:0] region;
  logic [REGION_BITS:0] last;  // offset of the last beat
  logic fits, aligned;
  assign region = address[REGION_BITS+:2];
  assign last = {1'b0, address[REGION_BITS-1:0]} +
      (size[0] ? (REGION_BITS + 1)'({len, 3'b000}) : (REGION_BITS + 1)'({len, 2'b00}));
  assign aligned = size[0] ? address[2:0] == '0 : address[1:0] == '0;
  always_comb begin
    case (region)
      2'd0: fits = last >> STORAGE_BYTES == '0 && (STORAGE_END == 1 << STORAGE_BYTES || last < (REGION_BITS + 1)'(STORAGE_END));
      2'd1: fits = CODE_BYTES != 0 && last >> CODE_BYTES == '0;
      2'd2: fits = last >> TEMPLATE_BYTES == '0;
      default: fits = 1'b0;
    endcase
  end
  assign refused = burst != INCR || size[2:1] != 2'b01 || !aligned || !fits;
endmodule
