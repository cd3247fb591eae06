#include "tests/laboratory/shadow/receiver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "models/compositing/shot_camera.h"
#include "models/files/failure.h"
#include "models/mesh/generated.h"
#include "models/rooms/probe_light.h"
#include "models/tracing/directions.h"
#include "models/tracing/embree_scene.h"
#include "models/work/random.h"
#include "sandglass/sandglass.hpp"
#include "tests/laboratory/room/known_room.h"
#include "tests/laboratory/shadow/app_cast.h"
#include "tests/laboratory/shadow/cast_world.h"

namespace sandglass::host {

namespace {

// Metres. The table is y = 0, the wall z = k_wall.
constexpr double k_wall = -0.3, k_lift = 1e-4, k_far = 100;
constexpr Vec3 k_chair_at = {0.0, 0, -0.1}, k_bucket_at = {0.135, 0, 0.03};
constexpr double k_chair_height = 0.3, k_bucket_height = 0.13;
constexpr Camera k_camera = {{0.42, 0.45, 0.95}, {0.04, 0.1, -0.1}, 30};
// A phone's depth image: its size, and how wrong it is, metres.
constexpr int k_depth_width = 160, k_depth_height = 120;
constexpr double k_depth_noise = 0.004, k_depth_offset = -0.003, k_bias = 0.02;
constexpr int k_rays = 256;      // a pixel, of each of two sets
constexpr double k_shown = 0.3;  // the mean of the camera's image

enum class Surface { table, wall, bucket };

struct Pixel {
  Surface surface;               // real
  Vec3 point;                    // of it
  double depth;                  // along the camera's axis
  Vec3 image;                    // what the camera shows
  double left[2];                // what the chair leaves of its light, by two sets of rays
  bool chair;                    // it stands before what is real
  std::optional<Vec3> on_chair;  // or behind it
  Vec3 chair_colour;
};

// Only what comes from above the table and before the wall.
RadianceMap before_wall(const RadianceMap& room) {
  RadianceMap seen(room.width, room.height);
  for (int v = 0; v < room.height; ++v)
    for (int u = 0; u < room.width; ++u) {
      const Vec3 d = panorama_direction(u, v, room.width, room.height);
      if (d.y > 0 && d.z > 0) seen.set(u, v, room.colour(u, v));
    }
  return seen;
}

Vec3 albedo_of(Surface surface, Vec3 p) {
  if (surface == Surface::bucket) return {0.16, 0.30, 0.42};
  if (surface == Surface::wall) return Vec3{0.62, 0.60, 0.55} * (1 + 0.03 * std::sin(90 * p.x) * std::sin(130 * p.y));
  const double grain = 0.6 * std::sin(80 * p.z + 3 * std::sin(9 * p.x)) + 0.4 * std::sin(31 * p.z + std::sin(5 * p.x));
  return Vec3{0.50, 0.36, 0.24} * (1 + 0.10 * grain);
}

// A picture of the scene, by rays: what is real, with and without the chair.
class Traced {
 public:
  Traced(const RadianceMap& light, int width, int height, ThreadPool& pool)
      : width_(width),
        height_(height),
        camera_(resting_camera(k_camera)),
        chair_mesh_(standing("chair", k_chair_height, k_chair_at)),
        bucket_mesh_(standing("bucket", k_bucket_height, k_bucket_at)),
        chair_(EmbreeScene::triangles(chair_mesh_.vertices, chair_mesh_.indices)),
        bucket_(EmbreeScene::triangles(bucket_mesh_.vertices, bucket_mesh_.indices)),
        light_(light, ViewRotation({std::numbers::pi / 2, std::numbers::pi / 2})),
        pixels_(static_cast<size_t>(width) * static_cast<size_t>(height)) {
    pool.run(static_cast<uint32_t>(height), [&](uint32_t y) {
      for (int x = 0; x < width; ++x) trace(x, static_cast<int>(y));
    });
    double sum = 0;
    for (const Pixel& p : pixels_) sum += luminance(p.image);
    const double exposure = k_shown * static_cast<double>(pixels_.size()) / sum;
    for (Pixel& p : pixels_) {
      p.image = limited(p.image * exposure);
      p.chair_colour = limited(p.chair_colour * exposure);
    }
  }

  int width() const { return width_; }
  int height() const { return height_; }
  const ShotCamera& camera() const { return camera_; }
  const Mesh& chair() const { return chair_mesh_; }
  const Mesh& bucket() const { return bucket_mesh_; }
  const std::vector<Pixel>& pixels() const { return pixels_; }
  Vec3 ray(double x, double y) const { return normalised(camera_.ray(x, y, width_, height_)); }
  double depth_of(Vec3 point) const { return dot(point - camera_.eye, camera_.forward); }

