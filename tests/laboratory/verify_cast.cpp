// `sandglass_lab verify cast`: shadows of triangles against rays, on real surfaces too, and reflections against panoramas.
#include <algorithm>

#include "models/compositing/surroundings.h"
#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/lighting/dataset.h"
#include "models/lighting/lit_view.h"
#include "models/mesh/generated.h"
#include "models/program/command_line.h"
#include "models/rooms/panorama_file.h"
#include "models/work/progress.h"
#include "tests/laboratory/room/reflections.h"
#include "tests/laboratory/verify.h"
#ifdef SANDGLASS_HAVE_EMBREE
#include "tests/laboratory/shadow/cast_rows.h"
#include "tests/laboratory/shadow/cast_world.h"
#include "tests/laboratory/shadow/receiver.h"
#endif

namespace sandglass::host {

#ifndef SANDGLASS_HAVE_EMBREE

int verify_cast_command(const VerifyOptions&) {
  throw Failure("cannot check shadows: this build lacks Embree. Install it, configure and build again.");
}

#else

namespace {

constexpr int k_picture_quality = 88;

// Means of pixels. 256 x 128 are as many as the cells of a room can use.
RadianceMap small_panorama(const std::string& path, int width) {
  const RadianceMap whole = read_panorama(path);
  RadianceMap small = shrunk(whole, std::max(1, whole.width / width));
  fill_tripod(&small);
  return small;
}

}  // namespace

int verify_cast_command(const VerifyOptions& options) {
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
  std::vector<RadianceMap> reflected;
  if (!options.panoramas.empty() || !data_folder().empty())
    for (const std::string& path :
         find_panoramas(options.panoramas.empty() ? std::vector<std::string>{data_folder() + "/hdri/indoor"}
                                                  : options.panoramas)) {
      rows.rooms.push_back(small_panorama(path, 256));
      reflected.push_back(small_panorama(path, 512));
      if (options.quick && rows.rooms.size() == 6) break;
    }
  const std::string baked = read_file(SANDGLASS_SHADOWS_DIR "/chair.shadow", "baked shadow");
  rows.baked.assign(baked.begin(), baked.end());
  rows.seed = options.seed;
  rows.quick = options.quick;
  ThreadPool pool(options.threads);
  std::vector<Verdict> verdicts;
  {
    Progress progress("casting and tracing shadows", 1);
    verdicts = verify_casts(rows, pool, [&](size_t done, size_t all) {
      progress.total(all);
      progress.done(done);
      return !interrupted();
    });
  }
  if (!interrupted()) {
    Progress progress("casting in the world", k_cast_worlds);
    size_t done = 0;
    const std::vector<Verdict> more = verify_cast_worlds(options.seed, options.quick, pool, [&] {
      progress.done(++done);
      return !interrupted();
    });
    verdicts.insert(verdicts.end(), more.begin(), more.end());
  }
  if (!interrupted() && !reflected.empty()) {
    Progress progress("reflecting rooms", reflected.size());
    size_t done = 0;
    const std::vector<Verdict> more = verify_reflections(reflected, options.seed, [&] {
      progress.done(done++);
      return !interrupted();
    });
    verdicts.insert(verdicts.end(), more.begin(), more.end());
  }
  if (!interrupted() && !rows.rooms.empty()) {
    std::vector<RadianceMap> some;
    for (size_t i = 0; i < rows.rooms.size(); i += options.quick ? 3 : 4) some.push_back(rows.rooms[i]);
    Progress progress("receiving shadows", some.size());
    size_t done = 0;
    const std::vector<Verdict> more = verify_receivers(some, pool, [&] {
      progress.done(done++);
      return !interrupted();
    });
    verdicts.insert(verdicts.end(), more.begin(), more.end());
  }
  if (interrupted()) return k_exit_interrupted;
  if (!options.picture.empty()) {
    Progress progress("tracing the picture", 1);
    write_file(options.picture, jpeg_file(receiver_picture(kept_room("lebombo"), pool), k_picture_quality));
  }
  return tell(options, "cast", "automatic", verdicts);
}

#endif

}  // namespace sandglass::host
