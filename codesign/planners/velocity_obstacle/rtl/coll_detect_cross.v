// Equation 4 over one multiplier, by the cross product: (r × V)² < R²|V|². A product a cycle, summed up in the next.
//
//     step      0      1      2      3      4      5      6      7      8         9        10
//     product   rx rx  ry ry  rx vx  ry vy  rx vy  ry vx  vx vx  vy vy  (r × V)²  R²|V|²
//     sum                     |r|²          r·V           r × V         |V|²               compare
//
// Steps 0 and 1 are only for RANGED, 2 and 3 only for APPROACHING.
module coll_detect_cross #(
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
    localparam [3:0] SIGN = APPROACHING != 0 ? 4'd2 : 4'd4;
    localparam [3:0] FIRST = RANGED != 0 ? 4'd0 : SIGN;

    reg [3:0] step;
    always @(posedge clk) begin
        if (reset || done) step <= FIRST;
        else if (go || !idle) step <= step == 4'd1 ? SIGN : step + 4'd1;
    end
    assign idle = step == FIRST;
    assign done = step == 4'd10;

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
    wire signed [WIDTH+HALF:0] first_vx = FIRST == 4'd2 && idle ? vx : held_vx;
    wire signed [WIDTH+HALF:0] first_vy = FIRST == 4'd4 && idle ? vy : held_vy;
    wire signed [FACTOR-1:0] wide_rx = {{(FACTOR - WIDTH - 1) {first_rx[WIDTH]}}, first_rx};
    wire signed [FACTOR-1:0] wide_ry = {{(FACTOR - WIDTH - 1) {held_ry[WIDTH]}}, held_ry};
    wire signed [FACTOR-1:0] wide_vx = {{(FACTOR - WIDTH - HALF - 1) {first_vx[WIDTH+HALF]}}, first_vx};
    wire signed [FACTOR-1:0] wide_vy = {{(FACTOR - WIDTH - HALF - 1) {first_vy[WIDTH+HALF]}}, first_vy};

    // The product of this cycle.
    reg signed [FACTOR-1:0] crossed, vab_sq;
    reg signed [FACTOR-1:0] first, second;
    always @* begin
        case (step)
            4'd0, 4'd2, 4'd4: first = wide_rx;
            4'd1, 4'd3, 4'd5: first = wide_ry;
            4'd6: first = wide_vx;
            4'd7: first = wide_vy;
            4'd8: first = crossed;
            default: first = RADIUS_SQUARED;
        endcase
        case (step)
            4'd0: second = wide_rx;
            4'd1: second = wide_ry;
            4'd2, 4'd5, 4'd6: second = wide_vx;
            4'd3, 4'd4, 4'd7: second = wide_vy;
            4'd8: second = crossed;
            default: second = vab_sq;
        endcase
    end
    reg signed [2*FACTOR-1:0] product;
    always @(posedge clk) product <= first * second;

    // The product of the cycle before; the one before that is in `earlier`.
    reg signed [2*FACTOR-1:0] earlier;
    wire signed [FACTOR-1:0] sum = earlier[FACTOR-1:0] + product[FACTOR-1:0];
    always @(posedge clk) begin
        earlier <= product;
        if (step == 4'd6) crossed <= earlier[FACTOR-1:0] - product[FACTOR-1:0];
        if (step == 4'd8) vab_sq <= sum;
    end
    wire near, closing;
    generate
        if (RANGED != 0) begin : ranged
            reg in_range;
            always @(posedge clk) if (step == SIGN) in_range <= sum <= RANGE_SQUARED;
            assign near = in_range;
        end else begin : everywhere
            assign near = 1'b1;
        end
        if (APPROACHING != 0) begin : approaching
            reg negative;
            always @(posedge clk) if (step == 4'd4) negative <= sum[FACTOR-1];
            assign closing = negative;
        end else begin : always_closing
            assign closing = 1'b1;
        end
    endgenerate
    assign collision = earlier < product && near && closing;
endmodule
