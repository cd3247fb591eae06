// A scene file is read completely, or it is refused with one message that names what is wrong.
#include "models/simulation/scene_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "models/files/failure.h"
#include "models/simulation/metrics.h"
#include "models/simulation/scene_fill.h"
#include "models/simulation/scene_meshes.h"

namespace sandglass::host {
namespace {

constexpr const char* k_good = R"({
  "name": "good", "particle_radius": 0.01,
  "bodies": [{"shape": "box", "size": [0.1, 0.2, 0.1], "position": [0, 0.02, 0]}],
  "colliders": [{"shape": "half_space"}]
})";

std::string refusal(const std::string& text) {
  try {
    parse_scene(text, "test.json");
  } catch (const Failure& failure) {
    return failure.what();
  }
  return "";
}

// k_good with its first `from` replaced by `to`.
std::string changed(const std::string& from, const std::string& to) {
  std::string text = k_good;
  text.replace(text.find(from), from.size(), to);
  return text;
}

TEST(SceneFile, ReadsWhatItIsGiven) {
  const SceneFile scene =
      parse_scene(changed("\"name\"", R"("frames": 7, "budget_ms": 2.5, "friction": {"static": 0.3, "kinetic": 0.2},
    "solver": {"scheme": "averaged", "iterations": 7, "relaxation": 1.5, "blend": "source"}, "name")"),
                  "test.json");
  EXPECT_EQ(scene.frames, 7u);
  EXPECT_EQ(scene.budget_ms, 2.5);
  EXPECT_EQ(scene.granular.static_friction, 0.3f);
  EXPECT_EQ(scene.granular.kinetic_friction, 0.2f);
  EXPECT_EQ(scene.granular.reference.scheme, SANDGLASS_SCHEME_AVERAGED);
  EXPECT_EQ(scene.granular.reference.solver_iterations, 7u);
  EXPECT_EQ(scene.granular.reference.relaxation, 1.5f);
  EXPECT_EQ(scene.granular.reference.blend, SANDGLASS_BLEND_SOURCE);
  EXPECT_EQ(scene.bodies.at(0).size.y, 0.2);
  EXPECT_EQ(scene.colliders.at(0).shape, SANDGLASS_SHAPE_HALF_SPACE);
}

// k_good with `from` replaced by `to` must be refused with a message that contains `named`.
struct Refusal {
  std::string from, to, named;
};
Refusal in_scene(const std::string& added, const char* named) { return {"\"name\"", added + ", \"name\"", named}; }
Refusal in_body(const std::string& added, const char* named) {
  return {"\"position\"", added + ", \"position\"", named};
}
Refusal collider(const char* instead, const char* named) { return {R"({"shape": "half_space"})", instead, named}; }

class Refused : public ::testing::TestWithParam<Refusal> {};

TEST_P(Refused, InOneSentenceThatNamesIt) {
  const std::string sentence = refusal(changed(GetParam().from, GetParam().to));
  EXPECT_NE(sentence.find("test.json"), std::string::npos) << sentence;
  EXPECT_NE(sentence.find(GetParam().named), std::string::npos) << sentence;
  EXPECT_EQ(sentence.find('\n'), std::string::npos) << sentence;
}

