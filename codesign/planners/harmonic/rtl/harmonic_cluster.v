// A cluster of the harmonic array (Girau et al. 2008, section 5.1): 3 x 6 nodes around a memory of 18 bits a word.
//
// Node (i, j) of the cluster has bit 6 i + j of every word. Only ROWS x COLUMNS nodes are there; the others hold 0.
// With digits of DIGIT_BITS bits there is a memory for each bit of a digit, and that of the highest bits is loaded.
module harmonic_cluster #(
    parameter ROWS = 3,
    parameter COLUMNS = 6,
    parameter ADDRESS_BITS = 10,
    parameter DIGIT_BITS = 1,
    parameter PIPELINE = 0
) (
    input  wire                         clk,
    input  wire                         integer_slot,
    input  wire                         flag_slot,
    input  wire [DIGIT_BITS-1:0]        keep,          // the bits of the lowest digit that are bits of the value
    input  wire [ADDRESS_BITS-1:0]      read_address,
    input  wire                         write_enable,
    input  wire [ADDRESS_BITS-1:0]      write_address,
    input  wire                         loads,
    input  wire [17:0]                  load_word,
    input  wire [18*DIGIT_BITS-1:0]     north,
    input  wire [18*DIGIT_BITS-1:0]     east,
    input  wire [18*DIGIT_BITS-1:0]     south,
    input  wire [18*DIGIT_BITS-1:0]     west,
    output wire [18*DIGIT_BITS-1:0]     stream,
    output wire [18*DIGIT_BITS-1:0]     border,
    output wire [17:0]                  changed,
    output wire [17:0]                  maximum
);
    // Node k has bits DIGIT_BITS k and above of these; the memory of a bit has that bit of all nodes.
    wire [18*DIGIT_BITS-1:0] written, values;
    reg [18*DIGIT_BITS-1:0] stored, results;
    always @* stored = by_node(values);
    always @* results = by_place(written);

    function [18*DIGIT_BITS-1:0] by_node(input [18*DIGIT_BITS-1:0] from);
        integer node, bit_place;
        for (node = 0; node < 18; node = node + 1)
            for (bit_place = 0; bit_place < DIGIT_BITS; bit_place = bit_place + 1)
                by_node[DIGIT_BITS*node+bit_place] = from[18*bit_place+node];
    endfunction

    function [18*DIGIT_BITS-1:0] by_place(input [18*DIGIT_BITS-1:0] from);
        integer node, bit_place;
        for (node = 0; node < 18; node = node + 1)
            for (bit_place = 0; bit_place < DIGIT_BITS; bit_place = bit_place + 1)
                by_place[18*bit_place+node] = from[DIGIT_BITS*node+bit_place];
    endfunction

    genvar row, column, index, place;
    generate
        for (place = 0; place < DIGIT_BITS; place = place + 1) begin : places
            wire [17:0] load = place == DIGIT_BITS - 1 ? load_word : 18'd0;
            ram_1w1r #(
                .WIDTH(18),
                .DEPTH(1 << ADDRESS_BITS),
                .ADDRESS_BITS(ADDRESS_BITS),
                .OUTPUT_REGISTER(PIPELINE)
            ) memory (
                .clk(clk),
                .write_enable(write_enable),
                .write_address(write_address),
                .write_data(loads ? load : results[18*place+:18]),
                .read_enable(1'b1),
                .read_address(read_address),
                .read_data(values[18*place+:18])
            );
        end
    endgenerate

    // The slots, when their words leave the memory (node_) and when their bits are on the stream (last, first, second).
    wire node_integer, node_flag, last;
    reg first;
    generate
        if (PIPELINE != 0) begin : slots
            reg integer_here, flag_here, last_here;
            always @(posedge clk) begin
                integer_here <= integer_slot;
                flag_here <= flag_slot;
                last_here <= flag_here;
            end
            assign node_integer = integer_here;
            assign node_flag = flag_here;
            assign last = last_here;
        end else begin : slots
            assign node_integer = integer_slot;
            assign node_flag = flag_slot;
            assign last = flag_slot;
        end
    endgenerate
    always @(posedge clk) first <= last;

    generate
        if (DIGIT_BITS == 1) begin : bits
            reg second;
            always @(posedge clk) second <= first;
            wire unused = &{1'b0, keep};
            for (row = 0; row < ROWS; row = row + 1) begin : rows
                for (column = 0; column < COLUMNS; column = column + 1) begin : columns
                    localparam INDEX = 6 * row + column;
                    harmonic_node #(
                        .PIPELINE(PIPELINE)
                    ) node (
                        .clk(clk),
                        .integer_slot(node_integer),
                        .flag_slot(node_flag),
                        .last(last),
                        .first(first),
                        .quiet(first | second),
                        .stored(stored[INDEX]),
                        .north(north[INDEX]),
                        .east(east[INDEX]),
                        .south(south[INDEX]),
                        .west(west[INDEX]),
                        .stream(stream[INDEX]),
                        .written(written[INDEX]),
                        .border(border[INDEX]),
                        .changed(changed[INDEX]),
                        .maximum(maximum[INDEX])
                    );
                end
            end
        end else begin : digits
            // The lowest digit is written in slot 1.
            reg [DIGIT_BITS-1:0] mask;
            always @(posedge clk) mask <= keep | {DIGIT_BITS{~first}};
            for (row = 0; row < ROWS; row = row + 1) begin : rows
                for (column = 0; column < COLUMNS; column = column + 1) begin : columns
                    localparam INDEX = 6 * row + column;
                    localparam LOW = DIGIT_BITS * INDEX;
                    harmonic_digit_node #(
                        .DIGIT_BITS(DIGIT_BITS),
                        .PIPELINE(PIPELINE)
                    ) node (
                        .clk(clk),
                        .integer_slot(node_integer),
                        .flag_slot(node_flag),
                        .last(last),
                        .first(first),
                        .mask(mask),
                        .stored(stored[LOW+:DIGIT_BITS]),
                        .north(north[LOW+:DIGIT_BITS]),
                        .east(east[LOW+:DIGIT_BITS]),
                        .south(south[LOW+:DIGIT_BITS]),
                        .west(west[LOW+:DIGIT_BITS]),
                        .stream(stream[LOW+:DIGIT_BITS]),
                        .written(written[LOW+:DIGIT_BITS]),
                        .border(border[LOW+:DIGIT_BITS]),
                        .changed(changed[INDEX]),
                        .maximum(maximum[INDEX])
                    );
                end
            end
        end
        for (index = 0; index < 18; index = index + 1) begin : nodes
            if (index / 6 >= ROWS || index % 6 >= COLUMNS) begin : absent
                localparam LOW = DIGIT_BITS * index;
                wire unused = &{
                    1'b0, stored[LOW+:DIGIT_BITS], north[LOW+:DIGIT_BITS], east[LOW+:DIGIT_BITS],
                    south[LOW+:DIGIT_BITS], west[LOW+:DIGIT_BITS]
                };
                assign stream[LOW+:DIGIT_BITS] = {DIGIT_BITS{1'b0}};
                assign written[LOW+:DIGIT_BITS] = {DIGIT_BITS{1'b0}};
                assign border[LOW+:DIGIT_BITS] = {DIGIT_BITS{1'b0}};
                assign changed[index] = 1'b0;
                assign maximum[index] = 1'b0;
            end
        end
    endgenerate
endmodule
