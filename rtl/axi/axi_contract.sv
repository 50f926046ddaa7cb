// What an engine behind AXI tells of itself.
package axi_contract;
  // One number for everything of an engine that a program depends on (rust/orbsoc-hw/src/machine/identity.rs has the same):
  // FNV-1a over whole words. A word that is added goes to the end of both lists, and another version to their begin.
  function automatic logic [31:0] mixed(input logic [31:0] hash, input int word);
    mixed = (hash ^ word) * 32'd16777619;
  endfunction
  function automatic logic [31:0] identity(input int fp, input int lanes, input int dividers, input int banks,
                                           input int clusters, input int address_bits, input int rows,
                                           input int compressed);
    logic [31:0] hash;
    hash = mixed(32'h811c9dc5, 1);
    hash = mixed(hash, fp);
    hash = mixed(hash, lanes);
    hash = mixed(hash, dividers);
    hash = mixed(hash, banks);
    hash = mixed(hash, clusters);
    // Rows of a bank stand above the bits of an address, where they are fewer than those reach.
    hash = mixed(hash, address_bits | (rows == (1 << address_bits) / banks ? 0 : rows << 8));
    hash = mixed(hash, compressed);
    hash = mixed(hash, fp == 64 ? contract::F64_ADD_CYCLES : contract::F32_ADD_CYCLES);
    hash = mixed(hash, fp == 64 ? contract::F64_MUL_CYCLES : contract::F32_MUL_CYCLES);
    hash = mixed(hash, fp == 64 ? contract::F64_DIV_CYCLES : contract::F32_DIV_CYCLES);
    hash = mixed(hash, fp == 64 ? contract::F64_SQRT_CYCLES : contract::F32_SQRT_CYCLES);
    hash = mixed(hash, fp == 64 ? contract::F64_DIV_INTERVAL_CYCLES : contract::F32_DIV_INTERVAL_CYCLES);
    hash = mixed(hash, fp == 64 ? contract::F64_SQRT_INTERVAL_CYCLES : contract::F32_SQRT_INTERVAL_CYCLES);
    hash = mixed(hash, contract::SIMPLE_CYCLES);
    hash = mixed(hash, contract::READ_CYCLES);
    hash = mixed(hash, contract::WRITE_CYCLES);
    hash = mixed(hash, contract::STARTUP_CYCLES);
    hash = mixed(hash, contract::DECODE_CYCLES);
    hash = mixed(hash, contract::HEADERS_AHEAD);
    hash = mixed(hash, contract::SHORT_BITS);
    hash = mixed(hash, contract::TEMPLATE_BITS);
    hash = mixed(hash, contract::TEMPLATE_WIDTH);
    identity = hash;
  endfunction
endpackage
