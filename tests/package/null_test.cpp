// The one rule for NULL, stated at the top of sandglass.h, in every public function: the table below calls each with
// each of its pointers NULL. Functions with a status refuse it and name the argument; functions that return nothing do
// nothing; functions that return a value return the neutral one. What the header calls optional is accepted.
//
// The names of the arguments come from the headers, which also say whether the table is complete.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "sandglass/sandglass.hpp"

namespace {

// ------------------------------------------------------------------------------------------------ the headers

struct Declared {
  std::vector<std::string> arguments;
  bool has_pointers = false;
};

std::map<std::string, Declared> declared_functions() {
  std::string text;
  for (const auto& entry : std::filesystem::directory_iterator(SANDGLASS_HEADERS)) {
    if (entry.path().extension() != ".h") continue;
    std::ifstream file(entry.path());
    text.append(std::istreambuf_iterator<char>(file), {});
  }
  for (size_t at; (at = text.find("/*")) != std::string::npos;) text.erase(at, text.find("*/", at) + 2 - at);
  text = std::regex_replace(text, std::regex("#[^\n]*\n"), "\n");
  std::map<std::string, Declared> functions;
  for (size_t at = 0; (at = text.find("SANDGLASS_API", at)) != std::string::npos; ++at) {
    const std::string declaration = text.substr(at, text.find(';', at) - at);
    const size_t open = declaration.find('('), close = declaration.rfind(')');
    std::smatch name;
    const std::string before = declaration.substr(0, open);
    if (!std::regex_search(before, name, std::regex("sandglass_[a-z0-9_]+$"))) continue;
    Declared& function = functions[name.str()];
    const std::string list = declaration.substr(open + 1, close - open - 1);
    function.has_pointers = list.find_first_of("*[") != std::string::npos;
    const std::regex argument("([a-z0-9_]+)(\\[[A-Z0-9_]*\\])?(,|$)");
    for (std::sregex_iterator i(list.begin(), list.end(), argument), end; i != end; ++i)
      function.arguments.push_back((*i)[1]);
  }
  return functions;
}

// ------------------------------------------------------------------------------------------------ the table

// A function with its name.
#define NAMED(function) #function, function

// What a function is given: everything it needs, so that only the NULL is wrong.
class Nulls : public ::testing::Test {
 protected:
  // A function that returns a status. `optional`: its arguments that may be NULL, apart from `reason`.
  template <class... P, class... A>
  void refuses(const char* name, sandglass_status (*call)(P...), const std::set<std::string>& optional,
               A... arguments) {
    each_null(name, call, std::tuple<P...>(arguments...), [&](const std::string& argument, auto values) {
      const char* said = nullptr;
      constexpr size_t last = sizeof...(P) - 1;
      const bool may_be = optional.count(argument) != 0 || argument == "reason";
      if (argument != "reason") std::get<last>(values) = &said;
      const sandglass_status status = std::apply(call, values);
      EXPECT_EQ(status, may_be ? SANDGLASS_OK : SANDGLASS_ERROR_INVALID_ARGUMENT) << (said != nullptr ? said : "");
      if (may_be) return;
      ASSERT_NE(said, nullptr);
      EXPECT_TRUE(std::regex_search(said, std::regex("\\b" + argument + "\\b"))) << said;
      EXPECT_NE(std::string(said).find("NULL"), std::string::npos) << said;
    });
  }

  // A function that returns a value, or nothing: then `neutral` is not looked at.
  template <class R, class... P, class... A>
  void returns(const char* name, R (*call)(P...), R neutral, const std::set<std::string>& optional, A... arguments) {
    each_null(name, call, std::tuple<P...>(arguments...), [&](const std::string& argument, auto values) {
      const R value = std::apply(call, values);
      if (optional.count(argument) == 0) {
        EXPECT_EQ(value, neutral);
      }
    });
  }
  template <class... P, class... A>
  void does_nothing(const char* name, void (*call)(P...), A... arguments) {
    each_null(name, call, std::tuple<P...>(arguments...),
              [&](const std::string&, auto values) { std::apply(call, values); });
  }

