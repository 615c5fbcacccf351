// Whether a step of the greatest acceleration reaches a velocity, and with which acceleration (section III):
//
//     |v_c - v|² ≤ (a_max t)²        a = (v_c - v) / t
//
// Three cycles for the comparison, and two more for the acceleration of a candidate that passes.
module acceleration_check #(
    parameter WIDTH = 16,
    parameter [31:0] CHANGE = 1,
    parameter [31:0] INVERSE_STEP = 1,
    parameter CHANGE_INVERSE_STEP_SHIFT = 16
) (
    input  wire                      clk,
    input  wire                      active,
    input  wire [2:0]                step,
    input  wire signed [WIDTH-1:0]   candidate_x,
    input  wire signed [WIDTH-1:0]   candidate_y,
    input  wire signed [WIDTH-1:0]   vx,
    input  wire signed [WIDTH-1:0]   vy,
    output wire signed [WIDTH:0]     first,
    output wire signed [WIDTH:0]     second,
    input  wire signed [2*WIDTH+1:0] product,
    output wire                      reached,
    output reg  signed [WIDTH-1:0]   acceleration_x,
    output reg  signed [WIDTH-1:0]   acceleration_y
);
    localparam SQUARE = 2 * WIDTH + 5;
    function [SQUARE-1:0] squared(input [31:0] value);
        reg [SQUARE+31:0] top_unused;
        begin
            top_unused = {{(SQUARE) {1'b0}}, value};
            squared = top_unused[SQUARE-1:0] * top_unused[SQUARE-1:0];
        end
    endfunction
    localparam [SQUARE-1:0] CHANGE_SQUARED = squared(CHANGE);
    localparam signed [WIDTH:0] INVERSE = INVERSE_STEP[WIDTH:0];

    // Steps 0, 1: cx cx, cy cy. Steps 2, 3: cx / t, cy / t.
    wire signed [WIDTH:0] cx = {candidate_x[WIDTH-1], candidate_x} - {vx[WIDTH-1], vx};
    wire signed [WIDTH:0] cy = {candidate_y[WIDTH-1], candidate_y} - {vy[WIDTH-1], vy};
    assign first = step[0] ? cy : cx;
    assign second = step[1] ? INVERSE : first;

    wire signed [WIDTH-1:0] rescaled;
    rescale #(.IN(2 * WIDTH + 2), .SHIFT(CHANGE_INVERSE_STEP_SHIFT), .OUT(WIDTH)) rescale_change (product, rescaled);
    reg [2*WIDTH+1:0] square_x;
    always @(posedge clk) if (active) begin
        square_x <= product;
        if (step == 3'd3) acceleration_x <= rescaled;
        if (step == 3'd4) acceleration_y <= rescaled;
    end
    wire [2*WIDTH+1:0] square = square_x + product;
    assign reached = {3'b000, square} <= CHANGE_SQUARED;
endmodule
