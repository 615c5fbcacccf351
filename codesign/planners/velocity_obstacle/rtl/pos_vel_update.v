// One robot, one time step on (section III, module pos_vel_update), resolved in x and y:
//
//     v' = v + a t                   (equation 2a)
//     r' = r + v t + a t²/2          (equation 2b)
//
// Six products. PARALLEL = 0: one multiplier, a product a cycle and a cycle to sum up, 7 cycles. PARALLEL = 1: all at
// once, 2 cycles. ACCELERATED = 0: the robot keeps its velocity, and only the two products v t are formed.
//
// The unit that takes an acceleration has its one multiplier outside, where other modules use it between two trials:
// `product` is that of `first` and `second` in the cycle before. All other units have their own.
//
// A run begins in the first cycle with `go`. Position, velocity and acceleration are held until `done`, its last cycle.
// The results stand in x, y, vx, vy from the cycle after it until the next run begins; the next_ values are the same
// one cycle earlier, in the cycle of `done`. `next_outside`: the position leaves its word.
module pos_vel_update #(
    parameter WIDTH = 16,
    parameter PARALLEL = 0,
    parameter ACCELERATED = 1,
    parameter [31:0] STEP = 1,
    parameter [31:0] HALF_SQUARE = 1,
    parameter VELOCITY_STEP_SHIFT = 16,
    parameter ACCELERATION_STEP_SHIFT = 16,
    parameter ACCELERATION_HALF_SQUARE_SHIFT = 16
) (
    input  wire                    clk,
    input  wire                    reset,
    input  wire                    go,
    input  wire signed [WIDTH-1:0] position_x,
    input  wire signed [WIDTH-1:0] position_y,
    input  wire signed [WIDTH-1:0] velocity_x,
    input  wire signed [WIDTH-1:0] velocity_y,
    input  wire signed [WIDTH-1:0] acceleration_x,
    input  wire signed [WIDTH-1:0] acceleration_y,
    output wire signed [WIDTH-1:0] first,
    output wire signed [WIDTH-1:0] second,
    input  wire signed [2*WIDTH-1:0] product,
    output wire                    done,
    output wire signed [WIDTH-1:0] x,
    output wire signed [WIDTH-1:0] y,
    output wire signed [WIDTH-1:0] vx,
    output wire signed [WIDTH-1:0] vy,
    output wire signed [WIDTH-1:0] next_x,
    output wire signed [WIDTH-1:0] next_y,
    output wire signed [WIDTH-1:0] next_vx,
    output wire signed [WIDTH-1:0] next_vy,
    output wire                    next_outside
);
    // A sum of position, v t and a t²/2 keeps the bits of the longest of them, and two more.
    localparam PRODUCT = 2 * WIDTH;
    localparam V_BITS = PRODUCT > VELOCITY_STEP_SHIFT + WIDTH ? PRODUCT - VELOCITY_STEP_SHIFT : WIDTH;
    localparam A_BITS = PRODUCT > ACCELERATION_HALF_SQUARE_SHIFT + WIDTH
        ? PRODUCT - ACCELERATION_HALF_SQUARE_SHIFT : WIDTH;
    localparam SUM = (V_BITS > A_BITS ? V_BITS : A_BITS) + 2;
    localparam signed [WIDTH-1:0] T = STEP[WIDTH-1:0];
    localparam signed [WIDTH-1:0] T2 = HALF_SQUARE[WIDTH-1:0];

    generate
        if (PARALLEL != 0) begin : parallel
            assign first = {WIDTH{1'b0}};
            assign second = {WIDTH{1'b0}};
            wire unused_product = &{1'b0, product};
            pos_vel_update_parallel #(
                .WIDTH(WIDTH), .SUM(SUM), .ACCELERATED(ACCELERATED), .T(T), .T2(T2),
                .VELOCITY_STEP_SHIFT(VELOCITY_STEP_SHIFT),
                .ACCELERATION_STEP_SHIFT(ACCELERATION_STEP_SHIFT),
                .ACCELERATION_HALF_SQUARE_SHIFT(ACCELERATION_HALF_SQUARE_SHIFT)
            ) unit (
                .clk(clk), .reset(reset), .go(go),
                .position_x(position_x), .position_y(position_y),
                .velocity_x(velocity_x), .velocity_y(velocity_y),
                .acceleration_x(acceleration_x), .acceleration_y(acceleration_y),
                .done(done), .x(x), .y(y), .vx(vx), .vy(vy),
                .next_x(next_x), .next_y(next_y), .next_vx(next_vx), .next_vy(next_vy),
                .next_outside(next_outside)
            );
        end else begin : serial
            wire signed [2*WIDTH-1:0] product_before;
            if (ACCELERATED != 0) begin : shared
                assign product_before = product;
            end else begin : own
                reg signed [2*WIDTH-1:0] own_product;
                always @(posedge clk) own_product <= first * second;
                assign product_before = own_product;
                wire unused_product = &{1'b0, product};
            end
            pos_vel_update_serial #(
                .WIDTH(WIDTH), .SUM(SUM), .ACCELERATED(ACCELERATED), .T(T), .T2(T2),
                .VELOCITY_STEP_SHIFT(VELOCITY_STEP_SHIFT),
                .ACCELERATION_STEP_SHIFT(ACCELERATION_STEP_SHIFT),
                .ACCELERATION_HALF_SQUARE_SHIFT(ACCELERATION_HALF_SQUARE_SHIFT)
            ) unit (
                .clk(clk), .reset(reset), .go(go),
                .position_x(position_x), .position_y(position_y),
                .velocity_x(velocity_x), .velocity_y(velocity_y),
                .acceleration_x(acceleration_x), .acceleration_y(acceleration_y),
                .first(first), .second(second), .product(product_before),
                .done(done), .x(x), .y(y), .vx(vx), .vy(vy),
                .next_x(next_x), .next_y(next_y), .next_vx(next_vx), .next_vy(next_vy),
                .next_outside(next_outside)
            );
        end
    endgenerate
endmodule
