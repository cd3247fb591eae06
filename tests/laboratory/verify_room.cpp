// `sandglass_lab verify room`: the light of rooms as sessions have seen them, against the light that is there.
#include <memory>

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
  study_options.panoramas = panoramas_of(options, "rooms");
  refuse_equal_stems(study_options.panoramas);
  study_options.manifest = manifest_of(options);
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
  return tell(options, "room", "automatic", room_verdicts(conditions), room_measurements(conditions));
}

#endif

}  // namespace sandglass::host
