// A session of an app, simulated in a panorama: a phone looks around (phone.h), and the library's room looks on.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "models/compositing/phone.h"
#include "models/compositing/surroundings.h"
#include "models/lighting/room_light.h"
#include "runtime/light/room/room.h"

namespace sandglass::host {

struct SessionOptions {
  double azimuth = 0.0;        // radians in the panorama: where the table is
  bool exposure_known = true;  // whether the app says how the images were exposed
  uint64_t seed = 1;
  bool guarded = true;       // whether dark parts of short images teach nothing; else a control
  bool reflections = false;  // whether the room keeps texels
  double shortest = 0;       // no image is exposed for less of the time
};

// What the room has seen after the session. Its sphere has radius 1 about the panorama's centre; its world is the
// panorama's. `exposure` is that of the last image: its pixel is radiance times it. Where nothing was seen it is what
// the camera would choose for the table.
struct SeenRoom {
  Room room;
  double exposure = 1.0;
  std::shared_ptr<std::vector<RoomTexel>> texels;  // the room's, if any
};
SeenRoom look_around(const RadianceMap& panorama, Session session, const SessionOptions& options);

// What a session of a phone, and one image where there is an estimate, tell of the light at the chair, in the picture's scale.
ShotLight light_of_session(const Surroundings& room, Session session, const SessionOptions& options,
                           const sandglass_estimator_light* estimate = nullptr);

// The library's part that a direction so many turns about y and `up` lies in.
uint32_t part_at(double turns, double up);
// The panorama's radiance in each part of a room, and the room as it would be had the camera shown more.
using PartRadiance = std::array<Vec3, k_room_parts>;
PartRadiance true_parts(const RadianceMap& panorama);
enum class Known { clipped_light, unseen_parts };
Room with_known(const SeenRoom& seen, const PartRadiance& truth, Known known);

// What the network of estimator.h makes of the one image of a table, in the panorama's frame.
sandglass_estimator_light estimate_of_table(const RadianceMap& panorama, const SessionOptions& options,
                                            RoomLight* network);

}  // namespace sandglass::host
