// Equation 4 with a multiplier for each product: cycle 0 multiplies components, cycle 1 their sums, cycle 2 compares.
module coll_detect_parallel #(
    parameter WIDTH = 16,
    parameter CROSS_PRODUCT = 0,
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

    reg [1:0] step;
    always @(posedge clk) begin
        if (reset || done) step <= 2'd0;
        else if (go || !idle) step <= step + 2'd1;
    end
    assign idle = step == 2'd0;
    assign done = step == 2'd2;

    reg signed [FACTOR-1:0] vx_vx, vy_vy;
    always @(posedge clk) begin
        vx_vx <= vx * vx;
        vy_vy <= vy * vy;
    end
    wire signed [FACTOR-1:0] vab_sq = vx_vx + vy_vy;
    // R²|V|² is compared with |r|²|V|² - (r·V)² or, the same, with (r × V)².
    reg signed [2*FACTOR-1:0] most;
    always @(posedge clk) most <= RADIUS_SQUARED * vab_sq;
    wire signed [2*FACTOR-1:0] distance;
    wire near, closing;
    generate
        if (CROSS_PRODUCT == 0 || RANGED != 0) begin : squares
            reg signed [FACTOR-1:0] rx_rx, ry_ry;
            always @(posedge clk) begin
                rx_rx <= rx * rx;
                ry_ry <= ry * ry;
            end
            wire signed [FACTOR-1:0] r_sq = rx_rx + ry_ry;
        end
        if (RANGED != 0) begin : ranged
            reg in_range;
            always @(posedge clk) in_range <= squares.r_sq <= RANGE_SQUARED;
            assign near = in_range;
        end else begin : everywhere
            assign near = 1'b1;
        end
        if (CROSS_PRODUCT == 0 || APPROACHING != 0) begin : dot
            reg signed [FACTOR-1:0] rx_vx, ry_vy;
            always @(posedge clk) begin
                rx_vx <= rx * vx;
                ry_vy <= ry * vy;
            end
            wire signed [FACTOR-1:0] dotp = rx_vx + ry_vy;
        end
        if (APPROACHING != 0) begin : approaching
            reg negative;
            always @(posedge clk) negative <= dot.dotp[FACTOR-1];
            assign closing = negative;
        end else begin : always_closing
            assign closing = 1'b1;
        end
        if (CROSS_PRODUCT != 0) begin : cross_product
            reg signed [FACTOR-1:0] rx_vy, ry_vx;
            always @(posedge clk) begin
                rx_vy <= rx * vy;
                ry_vx <= ry * vx;
            end
            wire signed [FACTOR-1:0] crossed = rx_vy - ry_vx;
            reg signed [2*FACTOR-1:0] cross_cross;
            always @(posedge clk) cross_cross <= crossed * crossed;
            assign distance = cross_cross;
        end else begin : published
            reg signed [2*FACTOR-1:0] r_sq_vab_sq, dotp_dotp;
            always @(posedge clk) begin
                r_sq_vab_sq <= squares.r_sq * vab_sq;
                dotp_dotp <= dot.dotp * dot.dotp;
            end
            assign distance = r_sq_vab_sq - dotp_dotp;
        end
    endgenerate
    assign collision = distance < most && near && closing;
endmodule