  template <class Call, class Values, class Try>
  void each_null(const char* name, Call, const Values& values, const Try& with_null) {
    covered_.insert(name);
    const auto function = functions_.find(name);
    ASSERT_NE(function, functions_.end()) << name << " is not in the headers";
    ASSERT_EQ(function->second.arguments.size(), std::tuple_size_v<Values>) << name;
    each_null_of(name, function->second.arguments, values, with_null,
                 std::make_index_sequence<std::tuple_size_v<Values>>());
  }
  template <class Values, class Try, size_t... I>
  void each_null_of(const char* name, const std::vector<std::string>& arguments, const Values& values,
                    const Try& with_null, std::index_sequence<I...>) {
    (one_null<I>(name, arguments[I], values, with_null), ...);
  }
  template <size_t I, class Values, class Try>
  void one_null(const char* name, const std::string& argument, Values values, const Try& with_null) {
    if constexpr (std::is_pointer_v<std::tuple_element_t<I, Values>>) {
      SCOPED_TRACE(std::string(name) + " without " + argument);
      std::get<I>(values) = nullptr;
      ++cases_;
      with_null(argument, values);
    }
  }

  void SetUp() override {
    functions_ = declared_functions();
    desc = sandglass::scene_desc();
    desc.granular.particle_capacity = desc.granular.grain_capacity = desc.granular.boundary_capacity = 64;
    desc.granular.body_capacity = 8, desc.granular.body_particle_capacity = 32;
    ASSERT_TRUE(scene.create(desc));
    ASSERT_EQ(sandglass_scene_bytes(&desc, &bytes, nullptr), SANDGLASS_OK);
    spare = sandglass::allocate_block(bytes);
  }

  // A file in words, as the library wants it aligned.
  static std::vector<uint64_t> file_of(const std::string& path, uint64_t* bytes) {
    *bytes = std::filesystem::file_size(path);
    std::vector<uint64_t> words(*bytes / 8 + 1);
    std::ifstream(path, std::ios::binary)
        .read(reinterpret_cast<char*>(words.data()), static_cast<std::streamsize>(*bytes));
    return words;
  }

  void scenes();
  void sampling();
  void fields();
  void lights();
  void shadows();
  void pile_shadows();

  std::map<std::string, Declared> functions_;
  std::set<std::string> covered_;
  int cases_ = 0;

