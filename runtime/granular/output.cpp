#include "runtime/granular/output.h"

#include "runtime/granular/granular.h"

namespace sandglass {

namespace {

uint32_t output_count(const Granular& g) {
  if (g.output.input == nullptr || g.output.input->grains == nullptr) return 0;
  const uint32_t all = g.grains.count + g.flow.free_grain_count;
  return all < g.output.input->grain_capacity ? all : g.output.input->grain_capacity;
}

bool next(const void* state, uint32_t level, WorkUnit* unit) {
  const Granular& g = *static_cast<const Granular*>(state);
  (void)level;
  const uint32_t all = g.grains.count + g.flow.free_grain_count;
  if (output_count(g) == 0 || g.output.cursor >= all) return false;
  const uint32_t left = all - g.output.cursor;
  unit->kind = k_unit_output;
  unit->name = "output.grains";
  unit->items = left < g.unit ? left : g.unit;
  return true;
}

// Half a grain's record: a position and a number, or a velocity. Four lanes, which the compiler makes one register.
typedef float Quad __attribute__((vector_size(16), may_alias));

// The grains, then the numbers that stand for none.
struct OutputTask {
  const Grain* grains;
  const uint32_t* removed;
  uint32_t grain_count;
  uint8_t* out;
  uint64_t stride;
  uint32_t capacity;
  float lag;
  void run(uint32_t piece, uint32_t begin, uint32_t end) {
    (void)piece;
    const OutputTask t = *this;  // what is written may not be this
    const uint32_t last = end < t.grain_count ? end : t.grain_count;
    uint32_t i = begin;
    for (; i < last; ++i) {
      const uint32_t number = t.grains[i].number;
      if (number >= t.capacity) continue;
      const Quad* record = reinterpret_cast<const Quad*>(&t.grains[i]);
      const Quad v = record[1], squares = v * v;
      Quad grain = record[0] - t.lag * v;
      grain[3] = __builtin_sqrtf(squares[0] + squares[1] + squares[2]);
      __builtin_memcpy(t.out + number * t.stride, &grain, sizeof grain);
    }
    for (; i < end; ++i) {
      const sandglass_grain grain = {{0.0f, SANDGLASS_REMOVED_Y, 0.0f}, -1.0f};
      const uint32_t number = t.removed[i - t.grain_count];
      if (number < t.capacity) __builtin_memcpy(t.out + number * t.stride, &grain, sizeof grain);
    }
  }
};
static_assert(offsetof(sandglass_grain, speed) == 12 && sizeof(sandglass_grain) == sizeof(Quad));

void run_output(void* state, uint32_t level) {
  (void)level;
  Granular* g = static_cast<Granular*>(state);
  const uint32_t all = g->grains.count + g->flow.free_grain_count;
  const float lag = g->output.input->output_lag > 0.0f
                        ? (g->output.input->output_lag < 0.1f ? g->output.input->output_lag : 0.1f)
                        : 0.0f;
  OutputTask task = {g->grains.records,
                     g->flow.free_grains,
                     g->grains.count,
                     static_cast<uint8_t*>(g->output.input->grains),
                     g->output.input->grain_stride,
                     output_count(*g),
                     lag};
  const uint32_t end = all - g->output.cursor < g->unit ? all : g->output.cursor + g->unit;
  granular_split(*g, g->output.cursor, end, &task);
  g->output.cursor = end;
}

uint32_t forecast(const void* state, uint32_t level, Forecast* entries) {
  const Granular& g = *static_cast<const Granular*>(state);
  (void)level;
  if (output_count(g) == 0) return 0;
  entries[0] = {k_unit_output, uint64_t{g.grains.count} + g.flow.free_grain_count};
  return 1;
}

}  // namespace

void output_begin_frame(Output* output, const sandglass_frame_input* input) {
  output->input = input;
  output->cursor = 0;
}

void output_restart(Output* output) { output->cursor = 0; }

Stage granular_output_stage(Granular* granular) {
  return {granular, next, run_output, forecast, k_granular_kinds, k_all_units, 1.0f};
}

}  // namespace sandglass
