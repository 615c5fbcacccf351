// The control of the harmonic circuit: passes over blocks, visits, sweeps and stages (Girau et al. 2008, section 4).
//
// A pass reads the p bits of every node of a block, lowest first, in p + 2 slots of one cycle (see harmonic_node); with
// digits of DIGIT_BITS bits, the L digits of its p bits in L + 2 slots (see harmonic_digit_node). It
// begins with a pre slot, slot p + 1 of the pass before, in which the flags of its block are read. An iteration is a
// pass that writes. Passes follow each other without a gap, so that an iteration takes p + 2 cycles. The answer of the
// OR trees comes during the next pass:
//
//   - a visit ends with its ITERATIONS-th iteration: the next block has begun already, at no cost;
//   - a visit ends early with an iteration that changed nothing: the pass that has begun is dropped. With one block it is
//     the first iteration of the next visit instead, unless the stage ends;
//   - SOUND: a stage ends with a sweep that changed no bit. Else, as published, with a sweep in which every visit ended
//     with an iteration that changed no bit; then the circuit waits at the end of every sweep that ends with a full
//     visit, since the next pass could write. With CHECK = 1 another pass over each block looks for local maxima.
//
// A dropped pass takes ANSWER + 1 cycles, where ANSWER counts the cycles from a pre slot to the answer.
module harmonic_control #(
    parameter DOWN = 1,
    parameter ACROSS = 1,
    parameter ROWS = 6,
    parameter CHUNKS = 1,
    parameter STAGES = 1,
    parameter PRECISION_BITS = 4,
    parameter DIGIT_PLACES = 0,                    // DIGIT_BITS = 2^DIGIT_PLACES
    parameter [11*STAGES-1:0] PRECISIONS = 11'd15,  // p + DIGIT_BITS - 1 of each stage, the first one lowest
    parameter ITERATIONS = 8,
    parameter ITERATION_BITS = 4,
    parameter SOUND = 1,
    parameter STOP_WITHOUT_MAXIMA = 1,
    parameter CHECK = 0,
    parameter DECISION = 1,
    parameter ANSWER = 2,
    parameter BLOCK_BITS = 1,
    parameter ROW_BITS = 3,
    parameter CHUNK_BITS = 1,
    parameter SWEEP_BITS = 24
) (
    input  wire                      clk,
    input  wire                      reset,
    input  wire                      start,
    input  wire                      loaded,      // the map is loaded with this edge
    input  wire                      taken,       // the position of the robot is taken with this edge
    input  wire [3:0]                robot_sides, // of its block: a block to the north, east, south, west
    input  wire                      changed,
    input  wire                      maximum,
    output reg  [3:0]                phase,
    output reg                       asks,        // waits for the position of the robot
    // Slots.
    output wire                      open,
    output wire                      advance,
    output wire                      home,
    output reg                       wrap,
    output reg                       pre,
    output reg                       zero,
    output wire                      reads,       // slots 0 to p
    output wire                      writes,      // slots 0 to p - 1 of an iteration
    output wire                      drops,       // what the pass that runs has not written yet is not written
    output reg  [PRECISION_BITS-1:0] precision,   // p + DIGIT_BITS - 1: the digits, above the bits of the lowest one less 1
    output wire [3:0]                sides,
    // Read-out.
    output reg  [ROW_BITS-1:0]       row,
    output reg  [CHUNK_BITS-1:0]     chunk,
    output wire                      shows,       // slots 0 to p of the read-out
    output wire                      finishes,    // slot p of the last pass of the phase
    input  wire                      finished,    // the last result of phase 3 or 4 is out with this edge
    // Events.
    output reg                       visit_event,
    output reg  [BLOCK_BITS-1:0]     visit_block,
    output reg  [ITERATION_BITS-1:0] visit_iterations,
    output reg                       stage_event,
    output reg  [SWEEP_BITS-1:0]     stage_sweeps,
    output reg                       stage_maxima,
    output reg                       done
);
    localparam BLOCKS = DOWN * ACROSS;
    localparam [3:0] IDLE = 0, LOAD = 1, RELAX = 2, DECIDE = 3, READ = 4;
    localparam STAGE_BITS = $clog2(STAGES + 1);
    localparam COLUMN_BITS = ACROSS > 1 ? $clog2(ACROSS) : 1;
    localparam LINE_BITS = DOWN > 1 ? $clog2(DOWN) : 1;
    localparam [31:0] BLOCKS_LESS_1 = BLOCKS - 1, ACROSS_LESS_1 = ACROSS - 1, DOWN_LESS_1 = DOWN - 1;
    localparam [31:0] ROWS_LESS_1 = ROWS - 1, CHUNKS_LESS_1 = CHUNKS - 1, STAGES_LESS_1 = STAGES - 1;
    localparam [31:0] MOST = ITERATIONS;
    localparam [BLOCK_BITS-1:0] LAST_BLOCK = BLOCKS_LESS_1[BLOCK_BITS-1:0];
    localparam [COLUMN_BITS-1:0] LAST_COLUMN = ACROSS_LESS_1[COLUMN_BITS-1:0];
    localparam [LINE_BITS-1:0] LAST_LINE = DOWN_LESS_1[LINE_BITS-1:0];
    localparam [ROW_BITS-1:0] LAST_ROW = ROWS_LESS_1[ROW_BITS-1:0];
    localparam [CHUNK_BITS-1:0] LAST_CHUNK = CHUNKS_LESS_1[CHUNK_BITS-1:0];
    localparam [STAGE_BITS-1:0] LAST_STAGE = STAGES_LESS_1[STAGE_BITS-1:0];
    // Without the pass that looks for them, maxima of several blocks are from before the last changes: not reported.
    localparam [0:0] TESTED = SOUND != 0 || BLOCKS == 1 || CHECK != 0;
    localparam LENGTH_BITS = PRECISION_BITS - DIGIT_PLACES;
    localparam [LENGTH_BITS-1:0] ONE = 1;
    localparam [ITERATION_BITS-1:0] FIRST = 1;
    localparam [ITERATION_BITS-1:0] LAST = MOST[ITERATION_BITS-1:0];

    // The slot. Every pass ends with a pre slot: that of the next pass, or of none.
    reg runs, halts, waits, checks, homes, opens, ended;
    reg [LENGTH_BITS-1:0] left;
    reg [PRECISION_BITS-1:0] next_precision;
    wire stops;
    wire slot_end = runs & zero;
    assign open = slot_end | stops | opens | loaded;
    assign reads = runs & ~pre;
    assign writes = reads & ~zero & phase == RELAX & ~checks;
    assign shows = reads & phase == READ;
    assign drops = stops;

    // The block that is visited.
    reg [BLOCK_BITS-1:0] block;
    reg [COLUMN_BITS-1:0] block_column;
    reg [LINE_BITS-1:0] block_line;
    assign home = phase == LOAD | homes;
    assign sides = phase == DECIDE ? robot_sides : {
        block_line != 0, block_column != LAST_COLUMN, block_line != LAST_LINE, block_column != 0
    };

    // The iterations of the pass that runs (full: the visit ends with it), and of the one before it, which is answered.
    reg [ITERATION_BITS-1:0] iteration, ended_iteration;
    reg full, ended_full, ended_last;
    reg [BLOCK_BITS-1:0] ended_block;
    reg row_over, rows_over;  // a cycle late, which does not matter: a pass takes more
    wire block_over = phase == READ ? rows_over : full | checks;
    wire sweep_ends = slot_end & wrap & block_over;
    wire halts_sweep = phase == RELAX && (checks || (SOUND == 0 && BLOCKS > 1));
    assign advance = slot_end ? block_over : ~(stops & ended_full);  // after a full visit it has advanced already
    assign finishes = phase == DECIDE ? slot_end : sweep_ends && phase == READ;

    // The answer of the OR trees for the pass before. What it leads to is prepared: nothing that it depends on changes in
    // the cycle before an answer.
    reg [ANSWER-1:0] answers;
    reg dirty, maxima, stage_ends, last_stage;
    reg settles;         // a stage ends with this pass, if it changed nothing
    reg stops_if_quiet;  // the pass that runs is dropped, if this one changed nothing
    reg [SWEEP_BITS-1:0] sweeps;
    reg [STAGE_BITS-1:0] stage;
    wire answered = answers[ANSWER-1];
    wire visit_over = answered & (ended_full | ~changed);
    wire sweep_over = visit_over & ended_last;
    wire settled = answered & ~changed & settles;
    wire stage_over = CHECK != 0 ? sweep_over & checks : settled;
    wire maxima_now = maxima | maximum;
    assign stops = answered & (waits | (~changed & stops_if_quiet));
    wire leaves = stage_over && (last_stage || (STOP_WITHOUT_MAXIMA != 0 && !maxima_now));
    wire begins = stops | (answered & ~changed & ~ended_full);  // the pass that runs, or follows, begins a visit

    always @(posedge clk) begin
        // Slots.
        if (open) begin
            runs <= 1'b1;
            pre <= 1'b1;
            zero <= 1'b0;
            ended <= slot_end & ~stops & phase == RELAX;
            halts <= finishes | (sweep_ends & halts_sweep);
        end else if (pre) begin
            pre <= 1'b0;
            runs <= ~halts;
            waits <= halts & phase == RELAX;
            left <= precision[PRECISION_BITS-1:DIGIT_PLACES];
        end else begin
            left <= left - 1'b1;
            zero <= left == ONE;
        end
        answers <= {answers[ANSWER-2:0], pre & ended};

        // Blocks, rows and chunks in raster order.
        wrap <= block == LAST_BLOCK;
        row_over <= chunk == LAST_CHUNK;
        rows_over <= chunk == LAST_CHUNK && row == LAST_ROW;
        if (home) begin
            block <= LAST_BLOCK;
            wrap <= 1'b1;
            block_column <= LAST_COLUMN;
            block_line <= LAST_LINE;
            row <= {ROW_BITS{1'b0}};
            chunk <= {CHUNK_BITS{1'b0}};
        end
        if (open & advance) begin
            block <= wrap ? {BLOCK_BITS{1'b0}} : block + 1'b1;
            block_column <= block_column == LAST_COLUMN ? {COLUMN_BITS{1'b0}} : block_column + 1'b1;
            if (block_column == LAST_COLUMN)
                block_line <= block_line == LAST_LINE ? {LINE_BITS{1'b0}} : block_line + 1'b1;
        end
        if (slot_end && phase == READ) begin
            chunk <= row_over ? {CHUNK_BITS{1'b0}} : chunk + 1'b1;
            if (row_over) row <= rows_over ? {ROW_BITS{1'b0}} : row + 1'b1;
        end

        // Visits.
        if (slot_end) begin
            ended_iteration <= iteration;
            ended_full <= full | checks;
            ended_last <= wrap;
            ended_block <= block;
        end
        if (home | begins | (slot_end & (full | checks))) begin
            iteration <= FIRST;
            full <= ITERATIONS == 1;
        end else if (slot_end) begin
            iteration <= iteration + 1'b1;
            full <= iteration == LAST - 1'b1;
        end

        // Sweeps and stages.
        settles <= ended_last & ~dirty & ~checks;
        stops_if_quiet <= (~ended_full && BLOCKS > 1) || (ended_last && ~dirty);
        last_stage <= stage == LAST_STAGE;
        if (answered) begin
            waits <= 1'b0;
            dirty <= ~sweep_over & (dirty | (changed & (SOUND != 0 | ended_full)));
            if (visit_over) maxima <= ~sweep_over & maxima_now;
            if (sweep_over & ~checks) sweeps <= sweeps + 1'b1;
        end
        if (settled) checks <= CHECK != 0;
        next_precision <= later_precision(stage);
        if (stage_over) begin
            checks <= 1'b0;
            stage_maxima <= maxima_now & TESTED;
            if (!leaves) begin
                stage <= stage + 1'b1;
                precision <= next_precision;
            end
        end

        // Events: a stage ends one cycle after its last visit.
        visit_event <= visit_over & ~checks;
        visit_block <= ended_block;
        visit_iterations <= ended_iteration;
        stage_ends <= stage_over;
        stage_event <= stage_ends;
        stage_sweeps <= sweeps;
        if (stage_ends) sweeps <= {SWEEP_BITS{1'b0}};

        // Phases.
        done <= 1'b0;
        homes <= 1'b0;
        opens <= homes | taken;
        if (taken) asks <= 1'b0;
        if (loaded) phase <= RELAX;
        if (leaves) begin
            runs <= 1'b0;
            pre <= 1'b0;
            phase <= DECISION != 0 ? DECIDE : READ;
            asks <= DECISION != 0;
            homes <= DECISION == 0;
        end
        if (finished) begin
            phase <= phase == DECIDE ? READ : IDLE;
            homes <= phase == DECIDE;
            done <= phase == READ;
        end
        if (start) begin
            phase <= LOAD;
            dirty <= 1'b0;
            maxima <= 1'b0;
            sweeps <= {SWEEP_BITS{1'b0}};
            stage <= {STAGE_BITS{1'b0}};
            precision <= PRECISIONS[PRECISION_BITS-1:0];
        end
        if (reset) begin
            phase <= IDLE;
            runs <= 1'b0;
            pre <= 1'b0;
            zero <= 1'b0;
            halts <= 1'b0;
            waits <= 1'b0;
            checks <= 1'b0;
            ended <= 1'b0;
            asks <= 1'b0;
            answers <= {ANSWER{1'b0}};
            homes <= 1'b0;
            opens <= 1'b0;
            visit_event <= 1'b0;
            stage_ends <= 1'b0;
            stage_event <= 1'b0;
        end
    end

    // The precision of the stage after the given one.
    function [PRECISION_BITS-1:0] later_precision(input [STAGE_BITS-1:0] index);
        integer entry;
        begin
            later_precision = PRECISIONS[PRECISION_BITS-1:0];
            for (entry = 1; entry < STAGES; entry = entry + 1)
                if (index == entry[STAGE_BITS-1:0] - 1'b1) later_precision = PRECISIONS[11*entry +: PRECISION_BITS];
        end
    endfunction
endmodule
