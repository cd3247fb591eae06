// `sandglass_lab verify room`: the light of rooms as sessions have seen them, against the light that is there.
#include <memory>

#include "models/lighting/dataset.h"
#include "tests/laboratory/verify.h"
#ifdef SANDGLASS_HAVE_EMBREE
#include "tests/laboratory/room/room_study.h"
#endif

namespace sandglass::host {

constexpr const char *k_name = "room",
                     *k_help = "Rooms: the light as a session has seen it, against the light that is there";

#ifndef SANDGLASS_HAVE_EMBREE

Command verify_room_suite() { return {k_name, k_help, {}, {}, {}, k_no_ray_tracer}; }

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
  RoomStudy far = study_rooms(options, study.objects);
  for (StudiedPlace& place : far.places) place.probes.clear();  // nothing depends on where the object stands
  if (interrupted()) return conditions;
  conditions.push_back({"object at 0.8 radii", room_table(far, pool)});
  options.place = RoomStudyOptions().place;
  options.exposure_known = false;
  const RoomStudy exposure_unknown = study_rooms(options, study.objects);
  if (!interrupted()) conditions.push_back({"exposure untold", room_table(exposure_unknown, pool)});
  return conditions;
}

Options options_of(VerifyOptions& o) {
  return {panoramas_option(o, "the interiors and studios of SANDGLASS_DATA_DIR"),
          manifest_option(o),
          network_option(o, "Network that estimates one light"),
          standard("chair, armadillo, trefoil and bucket",
                   {"--mesh", &o.meshes, "MESHES", "Objects on the floor: files, or names of generated meshes"}),
          {"--quick", &o.quick, "", "A quarter of the sessions"},
          seed_option(o.seed, "How the phone sways"),
          threads_option(o.threads),
          json_option(o.json)};
}

int run(const VerifyOptions& options) {
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

}  // namespace

Command verify_room_suite() { return command<VerifyOptions>(k_name, k_help, options_of, run); }

#endif

}  // namespace sandglass::host
