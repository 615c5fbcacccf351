// The acceleration that drives the robot to the velocity it chose (section III, PID control), one axis after the other:
//
//     e = v_wanted - v      a = P e + I Σe + D (e - e_last)
//
// The sum of errors is clipped to the greatest speed, the acceleration to the greatest one of an axis. Seven cycles:
// a product a cycle, summed up in the cycle after it.
module pid_control #(
    parameter WIDTH = 16,
    parameter [31:0] PROPORTIONAL = 1,
    parameter [31:0] INTEGRAL = 0,
    parameter [31:0] DERIVATIVE = 0,
    parameter [31:0] SPEED = 1,
    parameter [31:0] ACCELERATION = 1,
    parameter GAIN_SHIFT = 16
) (
    input  wire                      clk,
    input  wire                      clear,
    input  wire                      active,
    input  wire [2:0]                step,
    input  wire signed [WIDTH-1:0]   wanted_x,
    input  wire signed [WIDTH-1:0]   wanted_y,
    input  wire signed [WIDTH-1:0]   vx,
    input  wire signed [WIDTH-1:0]   vy,
    output reg  signed [WIDTH:0]     first,
    output reg  signed [WIDTH:0]     second,
    input  wire signed [2*WIDTH+1:0] product,
    output wire signed [WIDTH-1:0]   acceleration_x,
    output wire signed [WIDTH-1:0]   acceleration_y
);
    localparam signed [WIDTH:0] P = PROPORTIONAL[WIDTH:0], I = INTEGRAL[WIDTH:0], D = DERIVATIVE[WIDTH:0];
    localparam signed [WIDTH+1:0] MOST_SUM = SPEED[WIDTH+1:0], LEAST_SUM = -MOST_SUM;
    localparam TERM = 2 * WIDTH + 2 > GAIN_SHIFT + WIDTH ? 2 * WIDTH + 2 - GAIN_SHIFT : WIDTH;
    localparam SUM = TERM + 2;
    function [SUM-1:0] extended(input [31:0] value);
        reg [SUM+31:0] top_unused;
        begin
            top_unused = {{(SUM) {1'b0}}, value};
            extended = top_unused[SUM-1:0];
        end
    endfunction
    localparam signed [SUM-1:0] MOST = extended(ACCELERATION), LEAST = -MOST;

    reg signed [WIDTH-1:0] sum_x, sum_y, last_x, last_y;
    wire y_axis = step >= 3'd3;
    wire signed [WIDTH-1:0] wanted = y_axis ? wanted_y : wanted_x;
    wire signed [WIDTH-1:0] velocity = y_axis ? vy : vx;
    wire signed [WIDTH-1:0] sum = y_axis ? sum_y : sum_x;
    wire signed [WIDTH-1:0] last = y_axis ? last_y : last_x;

    wire signed [WIDTH:0] error = {wanted[WIDTH-1], wanted} - {velocity[WIDTH-1], velocity};
    wire signed [WIDTH+1:0] total = {error[WIDTH], error} + {{2{sum[WIDTH-1]}}, sum};
    wire signed [WIDTH+1:0] clipped = total > MOST_SUM ? MOST_SUM : total < LEAST_SUM ? LEAST_SUM : total;
    wire signed [WIDTH:0] change = error - {last[WIDTH-1], last};
    always @* begin
        case (step)
            3'd0, 3'd3: {first, second} = {error, P};
            3'd1, 3'd4: {first, second} = {clipped[WIDTH:0], I};
            default: {first, second} = {change, D};
        endcase
    end

    // The term of the cycle before.
    wire signed [SUM-1:0] term;
    rescale #(.IN(2 * WIDTH + 2), .SHIFT(GAIN_SHIFT), .OUT(SUM)) rescale_gain (product, term);
    reg signed [SUM-1:0] drive;
    wire begins = step == 3'd1 || step == 3'd4;
    wire signed [SUM-1:0] drive_now = begins ? term : drive + term;
    wire signed [SUM-1:0] limited = drive_now > MOST ? MOST : drive_now < LEAST ? LEAST : drive_now;
    wire unused_bits = &{1'b0, clipped, limited};
    reg signed [WIDTH-1:0] kept_x;
    assign acceleration_x = kept_x;
    assign acceleration_y = limited[WIDTH-1:0];
    always @(posedge clk) begin
        if (clear) {sum_x, sum_y, last_x, last_y} <= {(4 * WIDTH) {1'b0}};
        else if (active) begin
            drive <= drive_now;
            if (step == 3'd3) kept_x <= limited[WIDTH-1:0];
            if (step == 3'd2) begin
                sum_x <= clipped[WIDTH-1:0];
                last_x <= error[WIDTH-1:0];
            end
            if (step == 3'd5) begin
                sum_y <= clipped[WIDTH-1:0];
                last_y <= error[WIDTH-1:0];
            end
        end
    end
endmodule
