// `sandglass verify room`: the light of rooms as sessions have seen them, against the light that is there.
#include <cstdio>
#include <filesystem>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/laboratory/room/room_study.h"
#include "models/lighting/dataset.h"
#include "models/mesh/generated.h"
#include "models/program/commands.h"
#include "models/program/verify.h"
#include "models/work/progress.h"

namespace sandglass::host {

#ifndef SANDGLASS_HAVE_EMBREE

int verify_room_command(const VerifyOptions&) {
  throw Failure("cannot check rooms: this build lacks Embree. Install it, configure and build again.");
}

#else

namespace {

// The chair, an armadillo where the data folder has one, and two made by formula.
std::vector<FloorObject> objects_of(ThreadPool* pool) {
  std::vector<std::pair<std::string, Mesh> > meshes = {{"chair", make_named("chair").mesh}};
  const std::string armadillo = data_folder() + "/meshes/armadillo.obj";
  if (!data_folder().empty() && std::filesystem::exists(armadillo))
    meshes.emplace_back("armadillo", load_mesh(armadillo).mesh);
  meshes.emplace_back("trefoil", make_named("trefoil").mesh);
  meshes.emplace_back("bucket", make_named("bucket").mesh);
  std::vector<FloorObject> objects;
  for (const auto& [name, mesh] : meshes) objects.emplace_back(name, mesh, objects.size() + 1, pool);
  return objects;
}

void print_model(const char* name, const RoomModel& m) {
  std::printf(
      "%s: boost %.3f, fill %.3f, network %.3f, fill_below %.3f, albedo %.3f, floor_trust %.3f, unseen_level %.3f\n",
      name, m.boost, m.fill, m.network, m.fill_below, m.albedo, m.floor_trust, m.unseen_level);
}

}  // namespace

int verify_room_command(const VerifyOptions& options) {
  listen_for_interrupt();
  RoomStudyOptions study_options;
  if (options.panoramas.empty() && data_folder().empty()) throw no_panoramas("rooms");
  study_options.panoramas = options.panoramas.empty()
                                ? find_panoramas({data_folder() + "/hdri/indoor", data_folder() + "/hdri/studio"})
                                : find_panoramas(options.panoramas);
  refuse_equal_stems(study_options.panoramas);
  study_options.manifest =
      options.manifest.empty() && options.panoramas.empty() ? data_folder() + "/manifest.csv" : options.manifest;
  study_options.network = options.network.empty() ? SANDGLASS_LIGHTS_DIR "/room.light" : options.network;
  study_options.place = options.place, study_options.exposure_known = !options.untold;
  study_options.azimuths = options.quick ? 1 : 4;
  study_options.seed = options.seed + 1, study_options.threads = options.threads;
  ThreadPool pool(options.threads);
  const RoomStudy study = study_rooms(study_options, objects_of(&pool));
  if (interrupted()) return k_exit_interrupted;

  std::vector<RoomModel> models = {k_room_model};
  if (!options.quick) {
    models.clear();
    Progress progress("fitting", k_room_folds);
    for (int fold = 0; fold < k_room_folds && !interrupted(); ++fold) {
      models.push_back(fit_room_model(study, fold, &pool));
      progress.done(static_cast<uint64_t>(fold) + 1);
    }
    if (interrupted()) return k_exit_interrupted;
  }
  for (size_t fold = 0; fold < models.size() && !options.quick; ++fold)
    print_model(("without fold " + std::to_string(fold)).c_str(), models[fold]);
  print_model("shipped", k_room_model);

  const RoomTable table = room_table(study, models);
  const std::string markdown = room_markdown(table);
  std::printf("%zu places\n\n%s\n", table.places, markdown.c_str());
  const std::vector<Verdict> verdicts = room_verdicts(table);
  print_verdicts(verdicts);
  const uint32_t failed = count_failed(verdicts);
  std::printf("%zu rows, %u failed\n", verdicts.size(), failed);
  if (!options.json.empty())
    write_file(options.json, measurements_json(measurements_of("room", "automatic", options.threads, verdicts)));
  if (!options.out.empty()) {
    make_folder(options.out);
    write_verdicts(options.out, verdicts);
    write_file(options.out + "/rooms.md", markdown);
  }
  return failed > 0 ? k_exit_check_failed : k_exit_done;
}

#endif

}  // namespace sandglass::host
