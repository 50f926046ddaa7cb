// Main memory behind the core and the DMA. A simulation begins with the words of +image=FILE, as $readmemh takes them.
module soc_memory #(
    parameter int BYTE_BITS = 24
) (
    input logic clock,
    input logic reset,
    input logic [15:0] latency,
    soc_axi.slave bus
);
  localparam logic [31:0] BASE = 32'h8000_0000;
  logic [63:0] words[2**(BYTE_BITS-3)];
  string image;
  initial if ($value$plusargs("image=%s", image) != 0) $readmemh(image, words);

  logic write;
  logic [31:0] write_address, read_address;
  logic [63:0] write_word;
  logic [ 7:0] write_bytes;
  function automatic logic outside(input logic [31:0] address);
    return address[31:BYTE_BITS] != BASE[31:BYTE_BITS];
  endfunction

  soc_port port (
      .clock(clock),
      .reset(reset),
      .latency(latency),
      .bus(bus),
      .write(write),
      .write_address(write_address),
      .write_word(write_word),
      .write_bytes(write_bytes),
      .write_refused(outside(write_address)),
      .read_address(read_address),
      .read_word(words[read_address[BYTE_BITS-1:3]]),
      .read_refused(outside(read_address))
  );
  always_ff @(posedge clock)
    if (write && !outside(write_address))
      for (int k = 0; k < 8; ++k)
        if (write_bytes[k]) words[write_address[BYTE_BITS-1:3]][8*k+:8] <= write_word[8*k+:8];
endmodule
