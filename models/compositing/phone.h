// A phone that is held upright in a panorama and turned: where it looks in a session of an app, and the images that it
// takes. Its camera exposes by itself, clips, and rounds to bytes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "models/compositing/shot_camera.h"
#include "models/files/image.h"
#include "models/rooms/panorama.h"
#include "sandglass/camera.h"

namespace sandglass::host {

// What a camera sees: radiance.
RadianceMap view_of(const RadianceMap& panorama, const ShotCamera& camera, int width, int height);
// The exposure by which a view's mean luminance, clipped pixels and all, is a fifth of white.
double exposed_by_itself(const RadianceMap& view);

// An image as a phone takes it: exposed by itself times `factor`, clipped, and rounded to bytes.
struct PhoneImage {
  Picture picture;
  double exposure;               // a pixel is radiance times it
  sandglass_camera_image image;  // refers to the picture
};
PhoneImage take_image(const RadianceMap& panorama, const ShotCamera& camera, int width, int height,
                      double factor = 1.0);

enum class Session {
  nothing,            // not one image
  table,              // one image of a table
  around_table,       // the table, from all sides; never up
  glance,             // the table, 60 degrees to each side, then a glance up to 15 degrees, as far to each side
  full_turn,          // a full turn, from the horizon to 20 degrees above
  full_turn_short,    // the same, with every fourth image exposed for a 64th of the time
  everything,         // the whole sphere, every other image for a 64th
  full_turn_shorter,  // full_turn_short, with every fourth image for a 4096th besides
  everything_shorter  // everything, with a third image for a 4096th
};
constexpr Session k_sessions[] = {
    Session::nothing,           Session::table,           Session::around_table, Session::glance,
    Session::full_turn,         Session::full_turn_short, Session::everything,   Session::full_turn_shorter,
    Session::everything_shorter};
const char* session_name(Session session);

// Where the camera looks and how it is exposed, beside what it would choose.
struct SessionImage {
  double yaw_deg, pitch_deg;  // against the azimuth of the session, counter-clockwise from above; up is positive
  double exposure;
};
// The seed moves every direction by a few degrees, as a hand would.
std::vector<SessionImage> session_images(Session session, uint64_t seed);

// The camera of a session's image, held upright.
ShotCamera session_camera(double azimuth, const SessionImage& image, Vec3 eye = {});
constexpr int k_session_width = 90, k_session_height = 120;  // pixels; enough for parts of 11 degrees

}  // namespace sandglass::host
