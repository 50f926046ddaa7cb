// Moves words between memory (through the core's coherent port) and the engine's memories, by a list of descriptors in memory:
//   word 0: bits 0-31 address in memory, 32-63 address at the engine
//   word 1: bits 0-31 beats of 64 bits, bit 32: 1 from the engine to memory
// Bursts have at most 16 beats and cross no boundary of 128 bytes. A burst is read whole before it is written; the next is read
// meanwhile. An error on a bus ends the list.
module soc_dma (
    input logic clock,
    input logic reset,
    input logic [31:0] first,
    input logic [15:0] count,
    input logic start,
    input logic clear,
    output logic busy,
    output logic refused,
    output logic irq,
    soc_axi.master memory,
    soc_axi.master engine
);
  localparam int BURST = 16, ROOM = 2 * BURST;
  typedef enum logic [2:0] {
    IDLE,
    ASK,
    TAKE,
    MOVE
  } state_t;
  state_t state;
  logic [31:0] at, source, target, to_read, to_write;
  logic [15:0] left;
  logic half, back;

  // A queue of beats between the two sides.
  logic [63:0] queue[ROOM];
  logic [5:0] held, promised;  // promised: asked for and not yet taken out
  logic [4:0] in_at, out_at;
  wire [31:0] read_room = BURST - 32'(source[6:3]), write_room = BURST - 32'(target[6:3]);
  wire [31:0] read_beats = to_read > read_room ? read_room : to_read;
  wire [31:0] write_beats = to_write > write_room ? write_room : to_write;
  logic reading, writing, sent;
  logic [4:0] write_left;
  wire moving = state == MOVE;
  wire may_read = moving && !reading && to_read != 0 && 32'(promised) + read_beats <= ROOM;
  wire may_write = moving && !writing && to_write != 0 && 32'(held) >= write_beats;

  // Channels of the two sides; `back` says which one is read.
  wire ar_ready = back ? engine.arready : memory.arready;
  wire r_valid = back ? engine.rvalid : memory.rvalid;
  wire [63:0] r_data = back ? engine.rdata : memory.rdata;
  wire [1:0] r_resp = back ? engine.rresp : memory.rresp;
  wire r_last = back ? engine.rlast : memory.rlast;
  wire aw_ready = back ? memory.awready : engine.awready;
  wire w_ready = back ? memory.wready : engine.wready;
  wire b_valid = back ? memory.bvalid : engine.bvalid;
  wire [1:0] b_resp = back ? memory.bresp : engine.bresp;
  wire put = moving && reading && r_valid;
  wire take = writing && sent && write_left != 0 && w_ready;

  assign memory.arid = '0;
  assign memory.arsize = 3'd3;
  assign memory.araddr = state == ASK ? at : source;
  assign memory.arlen = state == ASK ? 8'd1 : 8'(read_beats - 1);
  assign memory.arvalid = state == ASK || (may_read && !back);
  assign memory.rready = state == TAKE || (reading && !back);
  assign engine.arid = '0;
  assign engine.arsize = 3'd3;
  assign engine.araddr = source;
  assign engine.arlen = 8'(read_beats - 1);
  assign engine.arvalid = may_read && back;
  assign engine.rready = reading && back;

  assign memory.awid = '0;
  assign memory.awsize = 3'd3;
  assign memory.awaddr = target;
  assign memory.awlen = 8'(write_beats - 1);
  assign memory.awvalid = writing && !sent && back;
  assign memory.wvalid = writing && sent && write_left != 0 && back;
  assign memory.wdata = queue[out_at];
  assign memory.wstrb = '1;
  assign memory.wlast = write_left == 1;
  assign memory.bready = back;
  assign engine.awid = '0;
  assign engine.awsize = 3'd3;
  assign engine.awaddr = target;
  assign engine.awlen = 8'(write_beats - 1);
  assign engine.awvalid = writing && !sent && !back;
  assign engine.wvalid = writing && sent && write_left != 0 && !back;
  assign engine.wdata = queue[out_at];
  assign engine.wstrb = '1;
  assign engine.wlast = write_left == 1;
  assign engine.bready = !back;

  assign busy = state != IDLE;
  always_ff @(posedge clock) begin
    if (reset) begin
      state <= IDLE;
      reading <= 1'b0;
      writing <= 1'b0;
      refused <= 1'b0;
      irq <= 1'b0;
      held <= '0;
      promised <= '0;
      in_at <= '0;
      out_at <= '0;
    end else begin
      if (clear) begin
        refused <= 1'b0;
        irq <= 1'b0;
      end
      case (state)
        IDLE:
        if (start && count != 0) begin
          at <= first;
          left <= count;
          state <= ASK;
        end
        ASK:
        if (memory.arready) begin
          half <= 1'b0;
          state <= TAKE;
        end
        TAKE:
        if (memory.rvalid) begin
          half <= 1'b1;
          refused <= refused || memory.rresp != 0;
          if (!half) {target, source} <= memory.rdata;
          else begin
            back <= memory.rdata[32];
            if (memory.rdata[32]) {target, source} <= {source, target};
            to_read <= memory.rdata[31:0];
            to_write <= memory.rdata[31:0];
            at <= at + 32'd16;
            left <= left - 1'b1;
            state <= MOVE;
          end
        end
        default:
        if (to_write == 0 && !writing) begin
          state <= left == 0 || refused ? IDLE : ASK;
          irq <= irq || left == 0 || refused;
        end
      endcase

      if (may_read && ar_ready) begin
        reading <= 1'b1;
        source <= source + 8 * read_beats;
        to_read <= to_read - read_beats;
      end
      if (put) begin
        queue[in_at] <= r_data;
        in_at <= in_at + 1'b1;
        if (r_resp != 0) refused <= 1'b1;
        if (r_last) reading <= 1'b0;
      end
      if (may_write) begin
        writing <= 1'b1;
        sent <= 1'b0;
        write_left <= 5'(write_beats);
      end
      if (writing && !sent && aw_ready) sent <= 1'b1;
      if (take) begin
        out_at <= out_at + 1'b1;
        write_left <= write_left - 1'b1;
      end
      if (writing && b_valid) begin
        writing <= 1'b0;
        target <= target + 8 * write_beats;
        to_write <= to_write - write_beats;
        if (b_resp != 0) refused <= 1'b1;
      end
      held <= held + 6'(put) - 6'(take);
      promised <= promised + (may_read && ar_ready ? 6'(read_beats) : 6'd0) - 6'(take);
    end
  end
endmodule
