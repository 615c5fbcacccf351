// Whether the robot has arrived (section III, target check): |target - r|² ≤ tolerance². Three cycles, two products.
//
// For the selector, the direction to the target is mirrored into the first octant: `along` ≥ `across` ≥ 0.
module target_check #(
    parameter WIDTH = 16,
    parameter [31:0] TOLERANCE = 1
) (
    input  wire                      clk,
    input  wire                      y_axis,
    input  wire signed [WIDTH-1:0]   target_x,
    input  wire signed [WIDTH-1:0]   target_y,
    input  wire signed [WIDTH-1:0]   x,
    input  wire signed [WIDTH-1:0]   y,
    input  wire                      active,
    output wire signed [WIDTH:0]     factor,
    input  wire signed [2*WIDTH+1:0] product,
    output wire                      in_range,
    output wire signed [WIDTH:0]     along,
    output wire signed [WIDTH:0]     across,
    output reg                       mirror_diagonal,
    output reg                       mirror_x,
    output reg                       mirror_y
);
    localparam SQUARE = 2 * WIDTH + 2;
    function [SQUARE-1:0] squared(input [31:0] value);
        reg [SQUARE+31:0] top_unused;
        begin
            top_unused = {{(SQUARE) {1'b0}}, value};
            squared = top_unused[SQUARE-1:0] * top_unused[SQUARE-1:0];
        end
    endfunction
    localparam [SQUARE-1:0] TOLERANCE_SQUARED = squared(TOLERANCE);

    // Cycle 0 multiplies dx dx, cycle 1 dy dy (`y_axis`), cycle 2 compares.
    wire signed [WIDTH:0] dx = {target_x[WIDTH-1], target_x} - {x[WIDTH-1], x};
    wire signed [WIDTH:0] dy = {target_y[WIDTH-1], target_y} - {y[WIDTH-1], y};
    assign factor = y_axis ? dy : dx;
    reg [2*WIDTH+1:0] square_x;
    assign in_range = square_x + product <= TOLERANCE_SQUARED;

    reg signed [WIDTH:0] size_x, size_y;
    always @(posedge clk) if (active) begin
        square_x <= product;
        size_x <= dx[WIDTH] ? -dx : dx;
        size_y <= dy[WIDTH] ? -dy : dy;
        mirror_x <= dx[WIDTH];
        mirror_y <= dy[WIDTH];
        mirror_diagonal <= size_y > size_x;
    end
    assign along = mirror_diagonal ? size_y : size_x;
    assign across = mirror_diagonal ? size_x : size_y;
endmodule
