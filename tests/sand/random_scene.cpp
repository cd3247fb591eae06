#include "tests/sand/random_scene.h"
#include "tests/camera_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "tests/light/light_fixture.h"
#include "tests/sand/granular_scene.h"

namespace sandglass::tests {

namespace {

constexpr uint32_t k_sand_max = 400, k_body_particles = 125, k_bodies = 3, k_emitters = 2, k_grains_each = 8;
constexpr uint32_t k_particles_max = 700, k_colliders = 6;
constexpr float k_fastest = 3.0f;  // m/s, of nozzles
constexpr double k_pi = 3.14159265358979323846;

}  // namespace

float RandomScene::log_between(double low, double high) {
  return static_cast<float>(low * std::exp(random_.uniform() * std::log(high / low)));
}

uint64_t RandomScene::now(void* user) {
  RandomScene* s = static_cast<RandomScene*>(user);
  switch (s->clock_kind_) {
    case 2:  // now and then a jump of up to a second, forward or backward
      if (s->clock_random_.below(500) == 0) s->clock_ns_ += s->clock_random_.next() % 2'000'000'000 - 1'000'000'000;
      return s->clock_ns_;
    case 3:
      return s->clock_random_.next();
    default:
      return s->clock_ns_;
  }
}

void RandomScene::unit_ends(void* user, const char*) {
  RandomScene* s = static_cast<RandomScene*>(user);
  s->clock_ns_ += s->unit_ns_ * (50 + s->clock_random_.below(100)) / 100;
}

// In a random order, some calls twice, some not at all.
void RandomScene::pool(void* user, sandglass_task_function task, void* context, uint32_t count) {
  RandomScene* s = static_cast<RandomScene*>(user);
  for (uint32_t i = 0; i < count; ++i) task(context, s->pool_random_.below(count));
}

void RandomScene::describe(bool replays) {
  desc = scene_desc();
  sandglass_granular_desc& g = desc.granular;
  r_ = one_in(10) ? log_between(0.0005, 0.5) : log_between(0.004, 0.03);
  g.particle_radius = r_;
  g.particle_capacity = k_particles_max + k_bodies * k_body_particles;
  g.grain_capacity = one_in(3) ? 0 : k_particles_max * k_grains_each;
  g.boundary_capacity = 64;
  g.body_capacity = k_bodies;
  g.body_particle_capacity = k_bodies * k_body_particles;
  g.emitter_capacity = k_emitters;
  g.sink_capacity = 1;
  g.collider_capacity = k_colliders + 1;
  if (one_in(2)) {
    g.static_friction = one_in(5) ? between(0, 10) : between(0, 1);
    g.kinetic_friction = one_in(5) ? between(0, 10) : between(0, 1);
  }
  if (one_in(8)) g.height_weighting = between(0, 1.5);
  if (one_in(8)) g.courant = between(0.05, 1);
  if (one_in(8)) g.list_margin = between(0.1, 1);
  if (one_in(4)) g.sleep_after = one_in(2) ? 0.0f : between(0.02, 0.5);
  if (one_in(8)) g.refine_step = log_between(0.001, 0.1);
  if (one_in(8)) g.grain_radius = r_ * between(0, 1);
  if (one_in(10))
    g.reference = {SANDGLASS_SCHEME_AVERAGED, SANDGLASS_BLEND_SOURCE, 1 + random_.below(4), random_.below(3),
                   between(0.1, 2)};
  if (one_in(10)) {
    desc.gravity[0] = between(-20, 20);
    desc.gravity[1] = between(-20, 20);
    desc.gravity[2] = between(-20, 20);
  }
  if (one_in(20)) desc.gravity[0] = desc.gravity[1] = desc.gravity[2] = 0.0f;
  desc.unit_items = one_in(2) ? 1024 : 16 * (1 + random_.below(40));
  desc.finest_level = one_in(6) ? random_.below(SANDGLASS_LEVEL_COUNT) : 0;
  clock_kind_ = random_.below(4);  // 0: none
  unit_ns_ = 20'000 + random_.below(100'000);
  const bool shared = one_in(3);
  if (replays) {
    desc.isa = SANDGLASS_ISA_SCALAR;
    return;
  }
  if (clock_kind_ != 0) {
    desc.clock = {now, this};
    desc.trace = {unit_begins, unit_ends, this};
  }
  if (shared) desc.parallel = {pool, this};
}

