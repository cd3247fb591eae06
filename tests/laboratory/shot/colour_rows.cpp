#include "tests/laboratory/shot/colour_rows.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "models/compositing/image_errors.h"
#include "models/compositing/light_estimate.h"
#include "models/compositing/surroundings.h"
#include "models/lighting/dataset.h"
#include "models/lighting/lit_view.h"
#include "models/rooms/panorama_file.h"
#include "runtime/core/random.h"
#include "tests/laboratory/interval.h"
#include "tests/laboratory/room/balls.h"
#include "tests/laboratory/room/session.h"
#include "tests/laboratory/shot/shot_stage.h"
#include "tests/laboratory/shot/traced_light.h"

namespace sandglass::host {

namespace {

constexpr uint64_t k_azimuth_stream = 62;
constexpr double k_infinity = std::numeric_limits<double>::infinity();

// What an app could draw.
enum Way {
  k_true,      // the true light
  k_old_rule,  // control: the true light, with the panorama below the horizon, and nothing lit by itself
  k_session,   // what a session knows whose images are exposed down to 1/4096
  k_session_1024,
  k_session_512,
  k_session_64,  // the same, down to 1/64
  k_unbaked,     // the true light on an object that does not know what it hides from itself
  k_no_shadow,   // the session's light, and nothing falls on the floor
  k_one_light,   // the network's
  k_ways
};
constexpr const char* k_way_names[k_ways] = {"true light",
                                             "control: true light by the rule before",
                                             "a settled session, exposures to 1/4096",
                                             "a settled session, exposures to 1/1024",
                                             "a settled session, exposures to 1/512",
                                             "a settled session, exposures to 1/64",
                                             "true light, no bake",
                                             "no shadow",
                                             "one light"};

enum Region { k_chair, k_sides, k_sand, k_floor_near, k_regions };
constexpr const char* k_region_names[k_regions] = {"chair", "chair's sides", "sand", "floor at the contacts"};

// What is known when the balls are drawn; the last is a control.
enum BallWay { k_from_table, k_from_turn, k_from_everything, k_mirrored, k_ball_ways };
constexpr const char* k_ball_ways_names[k_ball_ways] = {"one image of a table", "a full turn, exposures to 1/64",
                                                        "everything, exposures to 1/4096", "control: that, mirrored"};

struct RoomColours {
  std::string place;
  double level[k_ways][k_regions] = {}, red_over_blue[k_ways][k_regions] = {};  // |ln(composite / truth)|
  double flip[k_ways] = {};    // over the pixels that the things change
  double flip_true_means = 0;  // the same for the true light, chair and sand with the mean colours of the truth
  ThreeBalls balls[k_ball_ways];
};

struct Regions {
  std::vector<size_t> pixels[k_regions];
};

// A side faces away from the vertical by 17 degrees at most. The floor at the contacts is that within a fortieth of the
// picture's width of a leg's foot or of the sand.
Regions regions_of(const ShotPicture& picture, const ShotCamera& camera, const ShotPictureOptions& options) {
  constexpr double k_side = 0.3, k_foot = 0.05;  // metres
  const std::vector<ShotPicture::Seen> seen = picture.seen(camera, options.width, options.height);
  const int reach = std::max(2, options.width / 40);
  Regions regions;
  for (int y = 0; y < options.height; ++y)
    for (int x = 0; x < options.width; ++x) {
      const auto i = static_cast<size_t>(y) * static_cast<size_t>(options.width) + static_cast<size_t>(x);
      const ShotPicture::Seen& s = seen[i];
      if (s.what == ShotPicture::Seen::object) {
        regions.pixels[k_chair].push_back(i);
        if (std::fabs(s.normal.y) < k_side) regions.pixels[k_sides].push_back(i);
      }
      if (s.what == ShotPicture::Seen::sand) regions.pixels[k_sand].push_back(i);
      if (s.what != ShotPicture::Seen::floor) continue;
      bool near = false;
      for (int v = std::max(0, y - reach); v <= std::min(options.height - 1, y + reach) && !near; ++v)
        for (int u = std::max(0, x - reach); u <= std::min(options.width - 1, x + reach) && !near; ++u) {
          const ShotPicture::Seen& n =
              seen[static_cast<size_t>(v) * static_cast<size_t>(options.width) + static_cast<size_t>(u)];
          near = n.what == ShotPicture::Seen::sand || (n.what == ShotPicture::Seen::object && n.point.y < k_foot);
        }
      if (near) regions.pixels[k_floor_near].push_back(i);
    }
  return regions;
}

Vec3 mean_of(const RadianceMap& map, const std::vector<size_t>& pixels) {
  Vec3 sum;
  for (const size_t i : pixels) sum = sum + from_floats(map.rgb.data() + 3 * i);
  return sum * (1.0 / static_cast<double>(std::max<size_t>(1, pixels.size())));
}

// The picture with the truth's mean colour of chair and of sand: what no rule for their colour alone can better.
RadianceMap with_means_of(const RadianceMap& truth, RadianceMap picture, const Regions& regions) {
  for (const Region region : {k_chair, k_sand}) {
    const Vec3 right = mean_of(truth, regions.pixels[region]), drawn = mean_of(picture, regions.pixels[region]);
    for (const size_t i : regions.pixels[region]) {
      const Vec3 p = from_floats(picture.rgb.data() + 3 * i);
      to_floats({p.x * right.x / drawn.x, p.y * right.y / drawn.y, p.z * right.z / drawn.z},
                picture.rgb.data() + 3 * i);
    }
  }
  return picture;
}

double apart(double a, double b) {
  constexpr double k_black = 1e-4;
  return std::fabs(std::log(std::max(a, k_black) / std::max(b, k_black)));
}

// FLIP's mean over the pixels that the things change by more than a step of a byte in the truth.
double flip_where_changed(const RadianceMap& empty, const RadianceMap& truth, const RadianceMap& picture) {
  const std::vector<double> map = flip_map(truth, picture);
  double sum = 0;
  size_t count = 0;
  for (size_t i = 0; i < map.size(); ++i) {
    bool changed = false;
    for (size_t c = 0; c < 3; ++c)
      changed = changed || std::abs(srgb_byte(static_cast<double>(truth.rgb[3 * i + c])) -
                                    srgb_byte(static_cast<double>(empty.rgb[3 * i + c]))) > 1;
    if (!changed) continue;
    sum += map[i];
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

// What a session of a phone knows of the light at the chair, in the picture's scale.
ShotLight light_of_session(const Surroundings& room, Session session, const SessionOptions& options) {
  const SeenRoom seen = look_around(room.panorama, session, options);
  sandglass_room_place at;
  sandglass_room_place_default(&at);
  to_floats(room.foot, at.position);
  ShotLight light = {};
  light.struct_size = sizeof light;
  room_estimate(seen.room, k_room_model, at, &light);
  return scaled(light, room.exposure / seen.exposure);
}

RoomColours colours_of(const ColourOptions& options, const ShotStage& stage, const ShotPicture& picture,
                       const ShotPicture& unbaked, size_t index) {
  const std::string& file = options.panoramas[index];
  RoomColours colours;
  RadianceMap map = read_panorama(file);
  fill_tripod(&map);
  const double azimuth = 360.0 * random_stream(index, k_azimuth_stream + options.seed).uniform();
  const Surroundings room =
      panorama_surroundings(std::move(map), stem_of(file), *stage.scene.camera, azimuth, {}, k_object_insertion);
  const ShotCamera camera = resting_camera(*stage.scene.camera);
  const Regions regions = regions_of(picture, camera, options.picture);
  const RadianceMap truth = picture.truth(room, camera, options.picture);
  RadianceMap empty(options.picture.width, options.picture.height);
  for (int y = 0; y < empty.height; ++y)
    for (int x = 0; x < empty.width; ++x)
      empty.set(x, y, room.seen(camera, normalised(camera.ray(x + 0.5, y + 0.5, empty.width, empty.height))));
  const auto draw = [&](Way way, const ShotLight& light, CastShadow cast = CastShadow::textures) {
    ShotPictureOptions drawing = options.picture;
    drawing.lit_by_itself = way != k_old_rule;
    const ShotPicture& drawer = way == k_unbaked ? unbaked : picture;
    const RadianceMap drawn = drawer.composite(room, camera, light, stage.shadows_for(light), cast, drawing);
    for (int r = 0; r < k_regions; ++r) {
      const Vec3 a = mean_of(drawn, regions.pixels[r]), b = mean_of(truth, regions.pixels[r]);
      colours.level[way][r] = apart(luminance(a), luminance(b));
      colours.red_over_blue[way][r] = apart(a.x / std::max(a.z, 1e-6), b.x / std::max(b.z, 1e-6));
    }
    colours.flip[way] = flip_where_changed(empty, truth, drawn);
    if (way == k_true) colours.flip_true_means = flip_where_changed(empty, truth, with_means_of(truth, drawn, regions));
  };
  const Vec3 ahead = camera.forward;
  const SessionOptions session = {std::atan2(ahead.z, ahead.x), true, mix_bits(options.seed + 1000 * index), true};
  const ShotLight known = light_of_session(room, Session::everything_shorter, session);
  const auto balls = [&](BallWay way, Session seen) {
    colours.balls[way] =
        ball_errors(room.panorama, look_around(room.panorama, seen, session), session.azimuth, way == k_mirrored);
  };
  balls(k_from_table, Session::table);
  balls(k_from_turn, Session::full_turn_short);
  balls(k_from_everything, Session::everything_shorter);
  balls(k_mirrored, Session::everything_shorter);
  draw(k_true, room.true_light());
  draw(k_old_rule, scaled(light_of(room.warped, room.view), room.exposure));
  draw(k_session, known);
  for (const auto& [way, shortest] : {std::pair(k_session_1024, 1.0 / 1024), std::pair(k_session_512, 1.0 / 512)}) {
    SessionOptions longer = session;
    longer.shortest = shortest;
    draw(way, light_of_session(room, Session::everything_shorter, longer));
  }
  draw(k_session_64, light_of_session(room, Session::everything, session));
  draw(k_unbaked, room.true_light());
  draw(k_no_shadow, known, CastShadow::none);
  if (!options.network.empty()) {
    LightEstimate network(options.network, SANDGLASS_ISA_AUTOMATIC);
    network.take(room, camera, 1'000'000);
    network.finish();
    draw(k_one_light, network.light());
  }
  return colours;
}

std::vector<Verdict> judge(const ColourOptions& options, const std::vector<RoomColours>& rooms) {
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
  const auto limits_of = [&](int way) -> Limits {
    switch (way) {
      case k_true:
        return {{0.07, 0.13, 0.08, k_infinity}, 0.03};
      case k_old_rule:  // of what is not sand
        return {{0.07, 0.13, k_infinity, k_infinity}, 0.03};
      case k_session:
        return {{0.12, k_infinity, 0.15, k_infinity}, k_infinity};
      default:
        return {{k_infinity, k_infinity, k_infinity, k_infinity}, k_infinity};
    }
  };
  for (int way = 0; way < k_ways; ++way) {
    if (way == k_one_light && options.network.empty()) continue;
    const Limits limits = limits_of(way);
    const std::string name = std::string(k_way_names[way]) + ", ";
    for (int r = 0; r < k_regions; ++r) {
      const double level = over_places([&](const RoomColours& room) { return room.level[way][r]; });
      add("colour", name + k_region_names[r], level, limits.level[r],
          way == k_old_rule && limits.level[r] < k_infinity);
    }
    const double hue = over_places([&](const RoomColours& room) { return room.red_over_blue[way][k_chair]; });
    add("colour", name + "chair's red over blue", hue, limits.red_over_blue, way == k_old_rule);
    const double flip = over_places([&](const RoomColours& room) { return room.flip[way]; });
    rows.push_back({"FLIP", name + "where things change it", "", 0.0, flip, k_infinity, true, false});
  }
  for (int way = 0; way < k_ball_ways; ++way)
    for (size_t ball = 0; ball < std::size(k_ball_names); ++ball) {
      const auto mean = [&](double BallErrors::*error, int from) {
        return over_places([&](const RoomColours& room) { return room.balls[from][ball].*error; });
      };
      const std::string name = std::string(k_ball_ways_names[way]) + ", " + k_ball_names[ball] + ", ";
      const auto report = [&](const char* what, const char* unit, double value) {
        rows.push_back({"balls", name + what, unit, 0.0, value, k_infinity, true, false});
      };
      const double shape = mean(&BallErrors::scale_invariant, way);
      if (way == k_mirrored) {
        const double limit = mean(&BallErrors::scale_invariant, k_from_everything);
        rows.push_back({"balls", name + "si-RMSE", "of RMS", 0.0, shape, limit, shape > limit, true});
        continue;
      }
      report("RMSE", "of RMS", mean(&BallErrors::rmse, way));
      report("si-RMSE", "of RMS", shape);
      report("RGB angle", "degrees", mean(&BallErrors::angle_deg, way));
    }
  const auto share = [&](const std::string& name, const std::function<double(const RoomColours&)>& flip) {
    const double before = over_places([](const RoomColours& room) { return room.flip[k_old_rule]; });
    rows.push_back({"FLIP", name, "share", 0.0, over_places(flip) / before, k_infinity, true, false});
  };
  share("true light, of the rule before", [](const RoomColours& room) { return room.flip[k_true]; });
  share("true light and the truth's mean colours, of the rule before",
        [](const RoomColours& room) { return room.flip_true_means; });
  return rows;
}

}  // namespace

std::vector<Verdict> verify_colours(const ColourOptions& options, const std::function<bool(size_t done)>& progress) {
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
  std::vector<Verdict> rows = judge(options, rooms);
  const Warped warped = warped_beside_traced(options.seed, options.picture.threads);
  for (const auto& [name, errors] :
       {std::pair("warped to the foot", warped.foot), {"at the height of the eye", warped.eye}}) {
    const std::string claim = std::string("light by a panorama ") + name + ", beside traced there, ";
    rows.push_back({"traced", claim + "level", "|ln|", 0.0, errors.level, k_infinity, true, false});
    rows.push_back({"traced", claim + "cells", "0..2", 0.0, errors.shares, k_infinity, true, false});
  }
  return rows;
}

}  // namespace sandglass::host
