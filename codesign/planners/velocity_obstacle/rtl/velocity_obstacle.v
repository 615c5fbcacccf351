// The circuit of one robot (Dubey et al. 2013, section III): from the states of all robots to the acceleration of its
// own, one update after the other.
//
//     load -> target check -> heading -> select -> acceleration check -> trial -> PID control -> load ..
//                    |                     ^            | too far          | collides |
//                    | arrived             +------------+------------------+          |
//                    +-----------------------------------------------------------------> brake
//
// Load stream, words of 2 WIDTH + 1 bits, x in the low half and y above it: the target (its highest bit: this is the
// last update), then for robots 0, 1, .. the position and the velocity. Robot 0 is the own one.
//
// Phases: 1 load, 2 target check, 3 velocity selector, 4 acceleration check, 5 verify (the trial), 6 PID control.
// Events: 0 a candidate beyond the acceleration, 1 one on a collision course, 2 the one that is taken, each with its
// place in the array of velocities; 3 the velocity to reach; 4 the acceleration; both as in the load stream.
module velocity_obstacle #(
    parameter WIDTH = 16,
    parameter ROBOTS = 2,
    parameter UPDATE_UNITS = 1,
    parameter DETECT_UNITS = 1,
    parameter IN_TURN = 0,
    parameter PARALLEL = 0,
    parameter CROSS_PRODUCT = 0,
    parameter APPROACHING = 0,
    parameter RANGED = 0,
    parameter HALF = 0,
    parameter DIRECTIONS = 64,
    parameter SPEEDS = 10,
    parameter TURNS = 64,
    parameter HALVINGS = 4,
    parameter [31:0] RADIUS = 1,
    parameter [31:0] RANGE = 1,
    parameter [31:0] TOLERANCE = 1,
    parameter [31:0] CHANGE = 1,
    parameter [31:0] BRAKE = 1,
    parameter [31:0] STEP = 1,
    parameter [31:0] HALF_SQUARE = 1,
    parameter [31:0] INVERSE_STEP = 1,
    parameter [31:0] PROPORTIONAL = 1,
    parameter [31:0] INTEGRAL = 0,
    parameter [31:0] DERIVATIVE = 0,
    parameter [31:0] SPEED = 1,
    parameter [31:0] ACCELERATION = 1,
    parameter VELOCITY_STEP_SHIFT = 16,
    parameter ACCELERATION_STEP_SHIFT = 16,
    parameter ACCELERATION_HALF_SQUARE_SHIFT = 16,
    parameter CHANGE_INVERSE_STEP_SHIFT = 16,
    parameter GAIN_SHIFT = 16,
    parameter VELOCITIES_X = "velocities_x.hex",
    parameter VELOCITIES_Y = "velocities_y.hex",
    parameter BOUNDS = "bounds.hex"
) (
    input  wire                 clk,
    input  wire                 reset,
    input  wire                 start,
    input  wire [2*WIDTH:0]     in_data,
    input  wire                 in_valid,
    output wire                 in_ready,
    output reg  [3:0]           phase,
    output wire                 event_valid,
    output reg  [3:0]           event_kind,
    output reg  [2*WIDTH-1:0]   event_data,
    output wire                 done
);
    localparam [3:0] IDLE = 4'd0, LOAD = 4'd1, TARGET = 4'd2, HEADING = 4'd3, SELECT = 4'd4, CHECK = 4'd5,
        VERIFY = 4'd6, PID = 4'd7, DONE = 4'd8;
    localparam [3:0] TOO_FAR = 4'd0, COLLIDES = 4'd1, TAKEN = 4'd2, VELOCITY = 4'd3, ACCELERATE = 4'd4;

    reg [3:0] state;
    reg [2:0] step;
    wire load = state == LOAD, target = state == TARGET, heading = state == HEADING, select = state == SELECT;
    wire check = state == CHECK, verify = state == VERIFY, pid = state == PID;

    // Load: the target, then position and velocity of each robot.
    localparam WORD_BITS = $clog2(2 * ROBOTS + 1);
    localparam [31:0] LAST_WORD = 2 * ROBOTS;
    reg [WORD_BITS-1:0] word;
    reg last_update;
    reg signed [WIDTH-1:0] target_x, target_y, own_x, own_y, own_vx, own_vy;
    wire take = load && in_valid;
    wire last_word = word == LAST_WORD[WORD_BITS-1:0];
    wire first_word = word == {WORD_BITS{1'b0}};
    wire [2*WIDTH-1:0] pair = in_data[2*WIDTH-1:0];
    assign in_ready = load;
    always @(posedge clk) begin
        if (reset) word <= {WORD_BITS{1'b0}};
        else if (take) word <= last_word ? {WORD_BITS{1'b0}} : word + 1'b1;
        if (take && first_word) {last_update, target_y, target_x} <= in_data;
        if (take && word == 1) {own_y, own_x} <= pair;
        if (take && word == 2) {own_vy, own_vx} <= pair;
    end

    // One multiplier serves all modules but the further units of the trial: no two of them work at the same time.
    wire signed [WIDTH:0] target_factor, selector_first, check_first, check_second, pid_first, pid_second;
    wire signed [WIDTH-1:0] selector_second, trial_first, trial_second;
    wire trial_product = PARALLEL == 0 && verify;
    wire signed [WIDTH:0] first = target ? target_factor : heading ? selector_first : check ? check_first
        : trial_product ? {trial_first[WIDTH-1], trial_first} : pid_first;
    wire signed [WIDTH:0] second = target ? target_factor
        : heading ? {selector_second[WIDTH-1], selector_second} : check ? check_second
        : trial_product ? {trial_second[WIDTH-1], trial_second} : pid_second;
    wire signed [2*WIDTH+1:0] product_now = first * second;
    reg signed [2*WIDTH+1:0] product;
    always @(posedge clk) product <= product_now;

    wire in_range, mirror_diagonal, mirror_x, mirror_y;
    wire signed [WIDTH:0] along, across;
    target_check #(.WIDTH(WIDTH), .TOLERANCE(TOLERANCE)) arrival (
        .clk(clk), .y_axis(step[0]), .target_x(target_x), .target_y(target_y), .x(own_x), .y(own_y), .active(target),
        .factor(target_factor), .product(product), .in_range(in_range), .along(along), .across(across),
        .mirror_diagonal(mirror_diagonal), .mirror_x(mirror_x), .mirror_y(mirror_y)
    );

    // A robot that has arrived stays so until the next `start`.
    reg arrived;
    wire arrives = arrived || in_range;
    always @(posedge clk) begin
        if (state == IDLE) arrived <= 1'b0;
        else if (target && step == 3'd2) arrived <= arrives;
    end

    localparam [31:0] VELOCITIES = SPEEDS * DIRECTIONS;
    localparam RAM_BITS = $clog2(SPEEDS * DIRECTIONS);
    localparam CANDIDATE_BITS = RAM_BITS + 2;
    wire heading_last, last_candidate, advance;
    wire [CANDIDATE_BITS-1:0] candidate;
    velocity_selector #(
        .WIDTH(WIDTH), .DIRECTIONS(DIRECTIONS), .SPEEDS(SPEEDS), .TURNS(TURNS), .HALVINGS(HALVINGS),
        .ADDRESS_BITS(CANDIDATE_BITS), .BOUNDS(BOUNDS)
    ) selector (
        .clk(clk), .begin_heading(target), .heading_active(heading), .heading_last(heading_last), .advance(advance),
        .along(along), .across(across), .mirror_diagonal(mirror_diagonal), .mirror_x(mirror_x), .mirror_y(mirror_y),
        .first(selector_first), .second(selector_second), .product_now(product_now), .product(product),
        .candidate(candidate), .last_candidate(last_candidate)
    );
    wire [WIDTH-1:0] candidate_x, candidate_y;
    ram_1w1r #(
        .WIDTH(WIDTH), .DEPTH(VELOCITIES), .ADDRESS_BITS(RAM_BITS), .HAS_IMAGE(1), .IMAGE(VELOCITIES_X)
    ) array_x (
        .clk(clk), .write_enable(1'b0), .write_address({RAM_BITS{1'b0}}), .write_data({WIDTH{1'b0}}),
        .read_enable(select), .read_address(candidate[RAM_BITS-1:0]), .read_data(candidate_x)
    );
    ram_1w1r #(
        .WIDTH(WIDTH), .DEPTH(VELOCITIES), .ADDRESS_BITS(RAM_BITS), .HAS_IMAGE(1), .IMAGE(VELOCITIES_Y)
    ) array_y (
        .clk(clk), .write_enable(1'b0), .write_address({RAM_BITS{1'b0}}), .write_data({WIDTH{1'b0}}),
        .read_enable(select), .read_address(candidate[RAM_BITS-1:0]), .read_data(candidate_y)
    );

    wire reached;
    wire signed [WIDTH-1:0] tried_x, tried_y;
    acceleration_check #(
        .WIDTH(WIDTH), .CHANGE(CHANGE), .INVERSE_STEP(INVERSE_STEP),
        .CHANGE_INVERSE_STEP_SHIFT(CHANGE_INVERSE_STEP_SHIFT)
    ) reach (
        .clk(clk), .active(check), .step(step), .candidate_x(candidate_x), .candidate_y(candidate_y),
        .vx(own_vx), .vy(own_vy), .first(check_first), .second(check_second), .product(product),
        .reached(reached), .acceleration_x(tried_x), .acceleration_y(tried_y)
    );

    wire trial_last, safe;
    wire signed [WIDTH-1:0] chosen_x, chosen_y;
    trial #(
        .WIDTH(WIDTH), .ROBOTS(ROBOTS), .UPDATE_UNITS(UPDATE_UNITS), .DETECT_UNITS(DETECT_UNITS), .IN_TURN(IN_TURN),
        .PARALLEL(PARALLEL), .CROSS_PRODUCT(CROSS_PRODUCT), .APPROACHING(APPROACHING), .RANGED(RANGED),
        .HALF(HALF), .RADIUS(RADIUS), .RANGE(RANGE), .STEP(STEP), .HALF_SQUARE(HALF_SQUARE),
        .VELOCITY_STEP_SHIFT(VELOCITY_STEP_SHIFT), .ACCELERATION_STEP_SHIFT(ACCELERATION_STEP_SHIFT),
        .ACCELERATION_HALF_SQUARE_SHIFT(ACCELERATION_HALF_SQUARE_SHIFT)
    ) trials (
        .clk(clk), .reset(reset),
        .load_position(take && word[0]), .load_velocity(take && !word[0] && !first_word), .load_data(pair),
        .run(verify), .acceleration_x(tried_x), .acceleration_y(tried_y), .present_vx(own_vx), .present_vy(own_vy),
        .first(trial_first), .second(trial_second), .product(product[2*WIDTH-1:0]),
        .last(trial_last), .safe(safe), .own_vx(chosen_x), .own_vy(chosen_y)
    );

    // Without a safe velocity, and at the target, each axis brakes by itself.
    localparam signed [WIDTH:0] MOST_BRAKE = BRAKE[WIDTH:0], LEAST_BRAKE = -MOST_BRAKE;
    wire signed [WIDTH:0] wide_vx = {own_vx[WIDTH-1], own_vx};
    wire signed [WIDTH:0] wide_vy = {own_vy[WIDTH-1], own_vy};
    wire signed [WIDTH:0] slower_x = wide_vx > MOST_BRAKE ? wide_vx - MOST_BRAKE
        : wide_vx < LEAST_BRAKE ? wide_vx + MOST_BRAKE : {(WIDTH + 1) {1'b0}};
    wire signed [WIDTH:0] slower_y = wide_vy > MOST_BRAKE ? wide_vy - MOST_BRAKE
        : wide_vy < LEAST_BRAKE ? wide_vy + MOST_BRAKE : {(WIDTH + 1) {1'b0}};
    reg chosen;
    wire signed [WIDTH-1:0] wanted_x = chosen ? chosen_x : slower_x[WIDTH-1:0];
    wire signed [WIDTH-1:0] wanted_y = chosen ? chosen_y : slower_y[WIDTH-1:0];
    always @(posedge clk) begin
        if (load) chosen <= 1'b0;
        else if (verify && trial_last) chosen <= safe;
    end

    wire signed [WIDTH-1:0] acceleration_x, acceleration_y;
    pid_control #(
        .WIDTH(WIDTH), .PROPORTIONAL(PROPORTIONAL), .INTEGRAL(INTEGRAL), .DERIVATIVE(DERIVATIVE), .SPEED(SPEED),
        .ACCELERATION(ACCELERATION), .GAIN_SHIFT(GAIN_SHIFT)
    ) controller (
        .clk(clk), .clear(state == IDLE), .active(pid), .step(step), .wanted_x(wanted_x), .wanted_y(wanted_y),
        .vx(own_vx), .vy(own_vy), .first(pid_first), .second(pid_second), .product(product),
        .acceleration_x(acceleration_x), .acceleration_y(acceleration_y)
    );

    // Control: `step` counts the cycles of a state.
    wire too_far = check && step == 3'd2 && !reached;
    wire collides = verify && trial_last && !safe;
    assign advance = too_far || collides;
    always @(posedge clk) begin
        step <= step + 3'd1;
        case (state)
            IDLE: if (start) state <= LOAD;
            LOAD: if (take && last_word) {state, step} <= {TARGET, 3'd0};
            TARGET: if (step == 3'd2) {state, step} <= {arrives ? PID : HEADING, 3'd0};
            HEADING: if (heading_last) state <= SELECT;
            SELECT: {state, step} <= {CHECK, 3'd0};
            CHECK: begin
                if (too_far) {state, step} <= {last_candidate ? PID : SELECT, 3'd0};
                else if (step == 3'd4) state <= VERIFY;
            end
            VERIFY: if (trial_last) {state, step} <= {safe || last_candidate ? PID : SELECT, 3'd0};
            PID: if (step == 3'd6) state <= last_update ? DONE : LOAD;
            default: state <= IDLE;
        endcase
        if (reset) state <= IDLE;
    end
    assign done = state == DONE;

    always @* begin
        case (state)
            LOAD: phase = 4'd1;
            TARGET: phase = 4'd2;
            HEADING, SELECT: phase = 4'd3;
            CHECK: phase = 4'd4;
            VERIFY: phase = 4'd5;
            PID: phase = 4'd6;
            default: phase = 4'd0;
        endcase
    end

    assign event_valid = too_far || (verify && trial_last) || (pid && (step == 3'd0 || step == 3'd6));
    localparam CANDIDATE_PAD = 2 * WIDTH > CANDIDATE_BITS ? 2 * WIDTH - CANDIDATE_BITS : 1;
    wire [CANDIDATE_PAD+CANDIDATE_BITS-1:0] padded = {{CANDIDATE_PAD{1'b0}}, candidate};
    always @* begin
        if (pid) begin
            event_kind = step == 3'd0 ? VELOCITY : ACCELERATE;
            event_data = step == 3'd0 ? {wanted_y, wanted_x} : {acceleration_y, acceleration_x};
        end else begin
            event_kind = check ? TOO_FAR : safe ? TAKEN : COLLIDES;
            event_data = padded[2*WIDTH-1:0];
        end
    end
    wire unused_bits = &{1'b0, padded, slower_x, slower_y};
endmodule
