// From the units' result registers to the banks of CLUSTERS clusters. In a cycle each cluster exports one result to banks of
// others. The last unit is the PS, in the first cluster.
module write_network #(
    parameter int LANES = 4,
    parameter int DIVIDERS = 1,
    parameter int CLUSTERS = 1,
    parameter int BANKS = 16,
    parameter int ADDRESS_BITS = 14,
    parameter int WIDTH = 64,
    parameter int UNITS = LANES + DIVIDERS + 1,
    parameter int ROW = ADDRESS_BITS - $clog2(BANKS)
) (
    input logic clock,
    input logic reset,
    input logic enable,
    input logic [UNITS-1:0] valid,
    input logic [UNITS*ADDRESS_BITS-1:0] address,
    input logic [UNITS*WIDTH-1:0] word,
    // The banks of the first cluster, then those of the next.
    output logic [BANKS-1:0] write,
    output logic [BANKS*ROW-1:0] write_row,
    output logic [BANKS*WIDTH-1:0] write_word,
    output logic conflict
);
  `include "engine/clusters.svh"

  generate
    if (CLUSTERS == 1) begin : g_one
      write_crossbar #(
          .UNITS(UNITS),
          .BANKS(BANKS),
          .ADDRESS_BITS(ADDRESS_BITS),
          .WIDTH(WIDTH)
      ) whole (
          .clock(clock),
          .reset(reset),
          .enable(enable),
          .valid(valid),
          .address(address),
          .word(word),
          .write(write),
          .write_row(write_row),
          .write_word(write_word),
          .conflict(conflict)
      );
    end else begin : g_clusters
      localparam int A = ADDRESS_BITS;
      localparam int PICK = $clog2(CLUSTERS);
      localparam int OWN = A - PICK;
      localparam int FEW = BANKS / CLUSTERS;
      localparam int HOST = UNITS - 1;

      // Of each cluster the OR of the results for banks of others.
      logic [CLUSTERS-1:0] leaves;
      logic [CLUSTERS*A-1:0] leaving_address;
      logic [CLUSTERS*WIDTH-1:0] leaving_word;
      logic clash, hit;
      always_comb begin
        leaves = '0;
        leaving_address = '0;
        leaving_word = '0;
        clash = 1'b0;
        hit = 1'b0;
        for (int u = 0; u < UNITS; u++) begin
          for (int s = 0; s < CLUSTERS; s++) begin
            hit = valid[u] && s == (u == HOST ? 0 : cluster_of(u)) && address[u*A+:PICK] != PICK'(s);
            clash = clash || (hit && leaves[s]);
            leaves[s] = leaves[s] || hit;
            leaving_address[s*A+:A] = leaving_address[s*A+:A] | ({A{hit}} & address[u*A+:A]);
            leaving_word[s*WIDTH+:WIDTH] = leaving_word[s*WIDTH+:WIDTH] | ({WIDTH{hit}} & word[u*WIDTH+:WIDTH]);
          end
        end
      end

      // To a cluster's banks: its own units, the PS in the first, then what leaves the others.
      logic [CLUSTERS-1:0] conflicts;
      for (genvar s = 0; s < CLUSTERS; s++) begin : g_cluster
        localparam int OWNED = PORTS + (s == 0 ? 1 : 0);
        localparam int SOURCES = OWNED + CLUSTERS - 1;
        logic [SOURCES-1:0] source_valid;
        logic [SOURCES*OWN-1:0] source_address;
        logic [SOURCES*WIDTH-1:0] source_word;
        for (genvar j = 0; j < OWNED; j++) begin : g_port
          localparam int U = j == PORTS ? HOST : unit_at(s, j);
          if (j == PORTS || U < HOST) begin : g_unit
            assign source_valid[j] = valid[U] && address[U*A+:PICK] == PICK'(s);
            assign source_address[j*OWN+:OWN] = address[U*A+PICK+:OWN];
            assign source_word[j*WIDTH+:WIDTH] = word[U*WIDTH+:WIDTH];
          end else begin : g_unused
            assign source_valid[j] = 1'b0;
            assign source_address[j*OWN+:OWN] = '0;
            assign source_word[j*WIDTH+:WIDTH] = '0;
          end
        end
        for (genvar i = 0; i < CLUSTERS - 1; i++) begin : g_import
          localparam int FROM = i < s ? i : i + 1;
          assign source_valid[OWNED+i] = leaves[FROM] && leaving_address[FROM*A+:PICK] == PICK'(s);
          assign source_address[(OWNED+i)*OWN+:OWN] = leaving_address[FROM*A+PICK+:OWN];
          assign source_word[(OWNED+i)*WIDTH+:WIDTH] = leaving_word[FROM*WIDTH+:WIDTH];
        end
        write_crossbar #(
            .UNITS(SOURCES),
            .BANKS(FEW),
            .ADDRESS_BITS(OWN),
            .WIDTH(WIDTH)
        ) part (
            .clock(clock),
            .reset(reset),
            .enable(enable),
            .valid(source_valid),
            .address(source_address),
            .word(source_word),
            .write(write[s*FEW+:FEW]),
            .write_row(write_row[s*FEW*ROW+:FEW*ROW]),
            .write_word(write_word[s*FEW*WIDTH+:FEW*WIDTH]),
            .conflict(conflicts[s])
        );
      end
      assign conflict = (enable && clash) || conflicts != '0;
    end
  endgenerate
endmodule
