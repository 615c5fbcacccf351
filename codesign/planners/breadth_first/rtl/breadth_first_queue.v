// The circular queue of addresses, with its first cell in a register.
//
// next_cell is a copy of the first word. A push into an empty queue goes there too, so that the cell that an
// expansion pushes last may be popped in the next cycle. A pop takes next_cell. Two cycles later (settle) next_valid
// says whether another cell waits, and one cycle after that (refill) next_cell takes its word. preset puts the start
// into next_cell alone: the words hold what waits behind it.
// full says that a push finds no room, but for the first two cycles after a pop.
module breadth_first_queue #(
    parameter ADDRESS_BITS = 14,
    parameter WORDS = 16384,
    parameter POINTER_BITS = 14
) (
    input  wire                    clk,
    input  wire                    clear,
    input  wire                    preset,
    input  wire                    push,
    input  wire [ADDRESS_BITS-1:0] push_cell,
    input  wire                    pop,
    input  wire                    settle,
    input  wire                    refill,
    output reg                     next_valid,
    output reg  [ADDRESS_BITS-1:0] next_cell,
    output wire                    full
);
    localparam [31:0] LAST_WORD = WORDS - 1;
    localparam [POINTER_BITS-1:0] LAST = LAST_WORD[POINTER_BITS-1:0];
    localparam WRAPS = (1 << POINTER_BITS) == WORDS ? 1 : 0;
    reg [POINTER_BITS-1:0] head, tail;
    wire [ADDRESS_BITS-1:0] word;
    wire equal = head == tail;
    assign full = equal && next_valid;

    ram_1w1r #(
        .WIDTH(ADDRESS_BITS), .DEPTH(WORDS), .ADDRESS_BITS(POINTER_BITS), .OUTPUT_REGISTER(1)
    ) queue (
        .clk(clk),
        .write_enable(push), .write_address(tail), .write_data(push_cell),
        .read_enable(1'b1), .read_address(head), .read_data(word)
    );

    always @(posedge clk) begin
        if (clear) tail <= {POINTER_BITS{1'b0}};
        else if (push) tail <= WRAPS == 0 && tail == LAST ? {POINTER_BITS{1'b0}} : tail + 1'b1;
        if (clear) head <= {POINTER_BITS{1'b0}};
        else if (pop) head <= WRAPS == 0 && head == LAST ? {POINTER_BITS{1'b0}} : head + 1'b1;

        if (clear || pop) next_valid <= 1'b0;
        else if (push || preset) next_valid <= 1'b1;
        else if (settle) next_valid <= !equal;

        if (next_valid ? refill : push || preset) next_cell <= next_valid ? word : push_cell;
    end
endmodule
