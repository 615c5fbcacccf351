// One pair of robots (section III, module coll_detect): whether it is on a collision course (equation 4),
//
//     |r|² |V|² - (r·V)² < R² |V|²       r, V: position and velocity of one robot relative to the other
//
// By Lagrange's identity the left side is (r × V)²: CROSS_PRODUCT = 1 forms that, with three products less.
// APPROACHING = 1: and r·V < 0. RANGED = 1: and |r|² is at most RANGE². HALF = 1: V is formed of 2v' - v of the own
// robot (reciprocal velocity obstacles), one bit more.
//
// PARALLEL = 0: one multiplier, a product a cycle and a cycle to compare: 10 cycles, 7 for the cross product, and 2
// more each for its sign r·V and for its range. PARALLEL = 1: all products at once, 3 cycles.
//
// A run begins in the first cycle with `go`, which takes the operands. `collision` is valid with `done`, in its last.
module coll_detect #(
    parameter WIDTH = 16,
    parameter PARALLEL = 0,
    parameter CROSS_PRODUCT = 0,
    parameter APPROACHING = 0,
    parameter RANGED = 0,
    parameter HALF = 0,
    parameter [31:0] RADIUS = 1,
    parameter [31:0] RANGE = 1
) (
    input  wire                         clk,
    input  wire                         reset,
    input  wire                         go,
    input  wire signed [WIDTH-1:0]      own_x,
    input  wire signed [WIDTH-1:0]      own_y,
    input  wire signed [WIDTH+HALF:0]   own_vx,
    input  wire signed [WIDTH+HALF:0]   own_vy,
    input  wire signed [WIDTH-1:0]      other_x,
    input  wire signed [WIDTH-1:0]      other_y,
    input  wire signed [WIDTH-1:0]      other_vx,
    input  wire signed [WIDTH-1:0]      other_vy,
    output wire                         idle,
    output wire                         done,
    output wire                         collision
);
    // Relative position r and velocity V.
    wire signed [WIDTH:0] rx = {own_x[WIDTH-1], own_x} - {other_x[WIDTH-1], other_x};
    wire signed [WIDTH:0] ry = {own_y[WIDTH-1], own_y} - {other_y[WIDTH-1], other_y};
    wire signed [WIDTH+HALF:0] vx = own_vx - {{(HALF + 1) {other_vx[WIDTH-1]}}, other_vx};
    wire signed [WIDTH+HALF:0] vy = own_vy - {{(HALF + 1) {other_vy[WIDTH-1]}}, other_vy};

    generate
        if (PARALLEL != 0) begin : parallel
            coll_detect_parallel #(
                .WIDTH(WIDTH), .CROSS_PRODUCT(CROSS_PRODUCT), .APPROACHING(APPROACHING), .RANGED(RANGED),
                .HALF(HALF), .RADIUS(RADIUS), .RANGE(RANGE)
            ) unit (
                .clk(clk), .reset(reset), .go(go), .rx(rx), .ry(ry), .vx(vx), .vy(vy),
                .idle(idle), .done(done), .collision(collision)
            );
        end else if (CROSS_PRODUCT != 0) begin : cross_product
            coll_detect_cross #(
                .WIDTH(WIDTH), .APPROACHING(APPROACHING), .RANGED(RANGED),
                .HALF(HALF), .RADIUS(RADIUS), .RANGE(RANGE)
            ) unit (
                .clk(clk), .reset(reset), .go(go), .rx(rx), .ry(ry), .vx(vx), .vy(vy),
                .idle(idle), .done(done), .collision(collision)
            );
        end else begin : published
            coll_detect_serial #(
                .WIDTH(WIDTH), .APPROACHING(APPROACHING), .RANGED(RANGED),
                .HALF(HALF), .RADIUS(RADIUS), .RANGE(RANGE)
            ) unit (
                .clk(clk), .reset(reset), .go(go), .rx(rx), .ry(ry), .vx(vx), .vy(vy),
                .idle(idle), .done(done), .collision(collision)
            );
        end
    endgenerate
endmodule
