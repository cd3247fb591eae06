// A frame with any input, and what an app may call before it: each call is refused by a sentence and changes nothing, or
// it is done. The scalar kernels run by a forged clock; others replay their plan and must agree to the bit.
#include <map>
#include <vector>

#include "runtime/math/hash.h"
#include "runtime/math/random.h"
#include "runtime/relief/relief.h"
#include "tests/fuzz/edits.h"
#include "tests/fuzz/other_kernels.h"
#include "tests/sand/granular_scene.h"

namespace {

constexpr float k_radius = 0.01f, k_far = 4000.0f;
constexpr uint32_t k_colliders = 4, k_emitters = 2, k_points = 4, k_pixel_bytes = 4096, k_grain_bytes = 8192;
uint8_t g_pixels[k_pixel_bytes];

enum Action : uint32_t {
  k_gravity = 1,
  k_friction = 2,
  k_add = 4,
  k_add_body = 8,
  k_remove = 16,
  k_move = 32,
  k_boundary = 64,
  k_light = 128,
  k_reset = 256,
  k_replay = 512,
  k_set_body = 1024,
  k_push_body = 2048,
  k_remove_body = 4096,
  k_ray = 8192
};

// What one frame is given, and what is called before it, without a pointer that means anything: the fuzzer changes it.
struct Turn {
  uint32_t actions = 0, collider_count = k_colliders, emitter_count = 1, sink_count = 1;
  uint64_t budget_ns = 4'000'000, unit_ns = 50'000, jump_ns = 0;
  float time_step = 0.004f, headroom = 1.0f, output_lag = 0.0f;
  uint32_t grain_stride = sizeof(sandglass_grain), grain_capacity = 64;
  float gravity[3] = {0, -9.81f, 0}, static_friction = 0.3f, kinetic_friction = 0.2f, light[3] = {0.3f, 1, 0.2f};
  float rotation[4] = {0, 0, 0, 1}, translation[3] = {0.1f, 0, 0};
  float points[3 * k_points] = {0, 0.2f, 0, 0.02f, 0.2f, 0, 0, 0.2f, 0.02f, 0.02f, 0.2f, 0.02f},
                   speeds[3 * k_points] = {};
  sandglass_collider colliders[k_colliders] = {sandglass::floor_at(0), sandglass::sphere(0, 0.03f, 0, 0.02f),
                                               sandglass::collider(SANDGLASS_SHAPE_FIELD, 0, 0, 0),
                                               sandglass::collider(SANDGLASS_SHAPE_RELIEF, 0, 0, 0)};
  sandglass_collider sink = sandglass::box(0.1f, 0, 0, 0.03f, 0.03f, 0.03f);
  sandglass_emitter emitters[k_emitters] = {sandglass::emitter(-0.2f, 0.4f, 0.0f, 0.012f, 0.8f, 4),
                                            sandglass::emitter(0.2f, 0.4f, 0.0f, 0.012f, 0.8f, 4)};
  sandglass_body body = sandglass::body();
  sandglass_camera_image image = sandglass::camera_image();
  sandglass_body_pose pose = {{0.1f, 0.01f, 0}, {0, 0, 0, 1}, {}, {}};
  uint32_t body_index = 0;
};
struct Input {
  Turn turns[2];
  sandglass_plan plan = {sizeof(sandglass_plan), 0, {{SANDGLASS_STAGE_GRANULAR, 5}, {SANDGLASS_STAGE_REFINE, 7}}, 2};
};

Input edited(const uint8_t* data, size_t size) {
  static const Input base = [] {
    Input input;
    for (Turn& turn : input.turns) {
      turn.image.width = turn.image.height = 16;
      turn.image.strides[0] = 48;
      turn.image.focal_x = turn.image.focal_y = 12;
      turn.image.centre_x = turn.image.centre_y = 7.5f;
      for (float& gain : turn.image.gains) gain = 1.5f;
      turn.image.timestamp_ns = &turn == input.turns ? 1'000'000'000 : 2'000'000'000;
    }
    return input;
  }();
  return sandglass::fuzz::edited(base, data, size);
}

// What takes part in a frame beside the sand: one of each that is made from its defaults. The others are left out.
template <class Handle>
struct Made {
  sandglass::Block block;
  Handle* handle = nullptr;

