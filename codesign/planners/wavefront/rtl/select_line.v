// One of several words: an AND with the line that selects it, two words a LUT of four inputs, and an OR over all.
module select_line #(
    parameter COUNT = 8,
    parameter NUMBER_BITS = 3,
    parameter WORD = 6
) (
    input  wire [NUMBER_BITS-1:0] number,
    input  wire [COUNT*WORD-1:0]  words,
    output wire [WORD-1:0]        word
);
    localparam PAIRS = (COUNT + 1) / 2;
    wire [COUNT-1:0] lines;
    select_number #(.COUNT(COUNT), .NUMBER_BITS(NUMBER_BITS)) decoder (.number(number), .lines(lines));

    wire [PAIRS*WORD-1:0] pairs;
    genvar pair, place;
    generate
        for (pair = 0; pair < PAIRS; pair = pair + 1) begin : chosen
            wire [WORD-1:0] even = {WORD{lines[2*pair]}} & words[2*pair*WORD +: WORD];
            if (2 * pair + 1 < COUNT) begin : two
                assign pairs[pair*WORD +: WORD] = even | ({WORD{lines[2*pair+1]}} & words[(2*pair+1)*WORD +: WORD]);
            end else begin : alone
                assign pairs[pair*WORD +: WORD] = even;
            end
        end
        for (place = 0; place < WORD; place = place + 1) begin : any
            wire [PAIRS-1:0] terms;
            for (pair = 0; pair < PAIRS; pair = pair + 1) begin : gather
                assign terms[pair] = pairs[pair*WORD+place];
            end
            assign word[place] = |terms;
        end
    endgenerate
endmodule
