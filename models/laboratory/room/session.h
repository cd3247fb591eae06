// A session of an app, simulated in a panorama: a phone is held upright and turned, its camera exposes by itself, clips
// and rounds to bytes, and the library's room looks on.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "models/lighting/room_light.h"
#include "models/rooms/panorama.h"
#include "runtime/room/room.h"

namespace sandglass::host {

enum class Session {
  nothing,          // not one image
  table,            // one image of a table
  around_table,     // the table, from all sides; never up
  glance,           // the table, 60 degrees to each side, then a glance up to 15 degrees, as far to each side
  full_turn,        // a full turn, from the horizon to 20 degrees above
  full_turn_short,  // the same, with every fourth image exposed for a 64th of the time
  everything        // the whole sphere, every other image for a 64th
};
constexpr Session k_sessions[] = {Session::nothing,   Session::table,           Session::around_table, Session::glance,
                                  Session::full_turn, Session::full_turn_short, Session::everything};
const char* session_name(Session session);

// Where the camera looks and how it is exposed, beside what it would choose.
struct SessionImage {
  double yaw_deg, pitch_deg;  // against the azimuth of the session, counter-clockwise from above; up is positive
  double exposure;
};
// The seed moves every direction by a few degrees, as a hand would.
std::vector<SessionImage> session_images(Session session, uint64_t seed);

struct SessionOptions {
  double azimuth = 0.0;        // radians in the panorama: where the table is
  bool exposure_known = true;  // whether the app says how the images were exposed
  uint64_t seed = 1;
};

// What the room has seen after the session. Its sphere has radius 1 about the panorama's centre; its world is the
// panorama's. `exposure` is that of the last image: its pixel is radiance times it. Where nothing was seen it is what
// the camera would choose for the table.
struct SeenRoom {
  Room room;
  double exposure = 1.0;
};
SeenRoom look_around(const RadianceMap& panorama, Session session, const SessionOptions& options);

// The panorama's radiance in each part of a room, and the room as it would be had the camera shown more.
using PartRadiance = std::array<Vec3, k_room_parts>;
PartRadiance true_parts(const RadianceMap& panorama);
enum class Known { clipped_light, unseen_parts };
Room with_known(const SeenRoom& seen, const PartRadiance& truth, Known known);

// What the network of light.h makes of the one image of a table, in the panorama's frame.
sandglass_light_estimate estimate_of_table(const RadianceMap& panorama, const SessionOptions& options,
                                           RoomLight* network);

}  // namespace sandglass::host