void RandomScene::add_bodies() {
  const uint32_t bodies = one_in(2) ? 0 : 1 + random_.below(k_bodies);
  for (uint32_t i = 0; i < bodies; ++i) {
    BoxBody box;
    const std::array<float, 3> half = {r_ * between(1, 4), r_ * between(1, 4), r_ * between(1, 4)};
    const std::array<float, 3> place = {r_ * between(-6, 6), height_ + 8 * r_, r_ * between(-6, 6)};
    const float turn[3] = {between(-1, 1), between(-1, 1), between(0, 3)};
    ::accept(box_body(half, r_, place, 1.0f, &box, rotation_about(turn[0], 1, turn[1], turn[2])));
    box.body.density_ratio = log_between(0.001, 1000);
    for (float& v : box.body.linear_velocity) v = one_in(2) ? 0.0f : between(-1, 1);
    for (float& w : box.body.angular_velocity) w = one_in(2) ? 0.0f : between(-5, 5);
    if (box.body.particle_count > k_body_particles) continue;
    ::accept(scene.add_body(box.body));
    particles_added += box.body.particle_count;
    height_ += 16 * r_;
  }
  in_bodies = static_cast<uint32_t>(particles_added);
}

// A block on a lattice, tight, loose or overlapping, above everything so far.
void RandomScene::add_sand(uint32_t count_max) {
  const uint32_t side = 1 + random_.below(6), count = static_cast<uint32_t>(log_between(1, count_max));
  const float spacing = one_in(6) ? r_ * between(1.2, 2) : r_ * between(2, 2.3);
  const uint32_t each = desc.granular.grain_capacity == 0 ? 0 : random_.below(k_grains_each + 1);
  std::vector<float> particles, velocities, grains;
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t place[3] = {i % side, i / (side * side), i / side % side};
    float p[3];
    for (uint32_t k = 0; k < 3; ++k)
      p[k] = spacing * static_cast<float>(place[k]) + (k == 1 ? height_ + 1.01f * r_ : 0.0f);
    for (uint32_t k = 0; k < 3; ++k) particles.push_back(p[k] + r_ * between(0, 0.01));
    for (uint32_t k = 0; k < 3; ++k) velocities.push_back(between(-1, 1));
    for (uint32_t g = 0; g < each; ++g)
      for (uint32_t k = 0; k < 3; ++k) grains.push_back(p[k] + r_ * between(-0.5, 0.5));
  }
  const sandglass_points sand = {particles.data(), velocities.data(), count},
                         fine = {grains.data(), nullptr, count * each};
  Status status;
  status.code = sandglass_scene_add(scene.get(), &sand, &fine, &status.reason);
  if (status.code == SANDGLASS_ERROR_CAPACITY) return;
  ::accept(status);
  particles_added += count;
  grains_added += count * each;
  height_ += spacing * static_cast<float>(count / (side * side) + 1);
}

void RandomScene::add_colliders() {
  for (uint32_t i = random_.below(k_colliders); i > 0; --i) {
    const float x = r_ * between(-15, 15), y = r_ * between(0, 30), z = r_ * between(-15, 15);
    const float size[3] = {r_ * between(1, 10), r_ * between(1, 10), r_ * between(1, 10)};
    const float turn[3] = {between(-1, 1), between(-1, 1), between(0, 6)};
    sandglass_collider c = sphere(x, y, z, size[0]);
    const uint32_t shape = random_.below(5);
    if (shape == 1) c = capsule(x, y, z, size[0], size[1]);
    if (shape == 2) c = box(x, y, z, size[0], size[1], size[2]);
    if (shape == 3) c = collider(SANDGLASS_SHAPE_HALF_SPACE, -20 * r_, 0, 0);  // a wall
    if (shape == 4) {
      if (!field_) {
        // A bowl: solid outside a sphere.
        const float R = 20 * r_;
        const Box bounds = {{-1.2f * R, -1.2f * R, -1.2f * R}, {1.2f * R, 1.2f * R, 1.2f * R}};
        ::accept(field_.from_function(bounds, 2 * r_, SANDGLASS_SOLID_OUTSIDE,
                                      [R](const float* p) { return R - std::hypot(p[0], p[1], p[2]); }));
      }
      c = field_at(field_, 0, 19 * r_, 0);
    }
    const Rotation turned = shape == 3 ? rotation_about(0, 0, 1, static_cast<float>(-k_pi / 2))
                                       : rotation_about(turn[0], 1, turn[1], turn[2]);
    for (size_t k = 0; k < 4; ++k) c.rotation[k] = turned[k];
    c.grains_only = one_in(8) ? 1 : 0;
    grains_have_floor = grains_have_floor && c.grains_only == 0;
    Motion motion = {};
    motion.phase = between(0, 6);
    motion.rate = log_between(0.5, 20);
    for (uint32_t k = 0; k < 3; ++k) {
      motion.start[k] = c.position[k];
      motion.amplitude[k] = one_in(2) ? 0.0f : r_ * between(-10, 10);
    }
    colliders_.push_back(c);
    motions_.push_back(motion);
  }
  bodies_have_floor = colliders_.empty();
  colliders_.push_back(floor_at(0.0f));  // the last
  if (one_in(4)) {
    std::vector<float> samples;
    for (uint32_t i = 0; i < 64; ++i)
      for (const float p : {r_ * 2 * static_cast<float>(i % 8), 0.0f, r_ * 2 * static_cast<float>(i / 8)})
        samples.push_back(p);
    ::accept(scene.set_boundary(samples));
  }
  for (uint32_t i = one_in(3) ? 1 + random_.below(k_emitters) : 0; i > 0; --i) {
    const float place[2] = {r_ * between(-10, 10), r_ * between(-10, 10)};
    const float radius = r_ * between(1, 6), speed = between(0.05, k_fastest);
    const uint32_t each = random_.below(k_grains_each);
    emitters_.push_back(emitter(place[0], height_ + r_ * between(-20, 40), place[1], radius, speed,
                                desc.granular.grain_capacity == 0 ? 0 : each));
  }
  if (one_in(4)) sinks_.push_back(box(r_ * between(-15, 15), 0, 0, 6 * r_, 4 * r_, 6 * r_));
}

