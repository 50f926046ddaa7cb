// From the AXI4-Lite slave to the register bus: each write and each read reaches it once, from registers, one at a time.
// Eight registers are the wrapper's own. Between accesses the bus stays at STATUS, which has no effect and shows whether the
// engine runs; a write waits until the memories are quiet, and the memories until it is done and the engine's state known.
module axi_registers #(
    parameter logic [31:0] ENGINE_WORD = 32'd0,
    parameter logic [31:0] SIZES_WORD = 32'd0,
    parameter logic [31:0] IDENTITY_WORD = 32'd0,
    parameter logic [31:0] WORDS_WORD = 32'd0,  // 0: there is no such register
    parameter int STREAM = 0  // ports of streamed microcode
) (
    input logic clock,
    input logic reset,
    input logic write_wanted,
    input logic [15:0] write_address,
    input logic [31:0] write_value,
    output logic write_done,
    input logic read_wanted,
    input logic [15:0] read_address,
    output logic [31:0] read_value,
    output logic read_done,
    // The engine.
    output logic engine_reset,
    output logic bus_write,
    output logic bus_read,
    output logic [15:0] bus_address,
    output logic [31:0] bus_value,
    input logic [31:0] bus_answer,
    input logic irq,
    input logic busy,
    input logic [31:0] cycles,
    input logic [31:0] digest,
    output logic clear_digest,
    input logic stream_failed,
    output logic base_write,  // where a port's lines lie
    output logic [1:0] base_port,
    // The memories: no access is under way; they may be accessed in this cycle; the engine runs, and takes none.
    input logic quiet,
    output logic open,
    output logic running
);
  localparam logic [15:0] STATUS = 16'h0010;
  localparam logic [15:0] RESET = 16'h3000;
  localparam logic [15:0] ENGINE = 16'h3004;
  localparam logic [15:0] SIZES = 16'h3008;
  localparam logic [15:0] CYCLES = 16'h300C;
  localparam logic [15:0] IDENTITY = 16'h3010;
  localparam logic [15:0] DIGEST = 16'h3014;
  localparam logic [15:0] LIMIT = 16'h3018;
  localparam logic [15:0] SPENT = 16'h301C;
  localparam logic [15:0] STREAM_BASE = 16'h3020;
  localparam logic [15:0] WORDS = 16'h3030;
  localparam logic [3:0] CYCLE_LIMIT = 4'd9;
  localparam logic [3:0] STREAM_ERROR = 4'd11;

  logic resetting, reading, own, idle, known, last_write, take_write, take_read, own_address, reset_address, kept_address;
  logic restart, over, hold, tell, stopped, stopped_broken, base_address;
  logic [31:0] own_value, limit, spent;
  assign idle = !bus_write && !bus_read && !reading && !resetting && !engine_reset && !over;
  assign open = idle && known && !write_wanted;
  assign take_write = idle && write_wanted && quiet && !(read_wanted && last_write);
  assign take_read = idle && read_wanted && !take_write;
  assign reset_address = write_address == RESET;
  assign base_address = STREAM != 0 && write_address[15:4] == STREAM_BASE[15:4];
  assign kept_address = reset_address || write_address == DIGEST || write_address == LIMIT || base_address;
  assign restart = take_write && reset_address && write_value[0];
  assign clear_digest = take_write && write_address == DIGEST;
  assign base_write = take_write && base_address;
  assign base_port = write_address[3:2];
  assign own_address = read_address == ENGINE || read_address == SIZES || read_address == CYCLES
      || read_address == IDENTITY || read_address == DIGEST || read_address == LIMIT || read_address == SPENT
      || (WORDS_WORD != '0 && read_address == WORDS);
  assign write_done = take_write;
  assign read_done = reading;
  always_comb begin
    read_value = own ? own_value : bus_answer;
    if (stopped && !own && bus_address == STATUS) read_value[11:8] = stopped_broken ? STREAM_ERROR : CYCLE_LIMIT;
  end

  axi_limit launch_limit (
      .clock(clock),
      .reset(reset),
      .set(take_write && write_address == LIMIT),
      .value(write_value),
      .restart(restart),
      .limit(limit),
      .spent(spent),
      .is_status(bus_address == STATUS),
      .status_busy(bus_answer[0]),
      .irq(irq),
      .engine_reset(engine_reset),
      .broken(stream_failed),
      .over(over),
      .hold(hold),
      .tell(tell),
      .stopped(stopped),
      .stopped_broken(stopped_broken)
  );

  always_ff @(posedge clock) begin
    if (reset) begin
      engine_reset <= 1'b1;
      resetting <= 1'b0;
      bus_write <= 1'b0;
      bus_read <= 1'b0;
      reading <= 1'b0;
      known <= 1'b0;
      last_write <= 1'b0;
    end else begin
      resetting <= restart;
      engine_reset <= resetting || restart || hold;
      bus_write <= take_write && !kept_address;
      bus_read <= (take_read && !own_address) || tell;
      reading <= take_read;
      known <= idle;
      if (take_write || take_read) last_write <= take_write;
    end
    // STATUS wherever the engine takes no access, also in the clock after one to the wrapper's own.
    bus_address <= (take_write && !kept_address) ? write_address : (take_read && !own_address) ? read_address : tell ? LIMIT : STATUS;
    bus_value <= write_value;
    own <= own_address;
    case (read_address)
      ENGINE: own_value <= ENGINE_WORD;
      SIZES: own_value <= SIZES_WORD;
      IDENTITY: own_value <= IDENTITY_WORD;
      DIGEST: own_value <= digest;
      LIMIT: own_value <= limit;
      SPENT: own_value <= spent;
      default: own_value <= cycles;
    endcase
    if (WORDS_WORD != '0 && read_address == WORDS) own_value <= WORDS_WORD;
    if (idle) running <= bus_answer[0] || busy;
  end
endmodule
