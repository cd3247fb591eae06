#include "tests/laboratory/relief/seen_by_depth.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "models/mesh/generated.h"
#include "tests/laboratory/shadow/app_cast.h"
#include "tests/relief/relief_on.h"

namespace sandglass::host {

namespace {

constexpr double k_from = 3;                 // seconds: the relief knows the table
constexpr int k_each_image = 5, k_each = 3;  // of so many images, and pixels of rows and columns, one
constexpr double k_degree = std::numbers::pi / 180, k_polar = 40 * k_degree, k_half = 10 * k_degree;  // of the light
constexpr double k_height = 0.15;                 // metres, of the layers
constexpr double k_wrong = 0.1;                   // of the light
constexpr int k_points = 24;                      // along each side of the table
constexpr double k_above = 0.006, k_bias = 0.02;  // metres: of a point above what is real; by which depth may be wrong
constexpr int k_steps = 24;                       // along a ray to the heights, as in the kit

const Vec3 k_light = {std::sin(k_polar), std::cos(k_polar), 0};
const Thing k_board = box_thing({0.1, 0.30, 0}, {0.2, 0.01, 0.125});

bool meets_board(Vec3 from, Vec3 direction) {
  const Vec3 p = from - k_board.low_middle - Vec3{0, k_board.half.y, 0}, h = k_board.half;
  const double ps[3] = {p.x, p.y, p.z}, ds[3] = {direction.x, direction.y, direction.z}, hs[3] = {h.x, h.y, h.z};
  double in = 0, out = 1e9;
  for (int k = 0; k < 3; ++k) {
    const double a = (-hs[k] - ps[k]) / ds[k], b = (hs[k] - ps[k]) / ds[k];
    in = std::max(in, std::min(a, b));
    out = std::min(out, std::max(a, b));
  }
  return in <= out;
}

// The share of the light that the board hides of a place, by rays.
double hidden_by_board(Vec3 place) {
  constexpr int k_rings = 8, k_spokes = 8;
  const Vec3 across = {k_light.y, -k_light.x, 0}, side = {0, 0, 1};
  double hidden = 0;
  for (int i = 0; i < k_rings * k_spokes; ++i) {
    const double cosine = 1 - (i / k_spokes + 0.5) / k_rings * (1 - std::cos(k_half)),
                 turn = 2 * std::numbers::pi * (i % k_spokes + 0.5 * (i / k_spokes % 2) + 0.1) / k_spokes;
    const Vec3 d =
        k_light * cosine + (across * std::cos(turn) + side * std::sin(turn)) * std::sqrt(1 - cosine * cosine);
    hidden += meets_board(place, d) ? 1.0 / (k_rings * k_spokes) : 0;
  }
  return hidden;
}

cpp::Cast cast_of_board() {
  const float size[3] = {static_cast<float>(2 * k_board.half.x), static_cast<float>(2 * k_board.half.y),
                         static_cast<float>(2 * k_board.half.z)};
  const Mesh mesh = make_box(size);
  sandglass_cast_mesh one = cast_mesh_of(mesh, true, false);
  to_floats(k_board.low_middle + Vec3{0, k_board.half.y, 0}, one.world_from_mesh + 12);
  sandglass_cast_desc desc = cpp::cast_desc();
  desc.layers = 4;
  sandglass_cast_plane plane = cpp::cast_plane();
  plane.height = static_cast<float>(k_height);
  std::array<float, 3> light;
  to_floats(k_light, light.data());
  cpp::Cast cast;
  for (const cpp::Status& status : {cast.create(desc), cast.set_plane(plane), cast.set_meshes(&one, 1),
                                    cast.set_light(light, static_cast<float>(2 * k_half))})
    if (!status) throw std::runtime_error(status.reason);
  cast.run();
  return cast;
}

// sandglass_by_heights of the kit, of a map about the origin.
double by_heights(const cpp::Relief& relief, double highest, Vec3 eye, Vec3 ray) {
  const double last = -eye.y / ray.y, first = std::clamp((highest - eye.y) / ray.y, 0.0, last);
  const double half = 0.5 * relief.heights().cells[0] * static_cast<double>(relief.heights().cell);
  double before = 0;
  for (int i = 0; i <= k_steps; ++i) {
    const double along = first + (last - first) * i / k_steps;
    const Vec3 p = eye + ray * along;
    const bool on = std::max(std::fabs(p.x), std::fabs(p.z)) < half;
    const double over = p.y - (on ? tests::height_at(relief, p.x, p.z) : 0);
    if (over < 0) return along - (last - first) / k_steps * std::clamp(over / std::min(over - before, -1e-6), 0.0, 1.0);
    before = over;
  }
  return last;
}

// Over the plane, which the tracker finds anew: of its drift, what is along the plane stays.
struct View {
  const sandglass_depth_image& image;
  Vec3 eye;
  Quaternion orientation;
  View(const sandglass_depth_image& i, double plane)
      : image(i),
        eye(from_floats(i.position) - Vec3{0, plane, 0}),
        orientation{i.orientation[0], i.orientation[1], i.orientation[2], i.orientation[3]} {}
  // A metre long along the camera's axis.
  Vec3 ray(double x, double y) const {
    return rotate(orientation, {(x - static_cast<double>(image.centre_x)) / static_cast<double>(image.focal_x),
                                (static_cast<double>(image.centre_y) - y) / static_cast<double>(image.focal_y), -1});
  }
  Vec3 seen_from(Vec3 place) const { return rotate(conjugate(orientation), place - eye); }
  // 0: unknown.
  double depth(size_t pixel) const {
    if (image.confidence[pixel] < image.confidence_min) return 0;
    return static_cast<const uint16_t*>(image.depth)[pixel] * static_cast<double>(image.to_metres);
  }
};

// Metres along a ray by all that may be known. 0: nothing is.
std::array<double, k_known_by> metres_by(const cpp::Relief& relief, double highest, const View& view, size_t pixel,
                                         Vec3 ray) {
  const double depth = view.depth(pixel), scaled = depth * static_cast<double>(relief.heights().depth_scale);
  const double heights = by_heights(relief, highest, view.eye, ray);
  return {0, depth, scaled, depth > 0 ? scaled : heights, heights};
}

struct Sums {
  std::array<uint64_t, k_known_by> shade{}, seen{}, hidden{};
  uint64_t shaded = 0, behind = 0, before = 0;
};

// Where the real depth is known along the rays of pixels.
void add_shade(const DepthRecording& recording, const std::vector<float>& exact, const View& view,
               const cpp::Relief& relief, double highest, const sandglass_texture& shadow, Sums* sums) {
  const auto drawn = [&](Vec3 p) { return std::clamp(2 - std::fabs(p.y) / k_height, 0.0, 1.0) * slid(shadow, p, 0); };
  for (uint32_t y = 0; y < recording.height; y += k_each)
    for (uint32_t x = 0; x < recording.width; x += k_each) {
      const size_t pixel = size_t{y} * recording.width + x;
      const Vec3 ray = view.ray(x, y);
      if (exact[pixel] <= 0 || ray.y > -0.05) continue;
      const double floor = -view.eye.y / ray.y;
      const double truth = hidden_by_board(view.eye + ray * static_cast<double>(exact[pixel]));
      if (std::max(truth, drawn(view.eye + ray * floor)) < k_wrong) continue;
      ++sums->shaded;
      const std::array<double, k_known_by> metres = metres_by(relief, highest, view, pixel, ray);
      for (size_t i = 0; i < k_known_by; ++i)
        sums->shade[i] += std::fabs(drawn(view.eye + ray * (metres[i] > 0 ? metres[i] : floor)) - truth) > k_wrong;
    }
}

void add_points(const DepthRecording& recording, const TableState& state, Vec3 drift, const View& view,
                const cpp::Relief& relief, double highest, Sums* sums) {
  for (int i = 0; i < k_points * k_points; ++i) {
    const double x = k_table[0] * (2 * (i % k_points + 0.5) / k_points - 1),
                 z = k_table[1] * (2 * (i / k_points + 0.5) / k_points - 1);
    const Vec3 point = Vec3{x, recording.table->height(x, z, state) + k_above, z} + drift;
    const Vec3 seen = view.seen_from(point);
    const double column = static_cast<double>(view.image.centre_x) -
                          seen.x / seen.z * static_cast<double>(view.image.focal_x),
                 row = static_cast<double>(view.image.centre_y) +
                       seen.y / seen.z * static_cast<double>(view.image.focal_y);
    if (column < 1 || row < 1 || column > recording.width - 2.0 || row > recording.height - 2.0) continue;
    const Vec3 ray = view.ray(column, row);
    const bool is_hidden = recording.table->depth(view.eye - drift, ray, state) < -seen.z - 0.5 * k_above;
    (is_hidden ? sums->behind : sums->before) += 1;
    const size_t pixel = static_cast<size_t>(row + 0.5) * recording.width + static_cast<size_t>(column + 0.5);
    const std::array<double, k_known_by> metres = metres_by(relief, highest, view, pixel, ray);
    for (size_t k = 0; k < k_known_by; ++k) {
      const bool hides = metres[k] > 0 && metres[k] < -seen.z - k_bias;
      sums->seen[k] += is_hidden && !hides;
      sums->hidden[k] += !is_hidden && hides;
    }
  }
}

}  // namespace

std::array<SeenWrongly, k_known_by> seen_by_depth(const DepthRecording& recording, uint64_t seed) {
  cpp::Relief relief;
  if (!relief.create()) return {};
  const cpp::Cast cast = cast_of_board();
  const sandglass_texture shadow = cast.texture();
  DepthImages images(recording, {.seed = seed});
  Sums sums;
  for (size_t i = 0; images.next(); ++i) {
    const Vec3 drift = images.drift();
    const float plane[3] = {0, static_cast<float>(drift.y), 0};
    (void)relief.set_plane(plane, {0, 0, 0, 1});
    (void)relief.set_image(images.image());
    if (images.seconds() < k_from || i % k_each_image != 0) continue;
    const View view(images.image(), drift.y);
    const sandglass_heights h = relief.heights();
    const double highest = std::max(0.0f, *std::max_element(h.heights, h.heights + size_t{h.cells[0]} * h.cells[1]));
    add_shade(recording, recording.depths[i], view, relief, highest, shadow, &sums);
    add_points(recording, usual_state(images.seconds()), {drift.x, 0, drift.z}, view, relief, highest, &sums);
  }
  std::array<SeenWrongly, k_known_by> found;
  const auto share = [](uint64_t of, uint64_t all) {
    return 100.0 * static_cast<double>(of) / static_cast<double>(all);
  };
  for (size_t k = 0; k < k_known_by; ++k)
    found[k] = {share(sums.shade[k], sums.shaded), share(sums.seen[k], sums.behind),
                share(sums.hidden[k], sums.before)};
  return found;
}

}  // namespace sandglass::host
