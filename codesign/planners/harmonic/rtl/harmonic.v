// The harmonic circuit (Girau et al. 2008, section 5): h <- (N + E + S + W) / 4 on a block of ROWS x COLUMNS nodes,
// bit-serially, block after block, at rising precision; then a decision for the robot, and the read-out of the field.
//
// Phases: 1 load, 2 relax, 3 decide (where DECISION = 1), 4 read. Stream: the words of harmonic_load; then the position
// of the robot in one word, from the lowest bit: its column and row within its block, the address of the block's first
// word, and whether there is a block to the west, south, east, north.
//
// Events: 0 a visit ends {block, iterations}; 1 a stage ends {sweeps, some node is a local maximum, 0 where the
// circuit does not look: several blocks, SOUND = 0 and STOP_WITHOUT_MAXIMA = 0}; 2 the decision {horizontal, vertical},
// each {not equal, higher, the south or west one}; 3 a digit of nodes of a row, up to 64 bits together, the lowest digit
// first, in the order block, row, columns.
module harmonic #(
    parameter ROWS = 6,
    parameter COLUMNS = 12,
    parameter DOWN = 1,
    parameter ACROSS = 1,
    parameter LAST_PRECISION = 15,
    parameter STAGES = 1,
    parameter [10*STAGES-1:0] PRECISIONS = 10'd15,
    parameter ITERATIONS = 8,
    parameter SOUND = 1,
    parameter STOP_WITHOUT_MAXIMA = 1,
    parameter DECISION = 1,
    parameter DIGIT_BITS = 1,  // 1, 2, 4 or 8 bits of every value a cycle
    parameter PIPELINE = 0,
    parameter IN_BITS = 18,
    parameter EVENT_BITS = 32
) (
    input  wire                  clk,
    input  wire                  reset,
    input  wire                  start,
    input  wire [IN_BITS-1:0]    in_data,
    input  wire                  in_valid,
    output wire                  in_ready,
    output wire [3:0]            phase,
    output reg                   event_valid,
    output reg  [3:0]            event_kind,
    output reg  [EVENT_BITS-1:0] event_data,
    output wire                  done
);
    localparam BLOCKS = DOWN * ACROSS;
    localparam DIGIT_PLACES = $clog2(DIGIT_BITS);
    localparam STRIDE = (LAST_PRECISION + DIGIT_BITS - 1) / DIGIT_BITS + 1;
    localparam PRECISION_BITS = $clog2(LAST_PRECISION + DIGIT_BITS);
    localparam LENGTH_BITS = PRECISION_BITS - DIGIT_PLACES;
    localparam ADDRESS_BITS = $clog2(BLOCKS * STRIDE);
    localparam CLUSTERS = ((ROWS + 2) / 3) * ((COLUMNS + 5) / 6);
    localparam SIDES = (DOWN > 1 ? 2 * ((COLUMNS + 17) / 18) : 0) + (ACROSS > 1 ? 2 * ((ROWS + 17) / 18) : 0);
    localparam MEMORIES = CLUSTERS + SIDES;
    localparam MOST_COLUMNS = 64 / DIGIT_BITS;
    localparam CHUNK = COLUMNS < MOST_COLUMNS ? COLUMNS : MOST_COLUMNS;
    localparam CHUNKS = (COLUMNS + MOST_COLUMNS - 1) / MOST_COLUMNS;
    localparam BLOCK_BITS = BLOCKS > 1 ? $clog2(BLOCKS) : 1;
    localparam ROW_BITS = ROWS > 1 ? $clog2(ROWS) : 1;
    localparam COLUMN_BITS = COLUMNS > 1 ? $clog2(COLUMNS) : 1;
    localparam CHUNK_BITS = CHUNKS > 1 ? $clog2(CHUNKS) : 1;
    localparam ITERATION_BITS = $clog2(ITERATIONS + 1);
    localparam SWEEP_BITS = 24;

    // Cycles: from an address to its word, to its digit on the streams, and to the write of the result in its place.
    localparam MEMORY_DELAY = 1 + PIPELINE;
    localparam STREAM_DELAY = MEMORY_DELAY + PIPELINE;
    localparam WRITE_DELAY = STREAM_DELAY + PIPELINE + (DIGIT_BITS == 1 ? 2 : 1);
    // Registers in the OR trees, as harmonic_array has them: with a pipeline, one a cluster and one for 16 of those
    // before; without, one for 288 nodes, but for the last.
    localparam TREE = PIPELINE != 0 ? 1 + stages(CLUSTERS, 16) : stages(18 * CLUSTERS, 288) - 1;
    localparam ANSWER = 1 + STREAM_DELAY + TREE;

    function integer stages(input integer inputs, input integer group);
        integer rest;
        begin
            stages = 1;
            for (rest = inputs; rest > group; rest = (rest + group - 1) / group) stages = stages + 1;
        end
    endfunction

    // The precisions as harmonic_control has them.
    function [11*STAGES-1:0] rounded(input [10*STAGES-1:0] precisions);
        integer stage;
        begin
            for (stage = 0; stage < STAGES; stage = stage + 1)
                rounded[11*stage+:11] = {1'b0, precisions[10*stage+:10]} + DIGIT_BITS[10:0] - 11'd1;
        end
    endfunction

    wire open, advance, home, wrap, pre, zero, reads, writes, drops, shows, finishes;
    wire [PRECISION_BITS-1:0] precision;
    wire [3:0] sides;
    wire [ROW_BITS-1:0] read_row;
    wire [CHUNK_BITS-1:0] read_chunk;
    wire loaded, asks, changed, maximum, load_ready, load_writes;
    wire [ADDRESS_BITS-1:0] load_address;
    wire [MEMORIES-1:0] load_enable;
    wire [17:0] load_word;
    wire taken = asks & in_valid;
    assign in_ready = load_ready | asks;

    // The position of the robot.
    wire [COLUMN_BITS-1:0] column_word = in_data[0 +: COLUMN_BITS];
    wire [ROW_BITS-1:0] row_word = in_data[COLUMN_BITS +: ROW_BITS];
    wire [ADDRESS_BITS-1:0] base_word = in_data[COLUMN_BITS + ROW_BITS +: ADDRESS_BITS];
    wire [3:0] sides_word = in_data[COLUMN_BITS + ROW_BITS + ADDRESS_BITS +: 4];
    reg [COLUMN_BITS-1:0] robot_column;
    reg [ROW_BITS-1:0] robot_row;
    reg [3:0] robot_sides;
    always @(posedge clk) if (taken) begin
        robot_column <= column_word;
        robot_row <= row_word;
        robot_sides <= sides_word;
    end

    harmonic_load #(
        .BLOCKS(BLOCKS),
        .STRIDE(STRIDE),
        .MEMORIES(MEMORIES),
        .ADDRESS_BITS(ADDRESS_BITS)
    ) loader (
        .clk(clk),
        .reset(reset),
        .start(start),
        .in_data(in_data[17:0]),
        .in_valid(in_valid),
        .in_ready(load_ready),
        .over(loaded),
        .writes(load_writes),
        .write_address(load_address),
        .write_enable(load_enable),
        .load_word(load_word)
    );

    wire visit_event, stage_event, stage_maxima, finished;
    wire [BLOCK_BITS-1:0] visit_block;
    wire [ITERATION_BITS-1:0] visit_iterations;
    wire [SWEEP_BITS-1:0] stage_sweeps;
    harmonic_control #(
        .DOWN(DOWN),
        .ACROSS(ACROSS),
        .ROWS(ROWS),
        .CHUNKS(CHUNKS),
        .STAGES(STAGES),
        .PRECISION_BITS(PRECISION_BITS),
        .DIGIT_PLACES(DIGIT_PLACES),
        .PRECISIONS(rounded(PRECISIONS)),
        .ITERATIONS(ITERATIONS),
        .ITERATION_BITS(ITERATION_BITS),
        .SOUND(SOUND),
        .STOP_WITHOUT_MAXIMA(STOP_WITHOUT_MAXIMA),
        .CHECK(SOUND == 0 && STOP_WITHOUT_MAXIMA != 0 && BLOCKS > 1),
        .DECISION(DECISION),
        .ANSWER(ANSWER),
        .BLOCK_BITS(BLOCK_BITS),
        .ROW_BITS(ROW_BITS),
        .CHUNK_BITS(CHUNK_BITS),
        .SWEEP_BITS(SWEEP_BITS)
    ) control (
        .clk(clk),
        .reset(reset),
        .start(start),
        .loaded(loaded),
        .taken(taken),
        .robot_sides(robot_sides),
        .changed(changed),
        .maximum(maximum),
        .phase(phase),
        .asks(asks),
        .open(open),
        .advance(advance),
        .home(home),
        .wrap(wrap),
        .pre(pre),
        .zero(zero),
        .reads(reads),
        .writes(writes),
        .drops(drops),
        .precision(precision),
        .sides(sides),
        .row(read_row),
        .chunk(read_chunk),
        .shows(shows),
        .finishes(finishes),
        .finished(finished),
        .visit_event(visit_event),
        .visit_block(visit_block),
        .visit_iterations(visit_iterations),
        .stage_event(stage_event),
        .stage_sweeps(stage_sweeps),
        .stage_maxima(stage_maxima),
        .done(done)
    );

    // Addresses: of the visited block, and of the blocks around it.
    localparam [31:0] STEP = STRIDE, LINE = ACROSS * STRIDE;
    localparam [ADDRESS_BITS-1:0] STEP_BITS = STEP[ADDRESS_BITS-1:0], LINE_STEP = LINE[ADDRESS_BITS-1:0];
    wire [ADDRESS_BITS-1:0] length;
    wire [ADDRESS_BITS-1:0] here_address, north_address, east_address, south_address, west_address;
    generate
        if (ADDRESS_BITS > LENGTH_BITS)
            assign length = {{(ADDRESS_BITS - LENGTH_BITS){1'b0}}, precision[PRECISION_BITS-1:DIGIT_PLACES]};
        else assign length = precision[PRECISION_BITS-1:DIGIT_PLACES];
    endgenerate

    // The bits of the lowest digit that are bits of the value: all of its highest ones.
    wire [DIGIT_BITS-1:0] keep;
    generate
        if (DIGIT_BITS > 1) begin : lowest_digit
            reg [DIGIT_BITS-1:0] kept;
            always @(posedge clk) kept <= ~({1'b0, {(DIGIT_BITS-1){1'b1}}} >> precision[DIGIT_PLACES-1:0]);
            assign keep = kept;
        end else begin : lowest_digit
            assign keep = 1'b1;
        end
    endgenerate
    harmonic_address #(.BITS(ADDRESS_BITS), .ORIGIN(0), .STRIDE(STEP_BITS)) here (
        .clk(clk), .home(home), .jump(taken), .jump_base(base_word), .wrap(wrap), .open(open), .advance(advance),
        .pre(pre), .precision(length), .address(here_address)
    );
    generate
        if (DOWN > 1) begin : down
            harmonic_address #(.BITS(ADDRESS_BITS), .ORIGIN(-LINE_STEP), .STRIDE(STEP_BITS)) north (
                .clk(clk), .home(home), .jump(taken), .jump_base(base_word), .wrap(wrap), .open(open),
                .advance(advance), .pre(pre), .precision(length), .address(north_address)
            );
            harmonic_address #(.BITS(ADDRESS_BITS), .ORIGIN(LINE_STEP), .STRIDE(STEP_BITS)) south (
                .clk(clk), .home(home), .jump(taken), .jump_base(base_word), .wrap(wrap), .open(open),
                .advance(advance), .pre(pre), .precision(length), .address(south_address)
            );
        end else begin : one_line
            assign north_address = {ADDRESS_BITS{1'b0}};
            assign south_address = {ADDRESS_BITS{1'b0}};
        end
        if (ACROSS > 1) begin : across
            harmonic_address #(.BITS(ADDRESS_BITS), .ORIGIN(STEP_BITS), .STRIDE(STEP_BITS)) east (
                .clk(clk), .home(home), .jump(taken), .jump_base(base_word), .wrap(wrap), .open(open),
                .advance(advance), .pre(pre), .precision(length), .address(east_address)
            );
            harmonic_address #(.BITS(ADDRESS_BITS), .ORIGIN(-STEP_BITS), .STRIDE(STEP_BITS)) west (
                .clk(clk), .home(home), .jump(taken), .jump_base(base_word), .wrap(wrap), .open(open),
                .advance(advance), .pre(pre), .precision(length), .address(west_address)
            );
        end else begin : one_block_wide
            assign east_address = {ADDRESS_BITS{1'b0}};
            assign west_address = {ADDRESS_BITS{1'b0}};
        end
    endgenerate

    // What a slot leads to, cycles later: bit i of x_later is x of i + 1 cycles ago.
    reg integer_slot, flag_slot;
    reg [4*MEMORY_DELAY-1:0] sides_later;
    reg [WRITE_DELAY-1:0] writes_later;
    reg [ADDRESS_BITS*WRITE_DELAY-1:0] address_later;
    wire [4*MEMORY_DELAY+3:0] sides_line = {sides_later, sides & {4{reads}}};
    wire [WRITE_DELAY:0] writes_line = {writes_later, writes};
    wire [ADDRESS_BITS*(WRITE_DELAY+1)-1:0] address_line = {address_later, here_address};
    always @(posedge clk) begin
        integer_slot <= zero | pre;
        flag_slot <= pre;
        sides_later <= sides_line[4*MEMORY_DELAY-1:0];
        writes_later <= drops | reset ? {WRITE_DELAY{1'b0}} : writes_line[WRITE_DELAY-1:0];
        address_later <= address_line[ADDRESS_BITS*WRITE_DELAY-1:0];
    end
    wire [3:0] sides_now = sides_line[4*MEMORY_DELAY +: 4];

    // The row and the column that leave the array, one cycle after their bits are on the streams.
    wire [ROW_BITS-1:0] row = phase == 4'd3 ? robot_row : read_row;
    reg [ROWS-1:0] row_select;
    reg [COLUMNS-1:0] column_select;
    wire [DIGIT_BITS*(COLUMNS+2)-1:0] row_line;
    wire [DIGIT_BITS*(ROWS+2)-1:0] column_line;
    wire [ROW_BITS-1:0] row_now;
    harmonic_delay #(.BITS(ROW_BITS), .CYCLES(STREAM_DELAY - 1)) row_delay (
        .clk(clk), .reset(1'b0), .value(row), .later(row_now)
    );
    genvar index;
    generate
        for (index = 0; index < ROWS; index = index + 1) begin : row_selects
            localparam [31:0] NUMBER = index;
            always @(posedge clk) row_select[index] <= row_now == NUMBER[ROW_BITS-1:0];
        end
        for (index = 0; index < COLUMNS; index = index + 1) begin : column_selects
            localparam [31:0] NUMBER = index;
            always @(posedge clk) column_select[index] <= robot_column == NUMBER[COLUMN_BITS-1:0];
        end
    endgenerate

    harmonic_array #(
        .ROWS(ROWS),
        .COLUMNS(COLUMNS),
        .DOWN(DOWN),
        .ACROSS(ACROSS),
        .DECISION(DECISION),
        .ADDRESS_BITS(ADDRESS_BITS),
        .DIGIT_BITS(DIGIT_BITS),
        .PIPELINE(PIPELINE),
        .MEMORIES(MEMORIES)
    ) array (
        .clk(clk),
        .integer_slot(integer_slot),
        .flag_slot(flag_slot),
        .keep(keep),
        .north_inside(sides_now[3]),
        .east_inside(sides_now[2]),
        .south_inside(sides_now[1]),
        .west_inside(sides_now[0]),
        .here_address(here_address),
        .north_address(north_address),
        .east_address(east_address),
        .south_address(south_address),
        .west_address(west_address),
        .write_address(load_writes ? load_address : address_line[ADDRESS_BITS*WRITE_DELAY +: ADDRESS_BITS]),
        .write_enable(load_enable | {MEMORIES{writes_line[WRITE_DELAY]}}),
        .loads(load_writes),
        .load_word(load_word),
        .row_select(row_select),
        .column_select(column_select),
        .changed(changed),
        .maximum(maximum),
        .row_line(row_line),
        .column_line(column_line)
    );

    // The decision. Its last bit is that of the pre slot after the pass.
    wire [2:0] vertical, horizontal;
    wire decided;
    generate
        if (DECISION != 0) begin : decision
            wire first_bit, last_bit;
            wire [DIGIT_BITS*(ROWS+2)-1:0] column_digits = column_line >> {robot_row, {DIGIT_PLACES{1'b0}}};
            wire [DIGIT_BITS*(COLUMNS+2)-1:0] row_digits = row_line >> {robot_column, {DIGIT_PLACES{1'b0}}};
            // With a pipeline the selected digits have a register before the comparisons.
            wire [DIGIT_BITS-1:0] north_digit, here_digit, south_digit, east_digit, west_digit;
            harmonic_delay #(.BITS(5 * DIGIT_BITS), .CYCLES(PIPELINE)) digits_delay (
                .clk(clk), .reset(1'b0),
                .value({
                    row_digits[0+:DIGIT_BITS], row_digits[2*DIGIT_BITS+:DIGIT_BITS], column_digits[0+:3*DIGIT_BITS]
                }),
                .later({west_digit, east_digit, south_digit, here_digit, north_digit})
            );
            wire unused = &{1'b0, column_digits, row_digits};
            harmonic_delay #(.BITS(1), .CYCLES(STREAM_DELAY + PIPELINE + 2)) first_delay (
                .clk(clk), .reset(reset), .value(pre), .later(first_bit)
            );
            harmonic_delay #(.BITS(1), .CYCLES(STREAM_DELAY + PIPELINE + 3)) last_delay (
                .clk(clk), .reset(reset), .value(finishes && phase == 4'd3), .later(last_bit)
            );
            harmonic_decision #(.DIGIT_BITS(DIGIT_BITS)) vertical_axis (
                .clk(clk), .first(first_bit),
                .here(here_digit), .a(north_digit), .b(south_digit),
                .second(vertical[0]), .rises(vertical[1]), .differs(vertical[2])
            );
            harmonic_decision #(.DIGIT_BITS(DIGIT_BITS)) horizontal_axis (
                .clk(clk), .first(first_bit),
                .here(here_digit), .a(east_digit), .b(west_digit),
                .second(horizontal[0]), .rises(horizontal[1]), .differs(horizontal[2])
            );
            assign decided = last_bit;
        end else begin : decision
            assign vertical = 3'd0;
            assign horizontal = 3'd0;
            assign decided = 1'b0;
            wire unused = &{1'b0, column_line, row_line[DIGIT_BITS*(COLUMNS+1)+:DIGIT_BITS], row_line[0+:DIGIT_BITS]};
        end
    endgenerate

    // The read-out.
    wire shown, last_shown;
    wire [CHUNK_BITS-1:0] chunk;
    wire [DIGIT_BITS*CHUNK*CHUNKS-1:0] shown_row;
    assign shown_row[0+:DIGIT_BITS*COLUMNS] = row_line[DIGIT_BITS+:DIGIT_BITS*COLUMNS];
    generate
        if (CHUNK * CHUNKS > COLUMNS)
            assign shown_row[DIGIT_BITS*CHUNK*CHUNKS-1:DIGIT_BITS*COLUMNS] = {(DIGIT_BITS*(CHUNK*CHUNKS-COLUMNS)){1'b0}};
    endgenerate
    harmonic_delay #(.BITS(CHUNK_BITS), .CYCLES(STREAM_DELAY + 1)) chunk_delay (
        .clk(clk), .reset(1'b0), .value(read_chunk), .later(chunk)
    );
    harmonic_delay #(.BITS(1), .CYCLES(STREAM_DELAY + 1)) shown_delay (
        .clk(clk), .reset(reset), .value(shows), .later(shown)
    );
    harmonic_delay #(.BITS(1), .CYCLES(STREAM_DELAY + 2)) last_delay (
        .clk(clk), .reset(reset), .value(finishes && phase == 4'd4), .later(last_shown)
    );
    assign finished = decided | last_shown;

    always @(posedge clk) begin
        event_valid <= ~reset & (visit_event | stage_event | decided | shown);
        event_kind <= visit_event ? 4'd0 : stage_event ? 4'd1 : decided ? 4'd2 : 4'd3;
        event_data <= {EVENT_BITS{1'b0}};
        if (visit_event) event_data[0 +: ITERATION_BITS+BLOCK_BITS] <= {visit_block, visit_iterations};
        else if (stage_event) event_data[0 +: SWEEP_BITS+1] <= {stage_sweeps, stage_maxima};
        else if (decided) event_data[5:0] <= {horizontal, vertical};
        else event_data[0+:DIGIT_BITS*CHUNK] <= shown_row[DIGIT_BITS*CHUNK*chunk+:DIGIT_BITS*CHUNK];
    end
endmodule
