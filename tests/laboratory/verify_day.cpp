// `sandglass_lab verify day`: a day with a phone, in rooms whose light is known: lamps, a finger, the flash lamp, a pocket,
// missing metadata, bogus clocks, another room. A camera that adapts looks on at 30 Hz, a tenth of its images are short.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>

#include "models/compositing/phone.h"
#include "models/files/failure.h"
#include "models/lighting/dataset.h"
#include "models/lighting/lit_view.h"
#include "models/lighting/room_light.h"
#include "models/rooms/panorama_file.h"
#include "models/rooms/room_render.h"
#include "models/work/progress.h"
#include "models/work/random.h"
#include "models/work/thread_pool.h"
#include "sandglass/sandglass.hpp"
#include "tests/laboratory/verify.h"

namespace sandglass::host {

namespace {

constexpr double k_frame = 1.0 / 30;
constexpr double k_level_limit = 0.05, k_stay_limit = 0.1, k_step_limit = 0.07, k_turn_limit_deg = 2.0;

using Change = std::function<Vec3(Vec3 radiance, Vec3 direction)>;
Vec3 as_it_is(Vec3 radiance, Vec3) { return radiance; }

double level_of(const sandglass_room_light& light) {
  return luminance(Vec3{light.irradiance[0], light.irradiance[1], light.irradiance[2]});
}
double apart_deg(const sandglass_room_light& a, const sandglass_room_light& b) {
  const Vec3 x = {a.main_direction[0], a.main_direction[1], a.main_direction[2]};
  const Vec3 y = {b.main_direction[0], b.main_direction[1], b.main_direction[2]};
  return std::atan2(length(cross(x, y)), dot(x, y)) * 180 / std::numbers::pi;
}

// A phone and the app on it.
class Day {
 public:
  explicit Day(const RadianceMap& panorama) : panorama_(&panorama) {
    if (const cpp::Status made = room_.create(); !made) throw cannot("make", "room", made.reason);
  }

  const RadianceMap* panorama_;
  Change change = as_it_is;
  bool tracked = true, told = true;
  std::optional<uint64_t> stamp;  // of the next image, in place of the clock's
  double roll_deg = 0.0;
  double most_step = 0.0;        // of the level that is shown, as a logarithm
  double most_known_step = 0.0;  // the same, were what is known shown at once

  // So many seconds of looking around, or at rest at the floor ahead.
  void look_around(double seconds) { run(seconds, true); }
  void rest(double seconds) { run(seconds, false); }

  void begin() {
    told = false;  // the first image has no metadata
    rest(0.1);
    told = true;
    look_around(14);
    rest(2);
  }

  cpp::Room& room() { return room_; }
  sandglass_room_light known() const {
    const float place[3] = {0, 0, 0};
    return room_.light_at(place, &shown_);
  }
  // Of a level floor, in a unit that no exposure changes.
  double level() const { return level_of(known()) * static_cast<double>(known().white) * unit_; }
  void begin_steps() { most_step = 0; }
  // Will see the same images.
  void join(const Day& other) {
    change = other.change;
    gain_ = other.gain_;
    seconds_ = other.seconds_;
    frame_ = other.frame_;
  }