  sandglass_scene_desc desc;
  sandglass::Scene scene;
  uint64_t bytes = 0, need = 0;
  uint32_t count = 0, other = 0;
  const char* reason = nullptr;
  sandglass::Block spare;
  float point[4] = {0.0f, 0.5f, 0.0f, 1.0f}, low[3] = {-0.1f, -0.1f, -0.1f}, high[3] = {0.1f, 0.1f, 0.1f};
};

void Nulls::scenes() {
  sandglass_scene* const s = scene.get();
  sandglass_scene* made = nullptr;
  refuses(NAMED(sandglass_scene_bytes), {}, &desc, &need, &reason);
  refuses(NAMED(sandglass_scene_create), {}, &desc, spare.get(), bytes, &made, &reason);
  does_nothing(NAMED(sandglass_scene_desc_default), &desc);
  does_nothing(NAMED(sandglass_scene_reset), s);
  refuses(NAMED(sandglass_scene_move), {"rotation", "translation"}, s, point, low, &reason);
  std::vector<uint8_t> saved(1 << 20);
  uint64_t written = 0;
  returns(NAMED(sandglass_scene_save_bytes), uint64_t{0}, {}, s);
  refuses(NAMED(sandglass_scene_save), {}, s, saved.data(), uint64_t{saved.size()}, &written, &reason);
  refuses(NAMED(sandglass_scene_restore), {}, s, saved.data(), written, &reason);
  sandglass_region region;
  returns(NAMED(sandglass_scene_regions), 0u, {"regions"}, s, &region, 1u);
  returns(NAMED(sandglass_scene_isa), sandglass_isa{SANDGLASS_ISA_AUTOMATIC}, {}, s);
  returns(NAMED(sandglass_scene_hash), uint64_t{0}, {}, s);
  refuses(NAMED(sandglass_granular_add), {"particle_velocities", "grain_velocities"}, s, point, low, 1u, point, low, 1u,
          &reason);
  const sandglass_collider ball = sandglass::sphere(5.0f, 5.0f, 5.0f, 0.1f);
  refuses(NAMED(sandglass_granular_remove), {"particles", "grains"}, s, &ball, &count, &other, &reason);
  sandglass_body body;
  sandglass_body_default(&body);
  body.particle_positions = point, body.particle_count = 1;
  refuses(NAMED(sandglass_granular_add_body), {"index"}, s, &body, &count, &reason);
  does_nothing(NAMED(sandglass_body_default), &body);
  const float half[3] = {0.02f, 0.02f, 0.02f};
  float points[64 * 3];
  refuses(NAMED(sandglass_body_box_count), {}, half, 0.01f, &count, &reason);
  refuses(NAMED(sandglass_body_box), {"rotation"}, half, 0.01f, low, point, 1.0f, points, 64u, &body, &reason);
  sandglass_body_pose pose = sandglass_granular_body_pose(s, 0);
  sandglass_collider collider = {};
  does_nothing(NAMED(sandglass_body_box_collider), &pose, half, point, &collider);
  returns(NAMED(sandglass_rotation_about), int32_t{0}, {}, low, 1.0f, points);
  covered_.insert("sandglass_granular_body_pose"), ++cases_;
  pose = sandglass_granular_body_pose(nullptr, 0);
  EXPECT_EQ(pose.rotation[3], 1.0f);
  EXPECT_EQ(pose.position[1], 0.0f);
  refuses(NAMED(sandglass_granular_set_boundary), {}, s, low, 1u, &reason);
  refuses(NAMED(sandglass_granular_set_friction), {}, s, 0.2f, 0.2f, &reason);
  sandglass_frame_input input = sandglass::frame_input();
  sandglass_frame_report report = sandglass::frame_report();
  does_nothing(NAMED(sandglass_frame_input_default), &input);
  input.time_step = 0.01f;
  refuses(NAMED(sandglass_scene_frame), {"report"}, s, &input, &report, &reason);
  does_nothing(NAMED(sandglass_granular_particles), s, points, points);
  does_nothing(NAMED(sandglass_granular_grains), s, points, points);
}

constexpr float k_vertices[] = {0, -0.05f, 0, 0.05f, 0, 0, 0, 0, 0.05f, 0, 0.05f, 0};
constexpr uint32_t k_indices[] = {0, 1, 2, 3, 2, 1, 0, 3, 1, 0, 2, 3};
constexpr sandglass_mesh k_mesh = {k_vertices, 4, k_indices, 4};

int in_ball(void*, const float p[3]) { return p[0] * p[0] + p[1] * p[1] + p[2] * p[2] < 0.0064f ? 1 : 0; }
float from_plane(void*, const float p[3]) { return std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) - 0.05f; }

