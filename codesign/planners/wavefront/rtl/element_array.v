// An array of processing elements, each of them for CELLS cells of a column: a step of the wave takes CELLS cycles.
//
// Steps and their ends are those of delay_line_array; every step is completed, so that a pass to the potential D takes
// CELLS (D + 1) cycles. A word is read LATENCY = 2 edges after its address: the memory, then the register of the read-out.
module element_array #(
    parameter ROWS = 8,
    parameter COLUMNS = 8,
    parameter ROW_BITS = 3,
    parameter COLUMN_BITS = 3,
    parameter STRAIGHT = 2,
    parameter DIAGONAL = 3,
    parameter EXTRA = 0,
    parameter CORNER_CUTTING = 1,
    parameter SAFE = 0,
    parameter WAITS = 1,
    parameter BITS = 6,
    parameter OBSTACLE_BITS = 0,
    parameter LONGEST = 21,
    parameter CELLS = 4,
    parameter CELL_BITS = 2,
    parameter FLAGS = 2,
    parameter LOAD_CELLS = 16,
    parameter WORD = 6
) (
    input  wire                        clk,
    input  wire                        loading,
    input  wire                        load,
    input  wire [LOAD_CELLS*FLAGS-1:0] load_word,
    input  wire                        run,
    input  wire                        obstacle_pass,
    output wire                        stop,
    input  wire [ROW_BITS-1:0]         row,
    input  wire [COLUMN_BITS-1:0]      column,
    output wire [WORD-1:0]             word
);
    localparam DOWN = (ROWS + CELLS - 1) / CELLS;
    localparam ELEMENTS = DOWN * COLUMNS;
    localparam WORDS = (ELEMENTS + LOAD_CELLS - 1) / LOAD_CELLS;
    localparam WIDE = COLUMNS + 2;
    localparam PADDED = (DOWN + 2) * WIDE;
    localparam COUNTER_BITS = BITS > OBSTACLE_BITS ? BITS : OBSTACLE_BITS;
    localparam DOWN_BITS = ROW_BITS > CELL_BITS ? ROW_BITS - CELL_BITS : 1;
    localparam [31:0] LAST_COUNT = LONGEST + 1, LAST_WORD = WORDS - 1;

    // The row of an element, and the row of its cells.
    wire [DOWN_BITS-1:0] down;
    wire [CELL_BITS-1:0] cell_row;
    generate
        if (ROW_BITS > CELL_BITS) begin : several
            assign {down, cell_row} = row;
        end else if (ROW_BITS == CELL_BITS) begin : only
            assign down = 1'b0;
            assign cell_row = row;
        end else begin : partial
            assign down = 1'b0;
            assign cell_row = {{CELL_BITS-ROW_BITS{1'b0}}, row};
        end
    endgenerate

    // The load: the words of a row of cells, then the row is placed while the next word comes.
    reg [15:0] words_in;
    reg place;
    wire row_in = load && words_in == LAST_WORD[15:0];
    always @(posedge clk) begin
        place <= row_in;
        if (!loading || row_in) words_in <= 16'd0;
        else if (load) words_in <= words_in + 16'd1;
    end

    // The turn of the cells, and the steps.
    reg [CELL_BITS-1:0] turn;
    reg [COUNTER_BITS-1:0] counter;
    wire at_first = run && turn == {CELL_BITS{1'b0}};
    wire at_last = run && &turn;
    wire [CELL_BITS-1:0] read_cell = run ? turn + 1'b1 : loading ? {CELL_BITS{1'b0}} : cell_row;
    always @(posedge clk) begin
        if (place | run) turn <= turn + 1'b1;
        else if (!loading) turn <= {CELL_BITS{1'b0}};
        if (!run | stop) counter <= {{COUNTER_BITS-1{1'b0}}, 1'b1};
        else if (at_last) counter <= counter + 1'b1;
    end
    wire last_step = counter == LAST_COUNT[COUNTER_BITS-1:0];
    wire clear = obstacle_pass & last_step;

    // The elements, with a border that sends nothing.
    wire [PADDED-1:0] ring_end, first_bit, open_end, open_next, open;
    wire [3*PADDED-1:0] rows_seen;
    wire [ELEMENTS-1:0] y, moving;
    wire [ELEMENTS*FLAGS-1:0] flags;
    wire [ELEMENTS*WORD-1:0] words;
    genvar r, c;
    generate
        for (r = 0; r < DOWN + 2; r = r + 1) begin : padded_row
            for (c = 0; c < WIDE; c = c + 1) begin : place_of
                localparam AT = r * WIDE + c;
                if (r == 0 || r == DOWN + 1 || c == 0 || c == COLUMNS + 1) begin : border
                    assign {ring_end[AT], first_bit[AT], open_end[AT], open_next[AT], open[AT]} = 5'b00000;
                    assign rows_seen[3*AT +: 3] = 3'b000;
                end else begin : inner
                    localparam ELEMENT = (r - 1) * COLUMNS + c - 1;
                    wire [FLAGS-1:0] flags_in;
                    if (ELEMENT < LOAD_CELLS) begin : from_stream
                        assign flags_in = load_word[ELEMENT*FLAGS +: FLAGS];
                    end else begin : from_element
                        assign flags_in = flags[(ELEMENT-LOAD_CELLS)*FLAGS +: FLAGS];
                    end
                    wave_element #(
                        .STRAIGHT(STRAIGHT), .DIAGONAL(DIAGONAL), .EXTRA(EXTRA), .CORNER_CUTTING(CORNER_CUTTING),
                        .WAITS(WAITS), .SAFE(SAFE), .CELLS(CELLS), .CELL_BITS(CELL_BITS), .BITS(BITS),
                        .OBSTACLE_BITS(OBSTACLE_BITS), .COUNTER_BITS(COUNTER_BITS), .FLAGS(FLAGS), .WORD(WORD)
                    ) element (
                        .clk(clk), .load(load), .flags_in(flags_in), .flags(flags[ELEMENT*FLAGS +: FLAGS]),
                        .place(place), .run(run), .clear(clear), .obstacle_pass(obstacle_pass), .counter(counter),
                        .at_first(at_first), .at_last(at_last), .cell_number(turn), .read_cell(read_cell),
                        .above(ring_end[AT-WIDE]), .below(first_bit[AT+WIDE]),
                        .left(rows_seen[3*(AT-1) +: 3]), .right(rows_seen[3*(AT+1) +: 3]),
                        .above_open(open_end[AT-WIDE]), .below_open(open_next[AT+WIDE]),
                        .left_open(open[AT-1]), .right_open(open[AT+1]),
                        .ring_end(ring_end[AT]), .first_bit(first_bit[AT]), .column(rows_seen[3*AT +: 3]),
                        .open_end(open_end[AT]), .open_next(open_next[AT]), .open(open[AT]),
                        .word(words[ELEMENT*WORD +: WORD]), .moving(moving[ELEMENT])
                    );
                    assign y[ELEMENT] = rows_seen[3*AT+1];
                end
            end
        end
    endgenerate

    // The end of a pass, at the end of a step.
    wire at_end;
    generate
        if (WAITS != 0) begin : waits
            wire selected;
            select_word #(
                .ROWS(DOWN), .COLUMNS(COLUMNS), .ROW_BITS(DOWN_BITS), .COLUMN_BITS(COLUMN_BITS), .WORD(1)
            ) selected_y (.row(down), .column(column), .words(y), .word(selected));
            wire reached = selected && turn == cell_row;
            reg was_reached;
            always @(posedge clk) was_reached <= run & ~at_last & (was_reached | reached);
            assign at_end = was_reached | reached | &counter[BITS-1:0];
        end else begin : whole_map
            reg was_moving;
            always @(posedge clk) was_moving <= run & ~at_last & (was_moving | (|moving));
            assign at_end = ~(was_moving | (|moving));
        end
    endgenerate
    assign stop = at_last & (obstacle_pass ? last_step : at_end);

    // The read-out.
    reg [DOWN_BITS-1:0] read_down;
    reg [COLUMN_BITS-1:0] read_column;
    reg [WORD-1:0] read_word;
    wire [WORD-1:0] selected_word;
    select_word #(
        .ROWS(DOWN), .COLUMNS(COLUMNS), .ROW_BITS(DOWN_BITS), .COLUMN_BITS(COLUMN_BITS), .WORD(WORD)
    ) read_out (.row(read_down), .column(read_column), .words(words), .word(selected_word));
    always @(posedge clk) begin
        read_down <= down;
        read_column <= column;
        read_word <= selected_word;
    end
    assign word = read_word;

    // Inputs that other parameters need.
    wire unused = &{1'b0, load_word, row, column, y, moving, flags, obstacle_pass};
endmodule
