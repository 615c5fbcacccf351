// A summing machine, for tests of the flow alone: it loads COUNT words, then adds them up.
//
// Phase 1, load: one word an edge. Phase 2, sum: the memory takes one edge, then one word an edge; each partial sum is
// an event of kind 0. At the last edge of phase 2 the event of kind 1 has the sum plus the constant of the image.
module toy_sum #(
    parameter WIDTH = 8,
    parameter COUNT = 12,
    parameter ADDRESS_BITS = 4,
    parameter EVENT_BITS = 16,
    parameter IMAGE = "constant.hex"
) (
    input  wire                  clk,
    input  wire                  reset,
    input  wire                  start,
    input  wire [WIDTH-1:0]      in_data,
    input  wire                  in_valid,
    output wire                  in_ready,
    output wire [3:0]            phase,
    output wire                  event_valid,
    output wire [3:0]            event_kind,
    output wire [EVENT_BITS-1:0] event_data,
    output wire                  done
);
    localparam [1:0] IDLE = 2'd0, LOAD = 2'd1, SUM = 2'd2, ENDED = 2'd3;
    localparam LAST = COUNT - 1;

    reg [1:0] state;
    reg [ADDRESS_BITS-1:0] address;
    reg reading, last, closing;
    reg [EVENT_BITS-1:0] sum;
    wire [WIDTH-1:0] word, constant;
    wire take = state == LOAD && in_valid;
    wire at_end = address == LAST[ADDRESS_BITS-1:0];
    wire [EVENT_BITS-1:0] next_sum = sum + {{(EVENT_BITS - WIDTH){1'b0}}, word};

    assign in_ready = state == LOAD;
    assign phase = state == LOAD ? 4'd1 : state == SUM ? 4'd2 : 4'd0;
    assign event_valid = state == SUM && (reading || closing);
    assign event_kind = {3'd0, closing};
    assign event_data = closing ? sum + {{(EVENT_BITS - WIDTH){1'b0}}, constant} : next_sum;
    assign done = state == ENDED;

    ram_1w1r #(.WIDTH(WIDTH), .DEPTH(COUNT), .ADDRESS_BITS(ADDRESS_BITS)) store (
        .clk(clk), .write_enable(take), .write_address(address), .write_data(in_data),
        .read_enable(state == SUM), .read_address(address), .read_data(word)
    );

    ram_1w1r #(.WIDTH(WIDTH), .DEPTH(1), .ADDRESS_BITS(1), .HAS_IMAGE(1), .IMAGE(IMAGE)) constants (
        .clk(clk), .write_enable(1'b0), .write_address(1'b0), .write_data({WIDTH{1'b0}}),
        .read_enable(1'b1), .read_address(1'b0), .read_data(constant)
    );

    always @(posedge clk) begin
        if (reset) state <= IDLE;
        else case (state)
            IDLE: if (start) state <= LOAD;
            LOAD: if (take && at_end) state <= SUM;
            SUM: if (closing) state <= ENDED;
            ENDED: if (start) state <= LOAD;
        endcase
        if (state == IDLE || state == ENDED) begin
            address <= 0;
            sum <= 0;
            reading <= 1'b0;
            last <= 1'b0;
            closing <= 1'b0;
        end else if (take || state == SUM) begin
            address <= at_end ? {ADDRESS_BITS{1'b0}} : address + 1'b1;
        end
        if (state == SUM) begin
            reading <= !last;
            last <= last || at_end;
            closing <= last && reading;
            if (reading) sum <= next_sum;
        end
    end
endmodule
