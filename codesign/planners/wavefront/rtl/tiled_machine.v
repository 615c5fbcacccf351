// The machine around the array of one tile: the load stream, the visits of tiles, the tracked path, the report.
//
// The first word of the stream is the start: from the low bits on its row, its column, its address in the memory of its
// column, and that column of the tile. The others are the map, tile by tile in raster order, row by row, LOAD_CELLS
// cells of the row a word with the flags of the leftmost cell in the low bits.
//
// A visit:  scan      which tile is next, if any
//           read      rows from the one below the tile up to the one above; then the cells beside it, left and right
//           arm       the counter takes the time of the first emission
//           wave
//           write     the rows from the lowest up, and what they change for the tiles around
//
// phase   1 load   2 propagate_obstacles   3 propagate   4 exchange   5 track   0 the report, or nothing
// events  0 potential: the word of a cell, in raster order   2 step: the next cell of the path, its column in the low
//         bits, its row above   3 visit: a tile
module tiled_machine #(
    parameter ROWS = 8,
    parameter COLUMNS = 8,
    parameter ROW_BITS = 3,
    parameter COLUMN_BITS = 3,
    parameter TILE_ROWS = 4,
    parameter TILE_COLUMNS = 4,
    parameter DOWN = 2,             // rows of tiles, and how many across
    parameter ACROSS = 2,
    parameter DOWN_BITS = 2,
    parameter ACROSS_BITS = 2,
    parameter TILE_BITS = 2,        // of the number of a tile
    parameter ADDRESS_BITS = 4,     // of a cell in the memory of its column
    parameter PLACE_BITS = 2,       // of a column of the tile
    parameter STEP_BITS = 3,        // of a count of TILE_ROWS + 1
    parameter LEVELS = 2,           // 2 to the power of LEVELS is at least TILE_COLUMNS
    parameter STRAIGHT = 2,
    parameter DIAGONAL = 3,
    parameter EXTRA = 0,
    parameter CORNER_CUTTING = 1,
    parameter SAFE = 0,
    parameter WAITS = 1,
    parameter TRACK = 1,
    parameter MOST_STEPS = 1,
    parameter BITS = 6,
    parameter OBSTACLE_BITS = 0,
    parameter FLAGS = 2,
    parameter LOAD_CELLS = 4,
    parameter LOAD_BITS = 12,       // of a word of the stream
    parameter WORD = 6,
    parameter EVENT_BITS = 6
) (
    input  wire                  clk,
    input  wire                  reset,
    input  wire                  start,
    input  wire [LOAD_BITS-1:0]  in_data,
    input  wire                  in_valid,
    output wire                  in_ready,
    output wire [3:0]            phase,
    output wire                  event_valid,
    output wire [3:0]            event_kind,
    output wire [EVENT_BITS-1:0] event_data,
    output wire                  done
);
    localparam [3:0] IDLE = 0, LOAD = 1, SCAN = 2, READ = 3, ARM = 4, WAVE = 5, WRITE = 6, TRACKING = 7, REPORT = 8,
        DONE = 9;
    localparam LATENCY = 2;
    localparam WORDS = DOWN * ACROSS * TILE_ROWS;
    localparam DEPTH = WORDS > 1 ? WORDS : 2;
    localparam CHUNKS = (TILE_COLUMNS + LOAD_CELLS - 1) / LOAD_CELLS;
    localparam F_AT = BITS + OBSTACLE_BITS;
    localparam P_AT = F_AT + (CORNER_CUTTING != 0 ? 0 : 1);
    localparam NODE_WORD = BITS + (CORNER_CUTTING != 0 ? 0 : 1) + (EXTRA > 0 ? 1 : 0);
    // Sweeps of a read: rows, and the cells beside the tile; in a tile of one column these share a memory.
    localparam [1:0] LEFT_SWEEP = 1, RIGHT_SWEEP = TILE_COLUMNS > 1 ? 1 : 2;
    localparam [31:0] ROW_STEP = ACROSS, BELOW = TILE_ROWS * ACROSS, LOWEST = (TILE_ROWS - 1) * ACROSS;
    localparam [31:0] TOP_STEP = TILE_ROWS + 1, LAST_STEP = TILE_ROWS, LAST_ROW = TILE_ROWS - 1;
    localparam [31:0] LAST_CHUNK = CHUNKS - 1;
    localparam [31:0] BOTTOM = ROWS - 1, RIGHT = COLUMNS - 1;

    reg [3:0] state;
    reg obstacle_pass, fresh;
    wire loaded, decided, go, read_all, stop, tracked, reported;
    wire read_in = state == READ, run = state == WAVE, writing = state == WRITE;
    reg [STEP_BITS-1:0] step_count;
    wire written = step_count == LAST_STEP[STEP_BITS-1:0];
    always @(posedge clk)
        if (reset) state <= IDLE;
        else case (state)
            IDLE: if (start) state <= LOAD;
            LOAD: if (loaded) state <= SCAN;
            SCAN: if (decided) state <= go ? READ : obstacle_pass ? SCAN : TRACK != 0 ? TRACKING : REPORT;
            READ: if (read_all) state <= ARM;
            ARM: state <= WAVE;
            WAVE: if (stop) state <= WRITE;
            WRITE: if (written) state <= SCAN;
            TRACKING: if (tracked) state <= REPORT;
            REPORT: if (reported) state <= DONE;
            default: if (start) state <= LOAD;
        endcase
    always @(posedge clk)
        if (state == LOAD) begin
            obstacle_pass <= SAFE != 0;
            fresh <= 1'b1;
        end else if (decided) begin
            obstacle_pass <= obstacle_pass & go;
            fresh <= ~go;
        end
    assign phase = state == LOAD ? 4'd1 : run ? (obstacle_pass ? 4'd2 : 4'd3)
        : state >= SCAN && state <= WRITE ? 4'd4 : state == TRACKING ? 4'd5 : 4'd0;
    assign done = state == DONE;

    // The stream: the start, then the map.
    reg header, source_before, obstacle_before;
    reg [STEP_BITS-1:0] load_row;
    reg [ADDRESS_BITS-1:0] load_offset;
    reg [7:0] chunk;
    wire walk_last;
    wire [ADDRESS_BITS-1:0] walk_base;
    assign in_ready = state == LOAD;
    wire load = in_ready && in_valid, load_map = load & ~header;
    wire row_ends = chunk == LAST_CHUNK[7:0];
    wire note = load_map && row_ends && load_row == LAST_ROW[STEP_BITS-1:0];
    wire [LOAD_CELLS-1:0] word_sources, word_obstacles;
    wire has_source = source_before | (|word_sources), has_obstacle = obstacle_before | (|word_obstacles);
    genvar at;
    generate
        for (at = 0; at < LOAD_CELLS; at = at + 1) begin : loaded_cell
            assign word_sources[at] = &in_data[at*FLAGS +: 2];
            assign word_obstacles[at] = ~|in_data[at*FLAGS +: 2];
        end
    endgenerate
    assign loaded = note && walk_last;
    reg [ROW_BITS-1:0] start_row;
    reg [COLUMN_BITS-1:0] start_column;
    reg [ADDRESS_BITS-1:0] start_address;
    reg [PLACE_BITS-1:0] start_place;
    always @(posedge clk) begin
        if (state != LOAD) header <= 1'b1;
        else if (load) header <= 1'b0;
        if (load & header)
            {start_place, start_address, start_column, start_row} <=
                in_data[PLACE_BITS+ADDRESS_BITS+COLUMN_BITS+ROW_BITS-1:0];
        if (state != LOAD || note) begin
            chunk <= 8'd0;
            load_row <= {STEP_BITS{1'b0}};
            load_offset <= {ADDRESS_BITS{1'b0}};
            source_before <= 1'b0;
            obstacle_before <= 1'b0;
        end else if (load_map) begin
            chunk <= row_ends ? 8'd0 : chunk + 8'd1;
            load_row <= row_ends ? load_row + 1'b1 : load_row;
            load_offset <= row_ends ? load_offset + ROW_STEP[ADDRESS_BITS-1:0] : load_offset;
            source_before <= has_source;
            obstacle_before <= has_obstacle;
        end
    end

    // The scheduler.
    wire [BITS-1:0] north, north_east, east, south_east, south, south_west, west, north_west;
    wire [BITS-1:0] earliest, begins, stop_potential;
    wire [TILE_BITS-1:0] tile;
    wire [ADDRESS_BITS-1:0] base;
    wire at_top, at_bottom, at_left, at_right;
    wire visit = decided & go;
    assign go = earliest < stop_potential;
    tile_scheduler #(
        .DOWN(DOWN), .ACROSS(ACROSS), .DOWN_BITS(DOWN_BITS), .ACROSS_BITS(ACROSS_BITS), .TILE_BITS(TILE_BITS),
        .ADDRESS_BITS(ADDRESS_BITS), .DOWN_STEP((TILE_ROWS - 1) * ACROSS + 1), .SETTLE(LEVELS), .SAFE(SAFE),
        .BITS(BITS)
    ) scheduler (
        .clk(clk), .restart(load & header), .note(note), .has_source(has_source), .has_obstacle(has_obstacle),
        .walk_base(walk_base), .walk_last(walk_last), .scan(state == SCAN), .fresh(fresh),
        .obstacle_pass(obstacle_pass), .visit(visit), .north(north), .north_east(north_east), .east(east),
        .south_east(south_east), .south(south), .south_west(south_west), .west(west), .north_west(north_west),
        .decided(decided), .earliest(earliest), .begins(begins), .tile(tile), .base(base), .at_top(at_top),
        .at_bottom(at_bottom), .at_left(at_left), .at_right(at_right)
    );

    // The rows of a visit, lowest first. Step 0 of a read is the row below the tile, its last step the one above.
    reg [1:0] sweep;
    reg [ADDRESS_BITS-1:0] row_address, written_address;
    reg draining;
    wire step_ends = step_count == TOP_STEP[STEP_BITS-1:0];
    wire below = step_count == {STEP_BITS{1'b0}};
    wire outside = below ? at_bottom : step_ends & at_top;
    wire [ADDRESS_BITS-1:0] read_row_at = outside ? base : row_address;
    assign read_all = draining;
    always @(posedge clk) begin
        draining <= read_in && step_ends && sweep == RIGHT_SWEEP && !draining;
        if (!read_in && !writing || read_in && step_ends) step_count <= {STEP_BITS{1'b0}};
        else step_count <= step_count + 1'b1;
        if (!read_in) sweep <= 2'd0;
        else if (step_ends) sweep <= sweep + 2'd1;
        if (state == SCAN || read_in && step_ends) row_address <= base + BELOW[ADDRESS_BITS-1:0];
        else if (state == ARM) row_address <= base + LOWEST[ADDRESS_BITS-1:0];
        else if (read_in || writing) row_address <= row_address - ROW_STEP[ADDRESS_BITS-1:0];
        written_address <= row_address;
    end

    // What the words that arrive are for.
    wire to_left = sweep == LEFT_SWEEP, to_right = sweep == RIGHT_SWEEP;
    reg take_row, take_above, take_below, take_left, take_right, void_row, void_left, void_right, store;
    reg store_bottom, store_top;
    always @(posedge clk) begin
        take_row <= read_in && sweep == 2'd0 && !below && !step_ends;
        take_below <= read_in && sweep == 2'd0 && below;
        take_above <= read_in && sweep == 2'd0 && step_ends;
        take_left <= read_in && to_left && !draining;
        take_right <= read_in && to_right && !draining;
        void_row <= outside;
        void_left <= outside | at_left;
        void_right <= outside | at_right;
        store <= writing && !written;
        store_bottom <= writing && below;
        store_top <= writing && step_count == LAST_ROW[STEP_BITS-1:0];
    end

    // The counter: it is armed with the first time, and then one ahead of the time. It keeps the last count.
    reg [BITS-1:0] counter;
    always @(posedge clk)
        if (state == READ) counter <= begins;
        else if (state == ARM || run && !stop) counter <= counter + 1'b1;

    // The columns.
    wire [ADDRESS_BITS-1:0] cursor_address;
    wire [PLACE_BITS-1:0] cursor_place;
    wire visiting = read_in || writing;
    wire [ADDRESS_BITS-1:0] row_read = !visiting ? cursor_address : read_in ? read_row_at : written ? base : row_address;
    wire [ADDRESS_BITS-1:0] left_read = read_in && to_left && !at_left ? read_row_at - 1'b1 : row_read;
    wire [ADDRESS_BITS-1:0] right_read = read_in && to_right && !at_right ? read_row_at + 1'b1 : row_read;
    wire [ADDRESS_BITS-1:0] write_address = load ? walk_base + load_offset : written_address;
    wire [TILE_COLUMNS*FLAGS-1:0] row_flags;
    wire [TILE_COLUMNS-1:0] row_live, row_open;
    wire [TILE_COLUMNS*BITS-1:0] row_potentials, row_changes, results;
    wire [TILE_COLUMNS*WORD-1:0] row_words;
    generate
        for (at = 0; at < TILE_COLUMNS; at = at + 1) begin : column
            localparam [31:0] CHUNK = at / LOAD_CELLS;
            wire [ADDRESS_BITS-1:0] read_address;
            if (TILE_COLUMNS == 1) begin : only
                assign read_address = to_left ? left_read : right_read;
            end else if (at == 0) begin : first
                assign read_address = right_read;
            end else if (at == TILE_COLUMNS - 1) begin : last
                assign read_address = left_read;
            end else begin : middle
                assign read_address = row_read;
            end
            tile_column #(
                .SAFE(SAFE), .EXTRA(EXTRA), .CORNER_CUTTING(CORNER_CUTTING), .BITS(BITS),
                .OBSTACLE_BITS(OBSTACLE_BITS), .FLAGS(FLAGS), .WORD(WORD), .DEPTH(DEPTH), .ADDRESS_BITS(ADDRESS_BITS)
            ) memory (
                .clk(clk), .obstacle_pass(obstacle_pass), .read_address(read_address), .write_address(write_address),
                .load(load_map && chunk == CHUNK[7:0]), .load_flags(in_data[(at%LOAD_CELLS)*FLAGS +: FLAGS]),
                .store(store), .result(results[at*BITS +: BITS]), .last_count(counter),
                .flags(row_flags[at*FLAGS +: FLAGS]), .live(row_live[at]), .potential(row_potentials[at*BITS +: BITS]),
                .change(row_changes[at*BITS +: BITS]), .word(row_words[at*WORD +: WORD])
            );
            assign row_open[at] = row_flags[at*FLAGS];
        end
    endgenerate

    // The array of the tile, and what a visit changes.
    tile_array #(
        .ROWS(TILE_ROWS), .COLUMNS(TILE_COLUMNS), .STRAIGHT(STRAIGHT), .DIAGONAL(DIAGONAL), .EXTRA(EXTRA),
        .CORNER_CUTTING(CORNER_CUTTING), .BITS(BITS), .FLAGS(FLAGS), .WORD(NODE_WORD)
    ) array (
        .clk(clk), .load(take_row), .row_flags(row_flags), .load_above(take_above), .load_below(take_below),
        .row_open(row_open & {TILE_COLUMNS{~void_row}}), .row_live(row_live & {TILE_COLUMNS{~void_row}}),
        .row_potentials(row_potentials),
        .load_left(take_left), .left_open(row_open[TILE_COLUMNS-1] & ~void_left),
        .left_live(row_live[TILE_COLUMNS-1] & ~void_left),
        .left_potential(row_potentials[(TILE_COLUMNS-1)*BITS +: BITS]),
        .load_right(take_right), .right_open(row_open[0] & ~void_right), .right_live(row_live[0] & ~void_right),
        .right_potential(row_potentials[BITS-1:0]), .arm(state == ARM), .run(run), .counter(counter), .stop(stop),
        .shift(store), .row_out(results)
    );
    earliest_changes #(.COLUMNS(TILE_COLUMNS), .LEVELS(LEVELS), .BITS(BITS)) minima (
        .clk(clk), .take(store), .bottom(store_bottom), .top(store_top), .changes(row_changes), .north(north),
        .north_east(north_east), .east(east), .south_east(south_east), .south(south), .south_west(south_west),
        .west(west), .north_west(north_west)
    );

    // The word of a cell: from its address and its column of the tile, two edges later.
    reg [PLACE_BITS-1:0] place_asked;
    reg [WORD-1:0] word;
    wire [WORD-1:0] selected;
    select_line #(.COUNT(TILE_COLUMNS), .NUMBER_BITS(PLACE_BITS), .WORD(WORD)) read_out (
        .number(place_asked), .words(row_words), .word(selected)
    );
    always @(posedge clk) begin
        place_asked <= cursor_place;
        word <= selected;
    end

    // The potential of the start, which ends the visits: a scan reads it, the report compares with it.
    wire beyond;
    generate
        if (WAITS != 0) begin : waits
            reg [BITS-1:0] start_potential;
            always @(posedge clk) if (decided) start_potential <= stop_potential;
            assign stop_potential = obstacle_pass ? {BITS{1'b1}} : word[BITS-1:0];
            assign beyond = word[BITS-1:0] > start_potential;
        end else begin : whole_map
            assign stop_potential = {BITS{1'b1}};
            assign beyond = 1'b0;
        end
    endgenerate

    // The tracker.
    wire step;
    wire [ROW_BITS-1:0] read_row, step_row;
    wire [COLUMN_BITS-1:0] read_column, step_column;
    generate
        if (TRACK != 0) begin : track
            localparam TRACK_DISTANCE_BITS = SAFE == 0 ? 1 : OBSTACLE_BITS;
            wire [TRACK_DISTANCE_BITS-1:0] distance;
            wire free, penalised;
            if (SAFE != 0) begin : distances
                assign distance = word[BITS +: OBSTACLE_BITS];
            end else begin : no_distances
                assign distance = 1'b0;
            end
            if (CORNER_CUTTING != 0) begin : cuts
                assign free = 1'b1;
            end else begin : keeps_corners
                assign free = word[F_AT];
            end
            if (EXTRA > 0) begin : penalty
                assign penalised = word[P_AT];
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
                .potential(word[BITS-1:0]), .distance(distance), .free(free), .penalised(penalised),
                .step(step), .step_row(step_row), .step_column(step_column), .last(tracked)
            );
        end else begin : no_track
            assign {step, step_row, step_column} = {1 + ROW_BITS + COLUMN_BITS{1'b0}};
            assign {read_row, read_column} = {ROW_BITS + COLUMN_BITS{1'b0}};
            assign tracked = 1'b1;
        end
    endgenerate

    // The cell that is read: the start, the cells of a step, or all cells for the report.
    reg [ROW_BITS-1:0] scan_row;
    reg [COLUMN_BITS-1:0] scan_column;
    reg asked_all;
    reg [LATENCY-1:0] asked, final_one;
    wire at_row_end = scan_column == RIGHT[COLUMN_BITS-1:0];
    wire ask = state == REPORT && !asked_all;
    wire last_cell = ask && at_row_end && scan_row == BOTTOM[ROW_BITS-1:0];
    always @(posedge clk) begin
        asked_all <= state == REPORT && (asked_all || last_cell);
        asked <= state == REPORT ? {asked[LATENCY-2:0], ask} : {LATENCY{1'b0}};
        final_one <= state == REPORT ? {final_one[LATENCY-2:0], last_cell} : {LATENCY{1'b0}};
        if (state != REPORT) begin
            scan_row <= {ROW_BITS{1'b0}};
            scan_column <= {COLUMN_BITS{1'b0}};
        end else if (ask) begin
            scan_row <= at_row_end ? scan_row + 1'b1 : scan_row;
            scan_column <= at_row_end ? {COLUMN_BITS{1'b0}} : scan_column + 1'b1;
        end
    end
    wire node_shown = asked[LATENCY-1];
    assign reported = final_one[LATENCY-1];
    wire rewind = state == TRACKING ? tracked : TRACK == 0 && decided && !go && !obstacle_pass;
    tile_cursor #(
        .ACROSS(ACROSS), .COLUMNS(TILE_COLUMNS), .WORDS(WORDS), .ROW_BITS(ROW_BITS), .COLUMN_BITS(COLUMN_BITS),
        .ADDRESS_BITS(ADDRESS_BITS), .PLACE_BITS(PLACE_BITS)
    ) cursor (
        .clk(clk), .at_start(state <= WRITE), .start_row(start_row), .start_column(start_column),
        .start_address(start_address), .start_place(start_place), .rewind(rewind),
        .next(ask), .row_ends(at_row_end), .look(state == TRACKING), .move(step),
        .row(step ? step_row : read_row), .column(step ? step_column : read_column),
        .address(cursor_address), .place(cursor_place)
    );

    // The events.
    localparam [31:0] CELL_BITS = ROW_BITS + COLUMN_BITS;
    wire [WORD+BITS-1:0] hidden = {{WORD{1'b0}}, {BITS{beyond}}};
    wire [EVENT_BITS+WORD-1:0] wide_word = {{EVENT_BITS{1'b0}}, word | hidden[WORD-1:0]};
    wire [EVENT_BITS+CELL_BITS-1:0] wide_step = {{EVENT_BITS{1'b0}}, step_row, step_column};
    wire [EVENT_BITS+TILE_BITS-1:0] wide_tile = {{EVENT_BITS{1'b0}}, tile};
    assign event_valid = step | node_shown | visit;
    assign event_kind = visit ? 4'd3 : step ? 4'd2 : 4'd0;
    assign event_data = visit ? wide_tile[EVENT_BITS-1:0] : step ? wide_step[EVENT_BITS-1:0] : wide_word[EVENT_BITS-1:0];

    // Inputs that other parameters need.
    wire unused = &{1'b0, in_data, hidden, wide_word, wide_step, wide_tile, obstacle_pass, fresh, has_obstacle, read_row,
        read_column, step_row, step_column, word};
endmodule
