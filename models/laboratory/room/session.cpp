#include "models/laboratory/room/session.h"

namespace sandglass::host {

SeenRoom look_around(const RadianceMap& panorama, Session session, const SessionOptions& options) {
  SeenRoom seen = {};
  Room* room = &seen.room;
  room->radius = 1.0, room->half_life = 1e6, room->interval_ns = 0;
  room_reset(room);
  uint64_t time_ns = 0;
  for (const SessionImage& image : session_images(session, options.seed)) {
    PhoneImage shot =
        take_image(panorama, session_camera(options.azimuth, image), k_session_width, k_session_height, image.exposure);
    shot.image.timestamp_ns = time_ns += 100'000'000;
    shot.image.exposure = options.exposure_known ? static_cast<float>(shot.exposure) : 0.0f;
    (void)room_take_image(room, shot.image);
    while (room->phase != RoomPhase::idle) room_run_unit(room);
    seen.exposure = shot.exposure;
  }
  return seen;
}

sandglass_light_estimate estimate_of_table(const RadianceMap& panorama, const SessionOptions& options,
                                           RoomLight* network) {
  const SessionImage image = session_images(Session::table, options.seed).front();
  const PhoneImage shot = take_image(panorama, session_camera(options.azimuth, image), 4 * k_session_width,
                                     4 * k_session_height, image.exposure);
  return network->estimate(shot.image);
}

}  // namespace sandglass::host