  Vec3 truth(const Pixel& p, int set) const { return p.chair ? p.chair_colour : p.image * p.left[set]; }

  bool beside_bucket(int x, int y) const {
    constexpr int k_beside = 6;  // pixels: three of the depth image
    for (int b = std::max(0, y - k_beside); b <= std::min(height_ - 1, y + k_beside); ++b)
      for (int a = std::max(0, x - k_beside); a <= std::min(width_ - 1, x + k_beside); ++a)
        if (pixels_[static_cast<size_t>(b * width_ + a)].surface == Surface::bucket) return true;
    return false;
  }

  // The mean of something of the depth of what is real: of the four texels of a phone's image about a place, by how near
  // they are, or as it is.
  template <class Of>
  double over_depth(double x, double y, bool exact, const Of& of) const {
    if (exact) return of(pixels_[static_cast<size_t>(static_cast<int>(y) * width_ + static_cast<int>(x))].depth);
    const double u = x / width_ * k_depth_width - 0.5, v = y / height_ * k_depth_height - 0.5;
    double sum = 0;
    for (int i = 0; i < 4; ++i) {
      const double a = std::floor(u) + i % 2, b = std::floor(v) + i / 2;
      const int column = std::clamp(static_cast<int>(a), 0, k_depth_width - 1);
      const int row = std::clamp(static_cast<int>(b), 0, k_depth_height - 1);
      const int px = (2 * column + 1) * width_ / (2 * k_depth_width);
      const int py = (2 * row + 1) * height_ / (2 * k_depth_height);
      Random random = random_stream(static_cast<uint64_t>(row * k_depth_width + column), 91);
      const double depth = pixels_[static_cast<size_t>(py * width_ + px)].depth + k_depth_offset +
                           k_depth_noise * normal_deviate(&random);
      sum += (1 - std::fabs(u - a)) * (1 - std::fabs(v - b)) * of(depth);
    }
    return sum;
  }

 private:
  void trace(int x, int y) {
    Pixel& p = pixels_[static_cast<size_t>(y * width_ + x)];
    Random random = random_stream(static_cast<uint64_t>(y * width_ + x), 92);
    const Vec3 eye = camera_.eye, d = ray(x + 0.5, y + 0.5);
    Vec3 normal = {0, 0, 1};
    double distance = d.z < 0 ? (k_wall - eye.z) / d.z : k_far;
    p.surface = Surface::wall;
    if (d.y < 0 && -eye.y / d.y < distance) {
      distance = -eye.y / d.y;
      normal = {0, 1, 0};
      p.surface = Surface::table;
    }
    if (const EmbreeHit hit = bucket_.closest(eye, d, distance); hit.found) {
      distance = static_cast<double>(hit.distance);
      normal = hit.unit_normal();
      p.surface = Surface::bucket;
      if (dot(normal, d) > 0) normal = normal * -1.0;
    }
    p.point = eye + d * distance;
    p.depth = depth_of(p.point);
    const double shift[4] = {random.uniform(), random.uniform(), random.uniform(), random.uniform()};
    Vec3 sum;
    for (int set = 0; set < 2; ++set) {
      Vec3 with, without;
      light(p.point, normal, shift + 2 * set, &with, &without);
      p.left[set] = luminance(without) > 0 ? luminance(with) / luminance(without) : 1;
      sum = sum + without * 0.5;
    }
    p.image = product(albedo_of(p.surface, p.point), sum) * (1 / std::numbers::pi);
    if (const EmbreeHit hit = chair_.closest(eye, d, k_far); hit.found) {
      p.on_chair = eye + d * static_cast<double>(hit.distance);
      p.chair = static_cast<double>(hit.distance) < distance;
      Vec3 n = hit.unit_normal(), with, without;
      if (dot(n, d) > 0) n = n * -1.0;
      light(*p.on_chair, n, shift, &with, &without);
      p.chair_colour = product({0.60, 0.44, 0.30}, with) * (1 / std::numbers::pi);
    }
  }

  // The irradiance there, with the chair and without.
  void light(Vec3 point, Vec3 normal, const double shift[2], Vec3* with, Vec3* without) const {
    const Vec3 start = point + normal * k_lift;
    for (int i = 0; i < k_rays; ++i) {
      const auto s =
          light_.sample(lattice_point(shift[0], i, k_plane_steps[0]), lattice_point(shift[1], i, k_plane_steps[1]));
      const double cosine = dot(s.direction, normal);
      if (cosine <= 0 || bucket_.occluded(start, s.direction, k_far)) continue;
      const Vec3 brought = s.weight * (cosine / k_rays);
      *without = *without + brought;
      if (!chair_.occluded(start, s.direction, k_far)) *with = *with + brought;
    }
  }

