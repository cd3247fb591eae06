// The rules of argument_rules.h in every public function that they concern: the table below gives each function good
// arguments.
//
// The names of the arguments come from the headers (header_facts.py), which also say whether the table is complete.
// They give the rows of functions that take one pointer and nothing else, and of creation where the defaults are
// enough.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/package/argument_rules.h"

namespace sandglass::tests {

namespace {

// A camera's image, and what its rows lie in.
const std::vector<uint8_t> k_pixels(3 * 64 * 48, 100);
sandglass_camera_image grey_image() {
  sandglass_camera_image image = sandglass::camera_image();
  image.width = 64;
  image.height = 48;
  image.planes[0] = k_pixels.data();
  image.strides[0] = 3 * 64;
  image.focal_x = image.focal_y = 60.0f;
  image.centre_x = image.centre_y = 20.0f;
  return image;
}

}  // namespace

void Arguments::made_from_defaults() {
  // Only NULL is handed over: what else the pointer may be is never looked at.
#define ONE_POINTER(function, type) row(NAMED(function), "", reinterpret_cast<type*>(point));
#define MADE_ALONE(type)                                                           \
  if (type##_desc desc_of; is_made(&desc_of, type##_desc_default, type##_bytes)) { \
    GuardedBlock block{0};                                                         \
    MADE(type, &block, &desc_of);                                                  \
    EXPECT_TRUE(block.guards_intact());                                            \
  }
#include "handles.inc"
}

void Arguments::scenes() {
  sandglass_scene* const s = scene.get();
  sandglass_scene* made = nullptr;
  row(NAMED(sandglass_scene_bytes), "", &desc, &need);
  row(NAMED(sandglass_scene_create), "", &desc, spare.get(), bytes, &made);
  row(NAMED(sandglass_scene_set_gravity), "", s, low);
  row(NAMED(sandglass_scene_move), "rotation translation", s, point, low);
  std::vector<uint8_t> saved(1 << 20);
  uint64_t written = 0;
  row(NAMED(sandglass_scene_save), "", s, saved.data(), uint64_t{saved.size()}, &written);
  row(NAMED(sandglass_scene_restore), "", s, saved.data(), written);
  sandglass_region region;
  row(NAMED(sandglass_scene_regions), "regions", s, &region, 1u);
  const sandglass_points sand = {point, low, 1};
  row(NAMED(sandglass_scene_add), "particles grains", s, &sand, &sand);
  const sandglass_collider ball = sandglass::sphere(5.0f, 5.0f, 5.0f, 0.1f);
  row(NAMED(sandglass_scene_remove), "particles grains", s, &ball, &count, &other);
  sandglass_body body = sandglass::body();
  body.particle_positions = point;
  body.particle_count = 1;
  row(NAMED(sandglass_scene_add_body), "index", s, &body, &count);
  float points[64 * 3];
  sandglass_box_desc box = sandglass::box_desc();
  for (float& half : box.half_extents) half = 0.02f;
  box.particle_radius = 0.01f;
  row(NAMED(sandglass_box_count), "", &box, &count);
  row(NAMED(sandglass_box_body), "", &box, points, 64u, &body);
  sandglass_body_pose pose = sandglass_scene_body_pose(s, 0);
  sandglass_collider collider = {};
  row(NAMED(sandglass_box_collider), "", &box, &pose, &collider);
  row(NAMED(sandglass_scene_held_collider), "", s, 0u, &collider);
  row(NAMED(sandglass_scene_set_body), "", s, 0u, &pose);
  row(NAMED(sandglass_scene_push_body), "point", s, 0u, low, point);
  sandglass_ray_hit hit = {};
  row(NAMED(sandglass_scene_ray), "", s, point, low, 1.0f, &hit);
  row(NAMED(sandglass_scene_has_body), "", s, 0u);
  row(NAMED(sandglass_scene_remove_body), "", s, 0u);
  row(NAMED(sandglass_rotation_about), "", low, 1.0f, points);
  covered_.insert("sandglass_scene_body_pose");
  ++cases_;
  pose = sandglass_scene_body_pose(nullptr, 0);
  EXPECT_EQ(pose.rotation[3], 1.0f);
  EXPECT_EQ(pose.position[1], 0.0f);
  row(NAMED(sandglass_scene_set_boundary), "", s, low, 1u);
  row(NAMED(sandglass_scene_set_friction), "", s, 0.2f, 0.2f);
  sandglass_frame_input input = sandglass::frame_input();
  sandglass_frame_report report = sandglass::frame_report();
  input.time_step = 0.01f;
  row(NAMED(sandglass_scene_frame), "report", s, &input, &report);
  row(NAMED(sandglass_scene_particles), "", s, points, points);
  row(NAMED(sandglass_scene_grains), "", s, points, points);
}

namespace {

constexpr float k_vertices[] = {0, -0.05f, 0, 0.05f, 0, 0, 0, 0, 0.05f, 0, 0.05f, 0};
constexpr uint32_t k_indices[] = {0, 1, 2, 3, 2, 1, 0, 3, 1, 0, 2, 3};
constexpr sandglass_mesh k_mesh = {k_vertices, 4, k_indices, 4};

int32_t in_ball(void*, const float p[3]) { return p[0] * p[0] + p[1] * p[1] + p[2] * p[2] < 0.0064f ? 1 : 0; }
float from_plane(void*, const float p[3]) { return std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) - 0.05f; }

}  // namespace

