// Equations 2a and 2b with a multiplier for each product: cycle 0 multiplies, cycle 1 sums up.
module pos_vel_update_parallel #(
    parameter WIDTH = 16,
    parameter SUM = 18,
    parameter ACCELERATED = 1,
    parameter signed [WIDTH-1:0] T = 1,
    parameter signed [WIDTH-1:0] T2 = 1,
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
    reg summing;
    always @(posedge clk) summing <= !reset && go && !summing;
    assign done = summing;

    reg signed [2*WIDTH-1:0] vx_t, vy_t;
    always @(posedge clk) begin
        vx_t <= velocity_x * T;
        vy_t <= velocity_y * T;
    end
    wire signed [SUM-1:0] moved_x, moved_y, pushed_x, pushed_y;
    wire signed [WIDTH-1:0] changed_x, changed_y;
    rescale #(.IN(2 * WIDTH), .SHIFT(VELOCITY_STEP_SHIFT), .OUT(SUM)) rescale_vx_t (vx_t, moved_x);
    rescale #(.IN(2 * WIDTH), .SHIFT(VELOCITY_STEP_SHIFT), .OUT(SUM)) rescale_vy_t (vy_t, moved_y);
    generate
        if (ACCELERATED != 0) begin : accelerated
            reg signed [2*WIDTH-1:0] ax_t, ay_t, ax_t2, ay_t2;
            always @(posedge clk) begin
                ax_t <= acceleration_x * T;
                ay_t <= acceleration_y * T;
                ax_t2 <= acceleration_x * T2;
                ay_t2 <= acceleration_y * T2;
            end
            rescale #(.IN(2 * WIDTH), .SHIFT(ACCELERATION_HALF_SQUARE_SHIFT), .OUT(SUM)) rescale_ax_t2 (ax_t2, pushed_x);
            rescale #(.IN(2 * WIDTH), .SHIFT(ACCELERATION_HALF_SQUARE_SHIFT), .OUT(SUM)) rescale_ay_t2 (ay_t2, pushed_y);
            rescale #(.IN(2 * WIDTH), .SHIFT(ACCELERATION_STEP_SHIFT), .OUT(WIDTH)) rescale_ax_t (ax_t, changed_x);
            rescale #(.IN(2 * WIDTH), .SHIFT(ACCELERATION_STEP_SHIFT), .OUT(WIDTH)) rescale_ay_t (ay_t, changed_y);
        end else begin : coasting
            assign pushed_x = {SUM{1'b0}};
            assign pushed_y = {SUM{1'b0}};
            assign changed_x = {WIDTH{1'b0}};
            assign changed_y = {WIDTH{1'b0}};
            wire unused_acceleration = &{1'b0, acceleration_x, acceleration_y, T2};
        end
    endgenerate

    wire signed [SUM-1:0] sum_x = {{(SUM - WIDTH) {position_x[WIDTH-1]}}, position_x} + moved_x + pushed_x;
    wire signed [SUM-1:0] sum_y = {{(SUM - WIDTH) {position_y[WIDTH-1]}}, position_y} + moved_y + pushed_y;
    assign next_x = sum_x[WIDTH-1:0];
    assign next_y = sum_y[WIDTH-1:0];
    assign next_vx = velocity_x + changed_x;
    assign next_vy = velocity_y + changed_y;
    assign next_outside = sum_x[SUM-1:WIDTH-1] != {(SUM - WIDTH + 1) {sum_x[WIDTH-1]}}
        || sum_y[SUM-1:WIDTH-1] != {(SUM - WIDTH + 1) {sum_y[WIDTH-1]}};

    reg signed [WIDTH-1:0] result_x, result_y, result_vx, result_vy;
    always @(posedge clk) if (summing) begin
        result_x <= next_x;
        result_y <= next_y;
        result_vx <= next_vx;
        result_vy <= next_vy;
    end
    assign x = result_x;
    assign y = result_y;
    assign vx = result_vx;
    assign vy = result_vy;
endmodule
