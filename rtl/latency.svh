// Cycles from operands at a unit's inputs to the result at its output, and between two operations on one unit. They are
// defined only here: the RTL includes this file, and the schedulers and the hardware model read it (lines
// `localparam int NAME = N;`). Add and multiply take new operands every cycle; division and square root share a unit.
localparam int F64_ADD_CYCLES = 7;
localparam int F64_MUL_CYCLES = 8;
localparam int F64_DIV_CYCLES = 35;
localparam int F64_SQRT_CYCLES = 35;
localparam int F64_DIV_INTERVAL_CYCLES = 4;
localparam int F64_SQRT_INTERVAL_CYCLES = 4;
localparam int F32_ADD_CYCLES = 7;
localparam int F32_MUL_CYCLES = 8;
localparam int F32_DIV_CYCLES = 20;
localparam int F32_SQRT_CYCLES = 20;
localparam int F32_DIV_INTERVAL_CYCLES = 4;
localparam int F32_SQRT_INTERVAL_CYCLES = 4;
