// Cycles from operands at a unit's inputs to the result at its output. They are defined only here:
// the RTL includes this file, and the schedulers and the hardware model read it (lines `localparam int NAME = N;`).
// Add and multiply take new operands every cycle; division and square root hold their unit for all of their cycles.
localparam int F64_ADD_CYCLES = 6;
localparam int F64_MUL_CYCLES = 7;
localparam int F64_DIV_CYCLES = 32;
localparam int F64_SQRT_CYCLES = 32;
localparam int F32_ADD_CYCLES = 6;
localparam int F32_MUL_CYCLES = 7;
localparam int F32_DIV_CYCLES = 17;
localparam int F32_SQRT_CYCLES = 17;