INSTANTIATE_TEST_SUITE_P(
    Keys, Refused,
    ::testing::Values(
        Refusal{R"("name")", R"("nmae")", R"("nmae")"},
        Refusal{R"("size")", R"("sizes": 1, "size")", R"("bodies[0].sizes")"},
        Refusal{R"("half_space")", R"("halfspace")", R"("colliders[0].shape")"},
        collider(R"({"shape": "sphere"})", R"("colliders[0].size")"),
        collider(R"({"shape": "half_space", "size": 1})", R"("colliders[0].size")"),
        Refusal{R"("half_space")", R"("revolved")", R"("colliders[0].profile")"},
        collider(R"({"shape": "revolved", "profile": [[0, 0], [1, 0], [-1, 1]]})", "profile[2][0]"),
        collider(R"({"shape": "mesh"})", R"("colliders[0].size")"),
        collider(R"({"shape": "mesh", "size": 1, "solid": "both"})", R"("colliders[0].solid")"),
        Refusal{R"("box", "size": [0.1, 0.2, 0.1])", R"("revolved", "profile": [[0, 0], [1, 0], [2, 0]])",
                R"("bodies[0].profile")"},
        in_scene(R"("frames": 100000001)", "is 100000001. It must lie between 1 and 100000000."),
        in_body(R"("rigid": 2, "grains": 10)", R"("bodies[0].grains")"),
        in_body(R"("angular_velocity": [1, 0, 0])", R"("bodies[0].angular_velocity")"),
        collider("7", R"("colliders[0]")"), in_scene(R"("emitters": [{"radius": 0.05}])", R"("particle_capacity")"),
        in_scene(R"("particle_capacity": 10, "emitters": [{}])", R"("emitters[0].radius")"),
        in_scene(R"("particle_capacity": 10, "emitters": [{"radius": 1, "grains_per_particle": 8}])",
                 R"("grain_capacity")"),
        in_scene(R"("sinks": [{"shape": "mesh", "size": 1}])", R"("sinks[0].shape")"),
        in_scene(R"("frames": 0)", R"("frames")"), in_scene(R"("frames": 1.5)", R"("frames")"),
        in_scene(R"("frames": "ten")", R"("frames")"), in_scene(R"("frame_step": 0.2)", R"("frame_step")"),
        in_scene(R"("budget_ms": -1)", R"("budget_ms")"), in_scene(R"("gravity": [0, -9.81])", R"("gravity")"),
        in_scene(R"("gravity": [0, -1e9, 0])", R"("gravity[1]")"), in_scene(R"("budget_ms": 1e999)", "number"),
        in_scene(R"("friction": {"static": -0.1})", R"("friction.static")"),
        in_scene(R"("friction": {"static": 50})",
                 R"(cannot read "test.json": "friction.static" is 50. It must lie between 0 and 10.)"),
        in_scene(R"("friction": {"dynamic": 0.1})", R"("friction.dynamic")"),
        in_scene(R"("solver": {"relaxation": 1.5})", R"("solver.relaxation")"),
        in_scene(R"("solver": {"scheme": "fast"})", R"("solver.scheme")"), in_scene(R"("solver": [])", R"("solver")"),
        Refusal{"0.01", "0", R"("particle_radius")"}, Refusal{"0.01", "null", R"("particle_radius")"},
        Refusal{R"("particle_radius": 0.01,)", "", R"("particle_radius")"},
        Refusal{R"("box")", R"("lattice")", R"("bodies[0].size")"},
        Refusal{R"("box")", R"("cube")", R"("bodies[0].shape")"},
        Refusal{R"("size": [0.1, 0.2, 0.1])", R"("grains": 5)", R"("size")"},
        in_body(R"("spacing": 1.5)", R"("bodies[0].spacing")"),
        in_body(R"("rotation": [0, 0, 0, 0])", R"("bodies[0].rotation")"),
        in_body(R"("grains": 10, "grain_distance": 0.1)", R"("bodies[0].grain_distance")"),
        collider(R"({"shape": "half_space", "motion": [{"start": 2, "end": 1}]})", R"("colliders[0].motion[0].end")"),
        in_scene(R"("camera": {"eye": [0, 1, 0], "target": [0, 0, 0]})", R"("camera.target")"),
        Refusal{R"("bodies": [{)", R"("bodies": [], "x": [{)", R"("x")"},
        Refusal{R"("good",)", R"("good")", "line 2"}));

// It is named where the library refuses it; what stands at the ends of the ranges is taken.
TEST(SceneFile, IsWhatTheLibraryTakes) {
  const std::pair<const char*, const char*> k_parts[] = {
      {R"("gravity": [800, -800, 0])", R"(cannot use "test.json": desc.gravity)"},
      {R"("solver": {"substep_max": 1e-7})", R"(cannot use "test.json": granular.substep_max)"},
      {R"("gravity": [0, -1000, 0], "friction": {"static": 10, "kinetic": 10})", ""},
      {R"("friction": {"static": 0, "kinetic": 0}, "solver": {"substep_max": 1e-6, "courant": 1e-3})", ""},
      {R"("solver": {"substep_max": 0.1, "substep_min": 0.1, "courant": 1, "list_margin": 1, "relaxation": 1})", ""},
      {R"("solver": {"height_weighting": 1.5, "refine_step": 0.1, "iterations": 64, "stabilisation": 8})", ""},
      {R"("solver": {"scheme": "averaged", "relaxation": 2, "refine_step": 1e-4, "list_margin": 0.1})", ""}};
  for (const auto& [part, refused] : k_parts) {
    std::string reason;
    try {
      describe_scene(parse_scene(changed("\"name\"", std::string(part) + ", \"name\""), "test.json"), 1, 0);
    } catch (const Failure& failure) {
      reason = failure.what();
    }
    EXPECT_EQ(reason.substr(0, *refused == 0 ? std::string::npos : std::strlen(refused)), refused) << part;
  }
}

