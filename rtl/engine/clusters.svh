// Which cluster a unit belongs to: the lanes in equal runs, the dividers in turn. The ports of a cluster are its lanes, then
// its dividers; one without a divider in the last turn has a port that nothing uses.
localparam int EACH = LANES / CLUSTERS;
localparam int PORTS = EACH + (DIVIDERS + CLUSTERS - 1) / CLUSTERS;

function automatic integer cluster_of(input integer unit);
  cluster_of = unit < LANES ? unit / EACH : (unit - LANES) % CLUSTERS;
endfunction

function automatic integer unit_at(input integer cluster, input integer port);
  unit_at = port < EACH ? cluster * EACH + port : LANES + cluster + (port - EACH) * CLUSTERS;
endfunction
