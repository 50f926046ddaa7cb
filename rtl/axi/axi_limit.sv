// A limit on the clocks of a launch, by a counter beside the engine. A launch that is busy for one clock more than `limit`, which is not
// zero, has the engine reset for two clocks, and then told an address that it does not know: so it stands in FAULT as after
// any other fault, its interrupt up, until the next reset. STATUS then gets this fault's code (axi_registers.sv). So it is
// with a launch whose microcode memory cannot give: `broken`.
module axi_limit (
    input logic clock,
    input logic reset,
    // The register, and a write to RESET.
    input logic set,
    input logic [31:0] value,
    input logic restart,
    output logic [31:0] limit,
    output logic [31:0] spent,  // clocks of the launch that runs, or ran last
    // The engine: whether its answer is STATUS, the BUSY in it, its interrupt, its reset.
    input logic is_status,
    input logic status_busy,
    input logic irq,
    input logic engine_reset,
    input logic broken,
    // No access may begin; the engine is reset; it is told.
    output logic over,
    output logic hold,
    output logic tell,
    output logic stopped,
    output logic stopped_broken
);
  logic was_busy, busy, trip, first, second;
  logic [31:0] next;
  // In the clock of an access to another register the interrupt shows an end.
  assign busy = !engine_reset && (is_status ? status_busy : was_busy && !irq);
  assign next = was_busy ? spent + 32'd1 : 32'd1;
  assign trip = over && busy;
  assign hold = trip || first;
  assign tell = second;
  always_ff @(posedge clock) begin
    if (reset) begin
      limit <= '0;
      spent <= '0;
      was_busy <= 1'b0;
      over <= 1'b0;
      first <= 1'b0;
      second <= 1'b0;
      stopped <= 1'b0;
      stopped_broken <= 1'b0;
    end else begin
      if (set) limit <= value;
      if (busy) spent <= next;
      was_busy <= busy && !trip;
      over <= busy && !trip && (broken || (limit != '0 && next >= limit));
      first <= trip;
      second <= first;
      if (restart) stopped <= 1'b0;
      else if (trip) stopped <= 1'b1;
      if (trip) stopped_broken <= broken;
    end
  end
endmodule
