// Drives a circuit that CXXRTL wrote, by the contract of circuits, and reports what it says.
//
// run WORDS BOUND WATCHED [VCD FIRST LAST MODEL]: reads the stream from standard input, chunks of 32 bits. MODEL is a file with
// the events that the model expects, for the scope model of the waveform. Writes numbers of 64 bits: cycle, kind and
// value of each event, then the cycles of the 16 phases, the words taken, and whether the run ended. With PINS, the
// further outputs, it goes on to cycle WATCHED after the end, and writes each change of them as an event of kind 16.

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <vector>

#include "design.cc"

#ifdef WAVES
#include <cxxrtl/cxxrtl_vcd.h>
#endif

static cxxrtl_design::TOP top;

#ifdef WAVES
static cxxrtl::vcd_writer vcd;
static std::ofstream vcd_file;
static uint64_t first_wave, last_wave;

// What the model reports in this cycle, under the names of the circuit's outputs.
static std::vector<uint64_t> expected;
static size_t shown;
static cxxrtl::value<1> model_valid;
static cxxrtl::value<4> model_kind;
static cxxrtl::value<64> model_data;

static void read_model(const char *name) {
    std::ifstream file(name, std::ios::binary);
    uint64_t number;
    while (file.read(reinterpret_cast<char *>(&number), 8)) expected.push_back(number);
}

static void show_model(uint64_t cycle) {
    while (3 * shown < expected.size() && expected[3 * shown] < cycle) shown++;
    const bool valid = 3 * shown < expected.size() && expected[3 * shown] == cycle;
    model_valid.set<bool>(valid);
    if (valid) {
        model_kind.set<uint64_t>(expected[3 * shown + 1]);
        model_data.set<uint64_t>(expected[3 * shown + 2]);
    }
}

static void sample(uint64_t cycle, int half) {
    if (cycle < first_wave || cycle > last_wave || !vcd_file.is_open()) return;
    top.step();
    show_model(cycle + half);  // after the edge the outputs are those of the next cycle
    vcd.sample(2 * cycle + half);
    vcd_file << vcd.buffer;
    vcd.buffer.clear();
}
#else
static void sample(uint64_t, int) {}
#endif

// Low: everything settles on the state of the last edge and on the inputs. High: the edge.
static void set_clock(bool level) {
    top.p_clk.set<bool>(level);
    top.step();
}

// Whoever waits for a long run reads from a file how far it is.
static void show(uint64_t cycle) {
    if (cycle % 4096) return;
    std::ofstream("cycle") << cycle;
}

int main(int count, char **words) {
    const uint64_t stream_words = strtoull(words[1], nullptr, 10), bound = strtoull(words[2], nullptr, 10);
    const uint64_t watched = strtoull(words[3], nullptr, 10);
    const size_t chunks = top.p_in__data.chunks;
    std::vector<uint32_t> stream((stream_words + 1) * chunks);
    if (fread(stream.data(), 4, stream_words * chunks, stdin) != stream_words * chunks) return 2;
#ifdef WAVES
    if (count > 7) {
        read_model(words[7]);
        vcd_file.open(words[4]);
        first_wave = strtoull(words[5], nullptr, 10);
        last_wave = strtoull(words[6], nullptr, 10);
        cxxrtl::debug_items items;
        top.debug_info(&items, nullptr, "circuit ");
        items.add("model event_valid", cxxrtl::debug_item(model_valid));
        items.add("model event_kind", cxxrtl::debug_item(model_kind));
        items.add("model event_data", cxxrtl::debug_item(model_data));
        vcd.timescale(1, "ns");
        vcd.add_without_memories(items);
    }
#else
    (void)count;
#endif
    uint64_t taken = 0, ended = 0, cycles[16] = {};
    auto offer = [&]() {
        for (size_t i = 0; i < chunks; i++) top.p_in__data.data[i] = stream[taken * chunks + i];
        top.p_in__valid.set<bool>(taken < stream_words);
    };
    offer();
    for (int edge = 0; edge < 3; edge++) {  // reset, reset, start
        top.p_reset.set<bool>(edge < 2);
        top.p_start.set<bool>(edge == 2);
        set_clock(false);
        set_clock(true);
    }
    top.p_start.set<bool>(false);
#ifdef PINS
    uint64_t shown = ~UINT64_C(0);
#endif
    for (uint64_t cycle = 0; cycle < (ended ? watched : bound); cycle++) {
        set_clock(false);
        show(cycle);
        sample(cycle, 0);
        cycles[top.p_phase.get<unsigned>()]++;
        if (top.p_event__valid.get<bool>()) {
            uint64_t event[3] = {cycle, top.p_event__kind.get<uint64_t>(), top.p_event__data.get<uint64_t>()};
            fwrite(event, 8, 3, stdout);
        }
#ifdef PINS
        const uint64_t pins = PINS;
        if (pins != shown) {
            const uint64_t change[3] = {cycle, 16, pins};
            fwrite(change, 8, 3, stdout);
            shown = pins;
        }
#endif
        ended |= top.p_done.get<bool>();
        if (top.p_in__ready.get<bool>() && taken < stream_words) taken++;
        set_clock(true);
        sample(cycle, 1);
        offer();
    }
    fwrite(cycles, 8, 16, stdout);
    fwrite(&taken, 8, 1, stdout);
    fwrite(&ended, 8, 1, stdout);
    return 0;
}
