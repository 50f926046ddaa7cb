// Datapath from the issue register to the storage: read replicas, lanes, dividers, write crossbar.
// `fields` is the issue register without its last bit, zero where nothing is issued. Without `enable` every register
// keeps its value. With PARITY a word has one bit more in the banks, even parity: made behind the write registers, checked in the
// operand registers, which are zero where nothing is read.
module datapath #(
    parameter int EXP = 11,
    parameter int MAN = 52,
    parameter int ADD = EXP == 11 ? contract::F64_ADD_CYCLES : contract::F32_ADD_CYCLES,
    parameter int MUL = EXP == 11 ? contract::F64_MUL_CYCLES : contract::F32_MUL_CYCLES,
    parameter int DIV = EXP == 11 ? contract::F64_DIV_CYCLES : contract::F32_DIV_CYCLES,
    parameter int INTERVAL = EXP == 11 ? contract::F64_DIV_INTERVAL_CYCLES : contract::F32_DIV_INTERVAL_CYCLES,
    parameter int SIMPLE = contract::SIMPLE_CYCLES,
    parameter int READ = contract::READ_CYCLES,
    parameter int LANES = 4,
    parameter int DIVIDERS = 1,
    parameter int BANKS = 16,
    parameter int CLUSTERS = 1,
    parameter int ADDRESS_BITS = 14,
    parameter int PARITY = 0,
    parameter int ROWS = (1 << ADDRESS_BITS) / BANKS,
    parameter int FIELDS = LANES * (4 * ADDRESS_BITS + 4) + DIVIDERS * (3 * ADDRESS_BITS + 2),
    parameter int UNITS = LANES + DIVIDERS,
    parameter int STAGES = READ + MUL + ADD,
    parameter int DIVIDER_STAGES = READ + DIV,
    parameter int FLIGHTS = LANES * STAGES + DIVIDERS * DIVIDER_STAGES
) (
    input logic clock,
    input logic reset,
    input logic enable,
    input logic [FIELDS-1:0] fields,
    // The PS's access to the storage while the engine is idle; read latency READ cycles.
    input logic host_read,
    input logic host_write,
    input logic [ADDRESS_BITS-1:0] host_address,
    input logic [EXP+MAN:0] host_word,
    output logic [EXP+MAN:0] host_value,
    // Destinations in flight to the result registers, and results in them.
    output logic [FLIGHTS-1:0] flight_valid,
    output logic [FLIGHTS*ADDRESS_BITS-1:0] flight_address,
    output logic [UNITS-1:0] result_valid,
    output logic [UNITS*ADDRESS_BITS-1:0] result_address,
    output logic empty,  // no destination in flight, all writes done
    output logic read_conflict,
    output logic result_conflict,
    output logic write_conflict,
    output logic divider_busy,
    output logic wrong_parity  // of an operand a cycle ago
);
  localparam int A = ADDRESS_BITS;
  localparam int W = EXP + MAN + 1;
  localparam int STORED = W + (PARITY != 0 ? 1 : 0);
  localparam int ROW = A - $clog2(BANKS);

  // Fields to ports: operand a at replica A, b at B, c at C; lanes first, then dividers, which read no c.
  logic [4*LANES-1:0] lane_op;
  logic [2*DIVIDERS-1:0] divider_op;
  logic [UNITS*4*A-1:0] address;
  logic [UNITS*4-1:0] uses;
  unpack #(
      .LANES(LANES),
      .DIVIDERS(DIVIDERS),
      .ADDRESS_BITS(A)
  ) fields_by_unit (
      .fields(fields),
      .op(lane_op),
      .divider_op(divider_op),
      .address(address),
      .uses(uses)
  );
  logic [UNITS-1:0] read_a, read_b;
  logic [LANES-1:0] read_c;
  logic [UNITS*A-1:0] address_a, address_b, destination;
  logic [LANES*A-1:0] address_c;
  generate
    for (genvar u = 0; u < UNITS; u++) begin : g_ports
      assign read_a[u] = uses[4*u] || (u == 0 && host_read);
      assign read_b[u] = uses[4*u+1];
      assign address_a[u*A+:A] = address[4*u*A+:A] | ((u == 0 && host_read) ? host_address : '0);
      assign address_b[u*A+:A] = address[(4*u+1)*A+:A];
      assign destination[u*A+:A] = address[(4*u+3)*A+:A];
      if (u < LANES) begin : g_c
        assign read_c[u] = uses[4*u+2];
        assign address_c[u*A+:A] = address[(4*u+2)*A+:A];
      end
    end
  endgenerate

  // Storage: three replicas of the same words.
  logic [BANKS-1:0] write;
  logic [BANKS*ROW-1:0] write_row;
  logic [BANKS*W-1:0] write_word;
  logic [BANKS*STORED-1:0] write_stored;
  logic [UNITS*STORED-1:0] operand_a, operand_b;
  logic [LANES*STORED-1:0] operand_c;
  logic conflict_a, conflict_b, conflict_c;
  read_network #(
      .LANES(LANES),
      .DIVIDERS(DIVIDERS),
      .CLUSTERS(CLUSTERS),
      .BANKS(BANKS),
      .ADDRESS_BITS(A),
      .WIDTH(STORED),
      .ROWS(ROWS)
  ) replica_a (
      .clock(clock),
      .enable(enable),
      .read(read_a),
      .address(address_a),
      .write(write),
      .write_row(write_row),
      .write_word(write_stored),
      .operand(operand_a),
      .conflict(conflict_a)
  );
  read_network #(
      .LANES(LANES),
      .DIVIDERS(DIVIDERS),
      .CLUSTERS(CLUSTERS),
      .BANKS(BANKS),
      .ADDRESS_BITS(A),
      .WIDTH(STORED),
      .ROWS(ROWS)
  ) replica_b (
      .clock(clock),
      .enable(enable),
      .read(read_b),
      .address(address_b),
      .write(write),
      .write_row(write_row),
      .write_word(write_stored),
      .operand(operand_b),
      .conflict(conflict_b)
  );
  read_network #(
      .LANES(LANES),
      .DIVIDERS(0),
      .CLUSTERS(CLUSTERS),
      .BANKS(BANKS),
      .ADDRESS_BITS(A),
      .WIDTH(STORED),
      .ROWS(ROWS)
  ) replica_c (
      .clock(clock),
      .enable(enable),
      .read(read_c),
      .address(address_c),
      .write(write),
      .write_row(write_row),
      .write_word(write_stored),
      .operand(operand_c),
      .conflict(conflict_c)
  );
  assign read_conflict = conflict_a || conflict_b || conflict_c;
  assign host_value = operand_a[W-1:0];
  generate
    for (genvar b = 0; b < BANKS; b++) begin : g_stored
      assign write_stored[b*STORED+:W] = write_word[b*W+:W];
      if (PARITY != 0) begin : g_parity
        assign write_stored[b*STORED+W] = ^write_word[b*W+:W];
      end
    end
    if (PARITY != 0) begin : g_parity
      logic [2*UNITS+LANES-1:0] odd;
      for (genvar u = 0; u < UNITS; u++) begin : g_unit
        assign odd[2*u+:2] = {^operand_b[u*STORED+:STORED], ^operand_a[u*STORED+:STORED]};
      end
      for (genvar l = 0; l < LANES; l++) begin : g_lane
        assign odd[2*UNITS+l] = ^operand_c[l*STORED+:STORED];
      end
      always_ff @(posedge clock) if (enable) wrong_parity <= odd != '0;
    end else begin : g_no_parity
      assign wrong_parity = 1'b0;
    end
  endgenerate

  // Units.
  logic [UNITS*W-1:0] result;
  logic [LANES-1:0] lane_conflict;
  logic [DIVIDERS-1:0] divider_conflict;
  generate
    for (genvar l = 0; l < LANES; l++) begin : g_lane
      lane #(
          .EXP(EXP),
          .MAN(MAN),
          .ADD(ADD),
          .MUL(MUL),
          .SIMPLE(SIMPLE),
          .READ(READ),
          .ADDRESS_BITS(A)
      ) unit (
          .clock(clock),
          .reset(reset),
          .enable(enable),
          .op(lane_op[4*l+:4]),
          .destination(destination[l*A+:A]),
          .a(operand_a[l*STORED+:W]),
          .b(operand_b[l*STORED+:W]),
          .c(operand_c[l*STORED+:W]),
          .result_valid(result_valid[l]),
          .result_address(result_address[l*A+:A]),
          .result(result[l*W+:W]),
          .flight_valid(flight_valid[l*STAGES+:STAGES]),
          .flight_address(flight_address[l*STAGES*A+:STAGES*A]),
          .conflict(lane_conflict[l])
      );
    end
    for (genvar d = 0; d < DIVIDERS; d++) begin : g_divider
      divider #(
          .EXP(EXP),
          .MAN(MAN),
          .CYCLES(DIV),
          .INTERVAL(INTERVAL),
          .READ(READ),
          .ADDRESS_BITS(A)
      ) unit (
          .clock(clock),
          .reset(reset),
          .enable(enable),
          .op(divider_op[2*d+:2]),
          .destination(destination[(LANES+d)*A+:A]),
          .a(operand_a[(LANES+d)*STORED+:W]),
          .b(operand_b[(LANES+d)*STORED+:W]),
          .result_valid(result_valid[LANES+d]),
          .result_address(result_address[(LANES+d)*A+:A]),
          .result(result[(LANES+d)*W+:W]),
          .flight_valid(flight_valid[LANES*STAGES+d*DIVIDER_STAGES+:DIVIDER_STAGES]),
          .flight_address(flight_address[(LANES*STAGES+d*DIVIDER_STAGES)*A+:DIVIDER_STAGES*A]),
          .conflict(divider_conflict[d])
      );
    end
  endgenerate
  assign result_conflict = lane_conflict != '0;
  assign divider_busy = divider_conflict != '0;

  // Write-back; the PS is a further unit.
  write_network #(
      .LANES(LANES),
      .DIVIDERS(DIVIDERS),
      .CLUSTERS(CLUSTERS),
      .BANKS(BANKS),
      .ADDRESS_BITS(A),
      .WIDTH(W)
  ) write_back (
      .clock(clock),
      .reset(reset),
      .enable(enable),
      .valid({host_write, result_valid}),
      .address({host_address, result_address}),
      .word({host_word, result}),
      .write(write),
      .write_row(write_row),
      .write_word(write_word),
      .conflict(write_conflict)
  );
  assign empty = flight_valid == '0 && write == '0;
endmodule
