// An AXI4 slave that turns bursts into accesses of one word: one burst of each direction at a time, in order. A read's first beat
// comes `latency` clocks after its address, a write's answer as long after its last beat; beats follow one a clock. What
// `write_refused` and `read_refused` mark is answered DECERR.
module soc_port (
    input logic clock,
    input logic reset,
    input logic [15:0] latency,
    soc_axi.slave bus,
    output logic write,
    output logic [31:0] write_address,
    output logic [63:0] write_word,
    output logic [7:0] write_bytes,
    input logic write_refused,
    output logic [31:0] read_address,
    input logic [63:0] read_word,
    input logic read_refused
);
  localparam logic [1:0] OKAY = 2'd0, DECERR = 2'd3;
  typedef enum logic [1:0] {
    IDLE,
    BEATS,
    ANSWER
  } state_t;

  state_t writing;
  logic [7:0] write_left;
  logic [15:0] write_wait;
  logic [2:0] write_size;
  logic refused;
  assign bus.awready = writing == IDLE;
  assign bus.wready = writing == BEATS;
  assign bus.bvalid = writing == ANSWER && write_wait == 0;
  assign bus.bresp = refused ? DECERR : OKAY;
  assign write = bus.wvalid && bus.wready;
  assign write_word = bus.wdata;
  assign write_bytes = bus.wstrb;
  always_ff @(posedge clock) begin
    if (reset) writing <= IDLE;
    else
      case (writing)
        IDLE:
        if (bus.awvalid) begin
          writing <= BEATS;
          bus.bid <= bus.awid;
          write_address <= bus.awaddr;
          write_left <= bus.awlen;
          write_size <= bus.awsize;
          refused <= 1'b0;
        end
        BEATS:
        if (bus.wvalid) begin
          write_address <= write_address + (32'd1 << write_size);
          write_left <= write_left - 1'b1;
          refused <= refused || write_refused;
          if (write_left == 0) begin
            writing <= ANSWER;
            write_wait <= latency;
          end
        end
        default:
        if (write_wait != 0) write_wait <= write_wait - 1'b1;
        else if (bus.bready) writing <= IDLE;
      endcase
  end

  logic reading;
  logic [7:0] read_left;
  logic [15:0] read_wait;
  logic [2:0] read_size;
  assign bus.arready = !reading;
  assign bus.rvalid = reading && read_wait == 0;
  assign bus.rdata = read_word;
  assign bus.rresp = read_refused ? DECERR : OKAY;
  assign bus.rlast = read_left == 0;
  always_ff @(posedge clock) begin
    if (reset) reading <= 1'b0;
    else if (!reading) begin
      reading <= bus.arvalid;
      bus.rid <= bus.arid;
      read_address <= bus.araddr;
      read_left <= bus.arlen;
      read_size <= bus.arsize;
      read_wait <= latency;
    end else if (read_wait != 0) read_wait <= read_wait - 1'b1;
    else if (bus.rready) begin
      read_address <= read_address + (32'd1 << read_size);
      read_left <= read_left - 1'b1;
      reading <= read_left != 0;
    end
  end
endmodule
