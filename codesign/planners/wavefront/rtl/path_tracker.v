// The path down the potentials: by Dreyfus' rule (equation 2), or the safe path (equations 4 and 5).
//
// A step reads the eight neighbours one a cycle, straight ones first, clockwise from north and from north-east:
//
//   7 0 4
//   3   1        equation 2: the first j with p_i = p_j + w_ji
//   6 2 5        equations 4 and 5: of those with p_j < p_i the largest p^d, of these the smallest p^t
//
// A word arrives LATENCY edges after its address. So a step takes 8 + LATENCY cycles, and the first one waits LATENCY
// cycles for the potential of the start.
module path_tracker #(
    parameter ROWS = 8,
    parameter COLUMNS = 8,
    parameter ROW_BITS = 3,
    parameter COLUMN_BITS = 3,
    parameter STRAIGHT = 2,
    parameter DIAGONAL = 3,
    parameter EXTRA = 0,
    parameter CORNER_CUTTING = 1,
    parameter SAFE = 0,
    parameter BITS = 6,
    parameter OBSTACLE_BITS = 1,    // of p^d; 1 where no paths are safe
    parameter MOST_STEPS = 1        // 0: the whole path
) (
    input  wire                     clk,
    input  wire                     place,          // take the start
    input  wire [ROW_BITS-1:0]      start_row,
    input  wire [COLUMN_BITS-1:0]   start_column,
    input  wire                     run,
    output wire [ROW_BITS-1:0]      read_row,
    output wire [COLUMN_BITS-1:0]   read_column,
    input  wire [BITS-1:0]          potential,
    input  wire [OBSTACLE_BITS-1:0] distance,       // p^d
    input  wire                     free,
    input  wire                     penalised,
    output wire                     step,           // a step is chosen, to the cell of the next two
    output wire [ROW_BITS-1:0]      step_row,
    output wire [COLUMN_BITS-1:0]   step_column,
    output wire                     last
);
    localparam LATENCY = 2;
    localparam SUM_BITS = (BITS > 7 ? BITS : 7) + 1;
    localparam [31:0] LAST_SLOT = 7 + LATENCY, FIRST_SLOT = 16 - LATENCY, AWAY = LATENCY;
    localparam [31:0] STRAIGHT_STEP = STRAIGHT, DIAGONAL_STEP = DIAGONAL;
    localparam [31:0] BOTTOM = ROWS - 1, RIGHT = COLUMNS - 1;

    // Slots of a step: 0 to 7 ask for a neighbour, LAST_SLOT chooses; before the first step FIRST_SLOT to 15.
    reg [3:0] slot;
    wire at_last = slot == LAST_SLOT[3:0];
    always @(posedge clk)
        if (place) slot <= FIRST_SLOT[3:0];
        else slot <= at_last ? 4'd0 : slot + 4'd1;

    // The neighbours by their number: north of the cell, south, west, east.
    function goes_north(input [2:0] side); goes_north = side == 3'd0 || side == 3'd4 || side == 3'd7; endfunction
    function goes_south(input [2:0] side); goes_south = side == 3'd2 || side == 3'd5 || side == 3'd6; endfunction
    function goes_west(input [2:0] side); goes_west = side == 3'd3 || side == 3'd6 || side == 3'd7; endfunction
    function goes_east(input [2:0] side); goes_east = side == 3'd1 || side == 3'd4 || side == 3'd5; endfunction
    function [ROW_BITS-1:0] row_of(input [ROW_BITS-1:0] from, input [2:0] side);
        row_of = goes_north(side) ? from - 1'b1 : goes_south(side) ? from + 1'b1 : from;
    endfunction
    function [COLUMN_BITS-1:0] column_of(input [COLUMN_BITS-1:0] from, input [2:0] side);
        column_of = goes_west(side) ? from - 1'b1 : goes_east(side) ? from + 1'b1 : from;
    endfunction

    // The cell of the path, and the address of the neighbour.
    reg [ROW_BITS-1:0] row;
    reg [COLUMN_BITS-1:0] column;
    wire [2:0] asked = slot[2:0];
    wire own = slot[3];
    assign read_row = own ? row : row_of(row, asked);
    assign read_column = own ? column : column_of(column, asked);

    // Whether the neighbour that arrives now is inside of the map.
    wire asked_on_map = !own
        && !(goes_north(asked) && row == {ROW_BITS{1'b0}}) && !(goes_south(asked) && row == BOTTOM[ROW_BITS-1:0])
        && !(goes_west(asked) && column == {COLUMN_BITS{1'b0}})
        && !(goes_east(asked) && column == RIGHT[COLUMN_BITS-1:0]);
    reg [LATENCY-1:0] on_map_line;
    always @(posedge clk) on_map_line <= {on_map_line[LATENCY-2:0], asked_on_map};
    wire on_map = on_map_line[LATENCY-1];
    wire [3:0] arriving = slot - AWAY[3:0];
    wire [2:0] side = arriving[2:0];

    // The potential and the penalty of the cell of the path.
    reg waiting;
    reg [BITS-1:0] here;
    wire here_penalised;

    // Without corner cutting a diagonal step needs both cells beside it: F of N, E, S, W arrived before.
    wire allowed;
    generate
        if (CORNER_CUTTING != 0) begin : cuts
            assign allowed = on_map;
        end else begin : keeps_corners
            reg [3:0] beside;
            always @(posedge clk) if (run && !arriving[3] && !side[2]) beside[side[1:0]] <= free;
            wire vertical = goes_north(side) ? beside[0] : beside[2];
            wire horizontal = goes_east(side) ? beside[1] : beside[3];
            assign allowed = on_map && (!side[2] || vertical && horizontal);
        end
    endgenerate

    // The rule: is the neighbour that arrives now better than the best of this step?
    reg has_best;
    reg [2:0] best_side;
    reg [BITS-1:0] best;
    wire better;
    generate
        if (SAFE != 0) begin : safe_path
            reg [OBSTACLE_BITS-1:0] best_distance;
            always @(posedge clk) if (better) best_distance <= distance;
            assign better = allowed && potential < here && (!has_best || distance > best_distance
                || distance == best_distance && potential < best);
        end else begin : shortest_path
            wire [SUM_BITS-1:0] delay = side[2] ? DIAGONAL_STEP[SUM_BITS-1:0] : STRAIGHT_STEP[SUM_BITS-1:0];
            wire [SUM_BITS-1:0] there = {{SUM_BITS-BITS{1'b0}}, potential} + delay;
            wire [SUM_BITS-1:0] sum;
            if (EXTRA > 0) begin : with_penalty
                localparam [31:0] LONGER = EXTRA;
                assign sum = here_penalised ? there + LONGER[SUM_BITS-1:0] : there;
            end else begin : plain
                assign sum = there;
            end
            assign better = allowed && !has_best && sum == {{SUM_BITS-BITS{1'b0}}, here};
        end
    endgenerate
    always @(posedge clk) begin
        if (place || at_last) has_best <= 1'b0;
        else if (better) has_best <= 1'b1;
        if (better) begin
            best_side <= side;
            best <= potential;
        end
    end
    generate
        if (EXTRA > 0) begin : penalties
            reg penalised_here, best_penalised;
            always @(posedge clk) begin
                if (better) best_penalised <= penalised;
                if (at_last) penalised_here <= better ? penalised : best_penalised;
                else if (waiting && slot == 4'd0) penalised_here <= penalised;
            end
            assign here_penalised = penalised_here;
        end else begin : no_penalties
            assign here_penalised = 1'b0;
        end
    endgenerate

    // The choice.
    wire [2:0] choice = better ? side : best_side;
    wire [BITS-1:0] chosen = better ? potential : best;
    wire most;
    assign step = run && at_last && (better || has_best);
    assign step_row = row_of(row, choice);
    assign step_column = column_of(column, choice);
    assign last = run && at_last && (!(better || has_best) || chosen == {BITS{1'b0}} || most);
    always @(posedge clk) begin
        if (place) begin
            row <= start_row;
            column <= start_column;
            waiting <= 1'b1;
        end else if (step) begin
            row <= step_row;
            column <= step_column;
        end
        if (at_last) here <= chosen;
        else if (waiting && slot == 4'd0) begin
            here <= potential;
            waiting <= 1'b0;
        end
    end
    generate
        if (MOST_STEPS > 0) begin : local_course
            localparam [31:0] MOST = MOST_STEPS;
            reg [15:0] steps;
            always @(posedge clk)
                if (place) steps <= 16'd1;
                else if (step) steps <= steps + 16'd1;
            assign most = steps == MOST[15:0];
        end else begin : complete_course
            assign most = 1'b0;
        end
    endgenerate

    // Inputs that other parameters need.
    wire unused = &{1'b0, free, penalised, distance, arriving, here_penalised, waiting, best};
endmodule
