// Operation codes of lanes and dividers, and which operands each one reads (docs/pl-machine.md, Operations).
localparam logic [3:0] OP_NOP = 4'd0;
localparam logic [3:0] OP_MOVE = 4'd1;
localparam logic [3:0] OP_NEG = 4'd2;
localparam logic [3:0] OP_ABS = 4'd3;
localparam logic [3:0] OP_MUL = 4'd4;
localparam logic [3:0] OP_ADD = 4'd5;
localparam logic [3:0] OP_SUB = 4'd6;
localparam logic [3:0] OP_ADD_MUL = 4'd7;
localparam logic [3:0] OP_SUB_MUL = 4'd8;
localparam logic [3:0] OP_MIN = 4'd9;
localparam logic [3:0] OP_MAX = 4'd10;
localparam logic [3:0] OP_COMPARE = 4'd11;
localparam logic [3:0] OP_AND = 4'd12;
localparam logic [3:0] OP_SELECT = 4'd13;

localparam logic [1:0] DIVIDER_NOP = 2'd0;
localparam logic [1:0] DIVIDER_DIV = 2'd1;
localparam logic [1:0] DIVIDER_SQRT = 2'd2;

function automatic logic reads_b(input logic [3:0] code);
  reads_b = code == OP_MUL || (code >= OP_ADD_MUL && code <= OP_SELECT);
endfunction

function automatic logic reads_c(input logic [3:0] code);
  reads_c = (code >= OP_ADD && code <= OP_SUB_MUL) || code == OP_SELECT;
endfunction

function automatic logic is_product(input logic [3:0] code);  // goes through the multiplier
  is_product = code == OP_MUL || code == OP_ADD_MUL || code == OP_SUB_MUL;
endfunction

function automatic logic is_sum(input logic [3:0] code);  // goes through the adder
  is_sum = code >= OP_ADD && code <= OP_SUB_MUL;
endfunction
