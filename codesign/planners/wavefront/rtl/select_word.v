// The word of one node: an AND with the line of its row, an OR down every column, and the same along the columns.
module select_word #(
    parameter ROWS = 8,
    parameter COLUMNS = 8,
    parameter ROW_BITS = 3,
    parameter COLUMN_BITS = 3,
    parameter WORD = 6
) (
    input  wire [ROW_BITS-1:0]           row,
    input  wire [COLUMN_BITS-1:0]        column,
    input  wire [ROWS*COLUMNS*WORD-1:0]  words,
    output wire [WORD-1:0]               word
);
    localparam ACROSS = COLUMNS * WORD;
    genvar r, c;
    generate
        for (r = 0; r < ROWS; r = r + 1) begin : down
            localparam [31:0] AT = r;
            wire [ACROSS-1:0] chosen = {ACROSS{row == AT[ROW_BITS-1:0]}} & words[r*ACROSS +: ACROSS];
            wire [ACROSS-1:0] any;
            if (r == 0) begin : top
                assign any = chosen;
            end else begin : under
                assign any = down[r-1].any | chosen;
            end
        end
        for (c = 0; c < COLUMNS; c = c + 1) begin : along
            localparam [31:0] AT = c;
            wire [WORD-1:0] chosen = {WORD{column == AT[COLUMN_BITS-1:0]}} & down[ROWS-1].any[c*WORD +: WORD];
            wire [WORD-1:0] any;
            if (c == 0) begin : left
                assign any = chosen;
            end else begin : behind
                assign any = along[c-1].any | chosen;
            end
        end
    endgenerate
    assign word = along[COLUMNS-1].any;
endmodule
