// The nodes of a block (Girau et al. 2008, section 5.1): clusters, the memories of its four sides, and what is collected
// over all nodes: the OR trees, and the lines that carry one row or one column of streams out of the array.
//
// Memories in the order of loading: clusters in raster order; then, where there is a block to that side, the nodes along
// the north side, along the south side, along the west side and along the east side of the visited block.
module harmonic_array #(
    parameter ROWS = 6,
    parameter COLUMNS = 12,
    parameter DOWN = 1,
    parameter ACROSS = 1,
    parameter DECISION = 1,
    parameter ADDRESS_BITS = 10,
    parameter DIGIT_BITS = 1,
    parameter PIPELINE = 0,
    parameter MEMORIES = 4
) (
    input  wire                                  clk,
    input  wire                                  integer_slot,
    input  wire                                  flag_slot,
    input  wire [DIGIT_BITS-1:0]                 keep,         // the bits of the lowest digit that are bits of the value
    input  wire                                  north_inside,
    input  wire                                  east_inside,
    input  wire                                  south_inside,
    input  wire                                  west_inside,
    input  wire [ADDRESS_BITS-1:0]               here_address,
    input  wire [ADDRESS_BITS-1:0]               north_address,
    input  wire [ADDRESS_BITS-1:0]               east_address,
    input  wire [ADDRESS_BITS-1:0]               south_address,
    input  wire [ADDRESS_BITS-1:0]               west_address,
    input  wire [ADDRESS_BITS-1:0]               write_address,
    input  wire [MEMORIES-1:0]                   write_enable,
    input  wire                                  loads,
    input  wire [17:0]                           load_word,
    input  wire [ROWS-1:0]                       row_select,
    input  wire [COLUMNS-1:0]                    column_select,
    output wire                                  changed,      // OR trees; see harmonic_control for their delay
    output wire                                  maximum,
    output reg  [DIGIT_BITS*(COLUMNS+2)-1:0]     row_line,     // the selected row, one column more at either end
    output wire [DIGIT_BITS*(ROWS+2)-1:0]        column_line   // the selected column, one row more at either end
);
    localparam CLUSTER_ROWS = (ROWS + 2) / 3;
    localparam CLUSTER_COLUMNS = (COLUMNS + 5) / 6;
    localparam CLUSTERS = CLUSTER_ROWS * CLUSTER_COLUMNS;
    localparam SIDE_ROWS = (ROWS + 17) / 18;
    localparam SIDE_COLUMNS = (COLUMNS + 17) / 18;
    localparam WEST_SIDE = CLUSTERS + (DOWN > 1 ? 2 * SIDE_COLUMNS : 0);

    localparam LINE = DIGIT_BITS * COLUMNS;

    wire [LINE*ROWS-1:0] streams, borders;
    wire [18*CLUSTERS-1:0] changed_bits, maximum_bits;

    // Streams of the nodes around the block.
    wire [DIGIT_BITS*COLUMNS-1:0] north_stream, south_stream;
    wire [DIGIT_BITS*ROWS-1:0] west_stream, east_stream;

    genvar row, column, i, j;
    generate
        for (row = 0; row < CLUSTER_ROWS; row = row + 1) begin : cluster_rows
            for (column = 0; column < CLUSTER_COLUMNS; column = column + 1) begin : cluster_columns
                localparam HEIGHT = ROWS - 3 * row < 3 ? ROWS - 3 * row : 3;
                localparam WIDTH = COLUMNS - 6 * column < 6 ? COLUMNS - 6 * column : 6;
                localparam INDEX = CLUSTER_COLUMNS * row + column;
                wire [18*DIGIT_BITS-1:0] north, east, south, west, stream, border;
                harmonic_cluster #(
                    .ROWS(HEIGHT),
                    .COLUMNS(WIDTH),
                    .ADDRESS_BITS(ADDRESS_BITS),
                    .DIGIT_BITS(DIGIT_BITS),
                    .PIPELINE(PIPELINE)
                ) cluster (
                    .clk(clk),
                    .integer_slot(integer_slot),
                    .flag_slot(flag_slot),
                    .keep(keep),
                    .read_address(here_address),
                    .write_enable(write_enable[INDEX]),
                    .write_address(write_address),
                    .loads(loads),
                    .load_word(load_word),
                    .north(north),
                    .east(east),
                    .south(south),
                    .west(west),
                    .stream(stream),
                    .border(border),
                    .changed(changed_bits[18*INDEX +: 18]),
                    .maximum(maximum_bits[18*INDEX +: 18])
                );
                for (i = 0; i < 3; i = i + 1) begin : rows
                    for (j = 0; j < 6; j = j + 1) begin : columns
                        localparam R = 3 * row + i;
                        localparam C = 6 * column + j;
                        localparam LOW = DIGIT_BITS * (6 * i + j);
                        localparam HERE = DIGIT_BITS * (COLUMNS * R + C);
                        if (i < HEIGHT && j < WIDTH) begin : present
                            assign streams[HERE+:DIGIT_BITS] = stream[LOW+:DIGIT_BITS];
                            assign borders[HERE+:DIGIT_BITS] = border[LOW+:DIGIT_BITS];
                            if (R == 0) assign north[LOW+:DIGIT_BITS] = north_stream[DIGIT_BITS*C+:DIGIT_BITS];
                            else assign north[LOW+:DIGIT_BITS] = streams[HERE-LINE+:DIGIT_BITS];
                            if (R == ROWS - 1) assign south[LOW+:DIGIT_BITS] = south_stream[DIGIT_BITS*C+:DIGIT_BITS];
                            else assign south[LOW+:DIGIT_BITS] = streams[HERE+LINE+:DIGIT_BITS];
                            if (C == 0) assign west[LOW+:DIGIT_BITS] = west_stream[DIGIT_BITS*R+:DIGIT_BITS];
                            else assign west[LOW+:DIGIT_BITS] = streams[HERE-DIGIT_BITS+:DIGIT_BITS];
                            if (C == COLUMNS - 1) assign east[LOW+:DIGIT_BITS] = east_stream[DIGIT_BITS*R+:DIGIT_BITS];
                            else assign east[LOW+:DIGIT_BITS] = streams[HERE+DIGIT_BITS+:DIGIT_BITS];
                        end else begin : absent
                            wire unused = &{1'b0, stream[LOW+:DIGIT_BITS], border[LOW+:DIGIT_BITS]};
                            assign north[LOW+:DIGIT_BITS] = {DIGIT_BITS{1'b0}};
                            assign south[LOW+:DIGIT_BITS] = {DIGIT_BITS{1'b0}};
                            assign west[LOW+:DIGIT_BITS] = {DIGIT_BITS{1'b0}};
                            assign east[LOW+:DIGIT_BITS] = {DIGIT_BITS{1'b0}};
                        end
                    end
                end
            end
        end
    endgenerate

    // The memories of the four sides. That of the north side of a block is read while the block above is visited.
    wire [DIGIT_BITS*ROWS-1:0] west_nodes, east_nodes;
    wire unused_borders = &{1'b0, borders};
    generate
        for (row = 0; row < ROWS; row = row + 1) begin : side_nodes
            localparam LOW = DIGIT_BITS * row;
            assign west_nodes[LOW+:DIGIT_BITS] = borders[COLUMNS*LOW+:DIGIT_BITS];
            assign east_nodes[LOW+:DIGIT_BITS] = borders[COLUMNS*LOW+DIGIT_BITS*(COLUMNS-1)+:DIGIT_BITS];
        end
        if (DOWN > 1) begin : down
            harmonic_border #(
                .NODES(COLUMNS),
                .ADDRESS_BITS(ADDRESS_BITS),
                .DIGIT_BITS(DIGIT_BITS),
                .PIPELINE(PIPELINE)
            ) north_side (
                .clk(clk),
                .valid(south_inside),
                .read_address(south_address),
                .write_enable(write_enable[CLUSTERS +: SIDE_COLUMNS]),
                .write_address(write_address),
                .loads(loads),
                .load_word(load_word),
                .written(borders[0+:DIGIT_BITS*COLUMNS]),
                .stream(south_stream)
            );
            harmonic_border #(
                .NODES(COLUMNS),
                .ADDRESS_BITS(ADDRESS_BITS),
                .DIGIT_BITS(DIGIT_BITS),
                .PIPELINE(PIPELINE)
            ) south_side (
                .clk(clk),
                .valid(north_inside),
                .read_address(north_address),
                .write_enable(write_enable[CLUSTERS + SIDE_COLUMNS +: SIDE_COLUMNS]),
                .write_address(write_address),
                .loads(loads),
                .load_word(load_word),
                .written(borders[DIGIT_BITS*COLUMNS*(ROWS-1)+:DIGIT_BITS*COLUMNS]),
                .stream(north_stream)
            );
        end else begin : one_row
            assign south_stream = {(DIGIT_BITS*COLUMNS){1'b0}};
            assign north_stream = {(DIGIT_BITS*COLUMNS){1'b0}};
            wire unused = &{1'b0, north_inside, south_inside, north_address, south_address};
        end
        if (ACROSS > 1) begin : across
            harmonic_border #(
                .NODES(ROWS),
                .ADDRESS_BITS(ADDRESS_BITS),
                .DIGIT_BITS(DIGIT_BITS),
                .PIPELINE(PIPELINE)
            ) west_side (
                .clk(clk),
                .valid(east_inside),
                .read_address(east_address),
                .write_enable(write_enable[WEST_SIDE +: SIDE_ROWS]),
                .write_address(write_address),
                .loads(loads),
                .load_word(load_word),
                .written(west_nodes),
                .stream(east_stream)
            );
            harmonic_border #(
                .NODES(ROWS),
                .ADDRESS_BITS(ADDRESS_BITS),
                .DIGIT_BITS(DIGIT_BITS),
                .PIPELINE(PIPELINE)
            ) east_side (
                .clk(clk),
                .valid(west_inside),
                .read_address(west_address),
                .write_enable(write_enable[WEST_SIDE + SIDE_ROWS +: SIDE_ROWS]),
                .write_address(write_address),
                .loads(loads),
                .load_word(load_word),
                .written(east_nodes),
                .stream(west_stream)
            );
        end else begin : one_column
            assign east_stream = {(DIGIT_BITS*ROWS){1'b0}};
            assign west_stream = {(DIGIT_BITS*ROWS){1'b0}};
            wire unused = &{1'b0, west_inside, east_inside, west_address, east_address, west_nodes, east_nodes};
        end
    endgenerate

    // Has any bit of the block changed, and is any node a local maximum? With a pipeline each cluster has a register of
    // its own, and 16 of them lead to the next; without, 256 nodes lead to one.
    generate
        if (PIPELINE != 0) begin : trees
            reg [CLUSTERS-1:0] changed_clusters, maximum_clusters;
            for (i = 0; i < CLUSTERS; i = i + 1) begin : clusters
                always @(posedge clk) begin
                    changed_clusters[i] <= |changed_bits[18*i +: 18];
                    maximum_clusters[i] <= |maximum_bits[18*i +: 18];
                end
            end
            harmonic_or_tree #(.INPUTS(CLUSTERS), .GROUP(16), .REGISTERED(1)) changes (
                .clk(clk), .bits(changed_clusters), .any(changed)
            );
            harmonic_or_tree #(.INPUTS(CLUSTERS), .GROUP(16), .REGISTERED(1)) maxima (
                .clk(clk), .bits(maximum_clusters), .any(maximum)
            );
        end else begin : trees
            harmonic_or_tree #(.INPUTS(18 * CLUSTERS), .GROUP(18 * 16), .REGISTERED(0)) changes (
                .clk(clk), .bits(changed_bits), .any(changed)
            );
            harmonic_or_tree #(.INPUTS(18 * CLUSTERS), .GROUP(18 * 16), .REGISTERED(0)) maxima (
                .clk(clk), .bits(maximum_bits), .any(maximum)
            );
        end
    endgenerate

    // One row of streams for the read-out and the decision.
    always @(posedge clk)
        row_line <= {side_node(east_stream), selected_row(streams), side_node(west_stream)};

    function [LINE-1:0] selected_row(input [LINE*ROWS-1:0] block);
        integer line;
        begin
            selected_row = {LINE{1'b0}};
            for (line = 0; line < ROWS; line = line + 1)
                selected_row = selected_row | block[LINE*line+:LINE] & {LINE{row_select[line]}};
        end
    endfunction

    function [DIGIT_BITS-1:0] side_node(input [DIGIT_BITS*ROWS-1:0] side);
        integer line;
        begin
            side_node = {DIGIT_BITS{1'b0}};
            for (line = 0; line < ROWS; line = line + 1)
                side_node = side_node | side[DIGIT_BITS*line+:DIGIT_BITS] & {DIGIT_BITS{row_select[line]}};
        end
    endfunction

    // One column of streams for the decision.
    generate
        if (DECISION != 0) begin : column_lines
            reg [DIGIT_BITS*(ROWS+2)-1:0] digits;
            wire [LINE*(ROWS+2)-1:0] lines = {south_stream, streams, north_stream};
            for (row = 0; row < ROWS + 2; row = row + 1) begin : rows
                always @(posedge clk) digits[DIGIT_BITS*row+:DIGIT_BITS] <= selected_node(lines[LINE*row+:LINE]);
            end
            assign column_line = digits;
        end else begin : no_column_lines
            assign column_line = {(DIGIT_BITS * (ROWS + 2)){1'b0}};
            wire unused = &{1'b0, column_select};
        end
    endgenerate

    function [DIGIT_BITS-1:0] selected_node(input [LINE-1:0] line);
        integer place;
        begin
            selected_node = {DIGIT_BITS{1'b0}};
            for (place = 0; place < COLUMNS; place = place + 1)
                selected_node = selected_node | line[DIGIT_BITS*place+:DIGIT_BITS] & {DIGIT_BITS{column_select[place]}};
        end
    endfunction
endmodule
