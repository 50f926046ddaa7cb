// Register file and operation control of the PS (docs/ps-pl-protocol.md): frames in their only order, data-valid flags,
// interrupt; the first fault stops everything until reset. The table of segments lies at TABLE:
// 64 bytes per segment: +0 module, +4 first microcode word, +8 reads, +16 writes, +24 stales (BUFFERS flags each,
// low word first). It is written while no frame has begun; a segment without a module does not exist.
module registers #(
    parameter int SEGMENTS = 64,
    parameter int BUFFERS = 64,
    parameter int CODE_BITS = 16
) (
    input logic clock,
    input logic reset,
    input logic write,
    input logic read,
    input logic [15:0] address,
    input logic [31:0] value,
    output logic [31:0] answer,
    output logic irq,
    output logic start,
    output logic [CODE_BITS-1:0] start_address,
    input logic ended  // the sequencer's last busy cycle
);
  localparam logic [15:0] MODULE = 16'h0000;
  localparam logic [15:0] SEGMENT = 16'h0004;
  localparam logic [15:0] SEQUENCE = 16'h0008;
  localparam logic [15:0] CONTROL = 16'h000C;
  localparam logic [15:0] STATUS = 16'h0010;
  localparam logic [15:0] IRQ_ACK = 16'h0014;
  localparam logic [15:0] DATA_VALID = 16'h0020;
  localparam logic [15:0] TABLE = 16'h1000;
  localparam logic [15:0] TABLE_END = TABLE + 16'(64 * SEGMENTS);
  localparam logic [15:0] VALID_END = DATA_VALID + 16'(4 * (BUFFERS / 32));
  localparam logic [31:0] START = 32'd1;
  localparam logic [31:0] PUBLISH = 32'd2;

  localparam logic [3:0] NONE = 4'd0;
  localparam logic [3:0] LAUNCH_WHILE_BUSY = 4'd1;
  localparam logic [3:0] UNACKNOWLEDGED_INTERRUPT = 4'd2;
  localparam logic [3:0] SPURIOUS_ACKNOWLEDGE = 4'd3;
  localparam logic [3:0] WRITE_OUT_OF_ORDER = 4'd4;
  localparam logic [3:0] WRONG_SEGMENT = 4'd5;
  localparam logic [3:0] WRONG_SEQUENCE = 4'd6;
  localparam logic [3:0] READ_BEFORE_VALID = 4'd7;
  localparam logic [3:0] INVALID_ACCESS = 4'd8;

  localparam logic [2:0] IDLE = 3'd0;
  localparam logic [2:0] HAVE_MODULE = 3'd1;
  localparam logic [2:0] HAVE_SEGMENT = 3'd2;
  localparam logic [2:0] HAVE_SEQUENCE = 3'd3;
  localparam logic [2:0] BUSY = 3'd4;
  localparam logic [2:0] DONE = 3'd5;
  localparam logic [2:0] FAULT = 3'd6;

  localparam int PICK = $clog2(SEGMENTS);

  logic [2:0] state;
  logic [3:0] fault;

  // The table.
  logic [SEGMENTS-1:0] exists;
  (* ram_style = "distributed" *)
  logic [2:0] table_module[0:SEGMENTS-1];
  (* ram_style = "distributed" *)
  logic [CODE_BITS-1:0] table_start[0:SEGMENTS-1];
  (* ram_style = "distributed" *)
  logic [BUFFERS-1:0] table_reads[0:SEGMENTS-1];
  (* ram_style = "distributed" *)
  logic [BUFFERS-1:0] table_writes[0:SEGMENTS-1];
  (* ram_style = "distributed" *)
  logic [BUFFERS-1:0] table_stales[0:SEGMENTS-1];
  logic in_table, table_write;
  logic [PICK-1:0] row;
  logic [3:0] column;
  logic [15:0] into_table;
  assign into_table = address - TABLE;
  assign in_table = address >= TABLE && address < TABLE_END && address[1:0] == 2'b00;
  assign row = into_table[6+:PICK];
  assign column = into_table[5:2];
  assign table_write = write && state == IDLE && in_table;
  generate
    for (genvar i = 0; i < BUFFERS / 32; i++) begin : g_masks
      always_ff @(posedge clock) begin
        if (table_write && column == 4'(2 + i)) table_reads[row][32*i+:32] <= value;
        if (table_write && column == 4'(4 + i)) table_writes[row][32*i+:32] <= value;
        if (table_write && column == 4'(6 + i)) table_stales[row][32*i+:32] <= value;
      end
    end
  endgenerate
  always_ff @(posedge clock) begin
    if (table_write && column == 4'd0) table_module[row] <= value[2:0];
    if (table_write && column == 4'd1) table_start[row] <= value[CODE_BITS-1:0];
  end

  // The frame and its announcement.
  logic [31:0] module_id, segment, sequence_id, completed_sequence;
  logic [7:0] completed_segment;
  logic [BUFFERS-1:0] valid, written, reads, writes, stales;
  logic [31:0] announced;
  logic [2:0] announced_module;
  logic announced_exists, unreadable;
  // The announced segment's row of the table, registered: it is there in the cycle after the announcement, and what
  // its buffers say a cycle later, when the command may come.
  assign announced = (write && address == SEGMENT) ? value : segment;
  always_ff @(posedge clock) begin
    announced_exists <= announced < 32'(SEGMENTS) && exists[announced[PICK-1:0]];
    announced_module <= table_module[announced[PICK-1:0]];
    start_address <= table_start[announced[PICK-1:0]];
    reads <= table_reads[announced[PICK-1:0]];
    writes <= table_writes[announced[PICK-1:0]];
    stales <= table_stales[announced[PICK-1:0]];
    unreadable <= (reads & ~(valid | (writes & written))) != '0;
  end

  // The fault of this access, if any: first its register, then its order.
  logic [3:0] refusal, frame_fault, found;
  logic frame_address;
  assign frame_address = address == MODULE || address == SEGMENT || address == SEQUENCE || address == CONTROL;
  always_comb begin
    if (value != START && value != PUBLISH) frame_fault = INVALID_ACCESS;
    else if (sequence_id != completed_sequence + 32'd1) frame_fault = WRONG_SEQUENCE;
    else if (!announced_exists) frame_fault = WRONG_SEGMENT;
    else if (32'(announced_module) != module_id || (module_id == 32'd0) != (value == PUBLISH)) begin
      frame_fault = WRONG_SEGMENT;
    end else if (unreadable) frame_fault = READ_BEFORE_VALID;
    else frame_fault = NONE;
  end
  always_comb begin
    if (in_table && state == IDLE) refusal = NONE;
    else if (!frame_address && address != IRQ_ACK) refusal = INVALID_ACCESS;
    else if (state == BUSY) refusal = LAUNCH_WHILE_BUSY;
    else if (address == IRQ_ACK) refusal = (state == DONE && value == sequence_id) ? NONE : SPURIOUS_ACKNOWLEDGE;
    else if (state == DONE) refusal = UNACKNOWLEDGED_INTERRUPT;
    else if (address != {12'd0, state[1:0], 2'b00}) refusal = WRITE_OUT_OF_ORDER;
    else refusal = (address == CONTROL) ? frame_fault : NONE;
  end
  logic readable;
  assign readable = address == STATUS || (address >= DATA_VALID && address < VALID_END && address[1:0] == 2'b00);
  assign found = write ? refusal : (read && !readable) ? INVALID_ACCESS : NONE;

  logic command;
  assign command = write && address == CONTROL && state == HAVE_SEQUENCE && found == NONE;
  assign start = command && value == START;
  assign irq = state == DONE || state == FAULT;

  always_ff @(posedge clock) begin
    if (reset) begin
      state <= IDLE;
      fault <= NONE;
      exists <= '0;
      valid <= '0;
      written <= '0;
      module_id <= '0;
      segment <= '0;
      sequence_id <= '0;
      completed_segment <= '0;
      completed_sequence <= '0;
    end else if (state != FAULT) begin
      if (found != NONE) begin
        state <= FAULT;
        fault <= found;
      end else if (write) begin
        if (in_table && column == 4'd0) exists[row] <= 1'b1;
        if (address == MODULE) module_id <= value;
        if (address == SEGMENT) segment <= value;
        if (address == SEQUENCE) sequence_id <= value;
        if (address == IRQ_ACK) state <= IDLE;
        else if (address == CONTROL) state <= (value == START) ? BUSY : IDLE;
        else if (!in_table) state <= state + 3'd1;
      end else if (state == BUSY && ended) begin
        state <= DONE;
      end
      if (start) valid <= valid & ~writes;
      if ((command && value == PUBLISH) || (state == BUSY && ended)) begin
        valid <= (valid | writes) & ~stales;
        written <= written | writes;
        completed_segment <= segment[7:0];
        completed_sequence <= sequence_id;
      end
    end
  end

  logic armed;
  logic [31:0] flags;
  assign armed = state == HAVE_MODULE || state == HAVE_SEGMENT || state == HAVE_SEQUENCE;
  always_comb begin
    flags = '0;
    for (int i = 0; i < BUFFERS / 32; i++) begin
      if (address == DATA_VALID + 16'(4 * i)) flags = valid[32*i+:32];
    end
    // OUTCOME (bits 4, 5) is 0: the PS decides, a segment only computes.
    answer = (address == STATUS)
        ? {completed_sequence[7:0], completed_segment, 4'd0, fault, 5'd0, armed, state == DONE, state == BUSY} : flags;
  end
endmodule