// The network's weights are random, and so are those of the object's shadow.
void RandomScene::add_light() {
  if (!every_stage_ && light_random_.below(12) != 0) return;
  static const AssetFile file = [] {
    RandomShadow what;
    what.version = 2;
    what.ambient_side = 16;
    what.components = 24;
    return make_shadow_file(what);
  }();
  shadow.emplace(tests::describe(file, desc.isa));
  sandglass_estimator_desc light = describe_light();
  light.isa = desc.isa;
  light.interval = 8.0f;
  ::accept(light_.create(light));
  add_relief();
}

// Looks down at what is as high as numbers say, up to 0.2 m, and pushes what is there.
void RandomScene::add_relief() {
  constexpr uint32_t k_width = 48, k_height = 32;
  for (uint32_t i = 0; i < k_width * k_height; ++i)
    depths_.push_back(static_cast<uint16_t>(400 + (depth_random_.below(3) != 0 ? 200 : depth_random_.below(200))));
  depth_.width = k_width;
  depth_.height = k_height;
  depth_.depth = depths_.data();
  depth_.stride = 2 * k_width;
  depth_.focal_x = depth_.focal_y = 40;
  depth_.centre_x = 0.5f * (k_width - 1);
  depth_.centre_y = 0.5f * (k_height - 1);
  depth_.position[1] = 0.6f;
  const float x_axis[3] = {1, 0, 0};
  sandglass_rotation_about(x_axis, -1.57079632679f, depth_.orientation);
  ::accept(relief_.create());
  colliders_.insert(colliders_.end() - 1, relief_collider(relief_));
  bodies_have_floor = false;
}

void RandomScene::add_shadows() {
  if (one_in(6) || every_stage_) {
    sandglass_pile_shadow_desc d = pile_shadow_desc();
    d.isa = desc.isa;
    d.texels = 32;
    d.sky_texels = one_in(2) || every_stage_ ? 32 : 0;
    d.on_sand = random_.below(2);
    std::fill_n(d.low, 2, -20 * r_);
    std::fill_n(d.high, 2, 20 * r_);
    ::accept(pile_.create(d));
    if (desc.granular.particle_capacity != 0) ::accept(skin_.create(skin_desc(desc.granular)));
  }
  add_light();
  if (!one_in(6) && !light_) return;
  ::accept(room_.create());
  pixels_.resize(3 * 48 * 32);
  for (uint8_t& p : pixels_) p = static_cast<uint8_t>(random_.next());
  image_ = camera_picture(pixels_.data(), 48, 32, sandglass_camera_focal(48, 32, 80));
}

RandomScene::RandomScene(uint64_t number, bool replays)
    : random_(random_stream(number, 1)),
      clock_random_(random_stream(number, 2)),
      pool_random_(random_stream(number, 3)),
      light_random_(random_stream(number, 4)),
      depth_random_(random_stream(number, 5)),
      every_stage_(number % 8 == 0) {
  describe(replays);
  block = test::GuardedBlock(Scene::bytes(desc));
  ::accept(scene.create_in(desc, block.data(), block.bytes()));
  drawn = test::GuardedBlock(sizeof(sandglass_grain) * desc.granular.grain_capacity);
  add_bodies();
  add_sand(k_sand_max);
  add_colliders();
  add_shadows();
  frames = number % 100 == 99 ? 1000 : 20 + random_.below(60);
}

uint64_t RandomScene::hash() const {
  uint64_t all = scene.hash();
  for (const uint64_t part : {pile_.hash(), skin_.hash(), room_.hash(), sandglass_estimator_hash(light_.get()),
                              relief_.hash(), shadow ? sandglass_shadow_hash(shadow->shadow) : 0})
    all = 31 * all + part;
  return all;
}