  int width_, height_;
  ShotCamera camera_;
  Mesh chair_mesh_, bucket_mesh_;
  EmbreeScene chair_, bucket_;
  ProbeLight light_;
  std::vector<Pixel> pixels_;
};

// ---- as an app draws it

// A plane with the chair's shadows on it, in the light that the library's room knows of it.
class Receiver {
 public:
  Receiver(const cpp::Room& room, Vec3 origin, Vec3 normal, const Traced& traced) : normal_(normal), origin_(origin) {
    float n[3], o[3];
    to_floats(normal, n);
    to_floats(origin, o);
    const float along[3] = {1, 0, 0};
    const sandglass_room_light light = light_on(room, n, along);
    share_ = static_cast<double>(light.main_share);
    sandglass_cast_desc desc = cpp::cast_desc();
    desc.triangle_capacity = 2 * traced.chair().triangle_count() + 2 * traced.bucket().triangle_count();
    if (const cpp::Status made = cast_.create(desc); !made) throw Failure(made.reason);
    sandglass_cast_plane plane = cpp::cast_plane();
    std::copy(o, o + 3, plane.origin);
    std::copy(n, n + 3, plane.normal);
    plane.low[0] = -1;  // from the edge between table and wall
    plane.high[0] = 1;
    plane.low[1] = normal.y > 0 ? 0.0f : -1.0f;
    plane.high[1] = normal.y > 0 ? 2.0f : 0.0f;
    sandglass_cast_mesh meshes[2] = {cpp::cast_mesh(), cpp::cast_mesh()};
    for (int i = 0; i < 2; ++i) {
      const Mesh& mesh = i == 0 ? traced.chair() : traced.bucket();
      meshes[i].positions = mesh.vertices.data();
      meshes[i].vertex_count = mesh.vertex_count();
      meshes[i].indices = mesh.indices.data();
      meshes[i].triangle_count = mesh.triangle_count();
      meshes[i].closed = 1;
      meshes[i].is_real = i == 0 ? 0 : 1;
    }
    std::array<float, 3> towards;
    std::copy(light.main_direction, light.main_direction + 3, towards.begin());
    std::array<float, SANDGLASS_LIGHT_CELLS> cells;
    std::copy(light.ambient_cells, light.ambient_cells + SANDGLASS_LIGHT_CELLS, cells.begin());
    for (const cpp::Status& done :
         {cast_.set_plane(plane), cast_.set_meshes(meshes, 2), cast_.set_light(towards, 0.0f), cast_.set_cells(cells)})
      if (!done) throw Failure(done.reason);
    cast_.run();
  }

  double height(Vec3 p) const { return dot(normal_, p - origin_); }
  // By the formula for one object.
  double left(Vec3 p) const {
    return std::max(0.0, sampled(cast_.ambient(), p, 1) - share_ * sampled(cast_.texture(), p, 0));
  }

 private:
  cpp::Cast cast_;
  Vec3 normal_, origin_;
  double share_ = 0;
};

struct Mode {
  const char* name;
  bool table = true, wall = true, depth = true, exact = false;
  double bias = k_bias;
  bool mean_depth = false;  // as one linear sample has it
};

class Drawn {
 public:
  Drawn(const RadianceMap& light, const Traced& traced) : traced_(traced) {
    cpp::Room room;
    know_room(light, &room);
    planes_.emplace_back(room, Vec3{0, 0, k_wall}, Vec3{0, 1, 0}, traced);
    planes_.emplace_back(room, Vec3{0, 0, k_wall}, Vec3{0, 0, 1}, traced);
  }

  // How much something real hides of what is drawn at a point.
  double hidden(int x, int y, Vec3 point, const Mode& mode) const {
    if (!mode.depth) return 0;
    const double drawn = traced_.depth_of(point);
    const auto by = [&](double real) {
      const double share = real / drawn;
      double before = (1 - share) * drawn;
      for (const Receiver& plane : planes_) {
        const double eye = plane.height(traced_.camera().eye);
        before = std::min(before, eye + (plane.height(point) - eye) * share);
      }
      const double t = std::clamp(before / mode.bias - 1, 0.0, 1.0);
      return t * t * (3 - 2 * t);
    };
    if (mode.mean_depth) return by(traced_.over_depth(x + 0.5, y + 0.5, mode.exact, [](double real) { return real; }));
    return traced_.over_depth(x + 0.5, y + 0.5, mode.exact, by);
  }

