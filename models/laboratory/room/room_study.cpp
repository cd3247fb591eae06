#include "models/laboratory/room/room_study.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>

#include "models/lighting/dataset.h"
#include "models/lighting/labels.h"
#include "models/rooms/excerpt.h"
#include "models/rooms/panorama_file.h"
#include "models/work/progress.h"
#include "runtime/core/random.h"

namespace sandglass::host {

namespace {

constexpr int k_resamples = 10000;
constexpr uint64_t k_bootstrap_stream = 41;

RadianceMap halved(const RadianceMap& map) {
  RadianceMap half(map.width / 2, map.height / 2);
  for (int v = 0; v < half.height; ++v)
    for (int u = 0; u < half.width; ++u)
      half.set(u, v,
               (map.colour(2 * u, 2 * v) + map.colour(2 * u + 1, 2 * v) + map.colour(2 * u, 2 * v + 1) +
                map.colour(2 * u + 1, 2 * v + 1)) *
                   0.25);
  return half;
}

Cells cells_of(const sandglass_room_light& light, bool ambient) {
  Cells cells;
  for (uint32_t i = 0; i < k_light_cells; ++i)
    cells[i] = static_cast<double>(ambient ? light.ambient_cells[i] : light.cells[i]);
  return cells;
}

// The network's estimate is one input, except where nothing was seen.
sandglass_room_light light_at(const StudiedPlace& p, size_t session, const RoomModel& model) {
  sandglass_room_light light = {};
  light.struct_size = sizeof light;
  const double at[3] = {p.place.x, p.place.y, p.place.z};
  const SeenRoom& seen = p.sessions[session];
  room_estimate(seen.room, model, at, p.estimate.known && seen.room.images != 0 ? &p.network : nullptr, &light);
  return light;
}

Vec3 mean_direction(const Cells& cells) {
  Vec3 sum;
  for (uint32_t i = 0; i < k_light_cells; ++i) sum = sum + cell_direction(i) * cells[i];
  return normalised(sum);
}

double angle_deg(Vec3 a, Vec3 b) { return std::atan2(length(cross(a, b)), dot(a, b)) * 180.0 / std::numbers::pi; }

// What is fitted, as numbers that may take any value.
constexpr int k_numbers = 3, k_level_numbers = 3;
std::array<double, k_numbers> numbers_of(const RoomModel& m) {
  return {std::log(m.boost), std::log(m.fill), std::log(m.network)};
}
RoomModel model_of(const std::array<double, k_numbers>& x, RoomModel m) {
  m.boost = std::exp(x[0]), m.fill = std::exp(x[1]), m.network = std::exp(x[2]);
  return m;
}
std::array<double, k_level_numbers> level_numbers_of(const RoomModel& m) {
  return {std::log(m.albedo), m.floor_trust, m.unseen_level};
}
RoomModel level_model_of(const std::array<double, k_level_numbers>& x, RoomModel m) {
  m.albedo = std::exp(x[0]), m.floor_trust = std::clamp(x[1], 0.0, 1.0), m.unseen_level = x[2];
  return m;
}

// Coordinates in turns, with steps that shrink.
template <size_t N, class Cost>
std::array<double, N> descend(std::array<double, N> x, const Cost& cost) {
  std::array<double, N> step;
  step.fill(0.3);
  double best = cost(x);
  for (int round = 0; round < 9; ++round)
    for (size_t i = 0; i < N; ++i) {
      bool moved = false;
      for (const double sign : {1.0, -1.0}) {
        std::array<double, N> tried = x;
        tried[i] += sign * step[i];
        const double there = cost(tried);
        if (!(there < best)) continue;
        best = there, x = tried, moved = true;
        break;
      }
      step[i] *= moved ? 1.2 : 0.5;
    }
  return x;
}

double level_error(const StudiedPlace& place, size_t session, const sandglass_room_light& light) {
  const Vec3 e = {light.irradiance[0], light.irradiance[1], light.irradiance[2]};
  return std::log(luminance(e) / (luminance(place.light.irradiance) * place.sessions[session].exposure));
}

// Of the mean over places, by resampling them.
Interval interval_of(const std::vector<double>& values) {
  Random random = random_stream(1, k_bootstrap_stream);
  std::vector<double> means(k_resamples);
  for (double& mean : means) {
    for (size_t i = 0; i < values.size(); ++i) mean += values[random.below(static_cast<uint32_t>(values.size()))];
    mean /= static_cast<double>(values.size());
  }
  std::sort(means.begin(), means.end());
  double all = 0;
  for (const double v : values) all += v;
  return {all / static_cast<double>(values.size()), means[k_resamples / 40], means[k_resamples - 1 - k_resamples / 40]};
}

// The mean of a measure over each location.
std::vector<double> by_location(const RoomStudy& study, const std::function<double(const StudiedPlace&)>& measure) {
  std::map<std::string, std::pair<double, int>> sums;
  for (const StudiedPlace& place : study.places) {
    auto& [sum, count] = sums[place.location];
    sum += measure(place), ++count;
  }
  std::vector<double> means;
  for (const auto& [name, sum] : sums) means.push_back(sum.first / sum.second);
  return means;
}

std::vector<double> difference(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> d(a.size());
  for (size_t i = 0; i < a.size(); ++i) d[i] = a[i] - b[i];
  return d;
}

Vec3 vector_of(const float (&v)[3]) { return {v[0], v[1], v[2]}; }

std::array<double, 9> harmonics_of(const sandglass_room_light& light) {
  std::array<double, 9> harmonics;
  for (size_t j = 0; j < 9; ++j)
    harmonics[j] = luminance(Vec3{light.sh[3 * j], light.sh[3 * j + 1], light.sh[3 * j + 2]});
  return harmonics;
}

// A way to draw: the floor's ratio beside an object, and where there is one the light of its surface.
struct Way {
  std::string name;
  std::function<std::vector<float>(const StudiedPlace&, size_t object)> floor;
  std::function<std::vector<float>(const StudiedPlace&, size_t object)> surface;
  bool control = false;
};

using CellsOf = std::function<Cells(const StudiedPlace&)>;
using LightOf = std::function<sandglass_room_light(const StudiedPlace&)>;

Way in_cells(const RoomStudy& study, std::string name, const CellsOf& cells, bool control = false) {
  return {std::move(name),
          [&study, cells](const StudiedPlace& p, size_t o) { return study.objects[o].drawn(cells(p)); }, nullptr,
          control};
}

// One light, and ambient occlusion for `ambient` of the rest.
Way one_light(const RoomStudy& study, std::string name, StudiedPlace::OneLight StudiedPlace::*light, double ambient) {
  return {std::move(name),
          [&study, light, ambient](const StudiedPlace& p, size_t o) {
            const StudiedPlace::OneLight& one = p.*light;
            const double share = one.direction.y > 0 ? one.share : 0.0;
            Cells rest;
            rest.fill(ambient * (1 - share) / k_light_cells);
            return study.objects[o].drawn(rest, share, one.direction);
          },
          nullptr};
}

// The label of the panorama as it is seen from the object.
StudiedPlace::OneLight true_label(const RadianceMap& panorama, double azimuth, double radius) {
  const View view = {0.5 * std::numbers::pi, azimuth};
  const LightLabels labels = labels_of(warp(panorama, view, radius, 512, 256), {0, 1, 0}, greatest_luminance(panorama));
  return {ViewRotation(view).to_panorama(labels.direction),
          labels.has_direction ? labels.contrast * labels.concentration : 0.0, true};
}

// As an app draws it: the ambient shadow, and the sharp one of the main light.
Way in_room(const RoomStudy& study, std::string name, const LightOf& light_of) {
  return {std::move(name),
          [&study, light_of](const StudiedPlace& p, size_t o) {
            const sandglass_room_light light = light_of(p);
            return study.objects[o].drawn(cells_of(light, true), static_cast<double>(light.main_share),
                                          vector_of(light.main_direction));
          },
          [&study, light_of](const StudiedPlace& p, size_t o) {
            const sandglass_room_light light = light_of(p);
            return study.objects[o].lit(harmonics_of(light), luminance(vector_of(light.irradiance)));
          }};
}

Cells mirrored(const Cells& cells) {
  Cells out;
  for (uint32_t i = 0; i < k_light_cells; ++i)
    out[i] = cells[i / k_cell_sectors * k_cell_sectors + (k_cell_sectors - 1 - i % k_cell_sectors)];
  return out;
}

std::vector<Way> ways_of(const RoomStudy& study, const std::function<LightOf(Session)>& in_session) {
  Cells even;
  even.fill(1.0 / k_light_cells);
  std::vector<Way> ways = {in_cells(study, "no shadow", [](const StudiedPlace&) { return Cells{}; }),
                           in_cells(study, "ambient occlusion alone", [even](const StudiedPlace&) { return even; })};
  ways.push_back(one_light(study, "one light, the true label", &StudiedPlace::label, 0.0));
  ways.push_back(one_light(study, "the same and ambient occlusion", &StudiedPlace::label, 1.0));
  if (study.places.front().estimate.known) {
    ways.push_back(one_light(study, "one light, by the network from an image", &StudiedPlace::estimate, 0.0));
    ways.push_back(one_light(study, "the same and ambient occlusion", &StudiedPlace::estimate, 1.0));
  }
  for (const Session session : k_sessions) ways.push_back(in_room(study, session_name(session), in_session(session)));
  ways.push_back(in_cells(study, "the true light in cells", [](const StudiedPlace& p) { return p.light.cells; }));
  const LightOf turn = in_session(Session::full_turn);
  ways.push_back(in_cells(
      study, "control: a full turn, mirrored",
      [turn](const StudiedPlace& p) { return mirrored(cells_of(turn(p), false)); }, true));
  ways.push_back(in_cells(
      study, "control: a full turn in another room",
      [turn, &study](const StudiedPlace& p) {
        const auto index = static_cast<size_t>(&p - study.places.data());
        return cells_of(turn(study.places[(index + study.places.size() / 2) % study.places.size()]), false);
      },
      true));
  return ways;
}

// The mean over objects of a measure, by location.
std::vector<double> over_objects(const RoomStudy& study,
                                 const std::function<double(const StudiedPlace&, size_t)>& measure) {
  return by_location(study, [&](const StudiedPlace& p) {
    double sum = 0;
    for (size_t o = 0; o < study.objects.size(); ++o) sum += measure(p, o);
    return sum / static_cast<double>(study.objects.size());
  });
}

SessionRow session_row(const RoomStudy& study, Session session, const LightOf& light_of) {
  const auto over_places = [&](const std::function<double(const StudiedPlace&, const sandglass_room_light&)>& measure) {
    return interval_of(by_location(study, [&](const StudiedPlace& p) { return measure(p, light_of(p)); }));
  };
  const auto index = static_cast<size_t>(session);
  SessionRow row;
  row.name = session_name(session);
  row.seen =
      over_places([](const StudiedPlace&, const sandglass_room_light& l) { return static_cast<double>(l.seen); });
  row.direction_deg = over_places([](const StudiedPlace& p, const sandglass_room_light& l) {
    return angle_deg(mean_direction(cells_of(l, false)), mean_direction(p.light.cells));
  });
  row.level = over_places(
      [&](const StudiedPlace& p, const sandglass_room_light& l) { return std::fabs(level_error(p, index, l)); });
  row.level_bias =
      over_places([&](const StudiedPlace& p, const sandglass_room_light& l) { return level_error(p, index, l); });
  row.main_share = over_places([](const StudiedPlace&, const sandglass_room_light& l) {
                     return static_cast<double>(l.main_share);
                   }).mean;
  row.clipped = over_places([](const StudiedPlace&, const sandglass_room_light& l) {
                  return static_cast<double>(l.clipped);
                }).mean;
  return row;
}

std::string text_of(const char* format, double a, double b = 0, double c = 0) {
  char text[96];
  std::snprintf(text, sizeof text, format, a, b, c);
  return text;
}

}  // namespace

RoomStudy study_rooms(const RoomStudyOptions& options, std::vector<FloorObject> objects) {
  RoomStudy study = {std::move(objects), {}};
  const std::string manifest = read_locations(options.manifest);
  const std::vector<std::string>& files = options.panoramas;
  const auto azimuth_of = [&options](uint32_t a) { return 2.0 * std::numbers::pi * a / options.azimuths; };
  Progress progress("looking around", files.size());
  std::optional<RoomLight> network;
  if (!options.network.empty()) network.emplace(options.network);
  ThreadPool pool(options.threads);
  for (size_t i = 0; i < files.size() && !interrupted(); ++i) {
    RadianceMap panorama = read_panorama(files[i]);
    fill_tripod(&panorama);
    const RadianceMap coarse = halved(panorama);
    const Location location = location_of(files[i], manifest);
    std::vector<StudiedPlace> places(options.azimuths);
    pool.run(options.azimuths, [&](uint32_t a) {
      StudiedPlace& place = places[a];
      place.panorama = files[i], place.location = location.name, place.fold = location.fold;
      const double azimuth = azimuth_of(a);
      place.place = Vec3{std::cos(azimuth), 0, std::sin(azimuth)} * options.place;
      place.light = true_light(coarse, place.place);
      place.label = true_label(coarse, azimuth, options.place);
      for (const FloorObject& object : study.objects) {
        place.objects.push_back(object.quadratic(place.light));
        place.truths.push_back(object.truth(place.light));
        place.lit.push_back(object.lit(place.light));
      }
      for (const Session session : k_sessions)
        place.sessions.push_back(
            look_around(coarse, session, {azimuth, options.exposure_known, mix_bits(options.seed + 1000 * i + a)}));
    });
    for (uint32_t a = 0; a < options.azimuths && network; ++a) {
      const sandglass_light_estimate e =
          estimate_of_table(coarse, {azimuth_of(a), true, mix_bits(options.seed + 1000 * i + a)}, &*network);
      places[a].network = e;
      places[a].estimate = {vector_of(e.direction), static_cast<double>(e.contrast), true};
    }
    for (StudiedPlace& place : places) study.places.push_back(std::move(place));
    progress.done(i + 1);
  }
  return study;
}

RoomModel fit_room_model(const RoomStudy& study, int left_out, ThreadPool* pool) {
  const RoomModel start = k_room_model;
  const auto total = [&](const RoomModel& model, const auto& cost_of) {
    std::vector<double> sums(study.places.size(), 0.0);
    pool->run(static_cast<uint32_t>(study.places.size()), [&](uint32_t i) {
      const StudiedPlace& place = study.places[i];
      if (left_out >= 0 && place.fold == left_out) return;
      for (size_t s = 1; s < place.sessions.size(); ++s) sums[i] += cost_of(place, s, light_at(place, s, model));
    });
    double sum = 0;
    for (const double s : sums) sum += s;
    return sum;
  };
  const auto floor = [](const StudiedPlace& place, size_t, const sandglass_room_light& light) {
    double sum = 0;
    for (const FloorObject::Quadratic& object : place.objects) sum += object.error(cells_of(light, false));
    return sum;
  };
  const auto surface = [&study](const StudiedPlace& place, size_t, const sandglass_room_light& light) {
    double sum = 0;
    for (size_t o = 0; o < study.objects.size(); ++o)
      sum += error_of(study.objects[o].lit(harmonics_of(light), luminance(vector_of(light.irradiance))), place.lit[o]);
    return sum;
  };
  const auto level = [](const StudiedPlace& place, size_t session, const sandglass_room_light& light) {
    return std::fabs(level_error(place, session, light));
  };
  RoomModel fitted =
      model_of(descend(numbers_of(start), [&](const auto& x) { return total(model_of(x, start), floor); }), start);
  fitted.fill_below = std::exp(descend(std::array<double, 1>{std::log(fitted.fill_below)}, [&](const auto& x) {
    RoomModel tried = fitted;
    tried.fill_below = std::exp(x[0]);
    return total(tried, surface);
  })[0]);
  return level_model_of(
      descend(level_numbers_of(fitted), [&](const auto& x) { return total(level_model_of(x, fitted), level); }),
      fitted);
}

RoomTable room_table(const RoomStudy& study, const std::vector<RoomModel>& models) {
  const auto in_session = [&](Session session) -> LightOf {
    return [&models, session](const StudiedPlace& p) {
      const size_t fold = p.fold >= 0 ? static_cast<size_t>(p.fold) % models.size() : 0;
      return light_at(p, static_cast<size_t>(session), models[fold]);
    };
  };
  RoomTable table;
  for (const FloorObject& object : study.objects) table.objects.push_back(object.name());
  std::vector<double> none, ambient;
  for (const Way& way : ways_of(study, in_session)) {
    const std::vector<double> floor =
        over_objects(study, [&](const StudiedPlace& p, size_t o) { return error_of(way.floor(p, o), p.truths[o]); });
    if (table.drawn.empty()) none = floor;
    if (table.drawn.size() <= 1) ambient = floor;  // the second way, and until then no shadow
    DrawnRow row;
    row.name = way.name, row.control = way.control;
    row.floor = interval_of(floor);
    row.against_none = interval_of(difference(floor, none));
    row.against_ambient = interval_of(difference(floor, ambient));
    row.share_of_ambient = row.floor.mean / interval_of(ambient).mean;
    for (size_t o = 0; o < study.objects.size(); ++o)
      row.by_object.push_back(interval_of(by_location(study, [&](const StudiedPlace& p) {
                                return error_of(way.floor(p, o), p.truths[o]);
                              })).mean);
    if (way.surface)
      row.shading = interval_of(
          over_objects(study, [&](const StudiedPlace& p, size_t o) { return error_of(way.surface(p, o), p.lit[o]); }));
    table.drawn.push_back(row);
    table.places = floor.size();
  }
  table.drawn.front().against_ambient = interval_of(difference(none, ambient));
  table.drawn.front().share_of_ambient = interval_of(none).mean / interval_of(ambient).mean;
  for (const Session session : k_sessions) table.sessions.push_back(session_row(study, session, in_session(session)));
  table.zenith_deg = interval_of(by_location(study, [](const StudiedPlace& p) {
                       return angle_deg(Vec3{0, 1, 0}, mean_direction(p.light.cells));
                     })).mean;
  return table;
}

std::string room_markdown(const RoomTable& table) {
  std::string text =
      "| the floor is drawn with | error | of ambient occlusion | against no shadow | against ambient occlusion |";
  for (const std::string& object : table.objects) text += " " + object + " |";
  text += " surface |\n|---|---|---|---|---|";
  for (size_t o = 0; o <= table.objects.size(); ++o) text += "---|";
  text += "\n";
  const auto signed_interval = [](const Interval& i) { return text_of("%+.4f [%+.4f, %+.4f]", i.mean, i.low, i.high); };
  for (const DrawnRow& row : table.drawn) {
    text += "| " + row.name + " | " + text_of("%.4f", row.floor.mean) + " | " + text_of("%.2f", row.share_of_ambient) +
            " | " + signed_interval(row.against_none) + " | " + signed_interval(row.against_ambient) + " |";
    for (const double error : row.by_object) text += text_of(" %.4f |", error);
    text += row.shading ? text_of(" %.3f [%.3f, %.3f] |\n", row.shading->mean, row.shading->low, row.shading->high)
                        : " |\n";
  }
  text +=
      "\n| session | seen | direction of the floor's light, degrees | level, \\|log ratio\\| | log ratio | main share "
      "| "
      "clipped |\n|---|---|---|---|---|---|---|\n";
  for (const SessionRow& row : table.sessions)
    text += "| " + row.name + " | " + text_of("%.2f", row.seen.mean) + " | " +
            text_of("%.1f [%.1f, %.1f]", row.direction_deg.mean, row.direction_deg.low, row.direction_deg.high) +
            " | " + text_of("%.2f [%.2f, %.2f]", row.level.mean, row.level.low, row.level.high) + " | " +
            text_of("%+.2f", row.level_bias.mean) + " | " + text_of("%.2f", row.main_share) + " | " +
            text_of("%.2f", row.clipped) + " |\n";
  text += "| the zenith | | " + text_of("%.1f", table.zenith_deg) + " | | | | |\n";
  return text;
}

std::vector<Verdict> room_verdicts(const RoomTable& table) {
  std::vector<Verdict> rows;
  const auto row_of = [&](const std::string& name) -> const DrawnRow& {
    return *std::find_if(table.drawn.begin(), table.drawn.end(), [&](const DrawnRow& r) { return r.name == name; });
  };
  const auto below = [&](const std::string& group, const std::string& name, double result, double limit,
                         const std::string& unit, bool control = false) {
    rows.push_back({group, name, unit, 0.0, result, limit, control ? !(result <= limit) : result <= limit, control});
  };
  const auto of_session = [&](Session s) -> const DrawnRow& { return row_of(session_name(s)); };
  below("floor", "the true light in cells", row_of("the true light in cells").share_of_ambient, 0.5, "of AO");
  below("floor", "nothing seen, against no shadow", of_session(Session::nothing).against_none.high, 0.0, "upper end");
  below("floor", "nothing seen, against AO", of_session(Session::nothing).against_ambient.high, 0.001, "upper end");
  below("floor", "one image, against AO", of_session(Session::table).against_ambient.high, 0.001, "upper end");
  below("floor", "a glance up, against AO", of_session(Session::glance).against_ambient.high, 0.0, "upper end");
  below("floor", "a full turn", of_session(Session::full_turn).share_of_ambient, 0.75, "of AO");
  below("floor", "a full turn, against AO", of_session(Session::full_turn).against_ambient.high, 0.0, "upper end");
  below("direction", "a full turn", table.sessions[static_cast<size_t>(Session::full_turn)].direction_deg.mean, 15.0,
        "degrees");
  for (const DrawnRow& row : table.drawn)
    if (row.control) below("floor", row.name, row.against_ambient.mean, 0.0, "mean", true);
  return rows;
}

}  // namespace sandglass::host
