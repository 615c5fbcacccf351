// The machine around an array: the load stream, the passes of the wave, the read-out, the tracked path, the report.
//
// The first word of the stream is the start: its row in the low bits, its column above. The others are the map, LOAD_CELLS
// nodes a word with the flags of the lowest node in the low bits, the last word of the map first.
//
// phase   1 load   2 propagate_obstacles   3 propagate   4 read_out   5 track   0 the report, or nothing
// events  0 potential: the word of a node, in raster order   1 obstacle_potential: the same of a chain, after the first
//         wave   2 step: the next cell of the path, its column in the low bits, its row above
module wavefront_machine #(
    parameter STYLE = 0,            // 0: delay_line, 1: adder_comparator, 2: delay_line with several cells an element
    parameter ROWS = 8,
    parameter COLUMNS = 8,
    parameter ROW_BITS = 3,
    parameter COLUMN_BITS = 3,
    parameter STRAIGHT = 2,
    parameter DIAGONAL = 3,
    parameter EXTRA = 0,
    parameter CORNER_CUTTING = 1,
    parameter SAFE = 0,
    parameter CHAIN = 0,
    parameter WAITS = 1,
    parameter TRACK = 1,            // 1: the path is tracked here
    parameter MOST_STEPS = 1,
    parameter BITS = 6,
    parameter OBSTACLE_BITS = 0,
    parameter LONGEST = 21,
    parameter ELEMENT_CELLS = 1,
    parameter ELEMENT_BITS = 1,     // address bits of the cells of an element
    parameter FLAGS = 2,
    parameter LOAD_CELLS = 32,
    parameter LOAD_WORDS = 2,       // of the map
    parameter WORD = 6,
    parameter EVENT_BITS = 6
) (
    input  wire                        clk,
    input  wire                        reset,
    input  wire                        start,
    input  wire [LOAD_CELLS*FLAGS-1:0] in_data,
    input  wire                        in_valid,
    output wire                        in_ready,
    output wire [3:0]                  phase,
    output wire                        event_valid,
    output wire [3:0]                  event_kind,
    output wire [EVENT_BITS-1:0]       event_data,
    output wire                        done
);
    localparam [2:0] IDLE = 0, LOAD = 1, OBSTACLES = 2, WAVE = 3, READ_OUT = 4, TRACKING = 5, REPORT = 6, DONE = 7;
    localparam LATENCY = 2;         // edges from the address of a node to its word
    localparam SAFE_CHAIN = SAFE != 0 && CHAIN != 0;
    localparam [31:0] BOTTOM = ROWS - 1, RIGHT = COLUMNS - 1, LAST_WORD = LOAD_WORDS;
    localparam F_AT = BITS + OBSTACLE_BITS;
    localparam MEMORY_ROWS = ROWS > 1 ? ROWS : 2;
    localparam P_AT = F_AT + (CORNER_CUTTING != 0 ? 0 : 1);

    reg [2:0] state;
    wire loaded, stop, scanned, tracked, reported;
    wire first_pass;                // between the wave from the obstacles and the end of its read-out
    wire load = in_ready && in_valid;
    wire [2:0] after_wave = CHAIN != 0 ? READ_OUT : TRACK != 0 ? TRACKING : REPORT;
    wire [2:0] after_read_out = first_pass ? WAVE : TRACK != 0 ? TRACKING : DONE;
    always @(posedge clk)
        if (reset) state <= IDLE;
        else case (state)
            IDLE: if (start) state <= LOAD;
            LOAD: if (loaded) state <= SAFE != 0 ? OBSTACLES : WAVE;
            OBSTACLES: if (stop) state <= CHAIN != 0 ? READ_OUT : WAVE;
            WAVE: if (stop) state <= after_wave;
            READ_OUT: if (scanned) state <= after_read_out;
            TRACKING: if (tracked) state <= CHAIN != 0 ? DONE : REPORT;
            REPORT: if (reported) state <= DONE;
            DONE: if (start) state <= LOAD;
        endcase
    assign phase = state <= TRACKING ? {1'b0, state} : 4'd0;
    assign done = state == DONE;

    generate
        if (SAFE_CHAIN) begin : two_read_outs
            reg obstacles_held;
            always @(posedge clk)
                if (state == OBSTACLES) obstacles_held <= 1'b1;
                else if (state != READ_OUT) obstacles_held <= 1'b0;
            assign first_pass = obstacles_held;
        end else begin : one_read_out
            assign first_pass = 1'b0;
        end
    endgenerate

    // The stream: the start, then the map.
    reg header;
    reg [15:0] word_number;
    reg [ROW_BITS-1:0] start_row;
    reg [COLUMN_BITS-1:0] start_column;
    wire load_map = load & ~header;
    wire map_in = load && word_number == LAST_WORD[15:0];
    generate
        if (STYLE == 2) begin : memories
            // The last row of cells reaches the memories one edge later.
            reg all_in;
            always @(posedge clk) all_in <= map_in;
            assign loaded = all_in;
            assign in_ready = state == LOAD && !all_in;
        end else begin : registers
            assign loaded = map_in;
            assign in_ready = state == LOAD;
        end
    endgenerate
    always @(posedge clk) begin
        if (state != LOAD) begin
            header <= 1'b1;
            word_number <= 16'd0;
        end else if (load) begin
            header <= 1'b0;
            word_number <= word_number + 16'd1;
        end
        if (load & header) begin
            start_row <= in_data[ROW_BITS-1:0];
            start_column <= in_data[ROW_BITS +: COLUMN_BITS];
        end
    end

    // The nodes in raster order, for the read-out of a chain and for the report.
    reg [ROW_BITS-1:0] scan_row;
    reg [COLUMN_BITS-1:0] scan_column;
    wire scan = state == READ_OUT || state == REPORT;
    wire at_right = scan_column == RIGHT[COLUMN_BITS-1:0];
    assign scanned = at_right && scan_row == BOTTOM[ROW_BITS-1:0];
    always @(posedge clk)
        if (!scan || scanned) begin
            scan_row <= {ROW_BITS{1'b0}};
            scan_column <= {COLUMN_BITS{1'b0}};
        end else if (at_right) begin
            scan_row <= scan_row + 1'b1;
            scan_column <= {COLUMN_BITS{1'b0}};
        end else scan_column <= scan_column + 1'b1;

    // The array.
    wire run = state == OBSTACLES || state == WAVE;
    wire [ROW_BITS-1:0] row, read_row;
    wire [COLUMN_BITS-1:0] column, read_column;
    wire [WORD-1:0] word;
    assign row = state == TRACKING ? read_row : state == REPORT ? scan_row : start_row;
    assign column = state == TRACKING ? read_column : state == REPORT ? scan_column : start_column;

    // The selection of a node has a cycle of its own. Elements are read like a memory, and need none here.
    reg [ROW_BITS-1:0] selected_row;
    reg [COLUMN_BITS-1:0] selected_column;
    always @(posedge clk) begin
        selected_row <= row;
        selected_column <= column;
    end
    generate
        if (STYLE == 0) begin : delay_line
            delay_line_array #(
                .ROWS(ROWS), .COLUMNS(COLUMNS), .ROW_BITS(ROW_BITS), .COLUMN_BITS(COLUMN_BITS),
                .STRAIGHT(STRAIGHT), .DIAGONAL(DIAGONAL), .EXTRA(EXTRA), .CORNER_CUTTING(CORNER_CUTTING),
                .SAFE(SAFE), .CHAIN(CHAIN), .WAITS(WAITS), .BITS(BITS), .OBSTACLE_BITS(OBSTACLE_BITS),
                .LONGEST(LONGEST), .FLAGS(FLAGS), .LOAD_CELLS(LOAD_CELLS), .WORD(WORD)
            ) array (
                .clk(clk), .load(load_map), .load_word(in_data), .run(run), .obstacle_pass(state == OBSTACLES),
                .stop(stop), .shift(state == READ_OUT), .row(selected_row), .column(selected_column), .word(word)
            );
        end else if (STYLE == 1) begin : adder_comparator
            adder_array #(
                .ROWS(ROWS), .COLUMNS(COLUMNS), .ROW_BITS(ROW_BITS), .COLUMN_BITS(COLUMN_BITS),
                .STRAIGHT(STRAIGHT), .DIAGONAL(DIAGONAL), .EXTRA(EXTRA), .CORNER_CUTTING(CORNER_CUTTING),
                .SAFE(SAFE), .CHAIN(CHAIN), .BITS(BITS), .OBSTACLE_BITS(OBSTACLE_BITS),
                .FLAGS(FLAGS), .LOAD_CELLS(LOAD_CELLS), .WORD(WORD)
            ) array (
                .clk(clk), .load(load_map), .load_word(in_data), .run(run), .obstacle_pass(state == OBSTACLES),
                .stop(stop), .shift(state == READ_OUT), .row(selected_row), .column(selected_column), .word(word)
            );
        end else begin : elements
            element_array #(
                .ROWS(ROWS), .COLUMNS(COLUMNS), .ROW_BITS(ROW_BITS), .COLUMN_BITS(COLUMN_BITS),
                .STRAIGHT(STRAIGHT), .DIAGONAL(DIAGONAL), .EXTRA(EXTRA), .CORNER_CUTTING(CORNER_CUTTING),
                .SAFE(SAFE), .WAITS(WAITS), .BITS(BITS), .OBSTACLE_BITS(OBSTACLE_BITS),
                .LONGEST(LONGEST), .CELLS(ELEMENT_CELLS), .CELL_BITS(ELEMENT_BITS), .FLAGS(FLAGS), .LOAD_CELLS(LOAD_CELLS), .WORD(WORD)
            ) array (
                .clk(clk), .loading(state == LOAD), .load(load_map), .load_word(in_data),
                .run(run), .obstacle_pass(state == OBSTACLES),
                .stop(stop), .row(row), .column(column), .word(word)
            );
        end
    endgenerate

    // The tracker. It reads the array, or a memory that the chain filled.
    wire step;
    wire [ROW_BITS-1:0] step_row;
    wire [COLUMN_BITS-1:0] step_column;
    generate
        if (TRACK != 0) begin : track
            localparam TRACK_DISTANCE_BITS = SAFE == 0 ? 1 : CHAIN != 0 ? BITS : OBSTACLE_BITS;
            wire [WORD-1:0] read_word;
            wire [TRACK_DISTANCE_BITS-1:0] distance;
            wire free, penalised;
            wire unused_word = &{1'b0, read_word};
            if (CHAIN != 0) begin : from_memory
                ram_1w1r #(.WIDTH(WORD), .DEPTH(MEMORY_ROWS << COLUMN_BITS), .ADDRESS_BITS(ROW_BITS + COLUMN_BITS)) potentials (
                    .clk(clk), .write_enable(state == READ_OUT & ~first_pass), .write_address({scan_row, scan_column}),
                    .write_data(word), .read_enable(1'b1), .read_address({selected_row, selected_column}),
                    .read_data(read_word)
                );
                if (SAFE != 0) begin : distances
                    ram_1w1r #(
                        .WIDTH(BITS), .DEPTH(MEMORY_ROWS << COLUMN_BITS), .ADDRESS_BITS(ROW_BITS + COLUMN_BITS)
                    ) obstacle_potentials (
                        .clk(clk), .write_enable(state == READ_OUT & first_pass),
                        .write_address({scan_row, scan_column}), .write_data(word[BITS-1:0]), .read_enable(1'b1),
                        .read_address({selected_row, selected_column}), .read_data(distance)
                    );
                end else begin : no_distances
                    assign distance = 1'b0;
                end
            end else begin : from_array
                assign read_word = word;
                if (SAFE != 0) begin : distances
                    assign distance = word[BITS +: OBSTACLE_BITS];
                end else begin : no_distances
                    assign distance = 1'b0;
                end
            end
            if (CORNER_CUTTING != 0) begin : cuts
                assign free = 1'b1;
            end else begin : keeps_corners
                assign free = read_word[F_AT];
            end
            if (EXTRA > 0) begin : penalty
                assign penalised = read_word[P_AT];
            end else begin : no_penalty
                assign penalised = 1'b0;
            end
            path_tracker #(
                .ROWS(ROWS), .COLUMNS(COLUMNS), .ROW_BITS(ROW_BITS), .COLUMN_BITS(COLUMN_BITS),
                .STRAIGHT(STRAIGHT), .DIAGONAL(DIAGONAL), .EXTRA(EXTRA), .CORNER_CUTTING(CORNER_CUTTING),
                .SAFE(SAFE), .BITS(BITS), .OBSTACLE_BITS(TRACK_DISTANCE_BITS), .MOST_STEPS(MOST_STEPS)
            ) tracker (
                .clk(clk), .place(state != TRACKING), .start_row(start_row), .start_column(start_column),
                .run(state == TRACKING), .read_row(read_row), .read_column(read_column),
                .potential(read_word[BITS-1:0]), .distance(distance), .free(free), .penalised(penalised),
                .step(step), .step_row(step_row), .step_column(step_column), .last(tracked)
            );
        end else begin : no_track
            assign {step, step_row, step_column} = {1 + ROW_BITS + COLUMN_BITS{1'b0}};
            assign {read_row, read_column} = {ROW_BITS + COLUMN_BITS{1'b0}};
            assign tracked = 1'b1;
        end
    endgenerate

    // The report: the words of all nodes, LATENCY edges after their addresses.
    wire node_shown;
    generate
        if (CHAIN != 0) begin : report_chain
            assign reported = 1'b1;
            assign node_shown = state == READ_OUT;
        end else begin : report_array
            reg asked_all;
            reg [LATENCY-1:0] asked, final_one;
            wire [LATENCY:0] next_asked = {asked, state == REPORT && !asked_all};
            wire [LATENCY:0] next_final = {final_one, scanned && !asked_all};
            always @(posedge clk) begin
                asked_all <= state == REPORT && (asked_all || scanned);
                asked <= state == REPORT ? next_asked[LATENCY-1:0] : {LATENCY{1'b0}};
                final_one <= state == REPORT ? next_final[LATENCY-1:0] : {LATENCY{1'b0}};
            end
            assign node_shown = next_asked[LATENCY];
            assign reported = next_final[LATENCY];
        end
    endgenerate
    assign event_valid = step | node_shown;
    assign event_kind = step ? 4'd2 : first_pass ? 4'd1 : 4'd0;
    localparam [31:0] ADDRESS_BITS = ROW_BITS + COLUMN_BITS;
    wire [EVENT_BITS-1:0] shown_word, shown_step;
    generate
        if (EVENT_BITS > WORD) begin : wide_event
            assign shown_word = {{EVENT_BITS-WORD{1'b0}}, word};
        end else begin : word_event
            assign shown_word = word;
        end
        if (EVENT_BITS > ADDRESS_BITS) begin : wide_step
            assign shown_step = {{EVENT_BITS-ADDRESS_BITS{1'b0}}, step_row, step_column};
        end else begin : step_event
            assign shown_step = {step_row, step_column};
        end
    endgenerate
    assign event_data = step ? shown_step : shown_word;

    // Inputs that other parameters need.
    wire unused = &{1'b0, stop, first_pass, word, in_data, start_row, start_column, read_row, read_column, selected_row,
        selected_column};
endmodule
