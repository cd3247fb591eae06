#include "models/compositing/phone.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/lighting/room_light.h"
#include "models/rooms/excerpt.h"
#include "models/work/random.h"
#include "sandglass/camera.h"

namespace sandglass::host {

namespace {

constexpr double k_diagonal_deg = 75.0;
constexpr double k_key = 0.2;       // the mean of a picture that the camera exposed by itself
constexpr double k_sway_deg = 4.0;  // of a hand, standard deviation
constexpr double k_short = 1.0 / 64, k_shorter = 1.0 / 4096;
constexpr uint64_t k_sway_stream = 97;

double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }

}  // namespace

double exposed_by_itself(const RadianceMap& view) {
  double low = 1e-6, high = 1e6;
  for (int step = 0; step < 40; ++step) {
    const double middle = std::sqrt(low * high);
    double sum = 0;
    int count = 0;
    for (int v = 0; v < view.height; v += 3)
      for (int u = 0; u < view.width; u += 3, ++count) sum += std::min(1.0, luminance(view.colour(u, v)) * middle);
    (sum / count < k_key ? low : high) = middle;
  }
  return std::sqrt(low * high);
}

RadianceMap view_of(const RadianceMap& panorama, const ShotCamera& camera, int width, int height) {
  RadianceMap view(width, height);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) view.set(u, v, look_up(panorama, camera.ray(u + 0.5, v + 0.5, width, height)));
  return view;
}

PhoneImage take_image(const RadianceMap& panorama, const ShotCamera& camera, int width, int height, double factor) {
  const RadianceMap view = view_of(panorama, camera, width, height);
  const double exposure = exposed_by_itself(view) * factor;
  PhoneImage taken = {picture_of(view, exposure), exposure, {}};
  taken.image = camera_image_of(taken.picture, k_diagonal_deg);
  taken.image.focal_x = taken.image.focal_y = static_cast<float>(camera.focal * height);
  camera.pose(&taken.image);
  return taken;
}

ShotCamera session_camera(double azimuth, const SessionImage& image, Vec3 eye) {
  // A turn to the left, seen from above, takes +x to -z: it lowers the azimuth that runs from +x to +z.
  const double around = azimuth - radians(image.yaw_deg), above = radians(image.pitch_deg);
  ShotCamera camera;
  camera.eye = eye;
  camera.forward = {std::cos(above) * std::cos(around), std::sin(above), std::cos(above) * std::sin(around)};
  camera.right = {-std::sin(around), 0, std::cos(around)};
  camera.up = cross(camera.right, camera.forward);
  camera.focal = focal_length(k_session_width, k_session_height, k_diagonal_deg) / k_session_height;
  return camera;
}

const char* session_name(Session session) {
  constexpr const char* k_names[] = {"nothing seen",
                                     "one image of a table",
                                     "the table from all sides",
                                     "table, 60 degrees aside and a glance up",
                                     "a full turn",
                                     "a full turn, some images short",
                                     "everything, some images short",
                                     "a full turn, some images short, some shorter",
                                     "everything, some images short, some shorter"};
  return k_names[static_cast<int>(session)];
}

std::vector<SessionImage> session_images(Session session, uint64_t seed) {
  std::vector<SessionImage> images;
  const auto add = [&](double yaw, double pitch, double exposure = 1.0) { images.push_back({yaw, pitch, exposure}); };
  switch (session) {
    case Session::nothing:
      break;
    case Session::table:
      add(0, -35);
      break;
    case Session::around_table:
      for (int i = 0; i < 18; ++i) add(20.0 * i - 180.0, -35);
      break;
    case Session::glance:
      for (int i = 0; i <= 6; ++i) add(20.0 * i - 60.0, -35);
      for (int i = 0; i <= 6; ++i) add(60.0 - 20.0 * i, i % 2 == 0 ? 0.0 : 15.0);
      break;
    case Session::full_turn:
    case Session::full_turn_short:
    case Session::full_turn_shorter:
      for (int i = 0; i < 24; ++i) {
        const bool some = session != Session::full_turn && i % 4 == 1;
        const bool others = session == Session::full_turn_shorter && i % 4 == 3;
        add(15.0 * i, i % 2 == 0 ? 0.0 : 20.0, some ? k_short : others ? k_shorter : 1.0);
      }
      break;
    case Session::everything:
    case Session::everything_shorter:
      for (int ring = 0; ring < 4; ++ring)
        for (int i = 0; i < 12; ++i) {
          const double pitch[4] = {-40, 0, 40, 80};
          add(30.0 * i, pitch[ring]);
          add(30.0 * i, pitch[ring], k_short);
          if (session == Session::everything_shorter) add(30.0 * i, pitch[ring], k_shorter);
        }
      break;
  }
  Random random = random_stream(seed, k_sway_stream);
  for (SessionImage& image : images) {
    image.yaw_deg += k_sway_deg * normal_deviate(&random);
    image.pitch_deg = std::clamp(image.pitch_deg + k_sway_deg * normal_deviate(&random), -85.0, 85.0);
  }
  return images;
}

}  // namespace sandglass::host
