// Whether what is put into a room has the room's colour: a chair and sand, composited and path traced, compared where each
// of them is seen.
#include "tests/laboratory/shot/verify_shot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "models/compositing/light_estimate.h"
#include "models/compositing/surroundings.h"
#include "models/lighting/dataset.h"
#include "models/rooms/panorama_file.h"
#include "runtime/math/random.h"
#include "tests/laboratory/interval.h"
#include "tests/laboratory/room/session.h"
#include "tests/laboratory/shot/shot_stage.h"

namespace sandglass::host {

namespace {

// ---- balls
//
// Three balls, the yardstick of papers on lighting since 2022: a mirror, matte silver and a diffuse one, 32 pixels across,
// in the light that a session knows and in that of the panorama, both at the place of its camera.
constexpr const char* k_ball_names[] = {"a mirror", "matte silver", "diffuse"};
struct BallErrors {
  double rmse = 0, scale_invariant = 0;  // of the truth's root mean square
  double angle_deg = 0;                  // between the colours of a pixel, the mean
};
using ThreeBalls = std::array<BallErrors, 3>;

constexpr int k_across = 32, k_width = 64, k_height = 32;
constexpr double k_silver = 32.0;  // exponent of the lobe about the mirrored ray

RadianceMap coarse(const RadianceMap& panorama) {
  constexpr int k_fine = 4;
  RadianceMap map(k_width, k_height);
  for (int v = 0; v < k_height; ++v)
    for (int u = 0; u < k_width; ++u) {
      Vec3 sum;
      for (int k = 0; k < k_fine * k_fine; ++k)
        sum = sum + look_up(panorama, panorama_direction(u + (k % k_fine + 0.5) / k_fine - 0.5,
                                                         v + (k / k_fine + 0.5) / k_fine - 0.5, k_width, k_height));
      map.set(u, v, sum * (1.0 / (k_fine * k_fine)));
    }
  return map;
}

RadianceMap known_map(const SeenRoom& seen, double azimuth, bool mirrored = false) {
  float parts[k_room_parts][3];
  room_radiance(seen.room, k_room_model, parts);
  return panorama_of(k_width, k_height, [&](Vec3 d) {
    const double around = std::atan2(d.z, d.x), seen_at = mirrored ? 2 * azimuth - around : around;
    return from_floats(parts[part_at(seen_at / (2 * std::numbers::pi) - seen.room.yaw, d.y)]) * (1.0 / seen.exposure);
  });
}

// What the pixels of each ball show, seen from the azimuth's other side.
std::array<std::vector<Vec3>, 3> balls_in(const RadianceMap& map, double azimuth) {
  const Vec3 forward = {std::cos(azimuth), 0, std::sin(azimuth)}, right = {-std::sin(azimuth), 0, std::cos(azimuth)};
  std::array<std::vector<Vec3>, 3> balls;
  for (int i = 0; i < k_across * k_across; ++i) {
    const double x = 2 * (i % k_across + 0.5) / k_across - 1, y = 1 - 2 * (i / k_across + 0.5) / k_across;
    const double depth = 1 - x * x - y * y;
    if (depth <= 0) continue;
    const Vec3 normal = right * x + Vec3{0, y, 0} - forward * std::sqrt(depth);
    const Vec3 reflected = forward - normal * (2 * dot(normal, forward));
    Vec3 silver, diffuse;
    double lobe = 0;
    for (int v = 0; v < k_height; ++v) {
      const double area = pixel_solid_angle(v, k_width, k_height);
      for (int u = 0; u < k_width; ++u) {
        const Vec3 d = panorama_direction(u, v, k_width, k_height);
        const double weight = area * std::pow(std::max(dot(d, reflected), 0.0), k_silver);
        silver = silver + map.colour(u, v) * weight;
        lobe += weight;
        diffuse = diffuse + map.colour(u, v) * (area * std::max(dot(d, normal), 0.0));
      }
    }
    balls[0].push_back(look_up(map, reflected));
    balls[1].push_back(silver * (1 / lobe));
    balls[2].push_back(diffuse * (1 / std::numbers::pi));
  }
  return balls;
}

BallErrors errors_of(const std::vector<Vec3>& truth, const std::vector<Vec3>& shown) {
  double squares = 0, products = 0, own = 0, error = 0, angles = 0;
  for (size_t i = 0; i < truth.size(); ++i) {
    squares += dot(truth[i], truth[i]);
    products += dot(truth[i], shown[i]);
    own += dot(shown[i], shown[i]);
    error += dot(truth[i] - shown[i], truth[i] - shown[i]);
    angles += std::atan2(length(cross(truth[i], shown[i])), dot(truth[i], shown[i]));
  }
  const double best = squares - products * products / std::max(own, 1e-30);  // by the best factor
  return {std::sqrt(error / squares), std::sqrt(std::max(best, 0.0) / squares),
          angles / static_cast<double>(truth.size()) * 180.0 / std::numbers::pi};
}

// `mirrored`: a control, the light that is known is exchanged left and right.
ThreeBalls ball_errors(const RadianceMap& panorama, const SeenRoom& seen, double azimuth, bool mirrored = false) {
  const auto truth = balls_in(coarse(panorama), azimuth), shown = balls_in(known_map(seen, azimuth, mirrored), azimuth);
  ThreeBalls errors;
  for (size_t ball = 0; ball < errors.size(); ++ball) errors[ball] = errors_of(truth[ball], shown[ball]);
  return errors;
}

// ---- colours

constexpr uint64_t k_azimuth_stream = 62;
constexpr double k_infinity = std::numeric_limits<double>::infinity();

// What an app could draw.
enum Method {
  k_true,      // the true light
  k_old_rule,  // control: the true light, with the panorama below the horizon, and nothing lit by itself
  k_session,   // what a session knows whose images are exposed down to 1/4096
  k_session_1024,
  k_session_64,  // the same, down to 1/64
  k_unbaked,     // the true light on an object that does not know what it hides from itself
  k_one_light,   // the network's
  k_methods
};
constexpr const char* k_method_names[k_methods] = {"true light",
                                                   "control: true light by the rule before",
                                                   "a settled session, exposures to 1/4096",
                                                   "a settled session, exposures to 1/1024",
                                                   "a settled session, exposures to 1/64",
                                                   "true light, no bake",
                                                   "one light"};

enum Region { k_chair, k_sides, k_sand, k_regions };
constexpr const char* k_region_names[k_regions] = {"chair", "chair's sides", "sand"};

// What is known when the balls are drawn; the last is a control.
enum BallView { k_from_table, k_from_turn, k_from_everything, k_mirrored, k_ball_views };
constexpr const char* k_ball_view_names[k_ball_views] = {"one image of a table", "a full turn, exposures to 1/64",
                                                         "everything, exposures to 1/4096", "control: that, mirrored"};

struct RoomColours {
  std::string place;
  double level[k_methods][k_regions] = {}, red_over_blue[k_methods][k_regions] = {};  // |ln(composite / truth)|
  ThreeBalls balls[k_ball_views];
};

struct Regions {
  std::vector<size_t> pixels[k_regions];
};

// A side faces away from the vertical by 17 degrees at most.
Regions regions_of(const ShotPicture& picture, const ShotCamera& camera, const ShotPictureOptions& options) {
  constexpr double k_side = 0.3;
  const std::vector<ShotPicture::Seen> seen = picture.seen(camera, options.width, options.height);
  Regions regions;
  for (size_t i = 0; i < seen.size(); ++i) {
    const ShotPicture::Seen& s = seen[i];
    if (s.what == ShotPicture::Seen::object) {
      regions.pixels[k_chair].push_back(i);
      if (std::fabs(s.normal.y) < k_side) regions.pixels[k_sides].push_back(i);
    }
    if (s.what == ShotPicture::Seen::sand) regions.pixels[k_sand].push_back(i);
  }
  return regions;
}

Vec3 mean_of(const RadianceMap& map, const std::vector<size_t>& pixels) {
  Vec3 sum;
  for (const size_t i : pixels) sum = sum + from_floats(map.rgb.data() + 3 * i);
  return sum * (1.0 / static_cast<double>(std::max<size_t>(1, pixels.size())));
}

double log_ratio(double a, double b) {
  constexpr double k_black = 1e-4;
  return std::fabs(std::log(std::max(a, k_black) / std::max(b, k_black)));
}

RoomColours colours_of(const ShotVerdictOptions& options, const ShotStage& stage, const ShotPicture& picture,
                       const ShotPicture& unbaked, size_t index) {
  RoomColours colours;
  const double azimuth = 360.0 * random_stream(index, k_azimuth_stream + options.seed).uniform();
  const Surroundings room = stage.captured(options.panoramas[index], azimuth);
  const ShotCamera camera = resting_camera(*stage.scene.camera);
  const Regions regions = regions_of(picture, camera, options.picture);
  const RadianceMap truth = picture.truth(room, camera, options.picture);
  const auto draw = [&](Method method, const ShotLight& light) {
    ShotPictureOptions drawing = options.picture;
    drawing.lit_by_itself = method != k_old_rule;
    const ShotPicture& drawer = method == k_unbaked ? unbaked : picture;
    const RadianceMap drawn =
        drawer.composite(room, camera, light, stage.shadows_for(light), CastShadow::textures, drawing);
    for (int r = 0; r < k_regions; ++r) {
      const Vec3 a = mean_of(drawn, regions.pixels[r]), b = mean_of(truth, regions.pixels[r]);
      colours.level[method][r] = log_ratio(luminance(a), luminance(b));
      colours.red_over_blue[method][r] = log_ratio(a.x / std::max(a.z, 1e-6), b.x / std::max(b.z, 1e-6));
    }
  };
  const Vec3 ahead = camera.forward;
  const SessionOptions session = {std::atan2(ahead.z, ahead.x), true, mix_bits(options.seed + 1000 * index), true};
  const auto balls = [&](BallView view, Session seen) {
    colours.balls[view] =
        ball_errors(room.panorama, look_around(room.panorama, seen, session), session.azimuth, view == k_mirrored);
  };
  balls(k_from_table, Session::table);
  balls(k_from_turn, Session::full_turn_short);
  balls(k_from_everything, Session::everything_shorter);
  balls(k_mirrored, Session::everything_shorter);
  draw(k_true, room.true_light());
  draw(k_old_rule, scaled(light_of(room.warped, room.view), room.exposure));
  draw(k_session, light_of_session(room, Session::everything_shorter, session));
  SessionOptions longer = session;
  longer.shortest = 1.0 / 1024;
  draw(k_session_1024, light_of_session(room, Session::everything_shorter, longer));
  draw(k_session_64, light_of_session(room, Session::everything, session));
  draw(k_unbaked, room.true_light());
  if (!options.network.empty()) {
    LightEstimate network(options.network, SANDGLASS_ISA_AUTOMATIC);
    network.take(room, camera, 1'000'000);
    network.finish();
    draw(k_one_light, network.light());
  }
  return colours;
}

std::vector<Verdict> judge(const ShotVerdictOptions& options, const std::vector<RoomColours>& rooms) {
  const auto over_places = [&](const std::function<double(const RoomColours&)>& value) {
    std::vector<std::pair<std::string, double>> values;
    for (const RoomColours& room : rooms) values.emplace_back(room.place, value(room));
    return interval_of(place_means(values)).mean;
  };
  std::vector<Verdict> rows;
  const auto add = [&](const std::string& group, const std::string& name, double result, double limit, bool control) {
    const bool within = result <= limit;
    rows.push_back({group, name, "|ln|", 0.0, result, limit, control ? !within : within, control});
  };
  struct Limits {
    double level[k_regions], red_over_blue;
  };
  const auto limits_of = [&](int method) -> Limits {
    switch (method) {
      case k_true:
        return {{0.07, 0.13, 0.08}, 0.03};
      case k_old_rule:  // of what is not sand
        return {{0.07, 0.13, k_infinity}, 0.03};
      case k_session:
        return {{0.12, k_infinity, 0.15}, k_infinity};
      default:
        return {{k_infinity, k_infinity, k_infinity}, k_infinity};
    }
  };
  for (int method = 0; method < k_methods; ++method) {
    if (method == k_one_light && options.network.empty()) continue;
    const Limits limits = limits_of(method);
    const std::string name = std::string(k_method_names[method]) + ", ";
    for (int r = 0; r < k_regions; ++r) {
      const double level = over_places([&](const RoomColours& room) { return room.level[method][r]; });
      add("colour", name + k_region_names[r], level, limits.level[r],
          method == k_old_rule && limits.level[r] < k_infinity);
    }
    const double hue = over_places([&](const RoomColours& room) { return room.red_over_blue[method][k_chair]; });
    add("colour", name + "chair's red over blue", hue, limits.red_over_blue, method == k_old_rule);
  }
  for (int view = 0; view < k_ball_views; ++view)
    for (size_t ball = 0; ball < std::size(k_ball_names); ++ball) {
      const auto mean = [&](double BallErrors::*error, int from) {
        return over_places([&](const RoomColours& room) { return room.balls[from][ball].*error; });
      };
      const std::string name = std::string(k_ball_view_names[view]) + ", " + k_ball_names[ball] + ", ";
      const auto report = [&](const char* what, const char* unit, double value) {
        rows.push_back({"balls", name + what, unit, 0.0, value, k_infinity, true, false});
      };
      const double shape = mean(&BallErrors::scale_invariant, view);
      if (view == k_mirrored) {
        const double limit = mean(&BallErrors::scale_invariant, k_from_everything);
        rows.push_back({"balls", name + "si-RMSE", "of RMS", 0.0, shape, limit, shape > limit, true});
        continue;
      }
      report("RMSE", "of RMS", mean(&BallErrors::rmse, view));
      report("si-RMSE", "of RMS", shape);
      report("RGB angle", "degrees", mean(&BallErrors::angle_deg, view));
    }
  return rows;
}

}  // namespace

std::vector<Verdict> verify_colours(const ShotVerdictOptions& options,
                                    const std::function<bool(size_t done)>& progress) {
  for (const std::string& file : options.panoramas) read_panorama(file);  // a bad one is told at once
  const std::string manifest = read_locations(options.manifest);
  const ShotStage stage;
  const ShotPicture picture(stage.object, stage.sand);
  LitObject plain = stage.object;
  plain.transfer.clear();
  const ShotPicture unbaked(plain, stage.sand);
  std::vector<RoomColours> rooms;
  for (size_t i = 0; i < options.panoramas.size(); ++i) {
    rooms.push_back(colours_of(options, stage, picture, unbaked, i));
    rooms.back().place = location_of(options.panoramas[i], manifest).name;
    if (!progress(i + 1)) return {};
  }
  return judge(options, rooms);
}

}  // namespace sandglass::host