float RandomScene::draw_step() {
  switch (random_.below(24)) {
    case 0:
      return 0.0f;
    case 1:
      return std::numeric_limits<float>::quiet_NaN();
    case 2:
      return between(-1, 0.3);
    case 3:
      return log_between(1e-4, 0.1);
    case 4:
      return 0.1f;
    default:
      return 1.0f / 60.0f;
  }
}

// Each moves on a line to and fro, with the velocity of its motion; one in fifty times it jumps, with another velocity.
void RandomScene::move_colliders(float step) {
  time_ += step > 0 && step <= 0.1f ? static_cast<double>(step) : 0.0;
  for (size_t i = 0; i < motions_.size(); ++i) {
    Motion& m = motions_[i];
    if (one_in(200)) m.phase = between(0, 6);
    const float angle = m.rate * static_cast<float>(time_) + m.phase;
    for (uint32_t k = 0; k < 3; ++k) {
      colliders_[i].position[k] = m.start[k] + m.amplitude[k] * std::sin(angle);
      colliders_[i].linear_velocity[k] = m.amplitude[k] * m.rate * std::cos(angle);
    }
  }
}

// What an app does between frames.
void RandomScene::act() {
  const uint32_t action = random_.below(200);
  if (action == 0) add_sand(40);
  if (action == 1) {
    const float statics = between(0, 1), kinetic = between(0, 1);
    ::accept(scene.set_friction(statics, kinetic));
  }
  if (action == 2) {
    const float x = r_ * between(-10, 10), y = r_ * between(0, 20);
    ::accept(scene.remove(sphere(x, y, 0, r_ * 4)));
  }
  if (action == 3) {
    std::vector<std::byte> saved;
    ::accept(scene.save(&saved));
    ::accept(scene.restore(saved));
  }
  if (pile_ && relief_) ::accept(pile_.set_ground(relief_.heights()));
  if (pile_ && one_in(4)) ::accept(pile_.set_light({between(-1, 1), 1.0f, between(-1, 1)}));
  if (light_random_.below(40) == 0) {
    const auto tilt = [&] { return static_cast<float>(6.0 * light_random_.uniform() - 3.0); };
    ::accept(scene.set_gravity({tilt(), -9.81f, tilt()}));
  }
  if (!shadow || light_random_.below(10) != 0) return;
  const float time = static_cast<float>(time_), middle[3] = {};
  shadow->light(std::cos(time), 0.8f, std::sin(time));
  const sandglass_room_light seen = room_.light_at(middle);
  if (pile_ && pile_.texture(SANDGLASS_PILE_SHADOW_SKY_FLOOR).side > 0) ::accept(pile_.set_cells(seen.cells));
  EXPECT_EQ(sandglass_shadow_set_cells(shadow->shadow, seen.cells, time, nullptr), SANDGLASS_OK);
}

sandglass_frame_input RandomScene::next_input() {
  act();
  sandglass_frame_input input = frame_input();
  const float step = draw_step();
  move_colliders(step);
  input.time_step = step;
  asked += step > 0.0f ? static_cast<double>(step < 0.1f ? step : 0.1f) : 0.0;
  input.budget_ns = one_in(6)   ? 0
                    : one_in(4) ? random_.next() >> random_.below(64)
                                : 1'000'000 + random_.below(8'000'000);
  input.thermal_headroom = one_in(10) ? between(-0.5, 1.5) : 1.0f;
  input.colliders = colliders_.data();
  input.collider_count = static_cast<uint32_t>(colliders_.size());
  input.emitters = emitters_.data();
  input.emitter_count = one_in(10) ? 0 : static_cast<uint32_t>(emitters_.size());
  input.sinks = sinks_.data();
  input.sink_count = static_cast<uint32_t>(sinks_.size());
  input.grains = drawn.bytes() == 0 ? nullptr : reinterpret_cast<sandglass_grain*>(drawn.data());
  input.grain_capacity = static_cast<uint32_t>(drawn.bytes() / sizeof(sandglass_grain));
  input.output_lag = one_in(6) ? between(0, 0.1) : 0.0f;
  input.pile_shadow = pile_.get();
  input.skin = skin_.get();
  image_.timestamp_ns += 16'666'667;
  input.room = room_.get();
  input.camera = room_ ? &image_ : nullptr;
  input.estimator = light_.get();
  depth_.timestamp_ns = image_.timestamp_ns;
  input.relief = relief_.get();
  input.depth = relief_ ? &depth_ : nullptr;
  if (shadow) {
    input.shadows = &shadow->shadow;
    input.shadow_count = 1;
  }
  return input;
}

}  // namespace sandglass::tests
