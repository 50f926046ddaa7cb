// Latencies and sizes that modules, schedulers and harness share (docs/pl-machine.md), from the two parameter files.
package contract;
  `include "latency.svh"
  `include "engine.svh"
endpackage
