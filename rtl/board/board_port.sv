// An access of the core as one transfer of an AXI master: address and data each until they are taken, then the answer. `wanted`
// and what comes with it stay until `done`.
module board_port (
    input logic clock,
    input logic reset,
    input logic wanted,
    input logic write,
    output logic done,
    output logic refused,
    output logic awvalid,
    input logic awready,
    output logic wvalid,
    input logic wready,
    input logic bvalid,
    output logic bready,
    input logic [1:0] bresp,
    output logic arvalid,
    input logic arready,
    input logic rvalid,
    output logic rready,
    input logic [1:0] rresp
);
  logic address_taken, data_taken;
  assign awvalid = wanted && write && !address_taken;
  assign wvalid = wanted && write && !data_taken;
  assign arvalid = wanted && !write && !address_taken;
  assign bready = 1'b1;
  assign rready = 1'b1;
  assign done = wanted && (write ? bvalid : rvalid);
  assign refused = done && (write ? bresp[1] : rresp[1]);

  always_ff @(posedge clock) begin
    if (reset || done) begin
      address_taken <= 1'b0;
      data_taken <= 1'b0;
    end else begin
      if ((awvalid && awready) || (arvalid && arready)) address_taken <= 1'b1;
      if (wvalid && wready) data_taken <= 1'b1;
    end
  end
endmodule
