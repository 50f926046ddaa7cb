// One read replica of the storage in CLUSTERS parts, each with its own banks and units. The low bits of an address name its
// cluster. In a cycle each cluster exports one word to units of others; timing as in replica.sv.
module read_network #(
    parameter int LANES = 4,
    parameter int DIVIDERS = 1,
    parameter int CLUSTERS = 1,
    parameter int BANKS = 16,
    parameter int ADDRESS_BITS = 14,
    parameter int WIDTH = 64,
    parameter int UNITS = LANES + DIVIDERS,
    parameter int ROW = ADDRESS_BITS - $clog2(BANKS),
    parameter int ROWS = 1 << ROW
) (
    input logic clock,
    input logic enable,
    input logic [UNITS-1:0] read,
    input logic [UNITS*ADDRESS_BITS-1:0] address,
    // The banks of the first cluster, then those of the next.
    input logic [BANKS-1:0] write,
    input logic [BANKS*ROW-1:0] write_row,
    input logic [BANKS*WIDTH-1:0] write_word,
    output logic [UNITS*WIDTH-1:0] operand,
    output logic conflict
);
  `include "engine/clusters.svh"

  generate
    if (CLUSTERS == 1) begin : g_one
      logic [WIDTH-1:0] exported;
      replica #(
          .UNITS(UNITS),
          .BANKS(BANKS),
          .ADDRESS_BITS(ADDRESS_BITS),
          .WIDTH(WIDTH),
          .ROWS(ROWS)
      ) whole (
          .clock(clock),
          .enable(enable),
          .read(read),
          .address(address),
          .imported('0),
          .write(write),
          .write_row(write_row),
          .write_word(write_word),
          .operand(operand),
          .exported(exported),
          .conflict(conflict)
      );
    end else begin : g_clusters
      localparam int A = ADDRESS_BITS;
      localparam int PICK = $clog2(CLUSTERS);
      localparam int OWN = A - PICK;
      localparam int FEW = BANKS / CLUSTERS;

      // What units read in other clusters: for each cluster the OR of the addresses. A clash is an address that differs.
      logic [UNITS*CLUSTERS-1:0] local_read, remote, remote_1, remote_2, remote_3;
      logic [CLUSTERS-1:0] export_read;
      logic [CLUSTERS*OWN-1:0] export_address;
      logic clash, hit;
      always_comb begin
        export_read = '0;
        export_address = '0;
        clash = 1'b0;
        hit = 1'b0;
        for (int u = 0; u < UNITS; u++) begin
          for (int s = 0; s < CLUSTERS; s++) begin
            hit = read[u] && address[u*A+:PICK] == PICK'(s);
            local_read[u*CLUSTERS+s] = hit && cluster_of(u) == s;
            remote[u*CLUSTERS+s] = hit && cluster_of(u) != s;
            export_read[s] = export_read[s] || remote[u*CLUSTERS+s];
            export_address[s*OWN+:OWN] =
                export_address[s*OWN+:OWN] | ({OWN{remote[u*CLUSTERS+s]}} & address[u*A+PICK+:OWN]);
          end
        end
        for (int u = 0; u < UNITS; u++) begin
          for (int s = 0; s < CLUSTERS; s++) begin
            if (remote[u*CLUSTERS+s] && export_address[s*OWN+:OWN] != address[u*A+PICK+:OWN]) clash = 1'b1;
          end
        end
      end
      always_ff @(posedge clock) begin
        if (enable) begin
          remote_1 <= remote;
          remote_2 <= remote_1;
          remote_3 <= remote_2;
        end
      end

      logic [CLUSTERS*WIDTH-1:0] exported;
      logic [UNITS*WIDTH-1:0] imported;
      always_comb begin
        imported = '0;
        for (int u = 0; u < UNITS; u++) begin
          for (int s = 0; s < CLUSTERS; s++) begin
            imported[u*WIDTH+:WIDTH] =
                imported[u*WIDTH+:WIDTH] | ({WIDTH{remote_3[u*CLUSTERS+s]}} & exported[s*WIDTH+:WIDTH]);
          end
        end
      end

      logic [CLUSTERS-1:0] conflicts;
      for (genvar s = 0; s < CLUSTERS; s++) begin : g_cluster
        logic [PORTS-1:0] own_read;
        logic [PORTS*OWN-1:0] own_address;
        logic [PORTS*WIDTH-1:0] own_imported, own_operand;
        for (genvar j = 0; j < PORTS; j++) begin : g_port
          localparam int U = unit_at(s, j);
          if (U < UNITS) begin : g_unit
            assign own_read[j] = local_read[U*CLUSTERS+s];
            assign own_address[j*OWN+:OWN] = address[U*A+PICK+:OWN];
            assign own_imported[j*WIDTH+:WIDTH] = imported[U*WIDTH+:WIDTH];
            assign operand[U*WIDTH+:WIDTH] = own_operand[j*WIDTH+:WIDTH];
          end else begin : g_unused
            assign own_read[j] = 1'b0;
            assign own_address[j*OWN+:OWN] = '0;
            assign own_imported[j*WIDTH+:WIDTH] = '0;
          end
        end
        replica #(
            .UNITS(PORTS),
            .BANKS(FEW),
            .ADDRESS_BITS(OWN),
            .WIDTH(WIDTH),
            .EXPORT(1),
            .ROWS(ROWS)
        ) part (
            .clock(clock),
            .enable(enable),
            .read({export_read[s], own_read}),
            .address({export_address[s*OWN+:OWN], own_address}),
            .imported(own_imported),
            .write(write[s*FEW+:FEW]),
            .write_row(write_row[s*FEW*ROW+:FEW*ROW]),
            .write_word(write_word[s*FEW*WIDTH+:FEW*WIDTH]),
            .operand(own_operand),
            .exported(exported[s*WIDTH+:WIDTH]),
            .conflict(conflicts[s])
        );
      end
      assign conflict = (enable && clash) || conflicts != '0;
    end
  endgenerate
endmodule
