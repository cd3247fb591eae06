// In every shipped scene, no frame has an invalid operation or a division by zero (a trap ends the program), and none
// allocates. A second instruction set repeats the run to the bit from the recorded plans. In a sanitizer build the same
// frames test the code under the sanitizers. Scenes with rigid bodies, with emitters and sinks, and one that falls
// asleep run to their end.
#include <gtest/gtest.h>
#if defined(__x86_64__) && defined(__GLIBC__) && !defined(__clang__)
#include <fenv.h>
#endif

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "models/simulation/scene_fill.h"
#include "models/simulation/scene_meshes.h"
#include "models/simulation/simulation.h"
#include "platform/virtual_clock.h"
#include "tests/counting_allocator.h"

namespace sandglass::host {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t k_frames = 12;
constexpr uint64_t k_budget_ns = 4000000, k_reading_ns = 5000;  // the virtual clock advances by k_reading_ns a reading

// The purpose of some scenes. By their end they must have shown it.
struct Purpose {
  const char* scene;
  uint32_t frames;
  void (*check)(const sandglass_frame_report& last);
};
constexpr Purpose k_purposes[] = {
    {"throw", 400, [](const sandglass_frame_report& last) { EXPECT_LT(last.sand.awake, last.sand.particles / 50); }},
    {"repose", 600,
     [](const sandglass_frame_report& last) {
       EXPECT_EQ(last.sand.awake, 0u);
       EXPECT_EQ(last.sand.awake_grains, 0u);
     }},
    {"pour", 300,
     [](const sandglass_frame_report& last) {
       EXPECT_GT(last.sand.removed_grains, 0u);
       EXPECT_EQ(last.sand.emitted_particles, last.sand.particles + last.sand.removed_particles);
       EXPECT_EQ(last.sand.emitted_grains, last.sand.grains + last.sand.removed_grains);
     }},
};
constexpr uint64_t k_whole_budget_ns = 60000000;

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(fs::path(find_scene("demo")).parent_path()))
    if (entry.path().extension() == ".json") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

// Clang computes both sides of a selection, so traps would mean nothing there.
struct Trapping {
#if defined(__x86_64__) && defined(__GLIBC__) && !defined(__clang__)
  Trapping() {
    feclearexcept(FE_ALL_EXCEPT);
    feenableexcept(FE_INVALID | FE_DIVBYZERO);
  }
  ~Trapping() { fedisableexcept(FE_ALL_EXCEPT); }
#else
  Trapping() {}
  ~Trapping() {}
#endif
  Trapping(const Trapping&) = delete;
  Trapping& operator=(const Trapping&) = delete;
};

class EveryScene : public testing::TestWithParam<std::string> {};

TEST_P(EveryScene, RunsWithoutTrapsAndRepeatsOnAnotherInstructionSet) {
  SceneFile scene = load_scene(GetParam());
  const bool needs_mesh = std::any_of(scene.bodies.begin(), scene.bodies.end(),
                                      [](const Body& body) { return body.shape == BodyShape::mesh; });
  std::string mesh;
  if (needs_mesh) {
    const char* data = std::getenv("SANDGLASS_DATA_DIR");
    if (data == nullptr) GTEST_SKIP() << "needs a mesh: set SANDGLASS_DATA_DIR";
    mesh = (fs::path(data) / "meshes" / "armadillo.obj").string();
    if (!fs::exists(mesh)) GTEST_SKIP() << "SANDGLASS_DATA_DIR has no meshes/armadillo.obj";
  }
  const LoadedMeshes meshes(scene, mesh);
  const Material material = fill_scene(&scene, meshes.bodies());
  const CollisionFields fields(&scene);
  sandglass_scene_desc desc = describe_filled(scene, material);
  const Purpose* purpose = std::find_if(std::begin(k_purposes), std::end(k_purposes),
                                        [](const Purpose& p) { return p.scene == GetParam(); });
  if (purpose == std::end(k_purposes)) purpose = nullptr;
  const uint32_t frames = purpose != nullptr ? purpose->frames : k_frames;
  const uint64_t budget_ns = purpose != nullptr ? k_whole_budget_ns : k_budget_ns;

  std::vector<sandglass_plan> plans;
  std::vector<uint64_t> hashes;
  for (const sandglass_isa isa : {SANDGLASS_ISA_AUTOMATIC, SANDGLASS_ISA_SCALAR}) {
    const bool first = plans.empty();
    VirtualClock clock;
    clock.step_ns = k_reading_ns;
    desc.isa = isa;
    desc.clock = virtual_clock(&clock);
    Simulation simulation(desc);
    simulation.add(material);
    for (uint32_t frame = 0; frame < frames; ++frame) {
      std::vector<sandglass_collider> colliders = colliders_over_frame(scene, frame);
      simulation.flow(flow_over_frame(scene, frame * scene.frame_step));
      add_rigid_shapes(scene, simulation.handle(), scene.frame_step, &colliders);
      sandglass_frame_report report;
      {
        const Trapping trapping;
        start_counting_allocations();
        report = simulation.frame(scene.frame_step, budget_ns, colliders, first ? nullptr : &plans[frame]);
        ASSERT_EQ(stop_counting_allocations(), 0u) << "frame " << frame;
      }
      ASSERT_EQ(report.sand.quarantined, 0u) << "frame " << frame;
      ASSERT_EQ(report.sand.ignored_colliders + report.sand.ignored_emitters + report.sand.ignored_sinks, 0u) << frame;
      if (first) {
        plans.push_back(report.plan);
        hashes.push_back(sandglass_scene_hash(simulation.handle()));
      } else ASSERT_EQ(sandglass_scene_hash(simulation.handle()), hashes[frame]) << "frame " << frame;
      if (purpose != nullptr && frame + 1 == frames) purpose->check(report);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shipped, EveryScene, testing::ValuesIn(scene_names()),
                         [](const auto& scene) { return scene.param; });

}  // namespace
}  // namespace sandglass::host