void Arguments::sampling() {
  std::vector<float> points(3 * 4096);
  sandglass_sample_desc sample = sandglass::sample_desc();
  row(NAMED(sandglass_sample_disk), "", 1.0f, points.data(), 8u);
  row(NAMED(sandglass_sample_sphere), "", 1.0f, points.data(), 8u);
  row(NAMED(sandglass_sample_ring), "", 1.0f, 0.5f, 1.0f, points.data(), 8u);
  row(NAMED(sandglass_mesh_bounds), "", &k_mesh, low, high);
  double number = 0.0;
  row(NAMED(sandglass_mesh_area), "", &k_mesh, &number);
  row(NAMED(sandglass_mesh_winding_number), "", &k_mesh, point, &number);
  const sandglass_inside_rule rule = SANDGLASS_INSIDE_WINDING;
  row(NAMED(sandglass_mesh_inside_bytes), "", &k_mesh, rule, &need);
  const sandglass::Block block = sandglass::allocate_block(1 << 20);
  sandglass_mesh_inside* inside = nullptr;
  row(NAMED(sandglass_mesh_inside_create), "", &k_mesh, rule, block.get(), need, &inside);
  row(NAMED(sandglass_mesh_inside_test), "", inside, point);

  for (float& edge : sample.bounds_min) edge = -0.1f;
  for (float& edge : sample.bounds_max) edge = 0.1f;
  sample.distance = 0.02f;
  sample.mesh = &k_mesh;
  sample.inside = in_ball;
  const sandglass::Block scratch = sandglass::allocate_block(1 << 22);
  for (; sample.method <= SANDGLASS_SAMPLE_LATTICE; ++sample.method) {
    row(NAMED(sandglass_sample_capacity), "", &sample, &count);
    row(NAMED(sandglass_sample_bytes), "", &sample, 4096u, &need);
    row(NAMED(sandglass_sample_points), "", &sample, scratch.get(), uint64_t{1 << 22}, points.data(), 4096u, &count);
  }
}

