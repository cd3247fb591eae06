#include "tests/laboratory/relief/relief_rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "tests/laboratory/relief/depth_table.h"
#include "tests/laboratory/relief/relief_take.h"
#include "tests/laboratory/relief/sand_on_relief.h"
#include "tests/laboratory/relief/seen_by_depth.h"

namespace sandglass::host {

namespace {

constexpr double k_never = std::numeric_limits<double>::infinity();
constexpr double k_seconds = 10, k_book_seconds = 6;
constexpr double k_step = 0.005;  // metres between samples of the truth
constexpr double k_off = 0.010;   // metres: what hovers or leaks is so far off what is there or beside it

struct Range {
  double low, high;
};

// What is truly within 1.5 cm of a place.
Range about(const Table& table, double x, double z, const TableState& state) {
  Range range = {1e9, -1e9};
  for (int b = -3; b <= 3; ++b)
    for (int a = -3; a <= 3; ++a) {
      const double h = table.height(x + k_step * a, z + k_step * b, state);
      range = {std::min(range.low, h), std::max(range.high, h)};
    }
  return range;
}

Vec3 middle_of(const sandglass_heights& h, uint32_t x, uint32_t z) {
  return from_floats(h.corner) + from_floats(h.along) * ((x + 0.5) / h.cells[0]) +
         from_floats(h.across) * ((z + 0.5) / h.cells[1]);
}

double quantile_of(std::vector<double> values, double share) {
  const auto at = std::min(values.size() - 1, static_cast<size_t>(share * static_cast<double>(values.size())));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
  return values[at];
}

struct Known {
  double interior = 0;                     // mm, 95 of 100 cells
  double hovers = 0, leaks = 0;            // of 100 cells, of 100 cells of things
  double solid = k_never, gone = k_never;  // seconds
  double floats = 0;                       // cells of the box that was taken away
};

// Against the truth as the tracker has moved it.
void measure(const Table& table, const sandglass_heights& h, Vec3 drift, Known* known) {
  std::vector<double> inside;
  uint32_t cells = 0, things = 0, hovers = 0, leaks = 0;
  for (uint32_t z = 2; z + 2 < h.cells[1]; ++z)
    for (uint32_t x = 2; x + 2 < h.cells[0]; ++x) {
      const Vec3 p = middle_of(h, x, z) - drift;
      const double truth = table.height(p.x, p.z, {}), is = h.heights[z * h.cells[0] + x];
      if (truth == k_floor) continue;
      const Range range = about(table, p.x, p.z, {});
      const bool thing = range.high > 0.008;
      ++cells;
      things += thing;
      hovers += is > range.high + k_off;
      leaks += thing && range.low > k_floor && is < range.low - k_off;
      if (range.low > k_floor && range.high - range.low < 0.008) inside.push_back(1000 * std::fabs(is - truth));
    }
  known->interior = quantile_of(inside, 0.95);
  known->hovers = 100.0 * hovers / cells;
  known->leaks = 100.0 * leaks / things;
}

// The cells that lie wholly within the box which comes and goes.
std::vector<uint32_t> cells_of_box(const Table& table, const sandglass_heights& h) {
  std::vector<uint32_t> cells;
  for (uint32_t i = 0; i < h.cells[0] * h.cells[1]; ++i) {
    const Vec3 p = middle_of(h, i % h.cells[0], i / h.cells[0]);
    if (about(table, p.x, p.z, {true}).low > 0.05 && about(table, p.x, p.z, {}).high < 0.01) cells.push_back(i);
  }
  return cells;
}

Known session(const DepthRecording& recording, uint64_t seed, Left left = Left::nothing) {
  cpp::Relief relief;
  if (!relief.create()) return {};
  DepthImages images(recording, {.seed = seed});
  const std::vector<uint32_t> box = cells_of_box(*recording.table, relief.heights());
  Known known;
  while (images.next()) {
    take_image(&relief, images.image(), left);
    const double t = images.seconds() + 1 / k_image_rate;
    const sandglass_heights h = relief.heights();
    double up = 0, down = 0;
    for (const uint32_t i : box) {
      up += std::fabs(h.heights[i] - 0.08f) < 0.02f ? 1.0 / static_cast<double>(box.size()) : 0;
      down += h.heights[i] < 0.015f ? 1.0 / static_cast<double>(box.size()) : 0;
    }
    if (t > k_put && t < k_taken && up >= 0.8) known.solid = std::min(known.solid, t - k_put);
    if (t > k_taken && down >= 0.9) known.gone = std::min(known.gone, t - k_taken);
  }
  const sandglass_heights h = relief.heights();
  for (const uint32_t i : box) known.floats += h.heights[i] > 0.01f;
  measure(*recording.table, h, images.drift(), &known);
  return known;
}

// The median height of a book that fills most of the view, mm.
double book_height(const DepthRecording& recording, double bias, Left left) {
  cpp::Relief relief;
  if (!relief.create()) return 0;
  DepthImages images(recording, {.seed = 3, .bias = bias, .drift = false});
  while (images.next()) take_image(&relief, images.image(), left);
  const sandglass_heights h = relief.heights();
  std::vector<double> inside;
  for (uint32_t i = 0; i < h.cells[0] * h.cells[1]; ++i) {
    const Vec3 p = middle_of(h, i % h.cells[0], i / h.cells[0]);
    if (std::fabs(p.x) < 0.25 && std::fabs(p.z) < 0.19) inside.push_back(1000.0 * static_cast<double>(h.heights[i]));
  }
  return quantile_of(inside, 0.5);
}

struct Rows {
  std::vector<Verdict> rows;