  template <class Desc>
  void create(void (*defaults)(Desc*), sandglass_status (*bytes_of)(const Desc*, uint64_t*, const char**),
              sandglass_status (*create_in)(const Desc*, void*, uint64_t, Handle**, const char**), sandglass_isa isa) {
    Desc desc;
    defaults(&desc);
    if constexpr (requires { desc.texels = 32; }) desc.texels = 32;
    if constexpr (requires { desc.sky_texels = 32; }) desc.sky_texels = 32;
    if constexpr (requires { desc.isa = isa; }) desc.isa = isa;
    create(desc, bytes_of, create_in);
  }
  template <class Defaults>
  void create(Defaults, sandglass_status (*bytes_of)(const sandglass_skin_desc*, uint64_t*, const char**),
              sandglass_status (*create_in)(const sandglass_skin_desc*, void*, uint64_t, Handle**, const char**),
              sandglass_isa) {
    create(sandglass::skin_desc(description(64, 128, 16).granular), bytes_of, create_in);
  }
  template <class Desc, class Bytes, class Create>
  void create(const Desc& desc, Bytes bytes_of, Create create_in) {
    uint64_t bytes = 0;
    if (bytes_of(&desc, &bytes, nullptr) != SANDGLASS_OK) return;
    block = sandglass::allocate_block(bytes);
    accept(sandglass::call(create_in, &desc, block.get(), bytes, &handle));
  }
};
struct Others {
#define ONE(stage, field, kinds) Made<sandglass_##field> field;
#define MANY(stage, field, number, name, kinds) Made<sandglass_##name> field;
#include "runtime/frame/capabilities.inc"
  void create(sandglass_isa isa) {
#define CREATE(field, name) \
  field.create(sandglass_##name##_desc_default, sandglass_##name##_bytes, sandglass_##name##_create, isa);
#define ONE(stage, field, kinds) CREATE(field, field)
#define MANY(stage, field, number, name, kinds) CREATE(field, name)
#include "runtime/frame/capabilities.inc"
  }
  void join(sandglass_frame_input* input) const {
#define ONE(stage, field, kinds) input->field = field.handle;
#define MANY(stage, field, number, name, kinds) \
  input->field = &field.handle;                 \
  input->number = field.handle != nullptr ? 1 : 0;
#include "runtime/frame/capabilities.inc"
  }
};

// A scene with its clock, and all that takes part.
struct World {
  explicit World(sandglass_isa kernels, bool clocked)
      : scene([&] {
          sandglass_scene_desc desc = description(64, 128, 16);
          desc.granular.body_capacity = 2;
          desc.granular.body_particle_capacity = 20;
          desc.granular.emitter_capacity = desc.granular.sink_capacity = 1;
          desc.isa = kernels;
          if (clocked) {
            desc.clock = {now, this};
            desc.trace = {nullptr, unit_ends, this};
          }
          return desc;
        }()),
        isa(kernels) {}

  // As a new scene is, with a heap of sand, its grains and a body.
  void begin() {
    scene.scene.reset();
    const std::vector<float> block = lattice(2, 2, 2, 2.02f * k_radius, k_radius);
    scene.add(block, {}, grains_about(block, 0.004f));
    scene.add_body(shifted(lattice(2, 2, 1, 2.01f * k_radius, k_radius), 0.0f, 0.1f, 0.0f), 2.0f);
    others.create(isa);
    clock_ns = 0;
  }

  static uint64_t now(void* user) { return static_cast<World*>(user)->clock_ns; }
  static void unit_ends(void* user, const char*) {
    World* world = static_cast<World*>(user);
    world->clock_ns += world->unit_ns;
  }

