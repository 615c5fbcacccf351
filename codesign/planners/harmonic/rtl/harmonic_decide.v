// The decision module by itself (Girau et al. 2008, section 5.3), with the field in block RAM beside it.
//
// Phases: 1 load, 2 decide. Stream: the precision p; the p + 1 planes of the field, as harmonic_field has them, a word of
// five bits an address; then the position of the robot, from the lowest bit: the address of its cell in a plane, whether
// its western and its eastern neighbour are in another group of columns, the memory of the cell (3 bits), and whether
// there is a cell to the west, south, east, north. Event 0: the decision, as in harmonic.v.
module harmonic_decide #(
    parameter ROWS = 8,
    parameter COLUMNS = 8,
    parameter LAST_PRECISION = 15,
    parameter IN_BITS = 13
) (
    input  wire                  clk,
    input  wire                  reset,
    input  wire                  start,
    input  wire [IN_BITS-1:0]    in_data,
    input  wire                  in_valid,
    output wire                  in_ready,
    output reg  [3:0]            phase,
    output reg                   event_valid,
    output wire [3:0]            event_kind,
    output reg  [5:0]            event_data,
    output reg                   done
);
    localparam GROUPS = (COLUMNS + 4) / 5;
    localparam PLANE = ROWS * GROUPS;
    localparam WORDS = PLANE * (LAST_PRECISION + 1);
    localparam ADDRESS_BITS = $clog2(WORDS);
    localparam PLACE_BITS = PLANE > 1 ? $clog2(PLANE) : 1;
    localparam LEFT_BITS = $clog2(LAST_PRECISION + 2);
    localparam [31:0] PLANE_LESS_1 = PLANE - 1;
    localparam [PLACE_BITS-1:0] LAST_PLACE = PLANE_LESS_1[PLACE_BITS-1:0];
    localparam [3:0] IDLE = 0, LOAD = 1, DECIDE = 2;

    assign event_kind = 4'd0;

    // Loading: words of a plane, and planes that are left after this one.
    reg loads, asks, fresh, runs;
    reg [ADDRESS_BITS-1:0] write_address;
    reg [PLACE_BITS-1:0] place;
    reg [LEFT_BITS-1:0] left, precision;
    wire takes = in_ready & in_valid;
    wire stores = takes & loads & ~fresh;
    wire plane_over = place == LAST_PLACE;
    wire loaded = stores & plane_over & left == 0;
    wire placed = takes & asks;
    assign in_ready = loads | asks;

    // The decision: p + 1 planes, then a 0, as the sum of two values is one bit longer than each. Its bits come to the
    // comparisons three cycles after their addresses.
    wire reads = runs & left != 0;
    reg [1:0] reads_later;
    reg [2:0] first_later;
    reg [3:0] last_later;
    reg opens;
    always @(posedge clk) begin
        opens <= placed;
        reads_later <= {reads_later[0], reads};
        first_later <= {first_later[1:0], opens};
        last_later <= reset ? 4'd0 : {last_later[2:0], runs & left == 0};
    end

    always @(posedge clk) begin
        if (takes & loads) begin
            fresh <= 1'b0;
            if (fresh) begin
                left <= in_data[LEFT_BITS-1:0];
                precision <= in_data[LEFT_BITS-1:0];
            end else begin
                write_address <= write_address + 1'b1;
                place <= plane_over ? {PLACE_BITS{1'b0}} : place + 1'b1;
                if (plane_over) left <= left - 1'b1;
            end
        end
        if (loaded) begin
            loads <= 1'b0;
            asks <= 1'b1;
            phase <= DECIDE;
        end
        if (placed) begin
            asks <= 1'b0;
            runs <= 1'b1;
            left <= precision + 1'b1;
        end
        if (runs) begin
            left <= left - 1'b1;
            runs <= left != 0;
        end
        event_valid <= last_later[3];
        if (last_later[3]) phase <= IDLE;
        done <= event_valid;
        if (start) begin
            loads <= 1'b1;
            fresh <= 1'b1;
            phase <= LOAD;
            write_address <= {ADDRESS_BITS{1'b0}};
            place <= {PLACE_BITS{1'b0}};
        end
        if (reset) begin
            phase <= IDLE;
            loads <= 1'b0;
            asks <= 1'b0;
            runs <= 1'b0;
            event_valid <= 1'b0;
            done <= 1'b0;
        end
    end

    wire here, north, east, south, west;
    wire [ADDRESS_BITS-1:0] address;
    generate
        if (ADDRESS_BITS > PLACE_BITS) assign address = {{(ADDRESS_BITS - PLACE_BITS){1'b0}}, in_data[0 +: PLACE_BITS]};
        else assign address = in_data[0 +: ADDRESS_BITS];
    endgenerate
    harmonic_field #(
        .GROUPS(GROUPS),
        .PLANE(PLANE),
        .WORDS(WORDS),
        .ADDRESS_BITS(ADDRESS_BITS)
    ) field (
        .clk(clk),
        .write_enable(stores),
        .write_address(write_address),
        .write_data(in_data[4:0]),
        .place(placed),
        .address(address),
        .memory(in_data[PLACE_BITS + 2 +: 3]),
        .east_step(in_data[PLACE_BITS + 1]),
        .west_step(in_data[PLACE_BITS]),
        .sides(in_data[PLACE_BITS + 5 +: 4]),
        .read(runs),
        .step(reads & left != 1),
        .valid(reads_later[1]),
        .here(here),
        .north(north),
        .east(east),
        .south(south),
        .west(west)
    );

    wire [2:0] vertical, horizontal;
    harmonic_decision vertical_axis (
        .clk(clk), .first(first_later[2]), .here(here), .a(north), .b(south),
        .second(vertical[0]), .rises(vertical[1]), .differs(vertical[2])
    );
    harmonic_decision horizontal_axis (
        .clk(clk), .first(first_later[2]), .here(here), .a(east), .b(west),
        .second(horizontal[0]), .rises(horizontal[1]), .differs(horizontal[2])
    );
    always @(posedge clk) event_data <= {horizontal, vertical};
endmodule