  Vec3 colour(int x, int y, const Mode& mode) const {
    const Pixel& p = traced_.pixels()[static_cast<size_t>(y * traced_.width() + x)];
    // Where the ray meets the plane that is nearer.
    const Vec3 eye = traced_.camera().eye, d = traced_.ray(x + 0.5, y + 0.5);
    const double to_wall = (k_wall - eye.z) / d.z, to_table = d.y < 0 ? -eye.y / d.y : k_far;
    const bool on_table = to_table < to_wall;
    const Vec3 place = eye + d * std::min(to_table, to_wall);
    double left = 1;
    if (on_table ? mode.table : mode.wall) {
      left = planes_[on_table ? 0 : 1].left(place);
      left += (1 - left) * hidden(x, y, place, mode);
    }
    const Vec3 floor = p.image * left;
    if (!p.on_chair) return floor;
    const double away = hidden(x, y, *p.on_chair, mode);
    return p.chair_colour * (1 - away) + floor * away;
  }

 private:
  const Traced& traced_;
  std::vector<Receiver> planes_;
};

// The product of what is off by two sets of rays, whose noise cancels; of encoded channels.
double off(Vec3 drawn, Vec3 a, Vec3 b) {
  double sum = 0;
  for (const auto channel : {&Vec3::x, &Vec3::y, &Vec3::z})
    sum += (srgb_of(drawn.*channel) - srgb_of(a.*channel)) * (srgb_of(drawn.*channel) - srgb_of(b.*channel)) / 3;
  return sum;
}

// Of the picture; and the shares that are hidden, away from the bucket, of the chair's feet and of its shadow.
struct Errors {
  double picture = 0, feet = 0, shadow = 0;
};

Errors errors_of(const Traced& traced, const Drawn& drawn, const Mode& mode) {
  constexpr double k_foot = 0.02, k_dark = 0.9;  // metres; of the light
  Errors e;
  size_t feet = 0, dark = 0;
  for (int y = 0; y < traced.height(); ++y)
    for (int x = 0; x < traced.width(); ++x) {
      const Pixel& p = traced.pixels()[static_cast<size_t>(y * traced.width() + x)];
      e.picture += off(drawn.colour(x, y, mode), traced.truth(p, 0), traced.truth(p, 1));
      const bool foot = p.chair && p.on_chair->y < k_foot, in_shadow = !p.chair && p.left[0] < k_dark;
      if ((!foot && !in_shadow) || traced.beside_bucket(x, y)) continue;
      const double hidden = drawn.hidden(x, y, foot ? *p.on_chair : p.point, mode);
      if (foot) {
        e.feet += hidden;
        ++feet;
      } else {
        e.shadow += hidden;
        ++dark;
      }
    }
  return {std::sqrt(std::max(0.0, e.picture) / static_cast<double>(traced.pixels().size())),
          e.feet / static_cast<double>(std::max<size_t>(feet, 1)),
          e.shadow / static_cast<double>(std::max<size_t>(dark, 1))};
}

}  // namespace

std::vector<Verdict> verify_receivers(const std::vector<RadianceMap>& rooms, ThreadPool& pool,
                                      const std::function<bool()>& go_on) {
  constexpr double k_limit = 0.010, k_hidden = 0.01;  // half of what is off without the depth, or less
  const std::array<Mode, 8> modes = {Mode{"depth of a phone"},
                                     Mode{"depth of a phone, one sample", true, true, true, false, k_bias, true},
                                     Mode{"depth as it is", true, true, true, true, 0.002},
                                     Mode{"depth of a phone, no bias", true, true, true, false, 1e-6},
                                     Mode{"no depth", true, true, false},
                                     Mode{"no wall", true, false},
                                     Mode{"no table", false, true},
                                     Mode{"no shadow", false, false}};
  std::array<Errors, modes.size()> sums = {};
  for (const RadianceMap& room : rooms) {
    if (!go_on()) return {};
    const RadianceMap light = before_wall(room);
    const Traced traced(light, 320, 240, pool);
    const Drawn drawn(light, traced);
    for (size_t i = 0; i < modes.size(); ++i) {
      const Errors e = errors_of(traced, drawn, modes[i]);
      const auto n = static_cast<double>(rooms.size());
      sums[i] = {sums[i].picture + e.picture / n, sums[i].feet + e.feet / n, sums[i].shadow + e.shadow / n};
    }
  }
  std::vector<Verdict> rows;
  const auto row = [&](const std::string& name, const char* unit, double value, double limit, bool control) {
    const bool within = value <= limit;
    rows.push_back({"receiver", "receiver, " + name, unit, 0, value, limit, control ? !within : within, control});
  };
  for (size_t i = 0; i < modes.size(); ++i) {
    const std::string name = modes[i].name;
    const bool noisy = name == "depth of a phone, no bias", control = i > 2;
    row(name, "rmse", sums[i].picture, k_limit, control);
    if (control && !noisy) continue;
    row(name + ", of the chair's feet hidden", "share", sums[i].feet, k_hidden, noisy);
    row(name + ", of the shadow hidden", "share", sums[i].shadow, k_hidden, noisy);
  }
  return rows;
}

}  // namespace sandglass::host
