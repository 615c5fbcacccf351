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
    wire [(ROWS+1)*ACROSS-1:0] down;
    wire [(COLUMNS+1)*WORD-1:0] along;
    assign down[ACROSS-1:0] = {ACROSS{1'b0}};
    assign along[WORD-1:0] = {WORD{1'b0}};
    genvar r, c;
    generate
        for (r = 0; r < ROWS; r = r + 1) begin : each_row
            localparam [31:0] AT = r;
            wire chosen = row == AT[ROW_BITS-1:0];
            assign down[(r+1)*ACROSS +: ACROSS] =
                down[r*ACROSS +: ACROSS] | ({ACROSS{chosen}} & words[r*ACROSS +: ACROSS]);
        end
        for (c = 0; c < COLUMNS; c = c + 1) begin : each_column
            localparam [31:0] AT = c;
            wire chosen = column == AT[COLUMN_BITS-1:0];
            assign along[(c+1)*WORD +: WORD] =
                along[c*WORD +: WORD] | ({WORD{chosen}} & down[ROWS*ACROSS + c*WORD +: WORD]);
        end
    endgenerate
    assign word = along[COLUMNS*WORD +: WORD];
endmodule