  GranularScene scene;
  sandglass_isa isa;
  Others others;
  uint64_t clock_ns = 0, unit_ns = 0;
  alignas(8) uint8_t grains[k_grain_bytes];
};

// A call that fails says why and changes nothing.
int32_t checked(World* world, const char** reason, const std::function<int32_t()>& call) {
  const uint64_t before = world->scene.hash();
  const int32_t status = call();
  sandglass::fuzz::expect((status == SANDGLASS_OK) == (*reason == nullptr));
  if (status != SANDGLASS_OK) sandglass::fuzz::expect(world->scene.hash() == before);
  return status;
}

// All calls that the turn asks for; their statuses.
std::vector<int32_t> act(World* world, const Turn& t) {
  sandglass_scene* scene = world->scene.scene.get();
  const char* reason = nullptr;
  std::vector<int32_t> statuses;
  const auto call = [&](Action action, const std::function<int32_t()>& function) {
    if (t.actions & action) statuses.push_back(checked(world, &reason, function));
  };
  call(k_gravity, [&] { return sandglass_scene_set_gravity(scene, t.gravity, &reason); });
  call(k_friction, [&] { return sandglass_scene_set_friction(scene, t.static_friction, t.kinetic_friction, &reason); });
  const sandglass_points points = {t.points, t.speeds, k_points};
  call(k_add, [&] { return sandglass_scene_add(scene, &points, &points, &reason); });
  sandglass_body body = t.body;
  body.struct_size = sizeof body;
  body.particle_positions = t.points;
  body.particle_count %= k_points + 1;
  call(k_add_body, [&] { return sandglass_scene_add_body(scene, &body, nullptr, &reason); });
  sandglass_collider region = t.colliders[1];
  region.field = nullptr;
  region.relief = world->others.relief.handle;
  call(k_remove, [&] { return sandglass_scene_remove(scene, &region, nullptr, nullptr, &reason); });
  call(k_move, [&] { return sandglass_scene_move(scene, t.rotation, t.translation, &reason); });
  call(k_boundary, [&] { return sandglass_scene_set_boundary(scene, t.points, k_points, &reason); });
  call(k_set_body, [&] { return sandglass_scene_set_body(scene, t.body_index, &t.pose, &reason); });
  call(k_push_body, [&] { return sandglass_scene_push_body(scene, t.body_index, t.speeds, t.points, &reason); });
  call(k_remove_body, [&] { return sandglass_scene_remove_body(scene, t.body_index, &reason); });
  sandglass_ray_hit hit = {};
  const int32_t any = sandglass_scene_ray(scene, t.points, t.translation, t.gravity[1], &hit);
  if (t.actions & k_ray) {
    statuses.push_back(any);
    statuses.push_back(static_cast<int32_t>(hit.index));
  }
  call(k_light, [&] {
    return sandglass_pile_shadow_set_light(world->others.pile_shadow.handle, t.light,
                                           t.grain_stride % 2 != 0 ? 0.2f : 0.0f, &reason);
  });
  if (t.actions & k_reset) world->scene.scene.reset();
  return statuses;
}

// Pointers that an app must keep are right: only what the library can check is forged.
sandglass_camera_image image_of(const Turn& t) {
  sandglass_camera_image image = t.image;
  image.struct_size = sizeof image;
  for (size_t i = 0; i < 3; ++i) {
    const auto stride = static_cast<uint64_t>(std::abs(int64_t{image.strides[i]}));
    const bool fits = stride * image.height <= k_pixel_bytes;
    image.planes[i] = !fits ? nullptr : image.strides[i] < 0 ? g_pixels + stride * (image.height - 1) : g_pixels;
  }
  return image;
}

// Cells under the sand, as high as its numbers say.
void raise_some(const Turn& t, sandglass_relief* relief) {
  sandglass::ReliefState* r = &relief->relief;
  const uint32_t width = r->desc.cells[0], middle = (r->desc.cells[1] / 2) * width + width / 2;
  sandglass::Random random{sandglass::hash_bytes(t.points, sizeof t.points)};
  for (uint32_t i = 0; i < 6; ++i)
    relief_set_cell(r, middle + random.below(4) + width * random.below(4), static_cast<int16_t>(random.below(400)));
  relief_end_change(r);
}

int32_t run(World* world, Turn* t, const sandglass_plan* plan, sandglass_frame_report* report) {
  static const sandglass::Field bowl = [] {
    sandglass::Field field;
    accept(field.from_function({{-0.3f, -0.3f, -0.3f}, {0.3f, 0.3f, 0.3f}}, 0.05f, SANDGLASS_SOLID_OUTSIDE,
                               [](const float* p) { return 0.2f - std::hypot(p[0], p[1], p[2]); }));
    return field;
  }();
  for (sandglass_collider& c : t->colliders) c.field = c.grains_only & 2 ? nullptr : bowl.get();
  for (sandglass_collider& c : t->colliders) c.relief = c.grains_only & 4 ? nullptr : world->others.relief.handle;
  t->sink.field = bowl.get();
  t->sink.relief = world->others.relief.handle;
  raise_some(*t, world->others.relief.handle);
  auto ground = sandglass::reported<sandglass_heights>(sandglass_relief_get_heights, world->others.relief.handle);
  ground.corner[1] += t->light[0];
  static_cast<void>(sandglass_pile_shadow_set_ground(world->others.pile_shadow.handle, &ground, nullptr));
  const sandglass_camera_image image = image_of(*t);
  sandglass_frame_input input = sandglass::frame_input();
  input.time_step = t->time_step;
  input.budget_ns = t->budget_ns;
  input.thermal_headroom = t->headroom;
  input.colliders = t->colliders;
  input.collider_count = t->collider_count % (k_colliders + 1);
  input.emitters = t->emitters;
  input.emitter_count = t->emitter_count % (k_emitters + 1);
  input.sinks = &t->sink;
  input.sink_count = t->sink_count % 2;
  input.output_lag = t->output_lag;
  input.grain_stride = t->grain_stride;
  input.grains = reinterpret_cast<sandglass_grain*>(world->grains);
  const uint64_t stride = t->grain_stride < sizeof(sandglass_grain) ? sizeof(sandglass_grain) : t->grain_stride;
  input.grain_capacity = static_cast<uint32_t>(std::min<uint64_t>(t->grain_capacity, k_grain_bytes / stride));
  world->others.join(&input);
  input.camera = &image;
  input.plan = plan;
  world->clock_ns += t->jump_ns;
  world->unit_ns = t->unit_ns;
  const char* reason = nullptr;
  const uint64_t before = world->scene.hash();
  const int32_t status = sandglass_scene_frame(world->scene.scene.get(), &input, report, &reason);
  sandglass::fuzz::expect((status == SANDGLASS_OK) == (reason == nullptr));
  if (status == SANDGLASS_ERROR_INVALID_ARGUMENT) sandglass::fuzz::expect(world->scene.hash() == before);
  return status;
}

void check(World* world, const sandglass_frame_report& report) {
  using sandglass::fuzz::expect;
  const sandglass_time_report& t = report.time;
  if (t.clock_fault == 0 && t.elapsed_ns > t.last_unit_ns)
    expect(t.elapsed_ns - t.last_unit_ns <= std::max(t.target_ns, t.mandatory_ns));
  expect(std::isfinite(t.simulated) && std::isfinite(t.debt) && std::isfinite(report.sand.speed_max));
  world->scene.particle_count = report.sand.particle_numbers;
  for (const float x : world->scene.positions()) expect(std::fabs(x) <= k_far || x == SANDGLASS_REMOVED_Y);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using sandglass::fuzz::expect;
  static World scalar(SANDGLASS_ISA_SCALAR, true);
  static std::map<sandglass_isa, World> worlds;
  const sandglass_isa isa = sandglass::fuzz::other_kernels(data, size);
  World& other = worlds.try_emplace(isa, isa, false).first->second;
  Input input = edited(data, size);
  scalar.begin();
  other.begin();
  for (Turn& turn : input.turns) {
    expect(act(&scalar, turn) == act(&other, turn));
    sandglass_frame_report a = {}, b = {};
    a.struct_size = b.struct_size = sizeof a;
    const bool forged = (turn.actions & k_replay) != 0;
    const int32_t status = run(&scalar, &turn, forged ? &input.plan : nullptr, &a);
    expect(run(&other, &turn, forged ? &input.plan : &a.plan, &b) == status);
    if (status == SANDGLASS_OK) {
      check(&scalar, a);
      check(&other, b);
    }
    expect(scalar.scene.hash() == other.scene.hash());
    expect(sandglass_pile_shadow_hash(scalar.others.pile_shadow.handle) ==
           sandglass_pile_shadow_hash(other.others.pile_shadow.handle));
    expect(sandglass_skin_hash(scalar.others.skin.handle) == sandglass_skin_hash(other.others.skin.handle));
    expect(sandglass_room_hash(scalar.others.room.handle) == sandglass_room_hash(other.others.room.handle));
  }
  std::vector<std::byte> saved;
  accept(scalar.scene.scene.save(&saved));
  accept(other.scene.scene.restore(saved));
  expect(other.scene.hash() == scalar.scene.hash());
  return 0;
}
