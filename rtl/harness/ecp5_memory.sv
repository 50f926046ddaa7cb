// Our model of the ECP5's block of memory, DP16KD: 2048 words of 9 bits, a clock from address to word, port A to write and to read,
// port B to read (Lattice, ECP5 memory usage guide, FPGA-TN-02204). A port has 1, 2, 4, 9, 18 or 36 bits: below 9 the ninth bit of a word
// is left out, and 36 take the pins of both ports. What the model does not have ends the simulation: writes by port B, resets, registers
// behind the words, inverted clocks, selects.
module DP16KD (
    input logic DIA17, DIA16, DIA15, DIA14, DIA13, DIA12, DIA11, DIA10, DIA9, DIA8, DIA7, DIA6, DIA5, DIA4, DIA3, DIA2, DIA1,
    DIA0, ADA13, ADA12, ADA11, ADA10, ADA9, ADA8, ADA7, ADA6, ADA5, ADA4, ADA3, ADA2, ADA1, ADA0, CEA, OCEA, CLKA, WEA, RSTA,
    CSA2, CSA1, CSA0,
    output logic DOA17, DOA16, DOA15, DOA14, DOA13, DOA12, DOA11, DOA10, DOA9, DOA8, DOA7, DOA6, DOA5, DOA4, DOA3, DOA2, DOA1,
    DOA0,
    input logic DIB17, DIB16, DIB15, DIB14, DIB13, DIB12, DIB11, DIB10, DIB9, DIB8, DIB7, DIB6, DIB5, DIB4, DIB3, DIB2, DIB1,
    DIB0, ADB13, ADB12, ADB11, ADB10, ADB9, ADB8, ADB7, ADB6, ADB5, ADB4, ADB3, ADB2, ADB1, ADB0, CEB, OCEB, CLKB, WEB, RSTB,
    CSB2, CSB1, CSB0,
    output logic DOB17, DOB16, DOB15, DOB14, DOB13, DOB12, DOB11, DOB10, DOB9, DOB8, DOB7, DOB6, DOB5, DOB4, DOB3, DOB2, DOB1,
    DOB0
);
  parameter int DATA_WIDTH_A = 18, DATA_WIDTH_B = 18;
  parameter logic [119:0] WRITEMODE_A = "NORMAL", WRITEMODE_B = "NORMAL";
  parameter REGMODE_A = "NOREG", REGMODE_B = "NOREG";
  parameter CLKAMUX = "CLKA", CLKBMUX = "CLKB", CSDECODE_A = "0b000", CSDECODE_B = "0b000";
  parameter RESETMODE = "SYNC", ASYNC_RESET_RELEASE = "SYNC", GSR = "AUTO";

  logic [8:0] words[0:2047];  // a netlist fills them
  initial
    if (REGMODE_A != "NOREG" || REGMODE_B != "NOREG" || CLKAMUX != "CLKA" || CLKBMUX != "CLKB" || CSDECODE_A != "0b000" || CSDECODE_B != "0b000")
      $fatal(1, "DP16KD: a mode that the model does not have");

  logic [13:0] address_a, address_b;
  logic [35:0] data;
  assign address_a = {ADA13, ADA12, ADA11, ADA10, ADA9, ADA8, ADA7, ADA6, ADA5, ADA4, ADA3, ADA2, ADA1, ADA0};
  assign address_b = {ADB13, ADB12, ADB11, ADB10, ADB9, ADB8, ADB7, ADB6, ADB5, ADB4, ADB3, ADB2, ADB1, ADB0};
  assign data = {DIB17, DIB16, DIB15, DIB14, DIB13, DIB12, DIB11, DIB10, DIB9, DIB8, DIB7, DIB6, DIB5, DIB4, DIB3, DIB2, DIB1,
      DIB0, DIA17, DIA16, DIA15, DIA14, DIA13, DIA12, DIA11, DIA10, DIA9, DIA8, DIA7, DIA6, DIA5, DIA4, DIA3, DIA2, DIA1, DIA0};

  // The first word of an access; of one narrower than a word, its first bit.
  logic [10:0] first_a, first_b;
  logic [2:0] bit_a, bit_b;
  assign first_a = DATA_WIDTH_A == 36 ? {address_a[13:5], 2'd0} : DATA_WIDTH_A == 18 ? {address_a[13:4], 1'b0} : address_a[13:3];
  assign first_b = DATA_WIDTH_B == 36 ? {address_b[13:5], 2'd0} : DATA_WIDTH_B == 18 ? {address_b[13:4], 1'b0} : address_b[13:3];
  assign bit_a = address_a[2:0] & 3'(8 - DATA_WIDTH_A);
  assign bit_b = address_b[2:0] & 3'(8 - DATA_WIDTH_B);
  logic [35:0] found_a, found_b, read_a, read_b;
  logic [8:0] changed;
  always_comb begin
    found_a = 36'(words[first_a]);
    found_b = 36'(words[first_b]);
    if (DATA_WIDTH_A < 9) found_a = 36'(words[first_a][7:0]) >> bit_a;
    if (DATA_WIDTH_B < 9) found_b = 36'(words[first_b][7:0]) >> bit_b;
    if (DATA_WIDTH_A >= 18) found_a[17:9] = words[first_a+11'd1];
    if (DATA_WIDTH_B >= 18) found_b[17:9] = words[first_b+11'd1];
    if (DATA_WIDTH_A == 36) found_a[35:18] = {words[first_a+11'd3], words[first_a+11'd2]};
    if (DATA_WIDTH_B == 36) found_b[35:18] = {words[first_b+11'd3], words[first_b+11'd2]};
    changed = words[first_a];
    for (int k = 0; k < DATA_WIDTH_A && k < 8; ++k) changed[4'(bit_a)+4'(k)] = data[k];
  end
  always_ff @(posedge CLKA)
    if (CEA) begin
      if (WEA && DATA_WIDTH_A < 9) words[first_a] <= changed;
      if (WEA && DATA_WIDTH_A == 9) words[first_a] <= data[8:0];
      if (WEA && DATA_WIDTH_A >= 18 && address_a[0]) words[first_a] <= data[8:0];
      if (WEA && DATA_WIDTH_A >= 18 && address_a[1]) words[first_a+11'd1] <= data[17:9];
      if (WEA && DATA_WIDTH_A == 36 && address_a[2]) words[first_a+11'd2] <= data[26:18];
      if (WEA && DATA_WIDTH_A == 36 && address_a[3]) words[first_a+11'd3] <= data[35:27];
      if (!WEA || WRITEMODE_A == "READBEFOREWRITE") read_a <= found_a;
      else if (WRITEMODE_A == 120'("WRITETHROUGH")) read_a <= data;
      if (RSTA || CSA0 || CSA1 || CSA2) $fatal(1, "DP16KD: a signal that the model does not have");
    end
  always_ff @(posedge CLKB)
    if (CEB) begin
      read_b <= found_b;
      if (WEB || RSTB || CSB0 || CSB1 || CSB2) $fatal(1, "DP16KD: a signal that the model does not have");
    end
  logic [17:0] out_a, out_b;
  assign out_a = DATA_WIDTH_B == 36 ? read_b[17:0] : read_a[17:0];
  assign out_b = DATA_WIDTH_B == 36 ? read_b[35:18] : read_b[17:0];
  assign {DOA17, DOA16, DOA15, DOA14, DOA13, DOA12, DOA11, DOA10, DOA9, DOA8, DOA7, DOA6, DOA5, DOA4, DOA3, DOA2, DOA1, DOA0} =
      out_a;
  assign {DOB17, DOB16, DOB15, DOB14, DOB13, DOB12, DOB11, DOB10, DOB9, DOB8, DOB7, DOB6, DOB5, DOB4, DOB3, DOB2, DOB1, DOB0} =
      out_b;
endmodule
