// The field beside the decision module: five memories that give a cell and its four neighbours at once, bit by bit.
//
// Cell (r, c) is in memory (r + 2 c) mod 5, so a cell and its neighbours are in five memories: with the cell in memory s,
// its neighbours to the south, east, west and north are in s + 1, s + 2, s + 3 and s + 4 (mod 5). Words have one bit. A
// plane has one bit of all cells, at address GROUPS r + c div 5; plane i has bit i of the values, the lowest bit first.
module harmonic_field #(
    parameter GROUPS = 2,        // of five columns, in a row
    parameter PLANE = 8,
    parameter WORDS = 64,
    parameter ADDRESS_BITS = 6
) (
    input  wire                    clk,
    input  wire                    write_enable,
    input  wire [ADDRESS_BITS-1:0] write_address,
    input  wire [4:0]              write_data,   // bit k is that of memory k
    input  wire                    place,        // a cell: its address in a plane, its memory, and
    input  wire [ADDRESS_BITS-1:0] address,
    input  wire [2:0]              memory,
    input  wire                    east_step,    // the eastern neighbour is in the next group of columns
    input  wire                    west_step,
    input  wire [3:0]              sides,        // a cell to the north, east, south, west
    input  wire                    read,
    input  wire                    step,         // to the next plane
    input  wire                    valid,        // what the memories show are bits of a plane
    output reg                     here,         // one cycle after the memories show them
    output reg                     north,
    output reg                     east,
    output reg                     south,
    output reg                     west
);
    localparam [31:0] GROUPS_WORD = GROUPS, PLANE_WORD = PLANE;
    localparam [ADDRESS_BITS-1:0] LINE = GROUPS_WORD[ADDRESS_BITS-1:0];
    localparam [ADDRESS_BITS-1:0] NEXT = PLANE_WORD[ADDRESS_BITS-1:0];
    localparam [ADDRESS_BITS-1:0] ONE = 1, ZERO = 0;

    // The addresses of the cell and its neighbours, those beyond the map replaced by that of the cell.
    wire [ADDRESS_BITS-1:0] to_north = address - (sides[3] ? LINE : ZERO);
    wire [ADDRESS_BITS-1:0] to_east = address + (sides[2] && east_step ? ONE : ZERO);
    wire [ADDRESS_BITS-1:0] to_south = address + (sides[1] ? LINE : ZERO);
    wire [ADDRESS_BITS-1:0] to_west = address - (sides[0] && west_step ? ONE : ZERO);

    reg [2:0] first;
    reg [3:0] present;
    always @(posedge clk) if (place) begin
        first <= memory;
        present <= sides;
    end

    wire [4:0] stored;
    genvar index;
    generate
        for (index = 0; index < 5; index = index + 1) begin : memories
            localparam [31:0] NUMBER = index;
            // Whose bits memory number k has: role (k - s) mod 5.
            wire [2:0] role = NUMBER[2:0] >= memory ? NUMBER[2:0] - memory : NUMBER[2:0] - memory + 3'd5;
            reg [ADDRESS_BITS-1:0] read_address;
            always @(posedge clk) begin
                if (place)
                    case (role)
                        3'd0: read_address <= address;
                        3'd1: read_address <= to_south;
                        3'd2: read_address <= to_east;
                        3'd3: read_address <= to_west;
                        default: read_address <= to_north;
                    endcase
                else if (step) read_address <= read_address + NEXT;
            end
            ram_1w1r #(
                .WIDTH(1),
                .DEPTH(WORDS),
                .ADDRESS_BITS(ADDRESS_BITS),
                .OUTPUT_REGISTER(1)
            ) bits (
                .clk(clk),
                .write_enable(write_enable),
                .write_address(write_address),
                .write_data(write_data[index]),
                .read_enable(read),
                .read_address(read_address),
                .read_data(stored[index])
            );
        end
    endgenerate

    // Bit d is that of role d.
    wire [9:0] twice = {stored, stored};
    wire [4:0] by_role = twice[{1'b0, first} +: 5];
    always @(posedge clk) begin
        here <= valid & by_role[0];
        south <= valid & present[1] & by_role[1];
        east <= valid & present[2] & by_role[2];
        west <= valid & present[0] & by_role[3];
        north <= valid & present[3] & by_role[4];
    end
endmodule