  void add(const std::string& group, const std::string& name, const char* unit, double truth, double result,
           double limit, bool control = false) {
    const bool within = std::fabs(result - truth) <= limit;
    rows.push_back({group, name, unit, truth, result, limit, within != control, control});
  }
  // The mean of all seeds, and the worst, which may be 1.3 times as far off.
  template <class One>
  void add_all(const std::string& group, const std::string& name, const char* unit, const std::vector<One>& all,
               double One::*of, double limit) {
    double mean = 0, worst = 0;
    for (const One& one : all) {
      mean += one.*of / static_cast<double>(all.size());
      worst = std::max(worst, one.*of);
    }
    add(group, name, unit, 0, mean, limit);
    add(group, name + ", worst", unit, 0, worst, 1.3 * limit);
  }
};

constexpr struct {
  DepthKind kind;
  const char* name;
} k_kinds[] = {{DepthKind::raw, "raw"}, {DepthKind::lidar, "lidar"}, {DepthKind::smoothed, "smoothed"}};
constexpr double k_biases[] = {-0.02, 0, 0.02};

void add_books(const std::function<bool()>& go_on, Rows* rows) {
  const Table book = table_with_a_book();
  for (const auto& [kind, name] : k_kinds) {
    if (kind == DepthKind::lidar || !go_on()) continue;  // a lidar has no bias
    const DepthRecording recording = record_depth(kind, book, k_book_seconds);
    for (const double bias : k_biases) {
      const std::string what = std::to_string(static_cast<int>(100 * bias)) + " %, a book";
      rows->add(name, "off by " + what, "mm", 30, book_height(recording, bias, Left::nothing), 2);
    }
    rows->add(name, "control: highest peak, a book", "mm", 30, book_height(recording, 0.02, Left::lowest_peak), 2,
              true);
  }
}

constexpr double k_awake = 5, k_thrown = 1.5;  // % of particles; m/s

// False: it was asked to end.
bool add_sand(const DepthRecording& recording, const char* name, uint32_t seeds, const std::function<bool()>& go_on,
              Rows* rows) {
  constexpr struct {
    Pouring pouring;
    const char* row;
    const char* unit;
    double SandOnRelief::*of;
    double limit;
  } k_rows[] = {{Pouring::everywhere, "sand at rest, awake", "%", &SandOnRelief::awake, k_awake},
                {Pouring::onto_the_box, "sand that floats", "particles", &SandOnRelief::floats, 0},
                {Pouring::where_it_comes, "sand is thrown", "m/s", &SandOnRelief::fastest, k_thrown}};
  for (const auto& row : k_rows) {
    std::vector<SandOnRelief> all;
    for (uint32_t seed = 0; seed < seeds; ++seed) {
      if (!go_on()) return false;
      all.push_back(sand_on_relief(recording, seed + 1, row.pouring));
    }
    rows->add_all(name, row.row, row.unit, all, row.of, row.limit);
  }
  return true;
}

// False: it was asked to end.
bool add_sand_controls(const DepthRecording& recording, const char* name, const std::function<bool()>& go_on,
                       Rows* rows) {
  const auto of = [&](Pouring pouring, Left left, bool dense) {
    return go_on() ? sand_on_relief(recording, 1, pouring, left, dense) : SandOnRelief{};
  };
  rows->add(name, "control: no hysteresis, awake", "%", 0, of(Pouring::everywhere, Left::hysteresis, false).awake,
            k_awake, true);
  rows->add(name, "control: running maximum, floats", "particles", 0,
            of(Pouring::onto_the_box, Left::clearing, false).floats, 0, true);
  rows->add(name, "control: left 25 times as fast, thrown", "m/s", 0,
            of(Pouring::where_it_comes, Left::nothing, true).fastest, k_thrown, true);
  return go_on();
}

// From a scan of the room, that stands so many metres above where it is.
Known from_mesh(const Table& table, double above) {
  const std::vector<float> corners = table.triangles();
  sandglass_cast_mesh mesh = cpp::cast_mesh();
  mesh.positions = corners.data();
  mesh.vertex_count = static_cast<uint32_t>(corners.size() / 3);
  mesh.triangle_count = mesh.vertex_count / 3;
  mesh.world_from_mesh[13] = static_cast<float>(above);
  cpp::Relief relief;
  Known known;
  if (!relief.create() || !relief.set_meshes(&mesh, 1)) return {k_never, k_never, k_never};
  relief.run();
  measure(table, relief.heights(), {}, &known);
  return known;
}

void add_mesh(const Table& table, Rows* rows) {
  constexpr double k_interior = 1, k_above = 0.004;
  const Known known = from_mesh(table, 0);
  rows->add("mesh", "interior, P95", "mm", 0, known.interior, k_interior);
  rows->add("mesh", "hovers", "% of cells", 0, known.hovers, 1.5);
  rows->add("mesh", "leaks", "% of things", 0, known.leaks, 4);
  rows->add("mesh", "control: 4 mm above, interior", "mm", 0, from_mesh(table, k_above).interior, k_interior, true);
}

// False: it was asked to end.
bool add_seen(const DepthRecording& recording, const char* name, uint32_t seeds, const std::function<bool()>& go_on,
              Rows* rows) {
  std::array<std::vector<SeenWrongly>, k_known_by> all;
  for (uint32_t seed = 0; seed < seeds; ++seed) {
    if (!go_on()) return false;
    const auto found = seen_by_depth(recording, seed + 1);
    for (size_t k = 0; k < k_known_by; ++k) all[k].push_back(found[k]);
  }
  constexpr double k_shade = 6, k_seen = 30, k_hidden = 4;  // %
  const auto of = [&](KnownBy by) -> const std::vector<SeenWrongly>& { return all[static_cast<size_t>(by)]; };
  rows->add_all(name, "wrong shade", "%", of(KnownBy::scaled_or_heights), &SeenWrongly::shade, k_shade);
  rows->add_all(name, "hidden points seen", "%", of(KnownBy::scaled_or_heights), &SeenWrongly::seen, k_seen);
  rows->add_all(name, "seen points hidden", "%", of(KnownBy::scaled_or_heights), &SeenWrongly::hidden, k_hidden);
  // A lidar has no factor to speak of; only raw depth has holes.
  const bool raw = recording.kind == DepthKind::raw, lidar = recording.kind == DepthKind::lidar;
  const auto control = [&](const char* row, KnownBy by, double SeenWrongly::*what, double limit, bool fails) {
    rows->add(name, (fails ? "control: " : "") + std::string(row), "%", 0, of(by)[0].*what, fails ? limit : k_never,
              fails);
  };
  control("by the floor, wrong shade", KnownBy::floor, &SeenWrongly::shade, k_shade, true);
  control("without the factor, wrong shade", KnownBy::depth, &SeenWrongly::shade, k_shade, !lidar);
  control("holes are the plane, wrong shade", KnownBy::scaled, &SeenWrongly::shade, k_shade, raw);
  control("heights alone, wrong shade", KnownBy::heights, &SeenWrongly::shade, k_shade, false);
  control("without the factor, hidden points seen", KnownBy::depth, &SeenWrongly::seen, k_seen, raw);
  control("holes are the plane, hidden points seen", KnownBy::scaled, &SeenWrongly::seen, k_seen, raw);
  return true;
}

}  // namespace

uint64_t relief_recordings(uint32_t seeds) { return (2 * 3 + 2 * 3) * seeds + 2 + 3 + 1 + 2; }

std::vector<Verdict> relief_verdicts(uint32_t seeds, const std::function<bool()>& go_on) {
  Rows rows;
  sandglass_relief_desc desc = cpp::relief_desc();
  uint64_t bytes = 0;
  (void)sandglass_relief_bytes(&desc, &bytes, nullptr);
  rows.add("memory", "128 x 128 cells", "bytes", 0, static_cast<double>(bytes), 1 << 20);
  const Table table = usual_table();
  add_mesh(table, &rows);
  for (const auto& [kind, name] : k_kinds) {
    const DepthRecording recording = record_depth(kind, table, k_seconds);
    if (!add_seen(recording, name, seeds, go_on, &rows)) return rows.rows;
    std::vector<Known> all;
    for (uint32_t seed = 0; seed < seeds; ++seed) {
      if (!go_on()) return rows.rows;
      all.push_back(session(recording, seed + 1));
    }
    if (kind != DepthKind::smoothed) {
      if (!add_sand(recording, name, seeds, go_on, &rows)) return rows.rows;
      if (kind == DepthKind::raw && !add_sand_controls(recording, name, go_on, &rows)) return rows.rows;
    }
    rows.add_all(name, "interior, P95", "mm", all, &Known::interior, 3);
    rows.add_all(name, "hovers", "% of cells", all, &Known::hovers, 1.5);
    rows.add_all(name, "leaks", "% of things", all, &Known::leaks, 4);
    rows.add_all(name, "floats of what was taken away", "cells", all, &Known::floats, 0);
    rows.add_all(name, "a box is gone", "s", all, &Known::gone, 1.5);
    if (kind != DepthKind::smoothed) rows.add_all(name, "a box is solid", "s", all, &Known::solid, 2);
    if (kind != DepthKind::raw) continue;
    for (int i = 0; i < 2; ++i)
      if (!go_on()) return rows.rows;
    const Known unlocked = session(recording, 1, Left::lock), largest = session(recording, 1, Left::clearing);
    rows.add(name, "control: no lock, leaks", "% of things", 0, unlocked.leaks, 4, true);
    rows.add(name, "control: no lock, interior", "mm", 0, unlocked.interior, 3, true);
    rows.add(name, "control: running maximum, gone", "s", 0, largest.gone, 1.5, true);
    rows.add(name, "control: running maximum, hovers", "% of cells", 0, largest.hovers, 1.5, true);
  }
  add_books(go_on, &rows);
  return rows.rows;
}

}  // namespace sandglass::host