void Arguments::fields() {
  sandglass_field_desc from_mesh = sandglass::field_desc();
  for (float& edge : from_mesh.bounds_min) edge = -0.1f;
  for (float& edge : from_mesh.bounds_max) edge = 0.1f;
  from_mesh.spacing = 0.01f;
  from_mesh.band = 0.05f;
  sandglass_field_desc from_function = from_mesh;
  from_mesh.mesh = &k_mesh;
  from_mesh.inside = in_ball;
  from_function.distance = from_plane;
  row(NAMED(sandglass_field_bytes), "", &from_mesh, &need);
  GuardedBlock block(need);
  sandglass_field* field = nullptr;
  for (const sandglass_field_desc* from : {&from_mesh, &from_function})
    row(NAMED(sandglass_field_create), "", from, block.data(), need, &field);
  float normal[3];
  row(NAMED(sandglass_field_distance), "normal", field, point, normal);
  row(NAMED(sandglass_field_bounds), "bounds_min bounds_max", field, low, high);
  EXPECT_TRUE(block.guards_intact());
}

void Arguments::lights() {
  uint64_t file_bytes = 0;
  const std::vector<uint64_t> file = file_of(SANDGLASS_ROOM_LIGHT, &file_bytes);
  sandglass_estimator_desc desc_of = sandglass::estimator_desc();
  desc_of.asset = file.data();
  desc_of.asset_bytes = file_bytes;
  fills(NAMED(sandglass_estimator_inspect), file.data(), file_bytes);
  GuardedBlock block{0};
  sandglass_estimator* const estimator = MADE(sandglass_estimator, &block, &desc_of);
  row(NAMED(sandglass_estimator_turn), "", estimator, point);
  sandglass_camera_image image = grey_image();
  row(NAMED(sandglass_camera_check), "", &image);
  row(NAMED(sandglass_estimator_set_image), "taken", estimator, &image, &taken);
  float sh[27];
  const float matrix[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  row(NAMED(sandglass_camera_orientation), "", matrix, sh);
  row(NAMED(sandglass_estimator_run), "", estimator, 1u);
  sandglass_estimator_run(estimator, UINT32_MAX);  // so that there is an estimate to read
  auto estimate = sized<sandglass_estimator_light>();
  row(NAMED(sandglass_estimator_get_latest), "", estimator, &estimate);
  row(NAMED(sandglass_estimator_get), "", estimator, &estimate);
  sandglass_estimator_get(estimator, &estimate);
  fills(NAMED(sandglass_light_of_estimator), &estimate);
  sandglass_estimator_release(estimator);
  EXPECT_TRUE(block.guards_intact());
}

void Arguments::rooms() {
  sandglass_room_desc desc_of = sandglass::room_desc();
  desc_of.probe = desc_of.reflections = 1;
  GuardedBlock block{0};
  sandglass_room* const room = MADE(sandglass_room, &block, &desc_of);
  sandglass_camera_image image = grey_image();
  row(NAMED(sandglass_room_set_image), "taken", room, &image, &taken);
  const float level[4] = {0, 0, 0, 1};
  row(NAMED(sandglass_room_move), "", room, level, point);
  auto estimate = sized<sandglass_estimator_light>();
  auto light = sized<sandglass_room_light>();
  auto place = sized<sandglass_room_place>();
  place.network = &estimate;
  row(NAMED(sandglass_room_get), "", room, &place, &light);
  place.network = nullptr;
  row(NAMED(sandglass_room_exposure), "", &light, &image);
  auto cube = sized<sandglass_cube>();
  auto harmonics = sized<sandglass_harmonics>();
  std::vector<float> face(3 * 16, 0.5f);
  sandglass_cube_default(&cube);
  sandglass_harmonics_default(&harmonics);
  cube.format = SANDGLASS_CUBE_RGB32F;
  cube.size = 4;
  cube.stride = 48;
  for (const void*& f : cube.faces) f = face.data();
  row(NAMED(sandglass_room_set_harmonics), "harmonics", room, &harmonics);
  row(NAMED(sandglass_room_set_cube), "cube", room, &cube);
  std::vector<uint16_t> texels(4 * SANDGLASS_ROOM_CUBE_SIZE * SANDGLASS_ROOM_CUBE_SIZE);
  row(NAMED(sandglass_room_get_cube), "", room, point, 0.1f, 0u, 0u, texels.data());
  uint32_t turn_deg = 0;
  int32_t mirrored = 0;
  row(NAMED(sandglass_room_probe_fit), "", room, &turn_deg, &mirrored);
  sandglass_room_light shown = light;
  row(NAMED(sandglass_room_fade), "", &shown, &light, 0.1f);
  ASSERT_EQ(sandglass_room_get(room, &place, &light, nullptr), SANDGLASS_OK);
  auto lighting = sized<sandglass_light>();
  row(NAMED(sandglass_light_of_room), "", &light, &lighting);
  ASSERT_EQ(sandglass_light_of_room(&light, &lighting, nullptr), SANDGLASS_OK);
  fills(NAMED(sandglass_light_adapt), &lighting, 0.5f, 0);
  const sandglass_light_model model = SANDGLASS_LIGHT_WHOLE;
  float sh[27] = {}, turned[27];
  fills(NAMED(sandglass_light_to_filament), &lighting, model, 30.0f);
  fills(NAMED(sandglass_light_to_arkit), &lighting, model);
  fills(NAMED(sandglass_light_to_arcore), &lighting, model);
  fills(NAMED(sandglass_light_to_unity), &lighting, model);
  fills(NAMED(sandglass_light_of_harmonics), &harmonics);
  row(NAMED(sandglass_harmonics_turn), "", sh, point, turned);
  const uint64_t saved_bytes = sandglass_room_save_bytes(room);
  std::vector<uint64_t> saved(saved_bytes / 8);
  row(NAMED(sandglass_room_save), "", room, static_cast<void*>(saved.data()), saved_bytes, &need);
  row(NAMED(sandglass_room_restore), "", room, static_cast<const void*>(saved.data()), saved_bytes);
  EXPECT_TRUE(block.guards_intact());
}

void Arguments::reliefs() {
  sandglass_relief_desc desc_of = sandglass::relief_desc();
  GuardedBlock block{0};
  sandglass_relief* const relief = MADE(sandglass_relief, &block, &desc_of);
  const float level[4] = {0, 0, 0, 1};
  row(NAMED(sandglass_relief_set_plane), "", relief, point, level);
  sandglass_depth_image image = sandglass::depth_image();
  const std::vector<uint16_t> pixels(12, 500);
  image.width = 4;
  image.height = 3;
  image.depth = pixels.data();
  image.stride = 8;
  image.focal_x = image.focal_y = 3;
  row(NAMED(sandglass_relief_set_image), "taken", relief, &image, &taken);
  const sandglass_cast_mesh nothing = sandglass::cast_mesh();
  row(NAMED(sandglass_relief_set_meshes), "", relief, &nothing, 1u);
  const float square[8] = {-1, -1, 1, -1, 1, 1, -1, 1};
  const uint32_t corners = 4;
  row(NAMED(sandglass_relief_set_outline), "", relief, square, &corners, 1u);
  row(NAMED(sandglass_relief_run), "", relief, 1u);
  fills(NAMED(sandglass_relief_get_heights), relief);
  sandglass_collider collider = {};
  row(NAMED(sandglass_relief_get_collider), "", relief, &collider);
  row(NAMED(sandglass_relief_save_bytes), "", relief, 1u);
  const uint64_t saved_bytes = sandglass_relief_save_bytes(relief, 1);
  std::vector<uint8_t> saved(saved_bytes);
  row(NAMED(sandglass_relief_save), "", relief, 1u, static_cast<void*>(saved.data()), saved_bytes, &need);
  row(NAMED(sandglass_relief_restore), "", relief, static_cast<const void*>(saved.data()), saved_bytes);
  EXPECT_TRUE(block.guards_intact());
}

void Arguments::shadows() {
  uint64_t file_bytes = 0;
  const std::vector<uint64_t> file = file_of(SANDGLASS_CHAIR_SHADOW, &file_bytes);
  sandglass_shadow_desc desc_of = sandglass::shadow_desc();
  desc_of.asset = file.data();
  desc_of.asset_bytes = file_bytes;
  fills(NAMED(sandglass_shadow_inspect), file.data(), file_bytes);
  GuardedBlock block{0};
  sandglass_shadow* shadow = MADE(sandglass_shadow, &block, &desc_of);
  row(NAMED(sandglass_shadow_set_light), "", shadow, 0u, point, 1.0f);
  row(NAMED(sandglass_shadow_run), "", &shadow, 1u, 1u);
  sandglass_shadow* const with_null[] = {shadow, nullptr};
  EXPECT_EQ(sandglass_shadow_run(with_null, 2, 1), 0u);
  while (sandglass_shadow_run(&shadow, 1, UINT32_MAX) > 0) {
  }
  for (const uint32_t light : {0u, 1u})  // the second does not exist
    fills(NAMED(sandglass_shadow_get_texture), shadow, light);
  std::vector<float> cells(SANDGLASS_LIGHT_CELLS), transfer(9);
  row(NAMED(sandglass_shadow_set_cells), "", shadow, cells.data(), 0.0f);
  while (sandglass_shadow_run(&shadow, 1, UINT32_MAX) > 0) {
  }
  fills(NAMED(sandglass_shadow_get_ambient), shadow);
  row(NAMED(sandglass_shadow_evaluated), "", shadow, 0u);
  row(NAMED(sandglass_shadow_transfer), "normals", file.data(), file_bytes, point, high, 1u, transfer.data());
  std::vector<uint8_t> coverage(256 * 256);
  row(NAMED(sandglass_shadow_resample), "", shadow, 0u, coverage.data(), 128u);
  row(NAMED(sandglass_shadow_combine), "", shadow, coverage.data(), 64u, low, high);
  EXPECT_TRUE(block.guards_intact());
}

void Arguments::casts() {
  sandglass_cast_desc desc_of = sandglass::cast_desc();
  GuardedBlock block{0};
  sandglass_cast* cast = MADE(sandglass_cast, &block, &desc_of);
  sandglass_cast_plane plane = sandglass::cast_plane();
  row(NAMED(sandglass_cast_set_plane), "", cast, &plane);
  sandglass_cast_mesh mesh = sandglass::cast_mesh();
  const float triangle[9] = {0, 1, 0, 1, 1, 0, 0, 1, 1};
  mesh.positions = triangle;
  mesh.vertex_count = 3;
  mesh.triangle_count = 1;
  row(NAMED(sandglass_cast_set_meshes), "", cast, &mesh, 1u);
  row(NAMED(sandglass_cast_set_light), "", cast, high, 0.0f);
  const float cells[SANDGLASS_LIGHT_CELLS] = {};
  row(NAMED(sandglass_cast_set_cells), "", cast, cells);
  row(NAMED(sandglass_cast_run), "", &cast, 1u, 1u);
  while (sandglass_cast_run(&cast, 1, UINT32_MAX) > 0) {
  }
  fills(NAMED(sandglass_cast_get_texture), cast);
  fills(NAMED(sandglass_cast_get_ambient), cast);
  fills(NAMED(sandglass_cast_get_report), cast);
  EXPECT_TRUE(block.guards_intact());
}

void Arguments::pile_shadows() {
  sandglass_pile_shadow_desc desc_of = sandglass::pile_shadow_desc();
  desc_of.sky_texels = 64;
  GuardedBlock block{0};
  sandglass_pile_shadow* const shadow = MADE(sandglass_pile_shadow, &block, &desc_of);
  row(NAMED(sandglass_pile_shadow_set_light), "", shadow, point, 0.0f);
  const float cells[SANDGLASS_LIGHT_CELLS] = {};
  row(NAMED(sandglass_pile_shadow_set_cells), "", shadow, cells);
  const float flat[4] = {};
  const sandglass_heights map = {sizeof map,   {2, 2},    flat, 0.1f, {0, 0, 0}, {0.2f, 0, 0},
                                 {0, 0, 0.2f}, {0, 1, 0}, 1,    {},   {},        1};
  row(NAMED(sandglass_pile_shadow_set_ground), "heights", shadow, &map);
  row(NAMED(sandglass_pile_shadow_run), "", shadow, point, 1u, 0.01f, 1u);
  while (sandglass_pile_shadow_run(shadow, point, 1, 0.01f, UINT32_MAX) > 0) {
  }
  for (const sandglass_pile_shadow_part part : {SANDGLASS_PILE_SHADOW_FLOOR, SANDGLASS_PILE_SHADOW_HEIGHTS})
    fills(NAMED(sandglass_pile_shadow_get_texture), shadow, part);
  uint8_t visibility[1];
  row(NAMED(sandglass_pile_shadow_light_grains), "", shadow, point, 1u, 0.01f, visibility);
  EXPECT_TRUE(block.guards_intact());
}

void Arguments::skins() {
  sandglass_granular_desc granular = {};
  granular.particle_capacity = 100;
  granular.particle_radius = 0.01f;
  granular.collider_capacity = 1;
  sandglass_skin_desc desc_of = sandglass::skin_desc(granular);
  row(NAMED(sandglass_skin_bytes), "", &desc_of, &need);
  ASSERT_EQ(sandglass_skin_bytes(&desc_of, &need, nullptr), SANDGLASS_OK);
  GuardedBlock block(need);
  sandglass_skin* skin = nullptr;
  row(NAMED(sandglass_skin_create), "", &desc_of, block.data(), need, &skin);
  row(NAMED(sandglass_skin_desc_default), "N", &desc_of, &granular);
  ASSERT_NE(skin, nullptr);
  fills(NAMED(sandglass_skin_get_mesh), skin);
  EXPECT_TRUE(block.guards_intact());
}

TEST_F(Arguments, EveryFunctionKeepsTheThreeRules) {
  made_from_defaults();
  scenes();
  sampling();
  fields();
  lights();
  rooms();
  reliefs();
  shadows();
  casts();
  pile_shadows();
  skins();
  for (const Function& function : k_functions)
    EXPECT_EQ(covered_.count(std::string(function.name)), 1u) << function.name << " is not in the table";
  std::printf("%zu functions, %d cases; %d structs; %d blocks\n", covered_.size(), cases_, filled_, blocks_);
  EXPECT_GT(cases_, 200);
  EXPECT_GT(filled_, 15);
  EXPECT_GE(blocks_, 13);
}

TEST_F(Arguments, RegionsLieInTheBlockInOrderAndAligned) {
  desc.granular.emitter_capacity = desc.granular.sink_capacity = 1;  // with all that a scene can have
  ASSERT_TRUE(scene.create(desc));
  std::vector<sandglass_region> regions(sandglass_scene_regions(scene.get(), nullptr, 0));
  ASSERT_FALSE(regions.empty());
  sandglass_scene_regions(scene.get(), regions.data(), static_cast<uint32_t>(regions.size()));
  uint64_t end = 0;
  for (const sandglass_region& region : regions) {
    EXPECT_STRNE(region.name, "");
    EXPECT_EQ(region.offset % SANDGLASS_BLOCK_ALIGNMENT, 0u) << region.name;
    EXPECT_GE(region.offset, end) << region.name;
    end = region.offset + region.bytes;
  }
  EXPECT_EQ(end, sandglass::Scene::bytes(desc)) << "regions are left out: raise k_region_capacity";
  desc.granular.particle_capacity = desc.granular.grain_capacity = desc.granular.boundary_capacity = 0;
  EXPECT_LT(sandglass::Scene::bytes(desc), end / 2) << "what is not wanted has no memory";
}

// The same for pointers within structs: refused by name.
TEST_F(Arguments, PointersWithinStructsFollowTheRule) {
  const auto names = [this](const char* what, sandglass_status status) {
    EXPECT_EQ(status, SANDGLASS_ERROR_INVALID_ARGUMENT) << what;
    EXPECT_NE(std::string(reason).find(what), std::string::npos) << reason;
  };
  sandglass_body body = sandglass::body();
  body.particle_count = 1;
  names("particle_positions", sandglass_scene_add_body(scene.get(), &body, nullptr, &reason));
  body.particle_positions = point;
  body.particle_count = 0;
  names("particle_count", sandglass_scene_add_body(scene.get(), &body, nullptr, &reason));
  sandglass_mesh mesh = k_mesh;
  mesh.vertices = nullptr;
  names("vertices", sandglass_mesh_bounds(&mesh, low, high, &reason));
  mesh = k_mesh;
  mesh.indices = nullptr;
  names("indices", sandglass_mesh_bounds(&mesh, low, high, &reason));
  sandglass_sample_desc sample = sandglass::sample_desc();
  sample.distance = 0.1f;
  names("mesh", sandglass_sample_capacity(&sample, &count, &reason));
  sample.method = SANDGLASS_SAMPLE_VOLUME;
  names("inside", sandglass_sample_capacity(&sample, &count, &reason));
  sandglass_field_desc field = sandglass::field_desc();
  names("distance", sandglass_field_bytes(&field, &need, &reason));
  field.mesh = &k_mesh;
  names("inside", sandglass_field_bytes(&field, &need, &reason));
  field.distance = from_plane;
  names("neither", sandglass_field_bytes(&field, &need, &reason));
  const sandglass_points nowhere = {nullptr, nullptr, 1};
  names("particles.positions", sandglass_scene_add(scene.get(), &nowhere, nullptr, &reason));
  names("grains.positions", sandglass_scene_add(scene.get(), nullptr, &nowhere, &reason));
  const sandglass_shadow_desc shadow_desc = sandglass::shadow_desc();
  names("asset", sandglass_shadow_bytes(&shadow_desc, &need, &reason));
  const sandglass_estimator_desc estimator_desc = sandglass::estimator_desc();
  names("asset", sandglass_estimator_bytes(&estimator_desc, &need, &reason));
  const auto frame_with = [&](uint32_t sandglass_frame_input::*counter) {
    sandglass_frame_input input = sandglass::frame_input();
    input.*counter = 1;
    return sandglass_scene_frame(scene.get(), &input, nullptr, &reason);
  };
  names("input.shadows", frame_with(&sandglass_frame_input::shadow_count));
  names("input.colliders", frame_with(&sandglass_frame_input::collider_count));
  names("input.emitters", frame_with(&sandglass_frame_input::emitter_count));
  names("input.sinks", frame_with(&sandglass_frame_input::sink_count));
  // The number of samples is beyond the capacity too: what is NULL is said first.
  names("positions", sandglass_scene_set_boundary(scene.get(), nullptr, 1000000, &reason));
}

// What is left out is logged as what it is.
TEST_F(Arguments, TheLogNamesTheKindThatWasLeftOut) {
  std::vector<std::string> said;
  const auto write = [](void* user, const char* sentence) {
    static_cast<std::vector<std::string>*>(user)->push_back(sentence);
  };
  desc.log = {write, &said};
  ASSERT_TRUE(scene.create(desc));
  const char* const kinds[3] = {"a collider", "an emitter", "a sink"};
  for (int kind = 0; kind < 3; ++kind) {
    sandglass_frame_input input = sandglass::frame_input();
    const sandglass_collider flat{};  // no shape at all: every number is 0
    const sandglass_emitter closed{};
    input.colliders = input.sinks = &flat;
    input.emitters = &closed;
    *std::array{&input.collider_count, &input.emitter_count, &input.sink_count}[static_cast<size_t>(kind)] = 1;
    said.clear();
    EXPECT_TRUE(scene.frame(input));
    ASSERT_EQ(said.size(), 1u);
    EXPECT_NE(said[0].find(kinds[kind]), std::string::npos) << said[0];
  }
}

}  // namespace sandglass::tests
