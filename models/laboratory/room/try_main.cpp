#include <cstdio>
#include <cstdlib>
#include "models/laboratory/room/room_study.h"
#include "models/mesh/generated.h"
#include "models/mesh/mesh.h"
using namespace sandglass;
using namespace sandglass::host;
int main(int argc, char** argv) {
  const char* data = "/work/shared/data/";
  ThreadPool pool(2);
  std::vector<FloorObject> objects;
  objects.emplace_back("chair", make_named("chair").mesh, 1, &pool);
  objects.emplace_back("trefoil", make_named("trefoil").mesh, 2, &pool);
  RoomStudyOptions o;
  o.panoramas = {std::string(data) + "hdri/indoor", std::string(data) + "hdri/studio"};
  o.manifest = std::string(data) + "manifest.csv";
  o.threads = 2;
  o.network = "/work/main/models/lights/room.light";
  o.azimuths = argc > 1 ? atoi(argv[1]) : 2; setvbuf(stdout, nullptr, _IOLBF, 0);
  o.place = argc > 3 ? atof(argv[3]) : 0.25;
  o.exposure_known = argc <= 4 || atoi(argv[4]) != 0;
  RoomStudy study = study_rooms(o, std::move(objects));
  std::printf("%zu places\n", study.places.size());
  print_room_table(study, {k_room_model});
  if (argc > 2 && atoi(argv[2])) {
    std::vector<RoomModel> models;
    for (int fold = 0; fold < 5; ++fold) {
      models.push_back(fit_room_model(
          study, k_room_model, [](const StudiedPlace& p, int f) { return p.fold != f; }, fold, &pool));
      const RoomModel& m = models.back();
      std::printf("fold %d boost %.2f fill %.3f albedo %.3f trust %.3f unseen %.3f", fold, m.boost, m.fill, m.albedo,
                  m.floor_trust, m.unseen_level);
      std::printf("\n");
      std::fflush(stdout);
    }
    print_room_table(study, models);
  }
}
