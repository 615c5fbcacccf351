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
    parameter PIPELINE = 0,
    parameter MEMORIES = 4
) (
    input  wire                    clk,
    input  wire                    integer_slot,
    input  wire                    flag_slot,
    input  wire                    north_inside,
    input  wire                    east_inside,
    input  wire                    south_inside,
    input  wire                    west_inside,
    input  wire [ADDRESS_BITS-1:0] here_address,
    input  wire [ADDRESS_BITS-1:0] north_address,
    input  wire [ADDRESS_BITS-1:0] east_address,
    input  wire [ADDRESS_BITS-1:0] south_address,
    input  wire [ADDRESS_BITS-1:0] west_address,
    input  wire [ADDRESS_BITS-1:0] write_address,
    input  wire [MEMORIES-1:0]     write_enable,
    input  wire                    loads,
    input  wire [17:0]             load_word,
    input  wire [ROWS-1:0]         row_select,
    input  wire [COLUMNS-1:0]      column_select,
    output wire                    changed,       // OR trees; see harmonic_control for their delay
    output wire                    maximum,
    output reg  [COLUMNS+1:0]      row_line,      // the selected row, one column more at either end
    output wire [ROWS+1:0]         column_line    // the selected column, one row more at either end
);
    localparam CLUSTER_ROWS = (ROWS + 2) / 3;
    localparam CLUSTER_COLUMNS = (COLUMNS + 5) / 6;
    localparam CLUSTERS = CLUSTER_ROWS * CLUSTER_COLUMNS;
    localparam SIDE_ROWS = (ROWS + 17) / 18;
    localparam SIDE_COLUMNS = (COLUMNS + 17) / 18;
    localparam WEST_SIDE = CLUSTERS + (DOWN > 1 ? 2 * SIDE_COLUMNS : 0);

    wire [ROWS*COLUMNS-1:0] streams, borders;
    wire [18*CLUSTERS-1:0] changed_bits, maximum_bits;

    // Streams of the nodes around the block.
    wire [COLUMNS-1:0] north_stream, south_stream;
    wire [ROWS-1:0] west_stream, east_stream;

    genvar row, column, i, j;
    generate
        for (row = 0; row < CLUSTER_ROWS; row = row + 1) begin : cluster_rows
            for (column = 0; column < CLUSTER_COLUMNS; column = column + 1) begin : cluster_columns
                localparam HEIGHT = ROWS - 3 * row < 3 ? ROWS - 3 * row : 3;
                localparam WIDTH = COLUMNS - 6 * column < 6 ? COLUMNS - 6 * column : 6;
                localparam INDEX = CLUSTER_COLUMNS * row + column;
                wire [17:0] north, east, south, west, stream, border;
                harmonic_cluster #(
                    .ROWS(HEIGHT),
                    .COLUMNS(WIDTH),
                    .ADDRESS_BITS(ADDRESS_BITS),
                    .PIPELINE(PIPELINE)
                ) cluster (
                    .clk(clk),
                    .integer_slot(integer_slot),
                    .flag_slot(flag_slot),
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
                        if (i < HEIGHT && j < WIDTH) begin : present
                            assign streams[COLUMNS*R+C] = stream[6*i+j];
                            assign borders[COLUMNS*R+C] = border[6*i+j];
                            if (R == 0) assign north[6*i+j] = north_stream[C];
                            else assign north[6*i+j] = streams[COLUMNS*(R-1)+C];
                            if (R == ROWS - 1) assign south[6*i+j] = south_stream[C];
                            else assign south[6*i+j] = streams[COLUMNS*(R+1)+C];
                            if (C == 0) assign west[6*i+j] = west_stream[R];
                            else assign west[6*i+j] = streams[COLUMNS*R+C-1];
                            if (C == COLUMNS - 1) assign east[6*i+j] = east_stream[R];
                            else assign east[6*i+j] = streams[COLUMNS*R+C+1];
                        end else begin : absent
                            wire unused = &{1'b0, stream[6*i+j], border[6*i+j]};
                            assign north[6*i+j] = 1'b0;
                            assign south[6*i+j] = 1'b0;
                            assign west[6*i+j] = 1'b0;
                            assign east[6*i+j] = 1'b0;
                        end
                    end
                end
            end
        end
    endgenerate

    // The memories of the four sides. That of the north side of a block is read while the block above is visited.
    wire [ROWS-1:0] west_nodes, east_nodes;
    generate
        for (row = 0; row < ROWS; row = row + 1) begin : side_nodes
            assign west_nodes[row] = borders[COLUMNS*row];
            assign east_nodes[row] = borders[COLUMNS*row+COLUMNS-1];
        end
        if (DOWN > 1) begin : down
            harmonic_border #(
                .NODES(COLUMNS),
                .ADDRESS_BITS(ADDRESS_BITS),
                .PIPELINE(PIPELINE)
            ) north_side (
                .clk(clk),
                .valid(south_inside),
                .read_address(south_address),
                .write_enable(write_enable[CLUSTERS +: SIDE_COLUMNS]),
                .write_address(write_address),
                .loads(loads),
                .load_word(load_word),
                .written(borders[0 +: COLUMNS]),
                .stream(south_stream)
            );
            harmonic_border #(
                .NODES(COLUMNS),
                .ADDRESS_BITS(ADDRESS_BITS),
                .PIPELINE(PIPELINE)
            ) south_side (
                .clk(clk),
                .valid(north_inside),
                .read_address(north_address),
                .write_enable(write_enable[CLUSTERS + SIDE_COLUMNS +: SIDE_COLUMNS]),
                .write_address(write_address),
                .loads(loads),
                .load_word(load_word),
                .written(borders[COLUMNS*(ROWS-1) +: COLUMNS]),
                .stream(north_stream)
            );
        end else begin : one_row
            assign south_stream = {COLUMNS{1'b0}};
            assign north_stream = {COLUMNS{1'b0}};
            wire unused = &{1'b0, north_inside, south_inside, north_address, south_address, borders};
        end
        if (ACROSS > 1) begin : across
            harmonic_border #(
                .NODES(ROWS),
                .ADDRESS_BITS(ADDRESS_BITS),
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
            assign east_stream = {ROWS{1'b0}};
            assign west_stream = {ROWS{1'b0}};
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
    generate
        for (column = 0; column < COLUMNS; column = column + 1) begin : row_lines
            wire [ROWS-1:0] bits;
            for (row = 0; row < ROWS; row = row + 1) begin : rows
                assign bits[row] = streams[COLUMNS*row+column] & row_select[row];
            end
            always @(posedge clk) row_line[column+1] <= |bits;
        end
    endgenerate
    always @(posedge clk) begin
        row_line[0] <= |(west_stream & row_select);
        row_line[COLUMNS+1] <= |(east_stream & row_select);
    end

    // One column of streams for the decision.
    generate
        if (DECISION != 0) begin : column_lines
            reg [ROWS+1:0] line;
            for (row = 0; row < ROWS; row = row + 1) begin : rows
                always @(posedge clk) line[row+1] <= |(streams[COLUMNS*row +: COLUMNS] & column_select);
            end
            always @(posedge clk) begin
                line[0] <= |(north_stream & column_select);
                line[ROWS+1] <= |(south_stream & column_select);
            end
            assign column_line = line;
        end else begin : no_column_lines
            assign column_line = {(ROWS + 2){1'b0}};
            wire unused = &{1'b0, column_select};
        end
    endgenerate
endmodule
