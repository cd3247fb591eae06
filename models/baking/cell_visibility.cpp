// A packet holds sixteen rays from one point into the 4 x 4 strata of one cell. They visit the same nodes. Four points
// a texel give 64 rays a cell; on the armadillo a value has then a noise of 0.02, and far less after the components of
// all texels were found together. Directions come from prepared sets; a texel picks its set by a hash of its number, so
// results depend on neither thread nor order.
#include "models/baking/cell_visibility.h"

#include <algorithm>

#include "models/baking/light_cells.h"
#include "models/work/random.h"

namespace sandglass::host {
namespace {

constexpr uint32_t k_packet = EmbreeScene::k_packet;
static_assert(k_packet == k_cell_strata);  // a packet has a ray to each stratum of a cell
constexpr uint32_t k_points = 2;           // along each axis of a texel
constexpr uint32_t k_sets = 64;            // of directions
constexpr uint32_t k_rows = 8;             // between two calls of go_on
constexpr uint64_t k_direction_stream = 0xCE11, k_point_stream = 0xF1008;

// k_sets x SANDGLASS_LIGHT_CELLS x k_packet directions, one array an axis.
struct Directions {
  std::vector<float> x, y, z;
  explicit Directions(uint64_t seed) {
    uint64_t random = random_mix(seed ^ k_direction_stream);
    for (uint32_t set = 0; set < k_sets; ++set)
      for (uint32_t cell = 0; cell < SANDGLASS_LIGHT_CELLS; ++cell)
        for (uint32_t i = 0; i < k_packet; ++i) {
          random = random_mix(random);
          const double a = (i % k_strata_side + random_unit(random)) / k_strata_side;
          random = random_mix(random);
          const double b = (i / k_strata_side + random_unit(random)) / k_strata_side;
          const Vec3 d = cell_direction(cell, a, b);
          x.push_back(static_cast<float>(d.x));
          y.push_back(static_cast<float>(d.y));
          z.push_back(static_cast<float>(d.z));
        }
  }
};

struct Tracer {
  const EmbreeScene& object;
  const FloorSquare& square;
  const Directions& directions;
  uint32_t parts;  // of a cell: 1 or all strata
  uint64_t seed;

  void texel(uint32_t u, uint32_t v, float* hidden) const {
    std::fill_n(hidden, SANDGLASS_LIGHT_CELLS * parts, 0.0f);
    const double step = 2 * square.half / square.side;
    const float share = static_cast<float>(parts) / (k_packet * k_points * k_points);  // of one ray; sums are exact
    uint64_t random = random_mix(seed ^ k_point_stream) + uint64_t{v} * square.side + u;
    for (uint32_t point = 0; point < k_points * k_points; ++point) {
      random = random_mix(random);
      const size_t set = (random >> 40) % k_sets * SANDGLASS_LIGHT_CELLS * k_packet;
      const double a = (point % k_points + random_unit(random)) / k_points;
      random = random_mix(random);
      const double b = (point / k_points + random_unit(random)) / k_points;
      const double x = step * (u + a) - square.half, z = step * (v + b) - square.half;
      for (uint32_t cell = 0; cell < SANDGLASS_LIGHT_CELLS; ++cell) {
        const size_t from = set + size_t{cell} * k_packet;
        const uint32_t dark = object.hidden(x, z, &directions.x[from], &directions.y[from], &directions.z[from]);
        for (uint32_t i = 0; i < k_packet; ++i)
          if ((dark >> i & 1) != 0) hidden[cell * parts + i % parts] += share;
      }
    }
  }
};

}  // namespace

std::vector<float> trace_hidden(const EmbreeScene& object, const FloorSquare& square, HiddenOf parts, uint64_t seed,
                                ThreadPool& pool, const std::function<bool(uint32_t)>& go_on) {
  const Directions directions(seed);
  const Tracer tracer = {object, square, directions, parts == HiddenOf::strata ? k_cell_strata : 1, seed};
  const size_t texel = size_t{SANDGLASS_LIGHT_CELLS} * tracer.parts, row = square.side * texel;
  std::vector<float> hidden(row * square.side);
  for (uint32_t begin = 0; begin < square.side; begin += k_rows) {
    const uint32_t end = std::min(square.side, begin + k_rows);
    pool.run(end - begin, [&](uint32_t i) {
      const uint32_t v = begin + i;
      for (uint32_t u = 0; u < square.side; ++u) tracer.texel(u, v, &hidden[v * row + u * texel]);
    });
    if (!go_on(end) && end < square.side) return {};
  }
  return hidden;
}

}  // namespace sandglass::host
