// A cluster of the harmonic array (Girau et al. 2008, section 5.1): 3 x 6 nodes around a memory of 18 bits a word.
//
// Node (i, j) of the cluster has bit 6 i + j of every word. Only ROWS x COLUMNS nodes are there; the others hold 0.
module harmonic_cluster #(
    parameter ROWS = 3,
    parameter COLUMNS = 6,
    parameter ADDRESS_BITS = 10,
    parameter PIPELINE = 0
) (
    input  wire                    clk,
    input  wire                    integer_slot,
    input  wire                    flag_slot,
    input  wire [ADDRESS_BITS-1:0] read_address,
    input  wire                    write_enable,
    input  wire [ADDRESS_BITS-1:0] write_address,
    input  wire                    loads,
    input  wire [17:0]             load_word,
    input  wire [17:0]             north,
    input  wire [17:0]             east,
    input  wire [17:0]             south,
    input  wire [17:0]             west,
    output wire [17:0]             stream,
    output wire [17:0]             border,
    output wire [17:0]             changed,
    output wire [17:0]             maximum
);
    wire [17:0] stored, written;

    ram_1w1r #(
        .WIDTH(18),
        .DEPTH(1 << ADDRESS_BITS),
        .ADDRESS_BITS(ADDRESS_BITS),
        .OUTPUT_REGISTER(PIPELINE)
    ) memory (
        .clk(clk),
        .write_enable(write_enable),
        .write_address(write_address),
        .write_data(loads ? load_word : written),
        .read_enable(1'b1),
        .read_address(read_address),
        .read_data(stored)
    );

    // The slots, when their words leave the memory (node_) and when their bits are on the stream (last, first, second).
    wire node_integer, node_flag, last;
    reg first, second;
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
    always @(posedge clk) begin
        first <= last;
        second <= first;
    end

    genvar row, column;
    generate
        for (row = 0; row < 3; row = row + 1) begin : rows
            for (column = 0; column < 6; column = column + 1) begin : columns
                if (row < ROWS && column < COLUMNS) begin : present
                    harmonic_node #(
                        .PIPELINE(PIPELINE)
                    ) node (
                        .clk(clk),
                        .integer_slot(node_integer),
                        .flag_slot(node_flag),
                        .last(last),
                        .first(first),
                        .quiet(first | second),
                        .stored(stored[6 * row + column]),
                        .north(north[6 * row + column]),
                        .east(east[6 * row + column]),
                        .south(south[6 * row + column]),
                        .west(west[6 * row + column]),
                        .stream(stream[6 * row + column]),
                        .written(written[6 * row + column]),
                        .border(border[6 * row + column]),
                        .changed(changed[6 * row + column]),
                        .maximum(maximum[6 * row + column])
                    );
                end else begin : absent
                    wire unused = &{
                        1'b0, stored[6*row+column], north[6*row+column], east[6*row+column], south[6*row+column],
                        west[6*row+column]
                    };
                    assign stream[6 * row + column] = 1'b0;
                    assign written[6 * row + column] = 1'b0;
                    assign border[6 * row + column] = 1'b0;
                    assign changed[6 * row + column] = 1'b0;
                    assign maximum[6 * row + column] = 1'b0;
                end
            end
        end
    endgenerate
endmodule