void Nulls::sampling() {
  std::vector<float> points(3 * 4096);
  sandglass_sample_options options;
  does_nothing(NAMED(sandglass_sample_options_default), &options);
  sandglass_sample_options_default(&options);
  refuses(NAMED(sandglass_sample_disk), {}, 1.0f, 8u, points.data(), &reason);
  refuses(NAMED(sandglass_sample_sphere), {}, 1.0f, 8u, points.data(), &reason);
  refuses(NAMED(sandglass_sample_ring), {}, 1.0f, 0.5f, 1.0f, 8u, points.data(), &reason);
  refuses(NAMED(sandglass_mesh_bounds), {}, &k_mesh, low, high, &reason);
  double number = 0.0;
  refuses(NAMED(sandglass_mesh_area), {}, &k_mesh, &number, &reason);
  refuses(NAMED(sandglass_mesh_winding_number), {}, &k_mesh, point, &number, &reason);
  const sandglass_inside_rule rule = SANDGLASS_INSIDE_WINDING;
  refuses(NAMED(sandglass_mesh_inside_bytes), {}, &k_mesh, rule, &need, &reason);
  const sandglass::Block block = sandglass::allocate_block(1 << 20);
  sandglass_mesh_inside* inside = nullptr;
  refuses(NAMED(sandglass_mesh_inside_create), {}, &k_mesh, rule, block.get(), uint64_t{1 << 20}, &inside, &reason);
  returns(NAMED(sandglass_mesh_inside_test), 0, {}, inside, point);

  for (int k = 0; k < 3; ++k) low[k] = -0.1f, high[k] = 0.1f;
  const float d = 0.02f;
  const sandglass::Block scratch = sandglass::allocate_block(1 << 22);
  refuses(NAMED(sandglass_sample_surface_capacity), {"options"}, &k_mesh, d, &options, &count, &reason);
  refuses(NAMED(sandglass_sample_surface_bytes), {"options"}, &k_mesh, d, &options, 4096u, &need, &reason);
  refuses(NAMED(sandglass_sample_surface), {"options"}, &k_mesh, d, &options, scratch.get(), uint64_t{1 << 22},
          points.data(), 4096u, &count, &reason);
  refuses(NAMED(sandglass_sample_volume_capacity), {}, low, high, d, &count, &reason);
  refuses(NAMED(sandglass_sample_volume_bytes), {}, low, high, d, 4096u, &need, &reason);
  refuses(NAMED(sandglass_sample_volume), {"inside_user", "options"}, low, high, d, in_ball, points.data(), &options,
          scratch.get(), uint64_t{1 << 22}, points.data(), 4096u, &count, &reason);
  refuses(NAMED(sandglass_sample_lattice_capacity), {}, low, high, d, &count, &reason);
  refuses(NAMED(sandglass_sample_lattice_bytes), {}, low, high, d, &need, &reason);
  refuses(NAMED(sandglass_sample_lattice), {"inside_user", "options"}, low, high, d, in_ball, points.data(), &options,
          scratch.get(), uint64_t{1 << 22}, points.data(), 4096u, &count, &reason);
  refuses(NAMED(sandglass_sample_power), {}, points.data(), 8u, point, &number, &reason);
  refuses(NAMED(sandglass_sample_spectrum), {}, points.data(), 8u, 10.0f, 1u, 8u, 0, &number, &reason);
}

void Nulls::fields() {
  for (int k = 0; k < 3; ++k) low[k] = -0.1f, high[k] = 0.1f;
  const sandglass_solid solid = SANDGLASS_SOLID_INSIDE;
  refuses(NAMED(sandglass_field_bytes), {}, low, high, 0.01f, &need, &reason);
  const uint64_t room = 1 << 20;
  const sandglass::Block block = sandglass::allocate_block(room);
  sandglass_field* field = nullptr;
  refuses(NAMED(sandglass_field_from_mesh), {"inside_user"}, &k_mesh, in_ball, point, low, high, 0.01f, 0.05f, solid,
          block.get(), room, &field, &reason);
  refuses(NAMED(sandglass_field_from_function), {"user"}, low, high, 0.01f, solid, from_plane, point, block.get(), room,
          &field, &reason);
  float normal[3];
  returns(NAMED(sandglass_field_distance), 0.0f, {"normal"}, field, point, normal);
  returns(NAMED(sandglass_field_bounds), solid, {"bounds_min", "bounds_max"}, field, low, high);
}

