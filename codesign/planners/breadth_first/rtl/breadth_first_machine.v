// Breadth-first search on a grid (Vacariu et al. 2008, section 3): the states Standby, Init, BF and Path around the
// memories of the cells, the directions and the queue.
//
//   phase 1, Init (CopyMem): the stream gives a cell a cycle, row by row: 0 obstacle, 1 free, 2 goal, 3 start.
//   phase 2, BF (Listing 1): CYCLES cycles a popped cell, and one for the goal or the empty queue.
//   phase 3, Path (Listing 2): two cycles a cell from the goal back to the start, and one to see that it is the start.
//
// Events, with {side, cell} as value:
//   0 pop       the cell that leaves the queue (side 0)
//   1 push      the cell whose neighbour on this side enters the queue
//   2 path      a cell of the path, and the side that led there from the cell before it (side 0 at the goal)
//   3 empty     the queue is empty and no goal was popped: the last popped cell (side 0)
//   4 overflow  a push finds the queue full: the cell and the side; the search ends
//
// The memory of the cells holds 0 obstacle or start, 1 free, 2 goal or (after the search) path, 3 visited.
// SHOWN: whether and how a display looks at the cells and the directions; see breadth_first_memory.
// Only the first goal that is discovered can be popped first, so one register holds it, however many goals there are.
module breadth_first_machine #(
    parameter ROWS = 100,
    parameter COLUMNS = 100,
    parameter ROW_BITS = 7,
    parameter COLUMN_BITS = 7,
    parameter ADDRESS_BITS = 14,
    parameter LINEAR = 0,
    parameter CYCLES = 14,
    parameter QUEUE_WORDS = 16384,
    parameter POINTER_BITS = 14,
    parameter CHECKED = 0,
    parameter SHOWN = 0
) (
    input  wire                    clk,
    input  wire                    reset,
    input  wire                    start,
    input  wire [1:0]              in_data,
    input  wire                    in_valid,
    output wire                    in_ready,
    output wire [3:0]              phase,
    output wire                    event_valid,
    output wire [3:0]              event_kind,
    output wire [ADDRESS_BITS+1:0] event_data,
    output reg                     done,
    input  wire [ADDRESS_BITS-1:0] shown_address,
    output wire [1:0]              shown_code,
    output wire [1:0]              shown_direction
);
    localparam [1:0] STANDBY = 2'd0, INIT = 2'd1, BF = 2'd2, PATH = 2'd3;
    localparam [1:0] OBSTACLE = 2'd0, ON_PATH = 2'd2, VISITED = 2'd3, START = 2'd3;
    localparam PIPELINED = CYCLES == 6 ? 1 : 0;

    reg [1:0] state;
    assign phase = {2'b00, state};
    wire searching = state == BF;
    wire tracking = state == PATH;

    // The cell that was popped; in Init the cell before that of the stream, in Path the cell that is marked.
    reg [ADDRESS_BITS-1:0] current;
    reg current_valid, current_goal;

    // ---- the schedule of an expansion; popping is its first cycle
    wire scheduled_read, scheduled_mark, last_cycle, overflow;
    wire [1:0] mark_side;
    wire [3:0] next_move;
    breadth_first_schedule #(.CYCLES(CYCLES)) schedule (
        .clk(clk), .run(searching), .stop(overflow || reset), .read(scheduled_read), .mark_side(mark_side),
        .mark(scheduled_mark), .last(last_cycle), .next_move(next_move)
    );
    reg popping, settling, refilling;

    // ---- Path: a direction is read in even cycles (entering), and in the next even cycle it is followed (moving)
    reg entering, moving, moved;
    wire [1:0] direction, code;
    wire arrived = moving && code == OBSTACLE;

    // ---- the address of the next cell. Init and BF know the side a cycle ahead; Path follows a direction
    reg [3:0] move;
    wire [ADDRESS_BITS-1:0] to;
    wire leaving;
    breadth_first_move #(
        .LINEAR(LINEAR), .ROWS(ROWS), .COLUMNS(COLUMNS),
        .ROW_BITS(ROW_BITS), .COLUMN_BITS(COLUMN_BITS), .ADDRESS_BITS(ADDRESS_BITS)
    ) neighbour (
        .from(current), .known(move), .following(moving), .direction(direction), .to(to), .leaving(leaving)
    );

    // ---- Init: from the cell before the first one to the last, row by row; a linear address has walls between rows
    wire wall, row_end, last_cell, draining;
    assign in_ready = state == INIT && !wall && !draining;
    wire fill = state == INIT && !draining && (wall || in_valid);
    generate
        if (LINEAR != 0) begin : scan_linear
            localparam [31:0] WALL = COLUMNS, BEFORE_LAST = ROWS * (COLUMNS + 1) - 3;
            reg [COLUMN_BITS:0] column;
            always @(posedge clk)
                if (state == STANDBY) column <= {COLUMN_BITS+1{1'b0}};
                else if (fill) column <= wall ? {COLUMN_BITS+1{1'b0}} : column + 1'b1;
            assign wall = column == WALL[COLUMN_BITS:0];
            assign last_cell = current == BEFORE_LAST[ADDRESS_BITS-1:0];
            assign row_end = 1'b0;
        end else begin : scan_side_by_side
            // The cell after the current one is the last of its row, in a map of one column of the next row.
            localparam [31:0] BEFORE_END = COLUMNS - 2;
            localparam [31:0] BEFORE_LAST = COLUMNS == 1 ? ROWS - 2 : ROWS - 1;
            assign wall = 1'b0;
            assign row_end = current[COLUMN_BITS-1:0] == BEFORE_END[COLUMN_BITS-1:0];
            assign last_cell = row_end && current[ADDRESS_BITS-1:COLUMN_BITS] == BEFORE_LAST[ROW_BITS-1:0];
        end
    endgenerate

    // ---- what is marked: in Init the cell of the stream, in BF the neighbour, in Path the cell
    wire [1:0] given = wall ? OBSTACLE : in_data;
    wire written, init_end;
    wire [1:0] written_code;
    wire [ADDRESS_BITS-1:0] mark_cell;
    generate
        if (PIPELINED != 0) begin : delayed
            // Two cycles later than the read, on a port of their own.
            reg [ADDRESS_BITS-1:0] cell_1, cell_2;
            reg [1:0] given_1, given_2;
            reg fill_1, fill_2, last_1, last_2;
            always @(posedge clk) begin
                cell_1 <= to;
                cell_2 <= cell_1;
                given_1 <= given;
                given_2 <= given_1;
                fill_1 <= fill && !reset;
                fill_2 <= fill_1;
                last_1 <= fill && last_cell && !reset;
                last_2 <= last_1;
            end
            assign draining = last_1 || last_2;
            assign written = fill_2;
            assign written_code = given_2;
            assign mark_cell = cell_2;
            assign init_end = last_2;
        end else begin : at_once
            assign draining = 1'b0;
            assign written = fill;
            assign written_code = given;
            assign mark_cell = to;
            assign init_end = fill && last_cell;
        end
    endgenerate
    wire path_mark = PIPELINED != 0 ? moving : tracking && !entering;

    // ---- a neighbour is pushed if it is free or a goal, and inside of the map
    reg outside_1, outside_2;
    wire read = (searching && scheduled_read) || entering;
    always @(posedge clk) begin
        if (read) outside_1 <= leaving;
        outside_2 <= outside_1;
    end
    wire discovered = scheduled_mark && (code[1] ^ code[0]) && !outside_2;
    wire started = written && written_code == START;

    // ---- the memories
    wire [1:0] mark_code = written ? written_code & {2{!started}} : tracking ? ON_PATH : VISITED;
    wire mark = written || discovered || path_mark;
    breadth_first_memory #(.ADDRESS_BITS(ADDRESS_BITS), .SHOWN(SHOWN)) cells (
        .clk(clk),
        .write_enable(mark), .write_address(mark_cell), .write_data(mark_code),
        .read_enable(read), .read_address(to), .read_data(code),
        .shown_address(shown_address), .shown_data(shown_code)
    );
    breadth_first_memory #(.ADDRESS_BITS(ADDRESS_BITS), .SHOWN(SHOWN)) directions (
        .clk(clk),
        .write_enable(discovered), .write_address(mark_cell), .write_data(mark_side ^ 2'd1),
        .read_enable(entering), .read_address(to), .read_data(direction),
        .shown_address(shown_address), .shown_data(shown_direction)
    );
    wire next_valid, full;
    wire unused = &{1'b0, full};
    assign overflow = CHECKED != 0 ? discovered && full : 1'b0;
    wire [ADDRESS_BITS-1:0] next_cell;
    breadth_first_queue #(
        .ADDRESS_BITS(ADDRESS_BITS), .WORDS(QUEUE_WORDS), .POINTER_BITS(POINTER_BITS)
    ) waiting (
        .clk(clk), .clear(state == STANDBY), .preset(started), .push(discovered && !overflow), .push_cell(mark_cell),
        .pop(last_cycle), .settle(settling), .refill(refilling),
        .next_valid(next_valid), .next_cell(next_cell), .full(full)
    );

    // ---- the goal: the first that was discovered
    reg [ADDRESS_BITS-1:0] goal;
    reg goal_valid;
    always @(posedge clk) begin
        if (state == STANDBY) goal_valid <= 1'b0;
        else if (discovered && code[1]) goal_valid <= 1'b1;
        if (!goal_valid) goal <= mark_cell;
    end

    // ---- the cell that is popped: the first that waits, or what is pushed at this very time
    wire advance = last_cycle || init_end;
    always @(posedge clk) begin
        if (advance) begin
            current_valid <= next_valid || discovered || started;
            current_goal <= next_valid ? goal_valid && next_cell == goal : discovered && code[1] && !goal_valid;
        end
        if (state == STANDBY) current <= {ADDRESS_BITS{1'b1}};
        else if (advance) begin
            if (next_valid) current <= next_cell;
            else if (discovered || started) current <= mark_cell;
        end else if (fill || entering) begin
            current <= to;
            if (fill && row_end) current[COLUMN_BITS-1:0] <= {COLUMN_BITS{1'b1}};
        end
    end

    // ---- the states, and what the next cycle does
    wire goal_popped = popping && current_valid && current_goal;
    wire over = (popping && !current_valid) || overflow || arrived;
    localparam SIDE_BY_SIDE = LINEAR == 0 ? 1 : 0;
    always @(posedge clk) begin
        done <= over;
        popping <= advance && !overflow && !reset;
        settling <= popping;
        refilling <= settling;
        entering <= (goal_popped || (tracking && !entering)) && !reset;
        moving <= tracking && !entering && !reset;
        moved <= moving;
        case (state)
            STANDBY: begin
                move <= {1'b0, SIDE_BY_SIDE != 0, 2'b01};
                if (start) state <= INIT;
            end
            INIT: begin
                if (fill) move <= {1'b0, row_end, 2'b01};
                if (init_end) begin
                    move <= next_move;
                    state <= BF;
                end
            end
            BF: begin
                move <= next_move & {4{!goal_popped}};
                if (goal_popped) state <= PATH;
            end
            PATH: move <= 4'b0000;
        endcase
        if (over || reset) state <= STANDBY;
    end

    // ---- events
    assign event_valid = popping || discovered || (tracking && !entering);
    assign event_kind = popping ? (current_valid ? 4'd0 : 4'd3) : tracking ? 4'd2 : overflow ? 4'd4 : 4'd1;
    assign event_data = {tracking ? direction & {2{moved}} : mark_side, current};
endmodule
