// Every latency and size that modules, schedulers and harness share, under one name (docs/pl-machine.md): what the two files say.
package contract;
  `include "latency.svh"
  `include "engine.svh"
endpackage
