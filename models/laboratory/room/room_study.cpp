#include "models/laboratory/room/room_study.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <numbers>
#include <optional>

#include "models/files/failure.h"
#include "models/lighting/dataset.h"
#include "models/rooms/panorama_file.h"
#include "models/work/for_all.h"
#include "models/work/progress.h"
#include "runtime/core/random.h"

namespace sandglass::host {

namespace {

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

sandglass_room_light light_at(const SeenRoom& seen, const RoomModel& model, Vec3 place) {
  sandglass_room_light light = {};
  light.struct_size = sizeof light;
  const double at[3] = {place.x, place.y, place.z};
  room_estimate(seen.room, model, at, nullptr, &light);
  return light;
}

Vec3 mean_direction(const Cells& cells) {
  Vec3 sum;
  for (uint32_t i = 0; i < k_light_cells; ++i) sum = sum + cell_direction(i) * cells[i];
  return normalised(sum);
}

double angle_deg(Vec3 a, Vec3 b) { return std::atan2(length(cross(a, b)), dot(a, b)) * 180.0 / std::numbers::pi; }

// What is fitted, as numbers that may take any value.
constexpr int k_numbers = 2, k_level_numbers = 3;
std::array<double, k_numbers> numbers_of(const RoomModel& m) { return {std::log(m.boost), std::log(m.fill)}; }
RoomModel model_of(const std::array<double, k_numbers>& x, RoomModel m) {
  m.boost = std::exp(x[0]), m.fill = std::exp(x[1]);
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

struct Interval {
  double mean, low, high;
};
Interval interval_of(const std::vector<double>& values) {
  constexpr int k_resamples = 4000;
  Random random = random_stream(1, 41);
  std::vector<double> means(k_resamples);
  double all = 0;
  for (const double v : values) all += v;
  for (double& mean : means) {
    mean = 0;
    for (size_t i = 0; i < values.size(); ++i) mean += values[random.below(static_cast<uint32_t>(values.size()))];
    mean /= static_cast<double>(values.size());
  }
  std::sort(means.begin(), means.end());
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

}  // namespace

RoomStudy study_rooms(const RoomStudyOptions& options, std::vector<FloorObject> objects) {
  RoomStudy study = {std::move(objects), {}};
  const std::string manifest = read_locations(options.manifest);
  const std::vector<std::string> files = find_panoramas(options.panoramas);
  Progress progress("looking around", files.size());
  std::optional<RoomLight> network;
  if (!options.network.empty()) network.emplace(options.network);
  for (size_t i = 0; i < files.size(); ++i) {
    RadianceMap panorama = read_panorama(files[i]);
    fill_tripod(&panorama);
    const RadianceMap coarse = halved(panorama);
    const Location location = location_of(files[i], manifest);
    std::vector<StudiedPlace> places(options.azimuths);
    ThreadPool pool(options.threads);
    pool.run(options.azimuths, [&](uint32_t a) {
      StudiedPlace& place = places[a];
      place.panorama = files[i], place.location = location.name, place.fold = location.fold;
      place.azimuth = 2.0 * std::numbers::pi * a / options.azimuths;
      place.place = Vec3{std::cos(place.azimuth), 0, std::sin(place.azimuth)} * options.place;
      place.light = true_light(coarse, place.place);
      for (const FloorObject& object : study.objects) {
        place.objects.push_back(object.quadratic(place.light));
        place.truths.push_back(object.truth(place.light));
        place.lit.push_back(object.lit(place.light));
      }
      for (const Session session : k_sessions)
        place.sessions.push_back(look_around(
            coarse, session, {place.azimuth, options.exposure_known, mix_bits(options.seed + 1000 * i + a)}));
    });
    for (uint32_t a = 0; a < options.azimuths && network; ++a)
      places[a].estimate =
          estimate_of_table(coarse, {places[a].azimuth, true, mix_bits(options.seed + 1000 * i + a)}, &*network);
    for (StudiedPlace& place : places) study.places.push_back(std::move(place));
    progress.done(i + 1);
  }
  return study;
}

RoomModel fit_room_model(const RoomStudy& study, const RoomModel& start, bool (*use)(const StudiedPlace&, int fold),
                         int fold, ThreadPool* pool) {
  const auto total = [&](const RoomModel& model, const auto& cost_of) {
    std::vector<double> sums(study.places.size(), 0.0);
    pool->run(static_cast<uint32_t>(study.places.size()), [&](uint32_t i) {
      const StudiedPlace& place = study.places[i];
      if (!use(place, fold)) return;
      for (size_t s = 1; s < place.sessions.size(); ++s)
        sums[i] += cost_of(place, s, light_at(place.sessions[s], model, place.place));
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
  const auto level = [](const StudiedPlace& place, size_t session, const sandglass_room_light& light) {
    return std::fabs(level_error(place, session, light));
  };
  const RoomModel fitted =
      model_of(descend(numbers_of(start), [&](const auto& x) { return total(model_of(x, start), floor); }), start);
  return level_model_of(
      descend(level_numbers_of(fitted), [&](const auto& x) { return total(level_model_of(x, fitted), level); }),
      fitted);
}

void print_room_table(const RoomStudy& study, const std::vector<RoomModel>& models) {
  const auto model_for = [&](const StudiedPlace& place) -> const RoomModel& {
    return models[place.fold >= 0 ? static_cast<size_t>(place.fold) % models.size() : 0];
  };
  using Drawn = std::function<std::vector<float>(const StudiedPlace&, size_t object)>;
  using Lit = std::function<std::array<double, 10>(const StudiedPlace&)>;  // nine harmonics and the floor's irradiance
  Cells even;
  even.fill(1.0 / k_light_cells);
  const auto in_cells = [&](const std::function<Cells(const StudiedPlace&)>& cells) -> Drawn {
    return [&study, cells](const StudiedPlace& p, size_t o) { return study.objects[o].drawn(cells(p)); };
  };
  const auto seen_light = [&](const StudiedPlace& p, size_t s) {
    return light_at(p.sessions[s], model_for(p), p.place);
  };
  const auto harmonics = [](const sandglass_room_light& light) {
    std::array<double, 10> sh;
    for (size_t j = 0; j < 9; ++j) sh[j] = luminance(Vec3{light.sh[3 * j], light.sh[3 * j + 1], light.sh[3 * j + 2]});
    sh[9] = luminance(Vec3{light.irradiance[0], light.irradiance[1], light.irradiance[2]});
    return sh;
  };
  const auto one_light = [&](double ambient) -> Drawn {
    return [&study, ambient](const StudiedPlace& p, size_t o) {
      const Vec3 d = {p.estimate.direction[0], p.estimate.direction[1], p.estimate.direction[2]};
      const double share = d.y > 0.05 ? static_cast<double>(p.estimate.contrast) : 0.0;
      Cells rest;
      rest.fill(ambient * (1 - share) / k_light_cells);
      return study.objects[o].drawn(rest, share, d);
    };
  };
  struct Row {
    std::string name;
    Drawn drawn;
    Lit lit;
  };
  std::vector<Row> rows = {{"no shadow", in_cells([](const StudiedPlace&) { return Cells{}; }), nullptr},
                           {"ambient occlusion alone", in_cells([&](const StudiedPlace&) { return even; }), nullptr}};
  if (study.places.front().estimate.struct_size != 0) {
    rows.push_back({"one light of the network", one_light(0.0), nullptr});
    rows.push_back({"one light of the network and ambient occlusion", one_light(1.0), nullptr});
  }
  for (size_t s = 0; s < std::size(k_sessions); ++s)
    rows.push_back({session_name(k_sessions[s]),
                    [&, s](const StudiedPlace& p, size_t o) {
                      const sandglass_room_light light = seen_light(p, s);
                      const Vec3 main = {light.main_direction[0], light.main_direction[1], light.main_direction[2]};
                      return study.objects[o].drawn(cells_of(light, true), static_cast<double>(light.main_share), main);
                    },
                    [&, s](const StudiedPlace& p) { return harmonics(seen_light(p, s)); }});
  rows.push_back({"true cells", in_cells([](const StudiedPlace& p) { return p.light.cells; }), nullptr});
  const auto turn = static_cast<size_t>(Session::full_turn);
  rows.push_back({"control: a full turn, mirrored", in_cells([&](const StudiedPlace& p) {
                    const Cells cells = cells_of(seen_light(p, turn), false);
                    Cells mirrored;
                    for (uint32_t i = 0; i < k_light_cells; ++i)
                      mirrored[i] =
                          cells[i / k_cell_sectors * k_cell_sectors + (k_cell_sectors - 1 - i % k_cell_sectors)];
                    return mirrored;
                  }),
                  nullptr});
  rows.push_back({"control: a full turn in another room", in_cells([&](const StudiedPlace& p) {
                    const auto index = static_cast<size_t>(&p - study.places.data());
                    const StudiedPlace& other = study.places[(index + study.places.size() / 2) % study.places.size()];
                    return cells_of(seen_light(other, turn), false);
                  }),
                  nullptr});

  const auto mean_of = [&](const std::function<double(const StudiedPlace&, size_t)>& measure) {
    return by_location(study, [&](const StudiedPlace& p) {
      double sum = 0;
      for (size_t o = 0; o < study.objects.size(); ++o) sum += measure(p, o);
      return sum / static_cast<double>(study.objects.size());
    });
  };
  const auto floor_of = [&](const Row& row) {
    return mean_of([&](const StudiedPlace& p, size_t o) { return error_of(row.drawn(p, o), p.truths[o]); });
  };
  const std::vector<double> ambient = floor_of(rows[1]);
  const double ambient_mean = interval_of(ambient).mean;
  std::printf("%zu places, objects:", by_location(study, [](const StudiedPlace&) { return 0.0; }).size());
  for (const FloorObject& object : study.objects) std::printf(" %s", object.name().c_str());
  std::printf(
      "\nfloor error (RMSE of the ratio); against ambient occlusion, with 95 %% intervals over places; by object; "
      "shading\n");
  for (const Row& row : rows) {
    const std::vector<double> floor = floor_of(row);
    std::vector<double> difference(floor.size());
    for (size_t i = 0; i < floor.size(); ++i) difference[i] = floor[i] - ambient[i];
    const Interval d = interval_of(difference), m = interval_of(floor);
    std::printf("  %-46s %.4f  %.3f x  %+.4f [%+.4f, %+.4f] ", row.name.c_str(), m.mean, m.mean / ambient_mean, d.mean,
                d.low, d.high);
    for (size_t o = 0; o < study.objects.size(); ++o)
      std::printf(" %.4f", interval_of(by_location(study, [&](const StudiedPlace& p) {
                             return error_of(row.drawn(p, o), p.truths[o]);
                           })).mean);
    if (row.lit) {
      const Interval shading = interval_of(mean_of([&](const StudiedPlace& p, size_t o) {
        const std::array<double, 10> sh = row.lit(p);
        std::array<double, 9> nine;
        std::copy_n(sh.begin(), 9, nine.begin());
        return error_of(study.objects[o].lit(nine, sh[9]), p.lit[o]);
      }));
      std::printf("  shading %.3f [%.3f, %.3f]", shading.mean, shading.low, shading.high);
    }
    std::printf("\n");
  }
  std::printf(
      "by session: share seen; shadow direction, degrees; level, |log ratio| and log ratio; main share; clipped\n");
  std::printf("  %-42s %22.1f\n", "the zenith", interval_of(by_location(study, [&](const StudiedPlace& p) {
                                                  return angle_deg(Vec3{0, 1, 0}, mean_direction(p.light.cells));
                                                })).mean);
  for (size_t s = 0; s < std::size(k_sessions); ++s) {
    const auto mean = [&](const std::function<double(const StudiedPlace&, const sandglass_room_light&)>& measure) {
      return interval_of(by_location(study, [&](const StudiedPlace& p) { return measure(p, seen_light(p, s)); }));
    };
    const Interval seen =
        mean([](const StudiedPlace&, const sandglass_room_light& l) { return static_cast<double>(l.seen); });
    const Interval angle = mean([](const StudiedPlace& p, const sandglass_room_light& l) {
      return angle_deg(mean_direction(cells_of(l, false)), mean_direction(p.light.cells));
    });
    const Interval level =
        mean([&](const StudiedPlace& p, const sandglass_room_light& l) { return std::fabs(level_error(p, s, l)); });
    const Interval bias =
        mean([&](const StudiedPlace& p, const sandglass_room_light& l) { return level_error(p, s, l); });
    const Interval share =
        mean([](const StudiedPlace&, const sandglass_room_light& l) { return static_cast<double>(l.main_share); });
    const Interval clipped =
        mean([](const StudiedPlace&, const sandglass_room_light& l) { return static_cast<double>(l.clipped); });
    std::printf("  %-42s %.2f  %5.1f [%.1f, %.1f]  %.2f [%.2f, %.2f] %+.2f  %.2f  %.2f\n", session_name(k_sessions[s]),
                seen.mean, angle.mean, angle.low, angle.high, level.mean, level.low, level.high, bias.mean, share.mean,
                clipped.mean);
  }
}

}  // namespace sandglass::host
