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
//   2 path      a cell of the path, and the side of the cell before it (nearer to the goal) that led here
//   3 empty     the queue is empty and no goal was popped: the last popped cell (side 0)
//   4 overflow  a push finds the queue full: the cell and the side; the search ends
//
// The memory of the cells holds 0 obstacle or start, 1 free, 2 goal or (after the search) path, 3 visited.
// Only the first goal that is discovered can be popped first, so one register holds it, however many goals there are.
module breadth_first_top #(
    parameter ROWS = 100,
    parameter COLUMNS = 100,
    parameter ROW_BITS = 7,
    parameter COLUMN_BITS = 7,
    parameter ADDRESS_BITS = 14,
    parameter LINEAR = 0,
    parameter CYCLES = 14,
    parameter QUEUE_WORDS = 16384,
    parameter POINTER_BITS = 14,
    parameter CHECKED = 0
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
    output reg                     done
);
    localparam [1:0] STANDBY = 2'd0, INIT = 2'd1, BF = 2'd2, PATH = 2'd3;
    localparam [1:0] OBSTACLE = 2'd0, ON_PATH = 2'd2, VISITED = 2'd3, START = 2'd3;
    localparam PIPELINED = CYCLES == 6 ? 1 : 0;

    // The cell before the first one, in Init.
    localparam [31:0] BEFORE = LINEAR != 0 ? 32'hFFFFFFFF : (1 << COLUMN_BITS) - 1;

    reg [1:0] state;
    reg [3:0] cycle;
    assign phase = {2'b00, state};

    // The cell that was popped; in Init the cell before that of the stream, in Path the cell that is marked.
    reg [ADDRESS_BITS-1:0] current;
    reg current_valid;

    // ---- the schedule of an expansion
    wire scheduled_read, scheduled_mark, last_cycle;
    wire [1:0] read_side, mark_side;
    breadth_first_schedule #(.CYCLES(CYCLES)) schedule (
        .cycle(cycle), .read(scheduled_read), .read_side(read_side),
        .mark(scheduled_mark), .mark_side(mark_side), .last(last_cycle)
    );
    wire searching = state == BF;
    wire popping = searching && cycle == 4'd0;

    // ---- Path: a direction is read in even cycles, and its cell is entered two cycles later
    wire [1:0] direction, code;
    wire tracking = state == PATH;
    wire entering = tracking && !cycle[0];
    wire moving = entering && cycle != 4'd0;
    wire arrived = moving && code == OBSTACLE;

    // ---- the address of the next cell
    wire fill, new_row;
    wire [1:0] side = searching ? read_side : direction;
    wire stepping = searching || moving;
    wire [ADDRESS_BITS-1:0] to;
    wire outside;
    breadth_first_move #(
        .LINEAR(LINEAR), .ROWS(ROWS), .COLUMNS(COLUMNS),
        .ROW_BITS(ROW_BITS), .COLUMN_BITS(COLUMN_BITS), .ADDRESS_BITS(ADDRESS_BITS)
    ) move (
        .from(current),
        .north(stepping && side == 2'd0), .south(stepping ? side == 2'd1 : new_row),
        .west(stepping && side == 2'd2), .east(stepping ? side == 2'd3 : state == INIT),
        .to(to), .outside(outside)
    );

    // ---- Init: row by row; a linear address has a wall after every row
    wire wall, row_end, last_cell;
    wire draining;
    assign in_ready = state == INIT && !wall && !draining;
    assign fill = state == INIT && !draining && (wall || in_valid);
    generate
        if (LINEAR != 0) begin : scan_linear
            localparam [31:0] WALL = COLUMNS, LAST = ROWS * (COLUMNS + 1) - 2;
            reg [COLUMN_BITS:0] column;
            always @(posedge clk)
                if (state == STANDBY) column <= {COLUMN_BITS+1{1'b0}};
                else if (fill) column <= wall ? {COLUMN_BITS+1{1'b0}} : column + 1'b1;
            assign wall = column == WALL[COLUMN_BITS:0];
            assign last_cell = to == LAST[ADDRESS_BITS-1:0];
            assign row_end = 1'b0;
            assign new_row = 1'b0;
        end else begin : scan_side_by_side
            localparam [31:0] LAST_ROW = ROWS - 1, LAST_COLUMN = COLUMNS - 1;
            reg first_of_row;
            assign wall = 1'b0;
            assign row_end = to[COLUMN_BITS-1:0] == LAST_COLUMN[COLUMN_BITS-1:0];
            assign last_cell = row_end && to[ADDRESS_BITS-1:COLUMN_BITS] == LAST_ROW[ROW_BITS-1:0];
            assign new_row = state == INIT && first_of_row;
            always @(posedge clk)
                if (state == STANDBY) first_of_row <= 1'b0;
                else if (fill) first_of_row <= row_end;
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

    // ---- a neighbour is pushed if it is free or a goal, and inside of the map
    reg outside_1, outside_2;
    wire read = (searching && scheduled_read) || entering;
    always @(posedge clk) begin
        if (read) outside_1 <= outside;
        outside_2 <= outside_1;
    end
    wire discovered = searching && scheduled_mark && (code[1] ^ code[0]) && !outside_2;
    wire started = written && written_code == START;
    wire next_valid, full;
    wire push = (discovered && !full) || started;
    wire path_mark = PIPELINED != 0 ? moving : tracking && cycle[0];

    // ---- the memories
    wire [1:0] mark_code = written ? written_code & {2{!started}} : tracking ? ON_PATH : VISITED;
    wire mark = written || discovered || path_mark;
    ram_1w1r #(.WIDTH(2), .DEPTH(1 << ADDRESS_BITS), .ADDRESS_BITS(ADDRESS_BITS), .OUTPUT_REGISTER(1)) cells (
        .clk(clk),
        .write_enable(mark), .write_address(mark_cell), .write_data(mark_code),
        .read_enable(read), .read_address(to), .read_data(code)
    );
    ram_1w1r #(.WIDTH(2), .DEPTH(1 << ADDRESS_BITS), .ADDRESS_BITS(ADDRESS_BITS), .OUTPUT_REGISTER(1)) directions (
        .clk(clk),
        .write_enable(discovered), .write_address(mark_cell), .write_data(mark_side ^ 2'd1),
        .read_enable(entering), .read_address(to), .read_data(direction)
    );
    wire advance = (searching && last_cycle) || init_end;
    wire [ADDRESS_BITS-1:0] next_cell;
    breadth_first_queue #(
        .ADDRESS_BITS(ADDRESS_BITS), .WORDS(QUEUE_WORDS), .POINTER_BITS(POINTER_BITS), .CHECKED(CHECKED)
    ) waiting (
        .clk(clk), .clear(state == STANDBY), .push(push), .push_cell(mark_cell), .pop(advance),
        .settle(searching && cycle == 4'd1), .refill(searching && cycle == 4'd2),
        .next_valid(next_valid), .next_cell(next_cell), .full(full)
    );

    // ---- the goal: the first that was discovered, known again when it is popped
    reg [ADDRESS_BITS-1:0] goal;
    reg goal_valid;
    wire goal_popped = current_valid && goal_valid && current == goal;
    wire overflow = discovered && full;
    always @(posedge clk) begin
        if (state == STANDBY) goal_valid <= 1'b0;
        else if (discovered && code[1]) goal_valid <= 1'b1;
        if (!goal_valid) goal <= mark_cell;
    end

    // ---- the cell that is popped, and the states
    always @(posedge clk) begin
        if (advance) current_valid <= next_valid || push;
        if (state == STANDBY) current <= BEFORE[ADDRESS_BITS-1:0];
        else if (advance) begin
            if (next_valid) current <= next_cell;
            else if (push) current <= mark_cell;
        end else if (fill || entering) begin
            current <= to;
            if (fill && row_end) current[COLUMN_BITS-1:0] <= {COLUMN_BITS{1'b1}};
        end

        done <= (popping && !current_valid) || overflow || arrived;
        cycle <= 4'd0;
        case (state)
            STANDBY: if (start) state <= INIT;
            INIT: if (init_end) state <= BF;
            BF: begin
                cycle <= last_cycle ? 4'd0 : cycle + 4'd1;
                if ((popping && !current_valid) || overflow) state <= STANDBY;
                else if (popping && goal_popped) begin
                    state <= PATH;
                    cycle <= 4'd0;
                end
            end
            PATH: begin
                cycle <= {2'b00, cycle[1] | cycle[0], ~cycle[0]};
                if (arrived) state <= STANDBY;
            end
        endcase
        if (reset) state <= STANDBY;
    end

    // ---- events
    assign event_valid = popping || discovered || (tracking && cycle[0]);
    assign event_kind = popping ? (current_valid ? 4'd0 : 4'd3) : tracking ? 4'd2 : overflow ? 4'd4 : 4'd1;
    assign event_data = {tracking ? direction & {2{cycle[1]}} : mark_side, current};
endmodule
