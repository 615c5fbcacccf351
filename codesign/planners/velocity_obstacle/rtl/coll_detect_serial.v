// Equation 4 over one multiplier, with the nine products of figure 6: a product a cycle, summed up in the cycle after.
//
//     cycle     0      1      2      3      4      5      6          7       8          9
//     product   rx rx  ry ry  vx vx  vy vy  rx vx  ry vy  |r|²|V|²   (r·V)²  R²|V|²
//     sum                     |r|²          |V|²          r·V                subtract   compare
module coll_detect_serial #(
    parameter WIDTH = 16,
    parameter APPROACHING = 0,
    parameter RANGED = 0,
    parameter HALF = 0,
    parameter [31:0] RADIUS = 1,
    parameter [31:0] RANGE = 1
) (
    input  wire                       clk,
    input  wire                       reset,
    input  wire                       go,
    input  wire signed [WIDTH:0]      rx,
    input  wire signed [WIDTH:0]      ry,
    input  wire signed [WIDTH+HALF:0] vx,
    input  wire signed [WIDTH+HALF:0] vy,
    output wire                       idle,
    output wire                       done,
    output wire                       collision
);
    // |r|², |V|² and r·V, each with its sign.
    localparam FACTOR = 2 * WIDTH + 2 + HALF;
    function [FACTOR-1:0] squared(input [31:0] value);
        reg [FACTOR+31:0] top_unused;
        begin
            top_unused = {{(FACTOR) {1'b0}}, value};
            squared = top_unused[FACTOR-1:0] * top_unused[FACTOR-1:0];
        end
    endfunction
    localparam signed [FACTOR-1:0] RADIUS_SQUARED = squared(RADIUS);
    localparam signed [FACTOR-1:0] RANGE_SQUARED = squared(RANGE);
    localparam RANGED_BIT = RANGED != 0;
    localparam APPROACHING_BIT = APPROACHING != 0;

    reg [3:0] step;
    always @(posedge clk) begin
        if (reset || done) step <= 4'd0;
        else if (go || !idle) step <= step + 4'd1;
    end
    assign idle = step == 4'd0;
    assign done = step == 4'd9;

    // The operands, taken in the first cycle.
    reg signed [WIDTH:0] held_rx, held_ry;
    reg signed [WIDTH+HALF:0] held_vx, held_vy;
    always @(posedge clk) if (idle) begin
        held_rx <= rx;
        held_ry <= ry;
        held_vx <= vx;
        held_vy <= vy;
    end
    wire signed [WIDTH:0] first_rx = idle ? rx : held_rx;
    wire signed [FACTOR-1:0] wide_rx = {{(FACTOR - WIDTH - 1) {first_rx[WIDTH]}}, first_rx};
    wire signed [FACTOR-1:0] wide_ry = {{(FACTOR - WIDTH - 1) {held_ry[WIDTH]}}, held_ry};
    wire signed [FACTOR-1:0] wide_vx = {{(FACTOR - WIDTH - HALF - 1) {held_vx[WIDTH+HALF]}}, held_vx};
    wire signed [FACTOR-1:0] wide_vy = {{(FACTOR - WIDTH - HALF - 1) {held_vy[WIDTH+HALF]}}, held_vy};

    // The product of this cycle.
    reg signed [FACTOR-1:0] r_sq, vab_sq, dotp;
    reg signed [FACTOR-1:0] first, second;
    always @* begin
        case (step)
            4'd0, 4'd4: first = wide_rx;
            4'd1, 4'd5: first = wide_ry;
            4'd2: first = wide_vx;
            4'd3: first = wide_vy;
            4'd6: first = r_sq;
            4'd7: first = dotp;
            default: first = RADIUS_SQUARED;
        endcase
        case (step)
            4'd0: second = wide_rx;
            4'd1: second = wide_ry;
            4'd2, 4'd4: second = wide_vx;
            4'd3, 4'd5: second = wide_vy;
            4'd7: second = dotp;
            default: second = vab_sq;
        endcase
    end
    reg signed [2*FACTOR-1:0] product;
    always @(posedge clk) product <= first * second;

    // The product of the cycle before. The cycle before that is in `earlier`, and in the end |r|²|V|² - (r·V)².
    reg signed [2*FACTOR-1:0] earlier;
    wire signed [FACTOR-1:0] sum = earlier[FACTOR-1:0] + product[FACTOR-1:0];
    always @(posedge clk) begin
        earlier <= step == 4'd8 ? earlier - product : product;
        if (step == 4'd2) r_sq <= sum;
        if (step == 4'd4) vab_sq <= sum;
        if (step == 4'd6) dotp <= sum;
    end
    wire near = !RANGED_BIT || r_sq <= RANGE_SQUARED;
    wire closing = !APPROACHING_BIT || dotp[FACTOR-1];
    assign collision = earlier < product && near && closing;
endmodule
