// The state machine of breadth_first_machine.v without a display.
module breadth_first_top #(
    parameter ROWS = 100,
    parameter COLUMNS = 100,
    parameter ROW_BITS = 7,
    parameter COLUMN_BITS = 7,
    parameter ADDRESS_BITS = 14,
    parameter LINEAR = 0,
    parameter CYCLES = 14,
    parameter QUEUE_WORDS = 16384,
    parameter POINTER_BITS = 14,
    parameter CHECKED = 0
) (
    input  wire                    clk,
    input  wire                    reset,
    input  wire                    start,
    input  wire [1:0]              in_data,
    input  wire                    in_valid,
    output wire                    in_ready,
    output wire [3:0]              phase,
    output wire                    event_valid,
    output wire [3:0]              event_kind,
    output wire [ADDRESS_BITS+1:0] event_data,
    output wire                    done
);
    wire [1:0] shown_code, shown_direction;
    wire unused = &{1'b0, shown_code, shown_direction};

    breadth_first_machine #(
        .ROWS(ROWS), .COLUMNS(COLUMNS), .ROW_BITS(ROW_BITS), .COLUMN_BITS(COLUMN_BITS),
        .ADDRESS_BITS(ADDRESS_BITS), .LINEAR(LINEAR), .CYCLES(CYCLES), .QUEUE_WORDS(QUEUE_WORDS),
        .POINTER_BITS(POINTER_BITS), .CHECKED(CHECKED), .SHOWN(0)
    ) machine (
        .clk(clk), .reset(reset), .start(start), .in_data(in_data), .in_valid(in_valid),
        .in_ready(in_ready), .phase(phase), .event_valid(event_valid), .event_kind(event_kind),
        .event_data(event_data), .done(done),
        .shown_address({ADDRESS_BITS{1'b0}}), .shown_code(shown_code), .shown_direction(shown_direction)
    );
endmodule