 private:
  void run(double seconds, bool around) {
    for (const double end = seconds_ + seconds; seconds_ < end && !interrupted();) {
      seconds_ += k_frame;
      ++frame_;
      const double turn = around ? 36.0 * seconds_ : 30.0, tilt = around ? 55.0 * std::sin(1.5 * seconds_) : -35.0;
      if (frame_ % 3 == 0) see(turn, tilt);
      show();
    }
  }
  void see(double turn_deg, double tilt_deg) {
    const ShotCamera camera = rolled(session_camera(0, {turn_deg, tilt_deg, 1}));
    const RadianceMap view = view_of(*panorama_, camera, k_session_width, k_session_height);
    const bool is_short = frame_ % 30 == 0;
    const double gain = is_short ? gain_ / 64 : gain_;
    Picture picture(k_session_width, k_session_height, {0, 0, 0});
    double sum = 0;
    for (int v = 0; v < view.height; ++v)
      for (int u = 0; u < view.width; ++u) {
        const Vec3 c = change(view.colour(u, v), normalised(camera.ray(u + 0.5, v + 0.5, view.width, view.height)));
        const double of[3] = {c.x, c.y, c.z};
        for (size_t k = 0; k < 3; ++k)
          picture.rgb[3 * static_cast<size_t>(v * view.width + u) + k] = srgb_byte(std::min(1.0, of[k] * gain));
        sum += std::min(1.0, luminance(c) * gain_);
      }
    image_ = camera_image_of(picture, 75.0);
    image_.focal_x = image_.focal_y = static_cast<float>(camera.focal * k_session_height);
    camera.pose(&image_);
    image_.timestamp_ns = stamp ? *stamp : static_cast<uint64_t>(seconds_ * 1e9);
    image_.exposure = told ? static_cast<float>(k_app_unit * gain) : 0.0f;
    stamp.reset();
    const char* reason = nullptr;
    if (tracked && sandglass_room_set_image(room_.get(), &image_, nullptr, &reason) != SANDGLASS_OK)
      throw cannot("see", "image", reason);
    gain_ += 0.3 * (std::clamp(gain_ * 0.18 / std::max(sum / (view.width * view.height), 1e-3), 1e-4, 64.0) - gain_);
    if (!is_short) screen_gain_ = gain;
    if (!is_short) screen_ = image_;  // the short ones are not shown
  }
  void show() {
    const sandglass_room_light now = known();
    sandglass_room_fade(&shown_, &now, static_cast<float>(k_frame));
    const double drawn = level_of(shown_) * static_cast<double>(sandglass_room_exposure(&shown_, &screen_));
    const double level = drawn / screen_gain_;
    const double known = level_of(now) * static_cast<double>(sandglass_room_exposure(&now, &screen_)) / screen_gain_;
    if (last_ > 0) {
      most_step = std::max(most_step, std::fabs(std::log(level / last_)));
      most_known_step = std::max(most_known_step, std::fabs(std::log(known / last_known_)));
    }
    last_ = level;
    last_known_ = known;
  }
  ShotCamera rolled(ShotCamera camera) const {
    const double c = std::cos(roll_deg * std::numbers::pi / 180), s = std::sin(roll_deg * std::numbers::pi / 180);
    const Vec3 right = camera.right, up = camera.up;
    camera.right = right * c + up * s;
    camera.up = up * c - right * s;
    return camera;
  }

  static constexpr double k_app_unit = 0.08;  // seconds times ISO / 100 of gain 1
  static constexpr double unit_ = k_app_unit;
  cpp::Room room_;
  sandglass_room_light shown_ = {};
  sandglass_camera_image image_ = cpp::camera_image(), screen_ = cpp::camera_image();
  double gain_ = 1.0, screen_gain_ = 1.0, seconds_ = 0.0, last_ = 0.0, last_known_ = 0.0;
  uint64_t frame_ = 0;
};

class Rows {
 public:
  explicit Rows(std::string room) : room_(std::move(room)) {}
  std::vector<Verdict> rows;

  void add(const std::string& name, const char* unit, double truth, double result, double limit, bool control = false) {
    const bool holds = std::fabs(result - truth) <= limit;
    rows.push_back({room_, name, unit, truth, result, limit, holds != control, control});
  }

