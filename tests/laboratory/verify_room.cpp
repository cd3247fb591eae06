// `sandglass_lab verify room`: the light of rooms as sessions have seen them, against the light that is there.
#include <cstdio>
#include <memory>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/lighting/dataset.h"
#include "models/program/command_line.h"
#include "models/work/progress.h"
#include "tests/laboratory/verify.h"
#ifdef SANDGLASS_HAVE_EMBREE
#include "tests/laboratory/room/room_study.h"
#endif

namespace sandglass::host {

#ifndef SANDGLASS_HAVE_EMBREE

int verify_room_command(const VerifyOptions&) {
  throw Failure("cannot check rooms: this build lacks Embree. Install it, configure and build again.");
}

#else

namespace {

// The same sessions under other conditions.
std::vector<Condition> conditions_of(RoomStudyOptions options, const RoomStudy& study, ThreadPool* pool) {
  std::vector<Condition> conditions = {{"all rooms", room_table(study, pool)}};
  for (const auto& [name, part] : {std::pair("interiors", "/indoor/"), std::pair("studios", "/studio/")}) {
    const RoomStudy some = rooms_in(study, part);
    if (!some.places.empty() && some.places.size() < study.places.size())
      conditions.push_back({name, room_table(some, pool)});
  }
  options.place = 0.8;
  const RoomStudy far = moved(study, options);
  if (interrupted()) return conditions;
  conditions.push_back({"object at 0.8 radii", room_table(far, pool)});
  options.place = RoomStudyOptions().place;
  options.exposure_known = false;
  const RoomStudy untold = study_rooms(options, study.objects);
  if (!interrupted()) conditions.push_back({"exposure untold", room_table(untold, pool)});
  return conditions;
}

}  // namespace

int verify_room_command(const VerifyOptions& options) {
  RoomStudyOptions study_options;
  if (options.panoramas.empty() && data_folder().empty()) throw no_panoramas("rooms");
  study_options.panoramas = options.panoramas.empty()
                                ? find_panoramas({data_folder() + "/hdri/indoor", data_folder() + "/hdri/studio"})
                                : find_panoramas(options.panoramas);
  refuse_equal_stems(study_options.panoramas);
  study_options.manifest =
      options.manifest.empty() && options.panoramas.empty() ? data_folder() + "/manifest.csv" : options.manifest;
  study_options.network = options.network.empty() ? SANDGLASS_LIGHTS_DIR "/room.light" : options.network;
  study_options.azimuths = options.quick ? 1 : 4;
  study_options.seed = options.seed + 1;
  study_options.threads = options.threads;
  ThreadPool pool(options.threads);
  const RoomStudy study = study_rooms(study_options, std::make_shared<const std::vector<FloorObject> >(
                                                         study_objects(options.meshes, data_folder(), &pool)));
  if (interrupted()) return k_exit_interrupted;
  const std::vector<Condition> conditions = conditions_of(study_options, study, &pool);
  if (interrupted()) return k_exit_interrupted;

  print_room(conditions.front().table);
  const std::vector<Verdict> verdicts = room_verdicts(conditions);
  print_verdicts(verdicts);
  const uint32_t failed = count_failed(verdicts);
  std::printf("%zu rows, %u failed\n", verdicts.size(), failed);
  if (!options.json.empty()) {
    std::vector<Measurement> all = measurements_of("room", "automatic", options.threads, verdicts);
    for (const Measurement& m : room_measurements(conditions)) all.push_back(m);
    write_file(options.json, measurements_json(all));
  }
  return failed > 0 ? k_exit_check_failed : k_exit_done;
}

#endif

}  // namespace sandglass::host
