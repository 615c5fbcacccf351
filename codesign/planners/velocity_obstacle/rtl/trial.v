// One candidate held against all other robots: an update of each robot, a detection of each pair (figures 2 to 4).
//
// Update unit u computes the robots u, u + UPDATE_UNITS, ..; detector d the pairs of robot 0, the own one, with robots
// d + 1, d + 1 + DETECT_UNITS, .. Robot 0 takes the acceleration that is tried, all others keep their velocity.
// A unit begins as soon as its operands are there. So with cycles U of an update and D of a detection a trial takes
//
//     one unit of each, IN_TURN = 1 (sequential)          U n + D (n - 1)
//     one unit of each (pipelined)                        2 U + D (n - 1)
//     n and n - 1 units (hybrid)                          U + D
//
// `run` is high throughout, `last` in the last cycle; `safe` is valid with it.
module trial #(
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
    parameter [31:0] RADIUS = 1,
    parameter [31:0] RANGE = 1,
    parameter [31:0] STEP = 1,
    parameter [31:0] HALF_SQUARE = 1,
    parameter VELOCITY_STEP_SHIFT = 16,
    parameter ACCELERATION_STEP_SHIFT = 16,
    parameter ACCELERATION_HALF_SQUARE_SHIFT = 16
) (
    input  wire                    clk,
    input  wire                    reset,
    // The states of robots 0, 1, ..: the position and then the velocity of each, x in the low half of a word.
    input  wire                    load_position,
    input  wire                    load_velocity,
    input  wire [2*WIDTH-1:0]      load_data,
    input  wire                    run,
    input  wire signed [WIDTH-1:0] acceleration_x,
    input  wire signed [WIDTH-1:0] acceleration_y,
    input  wire signed [WIDTH-1:0] present_vx,
    input  wire signed [WIDTH-1:0] present_vy,
    // The multiplier of the update unit of robot 0, outside.
    output wire signed [WIDTH-1:0] first,
    output wire signed [WIDTH-1:0] second,
    input  wire signed [2*WIDTH-1:0] product,
    output wire                    last,
    output wire                    safe,
    output wire signed [WIDTH-1:0] own_vx,
    output wire signed [WIDTH-1:0] own_vy
);
    // A unit's robots are computed in rounds; `turn` of a robot is the rounds that its unit has then done.
    localparam ROUNDS = (ROBOTS + UPDATE_UNITS - 1) / UPDATE_UNITS;
    localparam TURN_BITS = $clog2((ROBOTS - 1 + DETECT_UNITS) / UPDATE_UNITS + 3);
    localparam UNIT_BITS = UPDATE_UNITS > 1 ? $clog2(UPDATE_UNITS) : 1;
    localparam ADDRESS_BITS = ROUNDS > 1 ? $clog2(ROUNDS) : 1;

    // Load: from unit to unit, then the next round.
    reg [UNIT_BITS-1:0] load_unit;
    reg [ADDRESS_BITS-1:0] load_round;
    localparam [31:0] FINAL_UNIT = (ROBOTS - 1) % UPDATE_UNITS;
    localparam [31:0] FINAL_ROUND = (ROBOTS - 1) / UPDATE_UNITS;
    localparam [31:0] LAST_UNIT = UPDATE_UNITS - 1;
    wire final_robot = load_unit == FINAL_UNIT[UNIT_BITS-1:0] && load_round == FINAL_ROUND[ADDRESS_BITS-1:0];
    wire round_full = load_unit == LAST_UNIT[UNIT_BITS-1:0];
    always @(posedge clk) begin
        if (reset) begin
            load_unit <= {UNIT_BITS{1'b0}};
            load_round <= {ADDRESS_BITS{1'b0}};
        end else if (load_velocity) begin
            load_unit <= final_robot || round_full ? {UNIT_BITS{1'b0}} : load_unit + 1'b1;
            if (final_robot) load_round <= {ADDRESS_BITS{1'b0}};
            else if (round_full) load_round <= load_round + 1'b1;
        end
    end

    // What the units say of each other.
    wire [UPDATE_UNITS-1:0] update_done, full, taken;
    wire [UPDATE_UNITS*TURN_BITS-1:0] turns;
    wire [UPDATE_UNITS*WIDTH-1:0] x, y, vx, vy;
    wire [DETECT_UNITS-1:0] detect_idle, detect_start, detect_done, collision;
    wire [DETECT_UNITS*UNIT_BITS-1:0] sources;
    wire in_turn = IN_TURN != 0;
    wire held_back = in_turn && (|full || !(&detect_idle));

    // Robot 0 after its update: kept where its unit goes on with another robot.
    wire signed [WIDTH-1:0] first_x, first_y, first_vx, first_vy;
    wire first_outside;
    wire first_done = update_done[0] && turns[TURN_BITS-1:0] == {TURN_BITS{1'b0}};
    wire signed [WIDTH-1:0] own_x, own_y;
    reg outside;
    always @(posedge clk) if (first_done) outside <= first_outside;
    generate
        if (ROUNDS > 1) begin : keep
            reg signed [WIDTH-1:0] kept_x, kept_y, kept_vx, kept_vy;
            always @(posedge clk) if (first_done) begin
                kept_x <= first_x;
                kept_y <= first_y;
                kept_vx <= first_vx;
                kept_vy <= first_vy;
            end
            assign {own_x, own_y, own_vx, own_vy} = {kept_x, kept_y, kept_vx, kept_vy};
        end else begin : stay
            assign {own_x, own_y, own_vx, own_vy} = {x[WIDTH-1:0], y[WIDTH-1:0], vx[WIDTH-1:0], vy[WIDTH-1:0]};
            wire unused_first = &{1'b0, first_x, first_y, first_vx, first_vy};
        end
    endgenerate

    // With HALF each robot takes half: 2v' - v in place of v'.
    wire signed [WIDTH+HALF:0] tested_vx, tested_vy;
    generate
        if (HALF != 0) begin : reciprocal
            assign tested_vx = {own_vx[WIDTH-1], own_vx, 1'b0} - {{2{present_vx[WIDTH-1]}}, present_vx};
            assign tested_vy = {own_vy[WIDTH-1], own_vy, 1'b0} - {{2{present_vy[WIDTH-1]}}, present_vy};
        end else begin : whole
            assign tested_vx = {own_vx[WIDTH-1], own_vx};
            assign tested_vy = {own_vy[WIDTH-1], own_vy};
            wire unused_present = &{1'b0, present_vx, present_vy};
        end
    endgenerate

    genvar u, d;
    generate
        for (u = 0; u < UPDATE_UNITS; u = u + 1) begin : updates
            localparam [31:0] COUNT = (ROBOTS - u + UPDATE_UNITS - 1) / UPDATE_UNITS;
            wire [2*WIDTH-1:0] position, velocity;
            reg [TURN_BITS-1:0] turn;
            reg result;
            state_bank #(.WIDTH(WIDTH), .DEPTH(ROUNDS), .ADDRESS_BITS(ADDRESS_BITS)) states (
                .clk(clk),
                .write_position(load_position && load_unit == u),
                .write_velocity(load_velocity && load_unit == u),
                .write_address(load_round), .write_data(load_data),
                .read_address(turn[ADDRESS_BITS-1:0]), .position(position), .velocity(velocity)
            );
            wire signed [WIDTH-1:0] next_x, next_y, next_vx, next_vy;
            wire next_outside;
            wire signed [WIDTH-1:0] unit_first, unit_second;
            wire robot_0 = u == 0 && turn == {TURN_BITS{1'b0}};
            wire go = run && turn != COUNT[TURN_BITS-1:0] && (!result || taken[u]) && !held_back;
            pos_vel_update #(
                .WIDTH(WIDTH), .PARALLEL(PARALLEL), .ACCELERATED(u == 0), .STEP(STEP), .HALF_SQUARE(HALF_SQUARE),
                .VELOCITY_STEP_SHIFT(VELOCITY_STEP_SHIFT), .ACCELERATION_STEP_SHIFT(ACCELERATION_STEP_SHIFT),
                .ACCELERATION_HALF_SQUARE_SHIFT(ACCELERATION_HALF_SQUARE_SHIFT)
            ) unit (
                .clk(clk), .reset(reset), .go(go),
                .position_x(position[WIDTH-1:0]), .position_y(position[2*WIDTH-1:WIDTH]),
                .velocity_x(velocity[WIDTH-1:0]), .velocity_y(velocity[2*WIDTH-1:WIDTH]),
                .acceleration_x(robot_0 ? acceleration_x : {WIDTH{1'b0}}),
                .acceleration_y(robot_0 ? acceleration_y : {WIDTH{1'b0}}),
                .first(unit_first), .second(unit_second), .product(product),
                .done(update_done[u]),
                .x(x[u*WIDTH +: WIDTH]), .y(y[u*WIDTH +: WIDTH]),
                .vx(vx[u*WIDTH +: WIDTH]), .vy(vy[u*WIDTH +: WIDTH]),
                .next_x(next_x), .next_y(next_y), .next_vx(next_vx), .next_vy(next_vy),
                .next_outside(next_outside)
            );
            // A result stays until its detector takes it.
            always @(posedge clk) begin
                if (reset || last) begin
                    turn <= {TURN_BITS{1'b0}};
                    result <= 1'b0;
                end else if (update_done[u]) begin
                    turn <= turn + 1'b1;
                    result <= !robot_0;
                end else if (taken[u]) result <= 1'b0;
            end
            assign full[u] = result;
            assign turns[u*TURN_BITS +: TURN_BITS] = turn;
            wire [DETECT_UNITS-1:0] takes;
            for (d = 0; d < DETECT_UNITS; d = d + 1) begin : takers
                assign takes[d] = detect_start[d] && sources[d*UNIT_BITS +: UNIT_BITS] == u;
            end
            assign taken[u] = |takes;
            if (u == 0) begin : own
                assign {first_x, first_y, first_vx, first_vy} = {next_x, next_y, next_vx, next_vy};
                assign first_outside = next_outside;
                assign {first, second} = {unit_first, unit_second};
            end else begin : others
                wire unused_next = &{1'b0, next_x, next_y, next_vx, next_vy, next_outside, unit_first, unit_second};
            end
        end
    endgenerate

    wire [DETECT_UNITS-1:0] final_pair;
    generate
        for (d = 0; d < DETECT_UNITS; d = d + 1) begin : detections
            // The unit that holds the detector's next robot, and the turn in which it does.
            localparam [31:0] SOURCE = (d + 1) % UPDATE_UNITS;
            localparam [31:0] TURN = (d + 1) / UPDATE_UNITS + 1;
            localparam [31:0] FINAL_TURN = (ROBOTS - 1) / UPDATE_UNITS + 1;
            localparam [31:0] MORE_SOURCE = DETECT_UNITS % UPDATE_UNITS;
            localparam [31:0] MORE_TURN = DETECT_UNITS / UPDATE_UNITS;
            wire [UNIT_BITS-1:0] source;
            wire [TURN_BITS-1:0] turn;
            if (d + DETECT_UNITS < ROBOTS - 1) begin : several
                reg [UNIT_BITS-1:0] next_source;
                reg [TURN_BITS-1:0] next_turn;
                localparam [31:0] BORROW = UPDATE_UNITS - MORE_SOURCE;
                wire wrap = {1'b0, next_source} >= BORROW[UNIT_BITS:0];
                always @(posedge clk) begin
                    if (reset || last) begin
                        next_source <= SOURCE[UNIT_BITS-1:0];
                        next_turn <= TURN[TURN_BITS-1:0];
                    end else if (detect_done[d]) begin
                        next_source <= wrap ? next_source - BORROW[UNIT_BITS-1:0] : next_source + MORE_SOURCE[UNIT_BITS-1:0];
                        next_turn <= next_turn + MORE_TURN[TURN_BITS-1:0] + {{(TURN_BITS - 1) {1'b0}}, wrap};
                    end
                end
                assign source = next_source;
                assign turn = next_turn;
            end else begin : single
                assign source = SOURCE[UNIT_BITS-1:0];
                assign turn = TURN[TURN_BITS-1:0];
            end
            assign final_pair[d] = source == FINAL_UNIT[UNIT_BITS-1:0] && turn == FINAL_TURN[TURN_BITS-1:0];
            wire due = full[source] && turns[source*TURN_BITS +: TURN_BITS] == turn;
            assign sources[d*UNIT_BITS +: UNIT_BITS] = source;
            assign detect_start[d] = detect_idle[d] && due;
            coll_detect #(
                .WIDTH(WIDTH), .PARALLEL(PARALLEL), .CROSS_PRODUCT(CROSS_PRODUCT), .APPROACHING(APPROACHING),
                .RANGED(RANGED), .HALF(HALF), .RADIUS(RADIUS), .RANGE(RANGE)
            ) unit (
                .clk(clk), .reset(reset), .go(due),
                .own_x(own_x), .own_y(own_y), .own_vx(tested_vx), .own_vy(tested_vy),
                .other_x(x[source*WIDTH +: WIDTH]), .other_y(y[source*WIDTH +: WIDTH]),
                .other_vx(vx[source*WIDTH +: WIDTH]), .other_vy(vy[source*WIDTH +: WIDTH]),
                .idle(detect_idle[d]), .done(detect_done[d]), .collision(collision[d])
            );
        end
    endgenerate

    // The trial ends with the detection of the last robot; all others have ended before, or end with it.
    wire collides = |(detect_done & collision);
    reg collided;
    always @(posedge clk) begin
        if (reset || last) collided <= 1'b0;
        else if (collides) collided <= 1'b1;
    end
    assign last = |(detect_done & final_pair);
    assign safe = !(outside || collided || collides);
endmodule