TEST(SceneFile, RefusesWhatIsNoObject) {
  EXPECT_NE(refusal(""), "");
  EXPECT_NE(refusal("[1, 2]"), "");
  EXPECT_NE(refusal("{\"name\": \"a\"}").find("\"bodies\""), std::string::npos);
}

TEST(SceneFile, RefusesACapacityBelowTheNeed) {
  const SceneFile scene = parse_scene(changed("\"name\"", "\"particle_capacity\": 10, \"name\""), "test.json");
  EXPECT_THROW(describe_scene(scene, 11, 0), Failure);
  EXPECT_EQ(describe_scene(scene, 10, 0).granular.particle_capacity, 10u);
}

// The library would leave it out, and pour nothing.
TEST(SceneFile, RefusesANozzleThatTheLibraryDoes) {
  const auto described = [](double radii) {
    SceneFile scene = parse_scene(k_good, "test.json");
    scene.granular.particle_capacity = 9;
    scene.emitters.emplace_back();
    scene.emitters[0].emitter.radius = 0.01f * static_cast<float>(radii);
    return describe_scene(scene, 0, 0);
  };
  EXPECT_NO_THROW(described(1.0));
  EXPECT_NO_THROW(described(100.0));
  EXPECT_THROW(described(0.99), Failure);
  EXPECT_THROW(described(101.0), Failure);
}

TEST(SceneFile, AnEmitterPoursFromItsStartToItsEnd) {
  const SceneFile scene = parse_scene(
      changed("\"name\"",
              R"("particle_capacity": 9, "emitters": [{"radius": 0.05, "speed": 2, "start": 0.1, "end": 0.3}],
    "sinks": [{"shape": "half_space", "position": [0, -1, 0]}], "name")"),
      "test.json");
  EXPECT_TRUE(flow_over_frame(scene, 0.08).emitters.empty());
  ASSERT_EQ(flow_over_frame(scene, 0.2).emitters.size(), 1u);
  EXPECT_EQ(flow_over_frame(scene, 0.2).emitters[0].speed, 2.0f);
  EXPECT_TRUE(flow_over_frame(scene, 0.3).emitters.empty());
  ASSERT_EQ(flow_over_frame(scene, 0.0).sinks.size(), 1u);
  EXPECT_EQ(flow_over_frame(scene, 0.0).sinks[0].position[1], -1.0f);
  EXPECT_EQ(describe_scene(scene, 0, 0).granular.emitter_capacity, 1u);
}

TEST(SceneFile, ACollidersMotionIsTheSumOfItsSegments) {
  ColliderTrack track;
  track.motion.push_back({0.1, 0.3, {1.0, 0.0, 0.0}, {0.0, std::acos(-1.0) * 2.5, 0.0}});
  const sandglass_collider before = collider_over_frame(track, 0.0, 0.1), during = collider_over_frame(track, 0.1, 0.1),
                           after = collider_over_frame(track, 0.5, 0.1);
  EXPECT_EQ(before.position[0], 0.0f);
  EXPECT_EQ(before.linear_velocity[0], 0.0f);
  EXPECT_FLOAT_EQ(during.position[0], 0.1f);
  EXPECT_EQ(during.linear_velocity[0], 1.0f);
  EXPECT_FLOAT_EQ(after.position[0], 0.2f);
  EXPECT_EQ(after.linear_velocity[0], 0.0f);
  EXPECT_NEAR(after.rotation[1], std::sqrt(0.5), 1e-6);  // a quarter of a turn about y
  EXPECT_NEAR(after.rotation[3], std::sqrt(0.5), 1e-6);
}