void Nulls::lights() {
  uint64_t file_bytes = 0;
  const std::vector<uint64_t> file = file_of(SANDGLASS_ROOM_LIGHT, &file_bytes);
  sandglass_light_desc desc_of = sandglass::light_desc();
  desc_of.asset = file.data(), desc_of.asset_bytes = file_bytes;
  sandglass_light_info info = {};
  info.struct_size = sizeof info;
  refuses(NAMED(sandglass_light_inspect), {}, file.data(), file_bytes, &info, &reason);
  refuses(NAMED(sandglass_light_bytes), {}, &desc_of, &need, &reason);
  ASSERT_EQ(sandglass_light_bytes(&desc_of, &need, nullptr), SANDGLASS_OK);
  const sandglass::Block block = sandglass::allocate_block(need);
  sandglass_light* light = nullptr;
  refuses(NAMED(sandglass_light_create), {}, &desc_of, block.get(), need, &light, &reason);
  does_nothing(NAMED(sandglass_light_desc_default), &desc_of);
  ASSERT_NE(light, nullptr);
  does_nothing(NAMED(sandglass_light_reset), light);
  refuses(NAMED(sandglass_light_turn), {}, light, point, &reason);
  std::vector<uint8_t> pixels(3 * 64 * 48, 100);
  sandglass_camera_image image = sandglass::camera_image();
  image.width = 64, image.height = 48, image.planes[0] = pixels.data(), image.strides[0] = 3 * 64;
  image.focal_x = image.focal_y = 60.0f;
  refuses(NAMED(sandglass_camera_check), {}, &image, &reason);
  refuses(NAMED(sandglass_light_set_image), {"taken"}, light, &image, &count, &reason);
  does_nothing(NAMED(sandglass_camera_image_default), &image);
  float sh[27];
  const float matrix[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  returns(NAMED(sandglass_camera_orientation), int32_t{0}, {}, matrix, sh);
  returns(NAMED(sandglass_light_run), 0u, {}, light, 1u);
  returns(NAMED(sandglass_light_units_left), 0u, {}, light);
  sandglass_light_estimate estimate = {};
  estimate.struct_size = sizeof estimate;
  does_nothing(NAMED(sandglass_light_get_latest), light, &estimate);
  does_nothing(NAMED(sandglass_light_get), light, &estimate);
  sandglass_light_get(light, &estimate);
  returns(NAMED(sandglass_light_hash), uint64_t{0}, {}, light);
  returns(NAMED(sandglass_light_isa), sandglass_isa{SANDGLASS_ISA_AUTOMATIC}, {}, light);
  const sandglass_light_model model = SANDGLASS_LIGHT_MODEL_WHOLE;
  refuses(NAMED(sandglass_light_harmonics), {}, &estimate, model, sh, &reason);
  sandglass_light_filament filament = {};
  sandglass_light_arkit arkit = {};
  sandglass_light_unity unity = {};
  filament.struct_size = sizeof filament, arkit.struct_size = sizeof arkit, unity.struct_size = sizeof unity;
  refuses(NAMED(sandglass_light_to_filament), {}, &estimate, model, 30.0f, &filament, &reason);
  refuses(NAMED(sandglass_light_to_arkit), {}, &estimate, model, &arkit, &reason);
  refuses(NAMED(sandglass_light_to_unity), {}, &estimate, model, &unity, &reason);
  does_nothing(NAMED(sandglass_light_release), light);
  sandglass_light_release(light);
}

void Nulls::shadows() {
  uint64_t file_bytes = 0;
  const std::vector<uint64_t> file = file_of(SANDGLASS_CHAIR_SHADOW, &file_bytes);
  sandglass_shadow_desc desc_of;
  sandglass_shadow_desc_default(&desc_of);
  desc_of.asset = file.data(), desc_of.asset_bytes = file_bytes;
  sandglass_shadow_info info = {};
  info.struct_size = sizeof info;
  refuses(NAMED(sandglass_shadow_inspect), {}, file.data(), file_bytes, &info, &reason);
  refuses(NAMED(sandglass_shadow_bytes), {}, &desc_of, &need, &reason);
  ASSERT_EQ(sandglass_shadow_bytes(&desc_of, &need, nullptr), SANDGLASS_OK);
  const sandglass::Block block = sandglass::allocate_block(need);
  sandglass_shadow* shadow = nullptr;
  refuses(NAMED(sandglass_shadow_create), {}, &desc_of, block.get(), need, &shadow, &reason);
  does_nothing(NAMED(sandglass_shadow_desc_default), &desc_of);
  ASSERT_NE(shadow, nullptr);
  refuses(NAMED(sandglass_shadow_set_light), {}, shadow, 0u, point, 1.0f, &reason);
  returns(NAMED(sandglass_shadow_run), 0u, {}, &shadow, 1u, 1u);
  sandglass_shadow* const with_null[] = {shadow, nullptr};
  EXPECT_EQ(sandglass_shadow_run(with_null, 2, 1), 0u);
  returns(NAMED(sandglass_shadow_units_left), 0u, {}, shadow);
  sandglass_shadow_texture texture = {};
  texture.struct_size = sizeof texture;
  does_nothing(NAMED(sandglass_shadow_get_texture), shadow, 0u, &texture);
  std::vector<uint8_t> coverage(256 * 256);
  refuses(NAMED(sandglass_shadow_resample), {}, shadow, 0u, 128u, coverage.data(), &reason);
  refuses(NAMED(sandglass_shadow_combine), {}, shadow, 64u, coverage.data(), low, high, &reason);
  returns(NAMED(sandglass_shadow_hash), uint64_t{0}, {}, shadow);
  returns(NAMED(sandglass_shadow_isa), sandglass_isa{SANDGLASS_ISA_AUTOMATIC}, {}, shadow);
}

void Nulls::pile_shadows() {
  sandglass_pile_shadow_desc desc_of;
  sandglass_pile_shadow_desc_default(&desc_of);
  desc_of.sky_texels = 64;
  refuses(NAMED(sandglass_pile_shadow_bytes), {}, &desc_of, &need, &reason);
  ASSERT_EQ(sandglass_pile_shadow_bytes(&desc_of, &need, nullptr), SANDGLASS_OK);
  const sandglass::Block block = sandglass::allocate_block(need);
  sandglass_pile_shadow* shadow = nullptr;
  refuses(NAMED(sandglass_pile_shadow_create), {}, &desc_of, block.get(), need, &shadow, &reason);
  does_nothing(NAMED(sandglass_pile_shadow_desc_default), &desc_of);
  ASSERT_NE(shadow, nullptr);
  refuses(NAMED(sandglass_pile_shadow_set_light), {}, shadow, point, &reason);
  const float cells[SANDGLASS_LIGHT_CELLS] = {};
  refuses(NAMED(sandglass_pile_shadow_set_cells), {}, shadow, cells, &reason);
  does_nothing(NAMED(sandglass_pile_shadow_refresh), shadow);
  returns(NAMED(sandglass_pile_shadow_run), 0u, {}, shadow, point, 1u, 0.01f, 1u);
  sandglass_pile_shadow_texture texture = {};
  texture.struct_size = sizeof texture;
  does_nothing(NAMED(sandglass_pile_shadow_get_texture), shadow, &texture);
  sandglass_pile_shadow_sky sky = {};
  sky.struct_size = sizeof sky;
  does_nothing(NAMED(sandglass_pile_shadow_get_sky), shadow, &sky);
  uint8_t visibility[1];
  does_nothing(NAMED(sandglass_pile_shadow_light_grains), shadow, point, 1u, 0.01f, visibility);
  returns(NAMED(sandglass_pile_shadow_hash), uint64_t{0}, {}, shadow);
}

TEST_F(Nulls, EveryFunctionRefusesOrIgnoresEachOfItsPointers) {
  scenes();
  sampling();
  fields();
  lights();
  shadows();
  pile_shadows();
  int missing = 0;
  for (const auto& [name, function] : functions_) {
    if (!function.has_pointers || covered_.count(name) != 0) continue;
    ++missing;
    ADD_FAILURE() << name << " is not in the table";
  }
  EXPECT_EQ(missing, 0);
  RecordProperty("cases", cases_);
  std::printf("%zu functions, %d cases\n", covered_.size(), cases_);
  EXPECT_GT(cases_, 200);
}

// The same for pointers within structs: refused by name.
TEST_F(Nulls, PointersWithinStructsFollowTheRule) {
  const auto names = [this](sandglass_status status, const char* what) {
    return status == SANDGLASS_ERROR_INVALID_ARGUMENT && std::string(reason).find(what) != std::string::npos;
  };
  sandglass_body body;
  sandglass_body_default(&body);
  body.particle_count = 1;
  EXPECT_TRUE(names(sandglass_granular_add_body(scene.get(), &body, nullptr, &reason), "particle_positions"));
  float place[3] = {0, 1, 0};
  body.particle_positions = place, body.particle_count = 0;
  EXPECT_TRUE(names(sandglass_granular_add_body(scene.get(), &body, nullptr, &reason), "particle_count"));
  sandglass_mesh mesh = k_mesh;
  mesh.vertices = nullptr;
  EXPECT_TRUE(names(sandglass_mesh_bounds(&mesh, low, high, &reason), "vertices"));
  mesh = k_mesh, mesh.indices = nullptr;
  EXPECT_TRUE(names(sandglass_mesh_bounds(&mesh, low, high, &reason), "indices"));
  sandglass_shadow_desc shadow_desc;
  sandglass_shadow_desc_default(&shadow_desc);
  EXPECT_TRUE(names(sandglass_shadow_bytes(&shadow_desc, &need, &reason), "asset"));
  const sandglass_light_desc light_desc = sandglass::light_desc();
  EXPECT_TRUE(names(sandglass_light_bytes(&light_desc, &need, &reason), "asset"));

  sandglass_frame_input input = sandglass::frame_input();
  input.shadow_count = 1;
  EXPECT_TRUE(names(sandglass_scene_frame(scene.get(), &input, nullptr, &reason), "input.shadows"));
  input.shadow_count = 0;
  input.collider_count = 1;
  EXPECT_TRUE(names(sandglass_scene_frame(scene.get(), &input, nullptr, &reason), "input.colliders"));
  input.collider_count = 0, input.emitter_count = 1;
  EXPECT_TRUE(names(sandglass_scene_frame(scene.get(), &input, nullptr, &reason), "input.emitters"));
  input.emitter_count = 0, input.sink_count = 1;
  EXPECT_TRUE(names(sandglass_scene_frame(scene.get(), &input, nullptr, &reason), "input.sinks"));
  // The number of samples is beyond the capacity too: what is NULL is said first.
  EXPECT_TRUE(names(sandglass_granular_set_boundary(scene.get(), nullptr, 1000000, &reason), "positions"));
}

// What is left out is logged as what it is.
TEST_F(Nulls, TheLogNamesTheKindThatWasLeftOut) {
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
    input.colliders = input.sinks = &flat, input.emitters = &closed;
    *std::array{&input.collider_count, &input.emitter_count, &input.sink_count}[static_cast<size_t>(kind)] = 1;
    said.clear();
    EXPECT_TRUE(scene.frame(input));
    ASSERT_EQ(said.size(), 1u);
    EXPECT_NE(said[0].find(kinds[kind]), std::string::npos) << said[0];
  }
}

// A far move leaves the coordinate limit; its translation is finite, and the reason must not say otherwise.
TEST_F(Nulls, AFarMoveSaysThatItLeavesTheCoordinateLimit) {
  ASSERT_TRUE(scene.add(sandglass::Points(point, 1)));
  for (const float far : {1500.0f, 5000.0f, 1e30f}) {
    const float translation[3] = {far, 0, 0};
    EXPECT_EQ(sandglass_scene_move(scene.get(), nullptr, translation, &reason), SANDGLASS_ERROR_INVALID_ARGUMENT);
    EXPECT_NE(std::string(reason).find("coordinate limit"), std::string::npos) << far << ": " << reason;
  }
  const float infinite[3] = {1e30f * 1e30f, 0, 0};
  EXPECT_EQ(sandglass_scene_move(scene.get(), nullptr, infinite, &reason), SANDGLASS_ERROR_INVALID_ARGUMENT);
  EXPECT_NE(std::string(reason).find("not finite"), std::string::npos) << reason;
}

}  // namespace
