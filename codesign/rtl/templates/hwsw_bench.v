// The test bench of one design point, self-checking. It prints PASS, or the first difference with its cycle.
//
// Outputs are sampled just before a rising edge; inputs change after it. The edge at which start is sampled high is
// the last one before cycle 0. A word of the stream is taken at an edge with in_valid and in_ready.
//
// +log writes every event into the file events.log, and compares nothing. +waves writes waves.vcd; +first=N and +last=N
// limit it to these cycles, and the run ends with the last one.
module hwsw_bench;
    localparam WORDS = {{ words }}, EVENTS = {{ events }};
    localparam EVENT_BITS = {{ event_bits }}, VALUE_BITS = {{ value_bits }};
    localparam [63:0] BOUND = 64'd{{ bound }};
{%- if contention %}
    // Cycles are not compared: {{ contention }}.
{%- endif %}
    localparam CHECK_CYCLES = {{ 0 if contention else 1 }};

    reg clk, reset, start, in_valid;
    reg {{ in_range }}in_data;
    wire in_ready, event_valid, done;
    wire [3:0] phase, event_kind;
    wire {{ event_range }}event_data;

    {{ top }} circuit (
        .clk(clk), .reset(reset), .start(start),
        .in_data(in_data), .in_valid(in_valid), .in_ready(in_ready),
        .phase(phase), .event_valid(event_valid), .event_kind(event_kind), .event_data(event_data),
        .done(done)
    );

    // The load stream, and the expected events: cycle, kind, value.
    reg {{ in_range }}stream [0:{{ [words, 1] | max - 1 }}];
    reg [52+VALUE_BITS-1:0] expected [0:{{ [events, 1] | max - 1 }}];

    integer taken, seen, index, log;
    integer phase_cycles [0:15], expected_cycles [0:15];
    reg [63:0] cycle, first_wave, last_wave;
    reg ended, failed, logging, dumping;
    reg [47:0] model_cycle;
    reg [3:0] model_kind;
    reg [VALUE_BITS-1:0] model_value, value;

    task write_kind(input [3:0] kind);
        case (kind)
{%- for kind in kinds %}
            4'd{{ loop.index0 }}: $write("{{ kind }}");
{%- endfor %}
            default: $write("kind %0d", kind);
        endcase
    endtask

    task write_phase(input integer number);
        case (number)
{%- for phase in phases %}
            {{ loop.index }}: $write("{{ phase }}");
{%- endfor %}
            default: $write("%0d", number);
        endcase
    endtask

    // A rising edge, and the time just after it, at which inputs change.
    task rise;
        begin
            clk = 1'b1;
            #1;
        end
    endtask

    // The rest of the period: outputs settle.
    task settle;
        begin
            #4 clk = 1'b0;
            #5;
        end
    endtask

    // Offers the next word of the stream, as long as words are left.
    task offer;
        begin
            in_valid = taken < WORDS;
            if (taken < WORDS) in_data = stream[taken];
        end
    endtask

    task fail;
        begin
            if (!failed) $write("FAIL at cycle %0d: ", cycle);
            failed = 1'b1;
        end
    endtask

    // Compares an event with the next one that the model expects.
    task check_event;
        begin
            if (seen < EVENTS) {model_cycle, model_kind, model_value} = expected[seen];
            if (seen >= EVENTS) begin
                fail;
                $write("the circuit reports ");
                write_kind(event_kind);
                $display(" %0d, the model nothing more", event_data);
            end else if (event_kind !== model_kind || value !== model_value
                         || (CHECK_CYCLES != 0 && cycle != {16'd0, model_cycle})) begin
                fail;
                $write("the model reports ");
                write_kind(model_kind);
                $write(" %0d at cycle %0d, the circuit ", model_value, model_cycle);
                write_kind(event_kind);
                $display(" %0d (event %0d)", event_data, seen);
            end
        end
    endtask

    // Compares what is known at the end only: missing events, the cycles of each phase, and the words taken.
    task check_end;
        begin
            if (!failed && seen < EVENTS) begin
                fail;
                {model_cycle, model_kind, model_value} = expected[seen];
                $write("the model reports ");
                write_kind(model_kind);
                $display(" %0d at cycle %0d, the circuit nothing more", model_value, model_cycle);
            end
            if (!failed && !ended) begin
                fail;
                $display("the circuit does not end");
            end
            for (index = 1; index < 16; index = index + 1)
                if (!failed && CHECK_CYCLES != 0 && phase_cycles[index] != expected_cycles[index]) begin
                    fail;
                    $write("phase ");
                    write_phase(index);
                    $display(" takes %0d cycles in the model, %0d in the circuit",
                             expected_cycles[index], phase_cycles[index]);
                end
            if (!failed && taken != WORDS) begin
                fail;
                $display("the circuit takes %0d of the %0d words of its stream", taken, WORDS);
            end
            if (!failed) $display("PASS: %0d events in %0d cycles", seen, cycle);
        end
    endtask

    // What the circuit shows just before a rising edge.
    task sample;
        begin
            if ((^phase) !== 1'bx) phase_cycles[phase] = phase_cycles[phase] + 1;
            if (event_valid !== 1'b0) begin
                value = {VALUE_BITS{1'b0}};
                value[EVENT_BITS-1:0] = event_data;
                if (logging) $fwrite(log, "event %0d %0d %0h\n", cycle, event_kind, event_data);
                else check_event;
                seen = seen + 1;
            end
            ended = done === 1'b1;
            if (in_ready === 1'b1 && taken < WORDS) taken = taken + 1;
        end
    endtask

    initial begin
        for (index = 0; index < 16; index = index + 1) begin
            phase_cycles[index] = 0;
            expected_cycles[index] = 0;
        end
{%- for cycles in cycles_by_phase %}
        expected_cycles[{{ loop.index }}] = {{ cycles }};
{%- endfor %}
        $readmemh("stream.hex", stream);
        $readmemh("expected.hex", expected);
        logging = $test$plusargs("log") != 0;
        dumping = $test$plusargs("waves") != 0;
        if ($value$plusargs("first=%d", first_wave) == 0) first_wave = 64'd0;
        if ($value$plusargs("last=%d", last_wave) == 0) last_wave = BOUND;
        log = 0;
        if (logging) log = $fopen("events.log", "w");
        taken = 0;
        seen = 0;
        cycle = 64'd0;
        ended = 1'b0;
        failed = 1'b0;

        clk = 1'b0;
        reset = 1'b1;
        start = 1'b0;
        offer;
        settle;
        rise;
        settle;
        rise;
        reset = 1'b0;
        start = 1'b1;
        settle;
        rise;
        start = 1'b0;
        while (!ended && !failed && cycle < BOUND && (!dumping || cycle <= last_wave)) begin
            settle;
            if (dumping && cycle == first_wave) begin
                $dumpfile("waves.vcd");
                $dumpvars(0, circuit);
            end
            sample;
            rise;
            offer;
            if (!ended && !failed) cycle = cycle + 64'd1;
        end
        if (logging) begin
            for (index = 0; index < 16; index = index + 1)
                $fwrite(log, "phase %0d %0d\n", index, phase_cycles[index]);
            $fwrite(log, "end %0d %0d\n", taken, ended);
            $fclose(log);
        end else if (dumping && !ended && !failed) $display("waves.vcd ends at cycle %0d", last_wave);
        else check_end;
        $finish;
    end
endmodule