TEST(SceneFill, MeetsTheWantedNumbersAndKeepsParticlesApart) {
  SceneFile scene = parse_scene(
      R"({"particle_radius": 0.01,
          "bodies": [{"shape": "trefoil", "particles": 800, "grains": 5000, "position": [0, 0.1, 0]}]})",
      "test.json");
  const LoadedMeshes meshes(scene);
  const Material material = fill_scene(&scene, meshes.bodies());
  EXPECT_NEAR(material.particles(), 800.0, 8.0);
  EXPECT_NEAR(material.grains(), 5000.0, 50.0);
  EXPECT_EQ(measure_overlap(material.particle_positions, 0.01).pairs, 0u);
}

TEST(SceneFill, ABodyOfGivenSizeAndNumberSetsTheRadius) {
  SceneFile scene = parse_scene(R"({"bodies": [{"shape": "sphere", "size": 0.5, "particles": 1000}]})", "test.json");
  const Material material = fill_scene(&scene, {});
  EXPECT_NEAR(material.particles(), 1000.0, 10.0);
  EXPECT_NEAR(scene.particle_radius, 0.5 * std::cbrt(0.74 / 1000.0) / 2.0, 0.002);
}

TEST(SceneFill, TheColumnOfTheBenchmarkIsThatOfThePeers) {
  SceneFile scene = load_scene("column14k");
  const Material material = fill_scene(&scene, {});
  ASSERT_EQ(material.particles(), 14280u);
  EXPECT_EQ(material.grains(), 228480u);
  double lowest = 1e9;
  for (size_t i = 1; i < material.particle_positions.size(); i += 3)
    lowest = std::min<double>(lowest, material.particle_positions[i]);
  EXPECT_NEAR(lowest, 0.0102, 1.01e-4);  // 1.02 r, with a jitter of at most 0.01 r
  // Neighbours are 2.02 r apart. Each coordinate has a jitter of up to 0.01 r, so two come closer by at most
  // 0.02 sqrt(3) r.
  EXPECT_LT(measure_overlap(material.particle_positions, 0.01).max, 0.0147);
}

TEST(SceneFill, IsTheSameToTheBitEveryTime) {
  const auto fill = [] {
    SceneFile scene = parse_scene(
        R"({"particle_radius": 0.02, "bodies": [{"shape": "trefoil", "size": 0.6, "grains": 2000, "jitter": 0.01,
            "rotation": {"axis": [1, 2, 3], "degrees": 40}}]})",
        "test.json");
    const LoadedMeshes meshes(scene);
    return fill_scene(&scene, meshes.bodies());
  };
  const Material first = fill(), second = fill();
  EXPECT_EQ(first.particle_positions, second.particle_positions);
  EXPECT_EQ(first.grain_positions, second.grain_positions);
}

TEST(SceneFill, RefusesAMeshBodyWithoutAMesh) {
  SceneFile scene = parse_scene(R"({"particle_radius": 0.01, "bodies": [{"shape": "mesh", "size": 1}]})", "test.json");
  EXPECT_THROW(fill_scene(&scene, {}), Failure);
}

TEST(SceneFill, RefusesABodySmallerThanAParticle) {
  SceneFile scene =
      parse_scene(R"({"particle_radius": 5, "bodies": [{"shape": "sphere", "size": 0.001}]})", "test.json");
  EXPECT_THROW(fill_scene(&scene, {}), Failure);
}

// A cylinder of radius 1 and height 2, made by turning its outline about the axis. The side on the axis is no surface.
TEST(Revolved, DistanceOfACylinder) {
  const Profile outline = {{0, 0}, {1, 0}, {1, 2}, {0, 2}};
  EXPECT_DOUBLE_EQ(revolved_distance(outline, {0, 1, 0}), -1.0);
  EXPECT_DOUBLE_EQ(revolved_distance(outline, {0.3, 1.9, 0.4}), -(2.0 - 1.9));
  EXPECT_NEAR(revolved_distance(outline, {3, 1, 4}), 4.0, 1e-12);
  EXPECT_NEAR(revolved_distance(outline, {0, 5, 0}), 3.0, 1e-12);
  EXPECT_NEAR(revolved_distance(outline, {4, 6, 0}), 5.0, 1e-12);  // 3 and 4 away from the edge
}

}  // namespace
}  // namespace sandglass::host
