// The word of one node, addressed like a RAM: the words of a row, and one of these.
module select_word #(
    parameter ROWS = 8,
    parameter COLUMNS = 8,
    parameter ROW_BITS = 3,
    parameter COLUMN_BITS = 3,
    parameter WORD = 6
) (
    input  wire [ROW_BITS-1:0]          row,
    input  wire [COLUMN_BITS-1:0]       column,
    input  wire [ROWS*COLUMNS*WORD-1:0] words,
    output wire [WORD-1:0]              word
);
    wire [COLUMNS*WORD-1:0] across;
    select_line #(.COUNT(ROWS), .NUMBER_BITS(ROW_BITS), .WORD(COLUMNS * WORD)) of_rows (
        .number(row), .words(words), .word(across)
    );
    select_line #(.COUNT(COLUMNS), .NUMBER_BITS(COLUMN_BITS), .WORD(WORD)) of_columns (
        .number(column), .words(across), .word(word)
    );
endmodule
