// `sandglass_lab verify anything`: shadows on what stands on a table, against rays, and what layers cost.
#include "models/lighting/lit_view.h"
#include "models/mesh/generated.h"
#include "tests/laboratory/verify.h"
#ifdef SANDGLASS_HAVE_EMBREE
#include "tests/laboratory/shadow/anything.h"
#include "tests/laboratory/shadow/placed.h"
#endif

namespace sandglass::host {

constexpr const char *k_name = "anything", *k_help = "Shadows on books, cups and slopes upon a table, against rays";

#ifndef SANDGLASS_HAVE_EMBREE

Command verify_anything_suite() { return {k_name, k_help, {}, {}, {}, k_no_ray_tracer}; }

#else

namespace {

Options options_of(VerifyOptions& o) {
  return {{"--mesh", &o.meshes, "MESHES",
           "What casts beside chair, bucket and trefoil: files, or names of generated meshes"},
          {"--quick", &o.quick, "", "A quarter of the lights, a third of the places"},
          {"--picture", &o.picture, "FILE",
           "Write a chair in a place here, as JPEG: 4 layers, path traced, the floor's texture"},
          seed_option(o.seed, "Where things stand"),
          threads_option(o.threads),
          json_option(o.json)};
}

int run(const VerifyOptions& options) {
  AnythingOptions anything;
  const auto read = [](const std::string& name) {
    MeshResult result = named_mesh({name});
    const bool closed = result.report.watertight() && result.report.oriented();
    return CastMeshFile{stem_of(name), std::move(result.mesh), closed};
  };
  for (const char* name : {"chair", "bucket", "trefoil"}) anything.meshes.push_back(read(name));
  for (const std::string& name : options.meshes) anything.further.push_back(read(name));
  anything.seed = options.seed;
  anything.quick = options.quick;
  ThreadPool pool(options.threads);
  std::vector<Verdict> rows = with_steps("casting on things", anything_steps(anything),
                                         [&](const auto& go_on) { return verify_anything(anything, pool, go_on); });
  if (interrupted()) return k_exit_interrupted;
  const PlacedOptions placed = {table_meshes(), options.seed, options.quick, options.picture};
  const std::vector<Verdict> pictures = with_steps(
      "tracing a place", k_placed_poses, [&](const auto& go_on) { return verify_placed(placed, pool, go_on); });
  if (interrupted()) return k_exit_interrupted;
  rows.insert(rows.end(), pictures.begin(), pictures.end());
  return tell(options, "anything", "automatic", rows);
}

}  // namespace

Command verify_anything_suite() { return command<VerifyOptions>(k_name, k_help, options_of, run); }

#endif

}  // namespace sandglass::host