 private:
  std::string room_;
};

// What ends as it began: after it all is as before, and nobody has seen a step. `light_switched`: but that of the light.
void ends(Rows* rows, Day* day, const char* name, bool light_switched, const std::function<void()>& happens) {
  const double before = day->level();
  const sandglass_room_light main = day->known();
  day->begin_steps();
  happens();
  day->change = as_it_is;
  day->rest(2);
  rows->add(std::string(name) + ": level", "1", 1, day->level() / before, k_level_limit);
  if (main.main_share > 0.05f)
    rows->add(std::string(name) + ": direction", "degrees", 0, apart_deg(day->known(), main), k_turn_limit_deg);
  if (!light_switched) rows->add(std::string(name) + ": step", "1", 0, day->most_step, k_step_limit);
}

// What stays: as a session that was there from the beginning and saw the same.
void stays(Rows* rows, Day* day, Day* other, const char* name) {
  for (Day* either : {day, other}) {
    either->look_around(12);
    either->rest(2);
  }
  rows->add(std::string(name) + ": level", "1", 1, day->level() / other->level(), k_stay_limit);
}

Change times(double factor) {
  return [factor](Vec3 c, Vec3) { return c * factor; };
}
Change all(Vec3 colour) {
  return [colour](Vec3, Vec3 d) { return colour * (1 + 0.4 * d.x); };
}

std::vector<Verdict> day_in(const std::string& name, const RadianceMap& here, const RadianceMap& other) {
  Rows rows(name);
  Day day(here);
  day.begin();
  // A unit of light for what covers the lens: what the floor shows.
  const double level = day.level();
  const auto for_seconds = [&day](double seconds, Change change) {
    return [&day, seconds, change] {
      day.change = change;
      day.rest(seconds);
    };
  };
  for (const double factor : {0.3, 0.03})
    ends(&rows, &day, factor < 0.1 ? "lamps off and on" : "lamps dimmed", true, for_seconds(4, times(factor)));
  ends(&rows, &day, "lamps up and down", true, for_seconds(4, times(6)));
  ends(&rows, &day, "finger", false, for_seconds(2, all(Vec3{0.05, 0.0075, 0.005} * (0.4 * level))));
  ends(&rows, &day, "pocket", false, for_seconds(5, times(0)));
  ends(&rows, &day, "glare", false, for_seconds(2, all(Vec3{1, 1, 1} * (1e4 * level))));
  ends(&rows, &day, "flash lamp", true, for_seconds(2, [](Vec3 c, Vec3 d) { return d.y < 0 ? c * (1 - 3 * d.y) : c; }));
  ends(&rows, &day, "landscape", false, [&] {
    day.roll_deg = 90;
    day.rest(3);
    day.roll_deg = 0;
  });
  ends(&rows, &day, "relocalisation", false, [&] {
    day.tracked = false;
    day.rest(5);
    day.tracked = true;
  });
  ends(&rows, &day, "missing metadata", false, [&] {
    for (int i = 0; i < 10; ++i) {
      day.told = i % 2 == 0;
      day.rest(0.2);
    }
    day.told = true;
  });
  ends(&rows, &day, "bogus clock", false, [&] {
    day.stamp = 0xffffffffffff0000ull;
    day.rest(0.2);
  });
  Day dim(here);
  dim.change = day.change = times(0.15);
  dim.begin();
  dim.join(day);
  stays(&rows, &day, &dim, "lamps off");
  day.change = as_it_is;
  day.panorama_ = &other;
  day.room().reset();
  Day there(other);
  there.join(day);
  stays(&rows, &day, &there, "another room");
  // Controls: the measure sees it where what covers the lens is believed, and where nothing is faded.
  Day believes(here);
  believes.look_around(14);
  const double before = believes.level();
  believes.room().reset();
  believes.change = all(Vec3{0.05, 0.0075, 0.005} * (0.4 * level));
  believes.rest(2);
  rows.add("control: not faded: step", "1", 0, day.most_known_step, k_step_limit, true);
  rows.add("control: a finger that is believed", "1", 1, believes.level() / before, k_level_limit, true);
  return rows.rows;
}

struct NamedRoom {
  std::string name;
  RadianceMap panorama;
};

// Made-up rooms, and captured ones where there are some.
std::vector<NamedRoom> rooms_of(const VerifyOptions& options) {
  std::vector<NamedRoom> rooms;
  std::vector<std::string> files =
      options.panoramas.empty() ? std::vector<std::string>() : find_panoramas(options.panoramas);
  if (options.panoramas.empty() && !data_folder().empty())
    for (const char* name : {"lebombo", "hotel_room"})
      files.push_back(data_folder() + "/hdri/indoor/" + name + "_1k.hdr");
  for (const std::string& file : files) {
    RadianceMap panorama = read_panorama(file);
    fill_tripod(&panorama);
    rooms.push_back({stem_of(file), std::move(panorama)});
  }
  const uint64_t made = options.panoramas.empty() ? 3 : 0;
  for (uint64_t i = 0; i < made; ++i) {
    const uint64_t seed = mix_bits(options.seed + i) % 10000;
    RoomRenderOptions render;
    render.width = 256;
    render.samples = 48;
    render.threads = options.threads;
    const Room room = make_room(seed);
    RadianceMap panorama = trace_room(room, render).radiance;
    expose(&panorama, room.key);
    rooms.push_back({"room " + std::to_string(seed), std::move(panorama)});
  }
  return rooms;
}

}  // namespace

int verify_day_command(const VerifyOptions& options) {
  const std::vector<NamedRoom> rooms = rooms_of(options);
  std::vector<std::vector<Verdict>> of_rooms(rooms.size());
  Progress progress("living a day", rooms.size());
  ThreadPool pool(options.threads);
  std::atomic<uint64_t> done = 0;
  pool.run(static_cast<uint32_t>(rooms.size()), [&](uint32_t i) {
    of_rooms[i] = day_in(rooms[i].name, rooms[i].panorama, rooms[(i + 1) % rooms.size()].panorama);
    progress.done(++done);
  });
  if (interrupted()) return k_exit_interrupted;
  std::vector<Verdict> rows;
  for (const std::vector<Verdict>& some : of_rooms) rows.insert(rows.end(), some.begin(), some.end());
  return tell(options, "day", "automatic", rows);
}

}  // namespace sandglass::host
