// Register file and operation control of the PS (docs/ps-pl-protocol.md): frames in their only order, data-valid flags,
// interrupt; the first fault stops everything until reset. The table of segments lies at TABLE:
// 64 bytes per segment: +0 module, +4 first microcode word, +8 reads, +16 writes, +24 stales (BUFFERS flags each,
// low word first). It is written while no frame has begun; a segment without a module does not exist.
module registers #(
    parameter int SEGMENTS = 64,
    parameter int BUFFERS = 64,
    parameter int CODE_BITS = 16,
    parameter int RESIDENT = 0,
    parameter int INSTRUCTIONS = 128
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
    input logic ended,  // the sequencer's last busy cycle
    input logic wrong_parity,  // a bit that turned over has been read
    // Resident control: its program, and what it asks for.
    output logic program_write,
    output logic [$clog2(INSTRUCTIONS):0] program_address,
    output logic launch,
    output logic [$clog2(INSTRUCTIONS)-1:0] entry,
    output logic stop,
    output logic halt,
    input logic run,
    input logic [7:0] run_segment,
    input logic finished,
    output logic [7:0] running  // the segment that runs, or ran last
);
  localparam logic [15:0] MODULE = 16'h0000;
  localparam logic [15:0] SEGMENT = 16'h0004;
  localparam logic [15:0] SEQUENCE = 16'h0008;
  localparam logic [15:0] CONTROL = 16'h000C;
  localparam logic [15:0] STATUS = 16'h0010;
  localparam logic [15:0] IRQ_ACK = 16'h0014;
  localparam logic [15:0] STOP = 16'h0018;
  localparam logic [15:0] DATA_VALID = 16'h0020;
  localparam logic [15:0] TABLE = 16'h1000;
  localparam logic [15:0] TABLE_END = TABLE + 16'(64 * SEGMENTS);
  localparam logic [15:0] PROGRAM = 16'h2000;
  localparam logic [15:0] PROGRAM_END = PROGRAM + 16'(8 * INSTRUCTIONS);
  localparam logic [15:0] VALID_END = DATA_VALID + 16'(4 * (BUFFERS / 32));
  localparam logic [31:0] START = 32'd1;
  localparam logic [31:0] PUBLISH = 32'd2;
  localparam logic [31:0] ATTEMPT = 32'd3;

  localparam logic [3:0] NONE = 4'd0;
  localparam logic [3:0] LAUNCH_WHILE_BUSY = 4'd1;
  localparam logic [3:0] UNACKNOWLEDGED_INTERRUPT = 4'd2;
  localparam logic [3:0] SPURIOUS_ACKNOWLEDGE = 4'd3;
  localparam logic [3:0] WRITE_OUT_OF_ORDER = 4'd4;
  localparam logic [3:0] WRONG_SEGMENT = 4'd5;
  localparam logic [3:0] WRONG_SEQUENCE = 4'd6;
  localparam logic [3:0] READ_BEFORE_VALID = 4'd7;
  localparam logic [3:0] INVALID_ACCESS = 4'd8;
  localparam logic [3:0] PARITY = 4'd10;

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
  logic resident;  // an attempt runs
  logic in_program;
  logic [INSTRUCTIONS-1:0] entries;
  logic [15:0] into_program;

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
  // A word is written a cycle after it came: a segment is announced two cycles later at the earliest.
  logic in_table, table_write;
  logic [PICK-1:0] row;
  logic [3:0] column;
  logic [15:0] into_table;
  logic [31:0] table_word;
  assign into_table = address - TABLE;
  assign in_table = address >= TABLE && address < TABLE_END && address[1:0] == 2'b00;
  always_ff @(posedge clock) begin
    table_write <= write && state == IDLE && in_table;
    row <= into_table[6+:PICK];
    column <= into_table[5:2];
    table_word <= value;
  end
  generate
    for (genvar i = 0; i < BUFFERS / 32; i++) begin : g_masks
      always_ff @(posedge clock) begin
        if (table_write && column == 4'(2 + i)) table_reads[row][32*i+:32] <= table_word;
        if (table_write && column == 4'(4 + i)) table_writes[row][32*i+:32] <= table_word;
        if (table_write && column == 4'(6 + i)) table_stales[row][32*i+:32] <= table_word;
      end
    end
  endgenerate
  always_ff @(posedge clock) begin
    if (table_write && column == 4'd0) table_module[row] <= table_word[2:0];
    if (table_write && column == 4'd1) table_start[row] <= table_word[CODE_BITS-1:0];
  end

  // The frame and its announcement.
  logic [31:0] module_id, segment, sequence_id, next_sequence;
  logic [7:0] completed_segment, completed_sequence;
  logic [BUFFERS-1:0] valid, written, reads, writes, stales;
  logic [31:0] announced;
  logic [2:0] announced_module;
  logic announced_exists, unreadable, is_publish, is_entry, wrong_module, wrong_sequence;
  // The announced segment's row of the table, registered: it is there in the cycle after the announcement, and what
  // its module and its buffers say a cycle later, when the command may come. The operation control of an attempt looks
  // its row up at once.
  logic row_exists, row_unreadable;
  logic [CODE_BITS-1:0] row_start;
  logic [BUFFERS-1:0] row_reads, row_writes, row_stales, now_reads;
  logic [PICK-1:0] now;
  assign announced = (write && address == SEGMENT) ? value : segment;
  always_ff @(posedge clock) begin
    row_exists <= announced < 32'(SEGMENTS) && exists[announced[PICK-1:0]];
    announced_module <= table_module[announced[PICK-1:0]];
    row_start <= table_start[announced[PICK-1:0]];
    row_reads <= table_reads[announced[PICK-1:0]];
    row_writes <= table_writes[announced[PICK-1:0]];
    row_stales <= table_stales[announced[PICK-1:0]];
    row_unreadable <= (row_reads & ~(valid | (row_writes & written))) != '0;
    wrong_module <= 32'(announced_module) != module_id;
    is_publish <= module_id == 32'd0;
    is_entry <= segment < 32'(INSTRUCTIONS) && entries[entry];
    if (write && address == SEQUENCE) wrong_sequence <= value != next_sequence;
  end
  assign now = run_segment[PICK-1:0];
  assign now_reads = table_reads[now];
  assign running = resident ? run_segment : segment[7:0];
  assign announced_exists = resident ? 32'(run_segment) < 32'(SEGMENTS) && exists[now] : row_exists;
  assign reads = resident ? now_reads : row_reads;
  assign writes = resident ? table_writes[now] : row_writes;
  assign stales = resident ? table_stales[now] : row_stales;
  assign start_address = resident ? table_start[now] : row_start;
  assign unreadable = resident ? (now_reads & ~(valid | (writes & written))) != '0 : row_unreadable;

  // The fault of this access, if any: first its register, then its order.
  logic [3:0] refusal, frame_fault, found;
  logic frame_address;
  assign frame_address = address == MODULE || address == SEGMENT || address == SEQUENCE || address == CONTROL;
  always_comb begin
    if (value != START && value != PUBLISH && !(RESIDENT != 0 && value == ATTEMPT)) frame_fault = INVALID_ACCESS;
    else if (wrong_sequence) frame_fault = WRONG_SEQUENCE;
    else if (RESIDENT != 0 && value == ATTEMPT) begin
      frame_fault = (is_publish && is_entry) ? NONE : WRONG_SEGMENT;
    end
    else if (!announced_exists) frame_fault = WRONG_SEGMENT;
    else if (wrong_module || is_publish != (value == PUBLISH)) frame_fault = WRONG_SEGMENT;
    else if (unreadable) frame_fault = READ_BEFORE_VALID;
    else frame_fault = NONE;
  end
  always_comb begin
    if ((in_table || in_program) && state == IDLE) refusal = NONE;
    else if (RESIDENT != 0 && address == STOP) refusal = NONE;
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
  logic run_fault;
  assign run_fault = run && (!announced_exists || unreadable);
  assign start = !wrong_parity && ((command && value == START) || (run && !run_fault));
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
      next_sequence <= 32'd1;
      resident <= 1'b0;
    end else if (state != FAULT) begin
      if (found != NONE) begin
        state <= FAULT;
        fault <= found;
      end else if (wrong_parity) begin
        state <= FAULT;
        fault <= PARITY;
      end else if (run_fault) begin
        state <= FAULT;
        fault <= announced_exists ? READ_BEFORE_VALID : WRONG_SEGMENT;
      end else if (finished) begin
        state <= DONE;
        resident <= 1'b0;
        completed_segment <= '0;
        completed_sequence <= sequence_id[7:0];
        next_sequence <= sequence_id + 32'd1;
      end else if (write && address != STOP) begin
        if (address == MODULE) module_id <= value;
        if (address == SEGMENT) segment <= value;
        if (address == SEQUENCE) sequence_id <= value;
        if (address == IRQ_ACK) state <= IDLE;
        else if (address == CONTROL) state <= (value == PUBLISH) ? IDLE : BUSY;
        else if (!in_table && !in_program) state <= state + 3'd1;
        if (launch) resident <= 1'b1;
      end else if (state == BUSY && ended && !resident) begin
        state <= DONE;
      end
      if (table_write && column == 4'd0) exists[row] <= 1'b1;
      if (start) valid <= valid & ~writes;
      if ((command && value == PUBLISH) || (state == BUSY && ended)) begin
        valid <= (valid | writes) & ~stales;
        written <= written | writes;
        if (!resident) begin
          completed_segment <= segment[7:0];
          completed_sequence <= sequence_id[7:0];
          next_sequence <= sequence_id + 32'd1;
        end
      end
    end
  end

  // Resident control: its program is written while no frame has begun; an entry is an instruction marked as one.
  generate
    if (RESIDENT != 0) begin : g_resident
      assign into_program = address - PROGRAM;
      assign in_program = address >= PROGRAM && address < PROGRAM_END && address[1:0] == 2'b00;
      always_ff @(posedge clock) begin
        if (reset) entries <= '0;
        else if (program_write && !program_address[0]) begin
          entries[program_address[$clog2(INSTRUCTIONS):1]] <= value[24];
        end
        if (reset || launch) stop <= 1'b0;
        else if (write && address == STOP) stop <= value[0];
      end
    end else begin : g_no_resident
      assign into_program = '0;
      assign in_program = 1'b0;
      assign entries = '0;
      assign stop = 1'b0;
    end
  endgenerate
  assign program_write = write && state == IDLE && in_program;
  assign program_address = into_program[2+:$clog2(INSTRUCTIONS) + 1];
  assign launch = RESIDENT != 0 && command && value == ATTEMPT;
  assign entry = segment[$clog2(INSTRUCTIONS)-1:0];
  assign halt = state == FAULT || found != NONE || wrong_parity || run_fault;

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
        ? {completed_sequence, completed_segment, 4'd0, fault, 5'd0, armed, state == DONE, state == BUSY} : flags;
  end
endmodule
