// Equations 2a and 2b over one multiplier outside: a product of its factors a cycle, added up in the cycle after it.
//
//     cycle     0      1          2       3       4          5       6
//     product   vx t   ax t²/2    ax t    vy t    ay t²/2    ay t
//     sum              x          x       vx      y          y       vy
module pos_vel_update_serial #(
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
    reg [2:0] step;
    always @(posedge clk) begin
        if (reset) step <= 3'd0;
        else if (step == 3'd6) step <= 3'd0;
        else if (go || step != 3'd0) step <= step + 3'd1;
    end
    assign done = step == 3'd6;

    // The factors of this cycle.
    wire second_axis = step >= 3'd3;
    wire signed [WIDTH-1:0] velocity = second_axis ? velocity_y : velocity_x;
    generate
        if (ACCELERATED != 0) begin : accelerated
            wire signed [WIDTH-1:0] acceleration = second_axis ? acceleration_y : acceleration_x;
            wire with_velocity = step == 3'd0 || step == 3'd3;
            assign first = with_velocity ? velocity : acceleration;
            assign second = with_velocity ? T : (step == 3'd1 || step == 3'd4) ? T2 : T;
        end else begin : coasting
            assign first = velocity;
            assign second = T;
            wire unused_acceleration = &{1'b0, acceleration_x, acceleration_y, T2};
        end
    endgenerate

    // The product of the cycle before, added to what it belongs to.
    wire signed [SUM-1:0] moved;
    rescale #(.IN(2 * WIDTH), .SHIFT(VELOCITY_STEP_SHIFT), .OUT(SUM)) rescale_v_t (product, moved);
    reg signed [SUM-1:0] sum_x, sum_y;
    reg signed [WIDTH-1:0] sum_vx, sum_vy;
    wire y_next = step >= 3'd4;
    generate
        if (ACCELERATED != 0) begin : sums
            wire signed [SUM-1:0] pushed;
            wire signed [WIDTH-1:0] changed;
            rescale #(.IN(2 * WIDTH), .SHIFT(ACCELERATION_HALF_SQUARE_SHIFT), .OUT(SUM)) rescale_a_t2 (product, pushed);
            rescale #(.IN(2 * WIDTH), .SHIFT(ACCELERATION_STEP_SHIFT), .OUT(WIDTH)) rescale_a_t (product, changed);
            wire signed [SUM-1:0] position_sum =
                (y_next ? sum_y : sum_x) + ((step == 3'd1 || step == 3'd4) ? moved : pushed);
            wire signed [WIDTH-1:0] velocity_sum = (y_next ? sum_vy : sum_vx) + changed;
            always @(posedge clk) begin
                case (step)
                    3'd0: if (go) begin
                        sum_x <= {{(SUM - WIDTH) {position_x[WIDTH-1]}}, position_x};
                        sum_y <= {{(SUM - WIDTH) {position_y[WIDTH-1]}}, position_y};
                        sum_vx <= velocity_x;
                        sum_vy <= velocity_y;
                    end
                    3'd1, 3'd2: sum_x <= position_sum;
                    3'd3: sum_vx <= velocity_sum;
                    3'd4, 3'd5: sum_y <= position_sum;
                    default: sum_vy <= velocity_sum;
                endcase
            end
            assign next_vy = velocity_sum;
        end else begin : positions
            wire signed [SUM-1:0] position_sum = (y_next ? sum_y : sum_x) + moved;
            always @(posedge clk) begin
                if (step == 3'd0 && go) begin
                    sum_x <= {{(SUM - WIDTH) {position_x[WIDTH-1]}}, position_x};
                    sum_y <= {{(SUM - WIDTH) {position_y[WIDTH-1]}}, position_y};
                    sum_vx <= velocity_x;
                    sum_vy <= velocity_y;
                end
                if (step == 3'd1) sum_x <= position_sum;
                if (step == 3'd4) sum_y <= position_sum;
            end
            assign next_vy = sum_vy;
        end
    endgenerate

    assign x = sum_x[WIDTH-1:0];
    assign y = sum_y[WIDTH-1:0];
    assign vx = sum_vx;
    assign vy = sum_vy;
    // All but the last sum are complete in the last cycle.
    assign next_x = x;
    assign next_y = y;
    assign next_vx = sum_vx;
    assign next_outside = sum_x[SUM-1:WIDTH-1] != {(SUM - WIDTH + 1) {sum_x[WIDTH-1]}}
        || sum_y[SUM-1:WIDTH-1] != {(SUM - WIDTH + 1) {sum_y[WIDTH-1]}};
endmodule
