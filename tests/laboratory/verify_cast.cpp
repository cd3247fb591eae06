// `sandglass_lab verify cast`: shadows of triangles against rays, on real surfaces too, and reflections against panoramas.
#include <algorithm>

#include "models/compositing/surroundings.h"
#include "models/files/atomic_file.h"
#include "models/lighting/dataset.h"
#include "models/lighting/lit_view.h"
#include "models/mesh/generated.h"
#include "models/rooms/panorama_file.h"
#include "tests/laboratory/room/reflections.h"
#include "tests/laboratory/verify.h"
#ifdef SANDGLASS_HAVE_EMBREE
#include "tests/laboratory/shadow/cast_rows.h"
#include "tests/laboratory/shadow/cast_world.h"
#include "tests/laboratory/shadow/receiver.h"
#endif

namespace sandglass::host {

constexpr const char *k_name = "cast", *k_help = "Shadows of triangles on floors, walls and below tables, against rays";

#ifndef SANDGLASS_HAVE_EMBREE

Command verify_cast_suite() { return {k_name, k_help, {}, {}, {}, k_no_ray_tracer}; }

#else

namespace {

// Means of pixels. 256 x 128 are as many as the cells of a room can use.
RadianceMap small_panorama(const std::string& path, int width) {
  const RadianceMap whole = read_panorama(path);
  RadianceMap small = shrunk(whole, std::max(1, whole.width / width));
  fill_tripod(&small);
  return small;
}

Options options_of(VerifyOptions& o) {
  return {standard("chair, and four of SANDGLASS_DATA_DIR",
                   {"--mesh", &o.meshes, "MESHES", "What casts: files, or names of generated meshes"}),
          panoramas_option(o),
          {"--quick", &o.quick, "", "Half of the lights, a quarter of the rooms"},
          seed_option(o.seed, "From where the lights come"),
          threads_option(o.threads),
          json_option(o.json)};
}

CastRowsOptions rows_of(const VerifyOptions& options) {
  CastRowsOptions rows;
  std::vector<std::string> names = options.meshes;
  if (names.empty()) {
    names = {"chair"};
    if (!data_folder().empty())
      for (const char* name : {"armadillo", "wicker_chair", "goathead", "koala_low_resolution"})
        names.push_back(data_folder() + "/meshes/" + name + ".obj");
  }
  for (const std::string& name : names) {
    MeshResult result = named_mesh({name});
    rows.meshes.push_back(
        {stem_of(name), std::move(result.mesh), result.report.watertight() && result.report.oriented()});
  }
  const std::string baked = read_file(SANDGLASS_SHADOWS_DIR "/chair.shadow", "baked shadow");
  rows.baked.assign(baked.begin(), baked.end());
  rows.seed = options.seed;
  rows.quick = options.quick;
  return rows;
}

int run(const VerifyOptions& options) {
  CastRowsOptions rows = rows_of(options);
  std::vector<RadianceMap> reflected, some;
  if (!options.panoramas.empty() || !data_folder().empty())
    for (const std::string& path : panoramas_of(options, "shadows", {"indoor"})) {
      rows.rooms.push_back(small_panorama(path, 256));
      reflected.push_back(small_panorama(path, 512));
      if (options.quick && rows.rooms.size() == 6) break;
    }
  for (size_t i = 0; i < rows.rooms.size(); i += options.quick ? 3 : 4) some.push_back(rows.rooms[i]);
  ThreadPool pool(options.threads);
  std::vector<Verdict> verdicts =
      with_progress("casting and tracing shadows", [&](const auto& go_on) { return verify_casts(rows, pool, go_on); });
  const auto add = [&](const char* what, size_t all, const auto& verify) {
    if (interrupted() || all == 0) return;
    const std::vector<Verdict> more = with_steps(what, all, verify);
    verdicts.insert(verdicts.end(), more.begin(), more.end());
  };
  add("casting in the world", k_cast_worlds,
      [&](const auto& go_on) { return verify_cast_worlds(options.seed, options.quick, pool, go_on); });
  add("reflecting rooms", reflected.size(),
      [&](const auto& go_on) { return verify_reflections(reflected, options.seed, go_on); });
  add("receiving shadows", some.size(), [&](const auto& go_on) { return verify_receivers(some, pool, go_on); });
  if (interrupted()) return k_exit_interrupted;
  return tell(options, "cast", "automatic", verdicts);
}

}  // namespace

Command verify_cast_suite() { return command<VerifyOptions>(k_name, k_help, options_of, run); }

#endif

}  // namespace sandglass::host
