// Which velocity of the array is tried next (section III, velocity selector).
//
// Heading: the direction of the array that is nearest to the target's. In the first octant it is the number of bounds
// with across cos > along sin, found by halving in 2 HALVINGS cycles; one more mirrors it back.
// Candidates: at the greatest speed the heading, then one direction to either side, two, ..; then the next lower speed.
module velocity_selector #(
    parameter WIDTH = 16,
    parameter DIRECTIONS = 64,
    parameter SPEEDS = 10,
    parameter TURNS = 64,
    parameter HALVINGS = 4,
    parameter ADDRESS_BITS = 10,
    parameter BOUNDS = "bounds.hex"
) (
    input  wire                       clk,
    input  wire                       begin_heading,
    input  wire                       heading_active,
    output wire                       heading_last,
    input  wire                       advance,
    input  wire signed [WIDTH:0]      along,
    input  wire signed [WIDTH:0]      across,
    input  wire                       mirror_diagonal,
    input  wire                       mirror_x,
    input  wire                       mirror_y,
    output wire signed [WIDTH:0]      first,
    output wire signed [WIDTH-1:0]    second,
    input  wire signed [2*WIDTH+1:0]  product_now,
    input  wire signed [2*WIDTH+1:0]  product,
    output reg  [ADDRESS_BITS-1:0]    candidate,
    output wire                       last_candidate
);
    localparam DIRECTION_BITS = $clog2(DIRECTIONS + 1);
    localparam [31:0] COUNT = DIRECTIONS;

    // `bit_value` is the bit of the number of bounds that is decided: a product of the cosine, then one of the sine.
    reg [HALVINGS-1:0] bit_value, number;
    reg mirroring, compare;
    wire signed [WIDTH-1:0] cosine, sine;
    direction_bounds #(.WIDTH(WIDTH), .ADDRESS_BITS(HALVINGS), .IMAGE(BOUNDS)) table_of_bounds (
        .address(number | (bit_value - 1'b1)), .cosine(cosine), .sine(sine)
    );
    assign first = compare ? along : across;
    assign second = compare ? sine : cosine;
    always @(posedge clk) begin
        if (begin_heading) begin
            bit_value <= {{1'b1}, {(HALVINGS - 1) {1'b0}}};
            number <= {HALVINGS{1'b0}};
            compare <= 1'b0;
            mirroring <= 1'b0;
        end else if (heading_active) begin
            compare <= !compare;
            if (compare) begin
                if (product > product_now) number <= number | bit_value;
                {bit_value, mirroring} <= {1'b0, bit_value};
            end
        end
    end
    assign heading_last = heading_active && mirroring;

    // Mirrored at 45°, at 90° and at 0°.
    wire [DIRECTION_BITS-1:0] octant = {{(DIRECTION_BITS - HALVINGS) {1'b0}}, number};
    wire [DIRECTION_BITS-1:0] quadrant = mirror_diagonal ? COUNT[DIRECTION_BITS+1:2] - octant : octant;
    wire [DIRECTION_BITS-1:0] half_plane = mirror_x ? COUNT[DIRECTION_BITS:1] - quadrant : quadrant;
    wire [DIRECTION_BITS-1:0] heading_now =
        mirror_y && half_plane != {DIRECTION_BITS{1'b0}} ? COUNT[DIRECTION_BITS-1:0] - half_plane : half_plane;

    // Speeds go down by one row of the array; at each, the directions up and down from the heading in turn.
    localparam SPEED_BITS = $clog2(SPEEDS + 1);
    localparam [31:0] LAST_TURN = TURNS - 1, LAST_SPEED = SPEEDS - 1, LAST_DIRECTION = DIRECTIONS - 1;
    reg [DIRECTION_BITS-1:0] heading, up, down, turn;
    reg [SPEED_BITS-1:0] speed;
    reg [ADDRESS_BITS-1:0] row;
    wire last_turn = turn == LAST_TURN[DIRECTION_BITS-1:0];
    wire [DIRECTION_BITS-1:0] next_up =
        up == LAST_DIRECTION[DIRECTION_BITS-1:0] ? {DIRECTION_BITS{1'b0}} : up + 1'b1;
    wire [DIRECTION_BITS-1:0] next_down =
        down == {DIRECTION_BITS{1'b0}} ? LAST_DIRECTION[DIRECTION_BITS-1:0] : down - 1'b1;
    wire [DIRECTION_BITS-1:0] next_direction = last_turn ? heading : turn[0] ? next_down : next_up;
    wire [ADDRESS_BITS-1:0] next_row = last_turn ? row + COUNT[ADDRESS_BITS-1:0] : row;
    always @(posedge clk) begin
        if (heading_last) begin
            heading <= heading_now;
            up <= heading_now;
            down <= heading_now;
            turn <= {DIRECTION_BITS{1'b0}};
            speed <= {SPEED_BITS{1'b0}};
            row <= {ADDRESS_BITS{1'b0}};
            candidate <= {{(ADDRESS_BITS - DIRECTION_BITS) {1'b0}}, heading_now};
        end else if (advance) begin
            turn <= last_turn ? {DIRECTION_BITS{1'b0}} : turn + 1'b1;
            up <= last_turn ? heading : turn[0] ? up : next_up;
            down <= last_turn ? heading : turn[0] ? next_down : down;
            if (last_turn) speed <= speed + 1'b1;
            row <= next_row;
            candidate <= next_row + {{(ADDRESS_BITS - DIRECTION_BITS) {1'b0}}, next_direction};
        end
    end
    assign last_candidate = last_turn && speed == LAST_SPEED[SPEED_BITS-1:0];
endmodule
