// The array of Hassoun and Sanghvi: a node with adders and comparators for every cell of the map.
//
// A pass sets the registers in its first cycle. It ends with the first cycle in which no potential changes, so it takes
// as many cycles as the longest shortest path has steps, and two more.
module adder_array #(
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
    parameter BITS = 6,
    parameter OBSTACLE_BITS = 0,
    parameter FLAGS = 2,
    parameter LOAD_CELLS = 32,
    parameter WORD = 6
) (
    input  wire                        clk,
    input  wire                        load,
    input  wire [LOAD_CELLS*FLAGS-1:0] load_word,
    input  wire                        run,
    input  wire                        obstacle_pass,
    output wire                        stop,
    input  wire                        shift,
    input  wire [ROW_BITS-1:0]         row,
    input  wire [COLUMN_BITS-1:0]      column,
    output wire [WORD-1:0]             word
);
    localparam NODES = ROWS * COLUMNS;
    localparam WIDE = COLUMNS + 2;
    localparam PADDED = (ROWS + 2) * WIDE;

    reg settled;
    wire begin_pass = run & ~settled;
    wire update = run & settled;
    always @(posedge clk) settled <= run & ~stop;

    // The nodes, with a border at infinity.
    wire [PADDED*BITS-1:0] p;
    wire [PADDED-1:0] open;
    wire [NODES-1:0] changes;
    wire [NODES*FLAGS-1:0] flags;
    wire [NODES*WORD-1:0] words;
    genvar r, c;
    generate
        for (r = 0; r < ROWS + 2; r = r + 1) begin : padded_row
            for (c = 0; c < WIDE; c = c + 1) begin : place
                localparam AT = r * WIDE + c;
                if (r == 0 || r == ROWS + 1 || c == 0 || c == COLUMNS + 1) begin : border
                    assign p[AT*BITS +: BITS] = {BITS{1'b1}};
                    assign open[AT] = 1'b0;
                end else begin : inner
                    localparam NODE = (r - 1) * COLUMNS + c - 1;
                    wire [FLAGS-1:0] flags_in;
                    wire [WORD-1:0] word_in;
                    if (NODE < LOAD_CELLS) begin : from_stream
                        assign flags_in = load_word[NODE*FLAGS +: FLAGS];
                    end else begin : from_node
                        assign flags_in = flags[(NODE-LOAD_CELLS)*FLAGS +: FLAGS];
                    end
                    if (NODE < NODES - 1) begin : link
                        assign word_in = words[(NODE+1)*WORD +: WORD];
                    end else begin : tail
                        // The words go round, as the next pass needs F and P.
                        assign word_in = words[WORD-1:0];
                    end
                    adder_node #(
                        .STRAIGHT(STRAIGHT), .DIAGONAL(DIAGONAL), .EXTRA(EXTRA), .CORNER_CUTTING(CORNER_CUTTING),
                        .SAFE(SAFE), .CHAIN(CHAIN), .BITS(BITS), .OBSTACLE_BITS(OBSTACLE_BITS),
                        .FLAGS(FLAGS), .WORD(WORD)
                    ) node (
                        .clk(clk), .load(load), .flags_in(flags_in), .flags(flags[NODE*FLAGS +: FLAGS]),
                        .begin_pass(begin_pass), .update(update), .obstacle_pass(obstacle_pass),
                        .straight({p[(AT-1)*BITS +: BITS], p[(AT+WIDE)*BITS +: BITS],
                            p[(AT+1)*BITS +: BITS], p[(AT-WIDE)*BITS +: BITS]}),
                        .diagonal({p[(AT-WIDE-1)*BITS +: BITS], p[(AT+WIDE-1)*BITS +: BITS],
                            p[(AT+WIDE+1)*BITS +: BITS], p[(AT-WIDE+1)*BITS +: BITS]}),
                        .beside({open[AT-1], open[AT+WIDE], open[AT+1], open[AT-WIDE]}),
                        .shift(shift), .word_in(word_in), .word(words[NODE*WORD +: WORD]),
                        .open(open[AT]), .p(p[AT*BITS +: BITS]), .changes(changes[NODE])
                    );
                end
            end
        end
    endgenerate

    assign stop = update & ~|changes;

    generate
        if (CHAIN != 0) begin : chain
            assign word = words[WORD-1:0];
        end else begin : addressed
            wire [WORD-1:0] selected;
            reg [WORD-1:0] read_word;
            select_word #(
                .ROWS(ROWS), .COLUMNS(COLUMNS), .ROW_BITS(ROW_BITS), .COLUMN_BITS(COLUMN_BITS), .WORD(WORD)
            ) read_out (.row(row), .column(column), .words(words), .word(selected));
            always @(posedge clk) read_word <= selected;
            assign word = read_word;
        end
    endgenerate

    // Inputs that other parameters need.
    wire unused = &{1'b0, load_word, row, column, shift, flags, p};
endmodule
