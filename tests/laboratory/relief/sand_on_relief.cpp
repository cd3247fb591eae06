#include "tests/laboratory/relief/sand_on_relief.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "tests/relief/relief_on.h"

namespace sandglass::host {

namespace {

constexpr float k_radius = 0.005f;
constexpr uint32_t k_particles = 4500;
constexpr int k_frames_a_second = 60, k_frames_an_image = 4;
constexpr double k_rest_from = 11;     // seconds
constexpr double k_thrown_from = 2.2;  // seconds: what was poured last has fallen
constexpr Vec3 k_box_place = {0.02, 0, -0.25};
constexpr double k_box_reach = 0.08;  // to its corners, and a cell
constexpr double k_nozzle_high = 0.6;

// The images of a recording with their noise, and then again, to and fro.
class Session {
 public:
  Session(const DepthRecording& recording, uint64_t seed) {
    DepthImages images(recording, {.seed = seed});
    const size_t pixels = size_t{recording.width} * recording.height;
    while (images.next()) {
      const auto* depth = static_cast<const uint16_t*>(images.image().depth);
      images_.push_back({images.image(), {depth, depth + pixels}, {}, images.drift()});
      Image& kept = images_.back();
      kept.confidence.assign(images.image().confidence, images.image().confidence + pixels);
    }
  }
  const sandglass_depth_image& next() {
    const auto last = static_cast<int>(images_.size()) - 1, fro = static_cast<int>(k_fro_from * k_image_rate);
    now_ += step_;
    if (now_ == last || (now_ == fro && step_ < 0)) step_ = -step_;
    Image& image = images_[static_cast<size_t>(now_)];
    image.image.depth = image.depths.data();
    image.image.confidence = image.confidence.data();
    image.image.timestamp_ns = ++shown_;
    return image.image;
  }
  Vec3 drift() const { return images_[static_cast<size_t>(now_)].drift; }

 private:
  static constexpr double k_fro_from = 7.5;  // seconds
  struct Image {
    sandglass_depth_image image;
    std::vector<uint16_t> depths;
    std::vector<uint8_t> confidence;
    Vec3 drift;
  };
  std::vector<Image> images_;
  int now_ = -1, step_ = 1;
  uint64_t shown_ = 0;
};

struct When {
  double from, to, end;  // seconds
};
When when(Pouring pouring) {
  return pouring == Pouring::everywhere     ? When{3, 5, 16}
         : pouring == Pouring::onto_the_box ? When{4.2, 5.2, 12}
                                            : When{0.2, 1.5, 8};
}

sandglass_emitter nozzle(Pouring pouring, double share) {
  const double turn = 2 * std::numbers::pi * share;
  const Vec3 at =
      pouring == Pouring::everywhere ? Vec3{0.33 * std::cos(turn), 0, 0.02 + 0.2 * std::sin(2 * turn)} : k_box_place;
  return cpp::emitter(static_cast<float>(at.x), static_cast<float>(k_nozzle_high), static_cast<float>(at.z), 0.03f,
                      0.6f, 0);
}

// Whether something truly is so high within 1.5 cm.
bool truly_high(const Table& table, Vec3 p, double height) {
  for (int b = -3; b <= 3; ++b)
    for (int a = -3; a <= 3; ++a)
      if (table.height(p.x + 0.005 * a, p.z + 0.005 * b, {}) > height - 0.01) return true;
  return false;
}

// Of the particles where the box stood.
double count_floating(const cpp::Scene& scene, uint32_t count, const cpp::Relief& relief, const Table& table,
                      Vec3 drift) {
  std::vector<float> positions(3 * count);
  sandglass_scene_particles(scene.get(), positions.data(), nullptr);
  const double r = static_cast<double>(k_radius), touches2 = 2.2 * r * 2.2 * r;
  double floating = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const Vec3 p = from_floats(&positions[3 * i]);
    const Vec3 aside = p - drift - k_box_place;
    if (std::hypot(aside.x, aside.z) > k_box_reach) continue;
    const double ground = std::max(tests::height_at(relief, p.x, p.z), 0.0);  // the plane is there, too
    const bool lies = p.y < ground + 1.3 * r;
    if (lies) {
      floating += ground > 0.01 && !truly_high(table, p - drift, ground);
      continue;
    }
    bool touches = false;
    for (uint32_t j = 0; j < count && !touches; ++j) {
      const Vec3 d = from_floats(&positions[3 * j]) - p;
      touches = i != j && dot(d, d) < touches2;
    }
    floating += !touches;
  }
  return floating;
}

void require(const cpp::Status& status) {
  if (!status) throw std::runtime_error(status.reason);
}

}  // namespace

SandOnRelief sand_on_relief(const DepthRecording& recording, uint64_t seed, Pouring pouring, Left left, bool dense) {
  cpp::Relief relief;
  cpp::Scene scene;
  sandglass_scene_desc desc = cpp::scene_desc();
  desc.granular.particle_radius = k_radius;
  desc.granular.particle_capacity = k_particles;
  desc.granular.emitter_capacity = desc.granular.body_capacity = 1;
  desc.granular.body_particle_capacity = 8;
  require(relief.create());
  require(scene.create(desc));
  if (dense) {
    sandglass_body body = cpp::body();
    const float one[3] = {1.0f, k_radius, 1.0f};
    body.particle_positions = one;
    body.particle_count = 1;
    body.density_ratio = 5;
    require(cpp::call(sandglass_scene_add_body, scene.get(), &body, nullptr));
  }
  sandglass_collider colliders[2] = {cpp::floor_at(0), cpp::relief_collider(relief)};
  colliders[0].id = 1;
  colliders[1].id = 2;
  sandglass_frame_input input = cpp::frame_input(1.0f / k_frames_a_second, ~0ull >> 1);
  input.colliders = colliders;
  input.collider_count = 2;
  Session session(recording, seed);
  const When times = when(pouring);
  SandOnRelief found;
  sandglass_frame_report report = cpp::frame_report();
  int rested = 0;
  for (int frame = 0; frame < times.end * k_frames_a_second; ++frame) {
    const double t = static_cast<double>(frame) / k_frames_a_second;
    if (frame % k_frames_an_image == 0) take_image(&relief, session.next(), left);
    const sandglass_emitter pours = nozzle(pouring, (t - times.from) / (times.to - times.from));
    input.emitters = &pours;
    input.emitter_count = t >= times.from && t < times.to ? 1 : 0;
    require(scene.frame(input, &report));
    if (t >= k_thrown_from) found.fastest = std::max(found.fastest, static_cast<double>(report.sand.speed_max));
    if (t < k_rest_from || report.sand.particles == 0) continue;
    found.awake += 100.0 * report.sand.awake / report.sand.particles;
    ++rested;
  }
  found.awake /= std::max(rested, 1);
  found.floats = count_floating(scene, report.sand.particle_numbers, relief, *recording.table, session.drift());
  return found;
}

}  // namespace sandglass::host
