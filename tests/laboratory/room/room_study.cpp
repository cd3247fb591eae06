#include "tests/laboratory/room/room_study.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace sandglass::host {

namespace {

// The floor's ratio beside an object.
struct Method {
  std::string name;
  std::function<std::vector<float>(const StudiedPlace&, size_t object)> floor;
  bool control = false;  // is wrong, and must be worse than what it spoils
};

// All shares of the light, or those of the ambient shadow alone.
Cells cells_of(const sandglass_room_light& light, bool ambient) {
  Cells cells;
  for (uint32_t i = 0; i < k_light_cells; ++i)
    cells[i] = static_cast<double>(ambient ? light.ambient_cells[i] : light.cells[i]);
  return cells;
}

std::vector<double> difference(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> d(a.size());
  for (size_t i = 0; i < a.size(); ++i) d[i] = a[i] - b[i];
  return d;
}

Method in_cells(const RoomStudy& study, std::string name, const std::function<Cells(const StudiedPlace&)>& cells,
                bool control = false) {
  return {std::move(name),
          [objects = study.objects, cells](const StudiedPlace& p, size_t o) { return (*objects)[o].drawn(cells(p)); },
          control};
}

Method no_shadow(const RoomStudy& study) {
  return in_cells(study, "no shadow", [](const StudiedPlace&) { return Cells{}; });
}

Method ambient_occlusion(const RoomStudy& study) {
  Cells even;
  even.fill(1.0 / k_light_cells);
  return in_cells(study, "ambient occlusion alone", [even](const StudiedPlace&) { return even; });
}

// One light, and ambient occlusion for `ambient` of the rest.
Method one_light(const RoomStudy& study, std::string name, const std::function<OneLight(const StudiedPlace&)>& light,
                 double ambient, bool control = false) {
  return {std::move(name),
          [objects = study.objects, light, ambient](const StudiedPlace& p, size_t o) {
            const OneLight sole = light(p);
            const double share = sole.direction.y > 0 ? sole.share : 0.0;
            Cells rest;
            rest.fill(ambient * (1 - share) / k_light_cells);
            return (*objects)[o].drawn(rest, share, sole.direction);
          },
          control};
}

// As an app draws it: the ambient shadow, and the sharp one of the main light.
Method in_room(const RoomStudy& study, std::string name,
               const std::function<sandglass_room_light(const StudiedPlace&)>& light_of) {
  return {std::move(name), [objects = study.objects, light_of](const StudiedPlace& p, size_t o) {
            const sandglass_room_light light = light_of(p);
            return (*objects)[o].drawn(cells_of(light, true), static_cast<double>(light.main_share),
                                       from_floats(light.main_direction));
          }};
}

// The first method must be no_shadow, the second ambient_occlusion.
std::vector<DrawnRow> drawn_rows(const RoomStudy& study, const std::vector<Method>& methods) {
  const size_t objects = study.objects->size();
  std::vector<DrawnRow> rows;
  std::vector<double> none, ambient;  // by place
  for (const Method& method : methods) {
    DrawnRow row;
    row.name = method.name;
    row.control = method.control;
    std::vector<double> floor;
    for (size_t o = 0; o < objects; ++o) {
      const std::vector<double> errors =
          by_location(study, [&](const StudiedPlace& p) { return error_of(method.floor(p, o), p.truths[o]); });
      floor.resize(errors.size());
      for (size_t i = 0; i < errors.size(); ++i) floor[i] += errors[i] / static_cast<double>(objects);
    }
    if (rows.empty()) none = floor;
    if (rows.size() == 1) ambient = floor;
    row.floor = interval_of(floor);
    row.against_none = interval_of(difference(floor, none));
    if (rows.size() >= 1) row.against_ambient = interval_of(difference(floor, ambient));
    rows.push_back(row);
  }
  rows.front().against_ambient = interval_of(difference(none, ambient));
  for (DrawnRow& row : rows) row.share_of_ambient = row.floor.mean / rows[1].floor.mean;
  return rows;
}

constexpr const char* k_true_cells = "the true light in cells";

// The network's estimate is one input, except where nothing was seen.
sandglass_room_light light_at(const StudiedPlace& p, const Room& room) {
  sandglass_room_light light = {};
  light.struct_size = sizeof light;
  sandglass_room_place at;
  sandglass_room_place_default(&at);
  to_floats(p.place, at.position);
  if (!p.estimates.empty() && room.images != 0) at.network = &p.network;
  room_estimate(room, k_room_model, at, &light);
  return light;
}

Vec3 mean_direction(const Cells& cells) {
  Vec3 sum;
  for (uint32_t i = 0; i < k_light_cells; ++i) sum = sum + cell_direction(i, 0.5, 0.5) * cells[i];
  return normalised(sum);
}

double angle_deg(Vec3 a, Vec3 b) { return std::atan2(length(cross(a, b)), dot(a, b)) * 180.0 / std::numbers::pi; }

double level_error(const StudiedPlace& place, const SeenRoom& seen, const sandglass_room_light& light) {
  const Vec3 e = {light.irradiance[0], light.irradiance[1], light.irradiance[2]};
  return std::log(luminance(e) / (luminance(place.light.irradiance) * seen.exposure));
}

Cells mirrored(const Cells& cells) {
  Cells out;
  for (uint32_t i = 0; i < k_light_cells; ++i) out[i] = cells[mirrored_cell(i)];
  return out;
}

// What each session makes known at each place.
using Lights = std::vector<std::vector<sandglass_room_light>>;

Lights lights_of(const RoomStudy& study, ThreadPool* pool) {
  Lights lights(study.places.size());
  pool->run(static_cast<uint32_t>(lights.size()), [&](uint32_t i) {
    const StudiedPlace& place = study.places[i];
    for (const SeenRoom& seen : place.sessions) lights[i].push_back(light_at(place, seen.room));
  });
  return lights;
}

std::vector<Method> methods_of(const RoomStudy& study, const Lights& lights) {
  const auto light_in = [&study, &lights](Session session, size_t away = 0) {
    return [&study, &lights, session, away](const StudiedPlace& p) -> const sandglass_room_light& {
      const auto index = static_cast<size_t>(&p - study.places.data());
      return lights[(index + away) % lights.size()][static_cast<size_t>(session)];
    };
  };
  const auto label = [](const StudiedPlace& p) { return p.label; };
  const auto estimate = [](const StudiedPlace& p) { return p.estimates.front(); };
  std::vector<Method> methods = {no_shadow(study), ambient_occlusion(study)};
  methods.push_back(one_light(study, "one light, the true label", label, 0.0));
  methods.push_back(one_light(study, "the true label and ambient occlusion", label, 1.0));
  if (!study.places.front().estimates.empty()) {
    methods.push_back(one_light(study, "one light, by the network from an image", estimate, 0.0));
    methods.push_back(one_light(study, "the network's and ambient occlusion", estimate, 1.0));
  }
  for (const Session session : k_sessions) methods.push_back(in_room(study, session_name(session), light_in(session)));
  methods.push_back(in_cells(study, k_true_cells, [](const StudiedPlace& p) { return p.light.cells; }));
  methods.push_back(in_cells(
      study, "control: a full turn, mirrored",
      [turn = light_in(Session::full_turn)](const StudiedPlace& p) { return mirrored(cells_of(turn(p), false)); },
      true));
  methods.push_back(in_cells(
      study, "control: a full turn in another room",
      [turn = light_in(Session::full_turn, study.places.size() / 2)](const StudiedPlace& p) {
        return cells_of(turn(p), false);
      },
      true));
  if (study.places.front().probes.empty()) return methods;
  const auto probe = [&study](size_t variant, size_t away = 0) {
    return [&study, variant, away](const StudiedPlace& p) {
      const auto index = static_cast<size_t>(&p - study.places.data());
      return study.places[(index + away) % study.places.size()].probes[variant];
    };
  };
  for (size_t variant = 0; variant < std::size(k_probe_variants); ++variant) {
    methods.push_back(in_room(study, k_probe_variants[variant].name, probe(variant)));
    methods.back().control = k_probe_variants[variant].control;
  }
  methods.push_back(in_room(study, k_probe_elsewhere, probe(0, study.places.size() / 2)));
  methods.back().control = true;
  return methods;
}

SessionRow session_row(const RoomStudy& study, const Lights& lights, Session session) {
  const auto index = static_cast<size_t>(session);
  const auto over_places = [&](const std::function<double(const StudiedPlace&, const sandglass_room_light&)>& measure) {
    return interval_of(by_location(study, [&](const StudiedPlace& p) {
      return measure(p, lights[static_cast<size_t>(&p - study.places.data())][index]);
    }));
  };
  SessionRow row;
  row.name = session_name(session);
  row.seen =
      over_places([](const StudiedPlace&, const sandglass_room_light& l) { return static_cast<double>(l.seen); });
  row.direction_deg = over_places([](const StudiedPlace& p, const sandglass_room_light& l) {
    return angle_deg(mean_direction(cells_of(l, false)), mean_direction(p.light.cells));
  });
  row.level = over_places([&](const StudiedPlace& p, const sandglass_room_light& l) {
    return std::fabs(level_error(p, p.sessions[index], l));
  });
  const auto level_where = [&](Known known) {
    return interval_of(by_location(study, [&](const StudiedPlace& p) {
      const Room room = with_known(p.sessions[index], p.parts, known);
      return std::fabs(level_error(p, p.sessions[index], light_at(p, room)));
    }));
  };
  row.level_clipped_known = level_where(Known::clipped_light);
  row.level_unseen_known = level_where(Known::unseen_parts);
  return row;
}

}  // namespace

const DrawnRow& row_of(const std::vector<DrawnRow>& rows, const std::string& name) {
  for (const DrawnRow& row : rows)
    if (row.name == name) return row;
  throw std::out_of_range("no way to draw is called " + name);
}

RoomTable room_table(const RoomStudy& study, ThreadPool* pool) {
  const Lights lights = lights_of(study, pool);
  RoomTable table;
  table.drawn = drawn_rows(study, methods_of(study, lights));
  for (const Session session : k_sessions) table.sessions.push_back(session_row(study, lights, session));
  const std::vector<double> unguarded = by_location(study, [](const StudiedPlace& p) {
    return std::fabs(level_error(p, p.unguarded, light_at(p, p.unguarded.room)));
  });
  table.unguarded = interval_of(unguarded);
  table.places = unguarded.size();
  return table;
}

RoomStudy rooms_in(const RoomStudy& study, const std::string& part) {
  RoomStudy some = {study.objects, {}};
  for (const StudiedPlace& place : study.places)
    if (place.panorama.find(part) != std::string::npos) some.places.push_back(place);
  return some;
}

void print_room(const RoomTable& table) {
  std::printf("%zu places\n\n%-56s %8s %6s %30s\n", table.places, "the floor is drawn with", "error", "of AO",
              "against AO");
  for (const DrawnRow& row : table.drawn)
    std::printf("%-56s %8.4f %6.2f %+10.4f %+9.4f %+9.4f\n", row.name.c_str(), row.floor.mean, row.share_of_ambient,
                row.against_ambient.mean, row.against_ambient.low, row.against_ambient.high);
  std::printf("\n%-56s %8s %10s %12s\n", "session", "seen", "direction", "level, |log|");
  for (const SessionRow& row : table.sessions)
    std::printf("%-56s %8.2f %9.1f° %12.2f\n", row.name.c_str(), row.seen.mean, row.direction_deg.mean, row.level.mean);
  std::puts("");
}

std::vector<Measurement> room_measurements(const std::vector<Condition>& conditions) {
  std::vector<Measurement> all;
  const auto keep = [&](const std::string& name, const std::string& metric, double value, const char* unit = "1") {
    all.push_back({"room", name, metric, unit, "automatic", value, 1, {}});
  };
  const auto keep_interval = [&](const std::string& name, const std::string& metric, const Interval& interval) {
    keep(name, metric, interval.mean);
    keep(name, metric + "_low", interval.low);
    keep(name, metric + "_high", interval.high);
  };
  for (const Condition& condition : conditions) {
    const std::string where = &condition == &conditions.front() ? "" : ", " + condition.name;
    for (const DrawnRow& row : condition.table.drawn) {
      keep_interval(row.name + where, "floor", row.floor);
      keep(row.name + where, "of_ambient_occlusion", row.share_of_ambient);
      keep_interval(row.name + where, "against_ambient_occlusion", row.against_ambient);
    }
    for (const SessionRow& row : condition.table.sessions) {
      keep_interval(row.name + where, "direction_deg", row.direction_deg);
      keep_interval(row.name + where, "level", row.level);
      keep(row.name + where, "level_clipped_known", row.level_clipped_known.mean);
      keep(row.name + where, "level_unseen_known", row.level_unseen_known.mean);
      keep(row.name + where, "seen", row.seen.mean);
    }
  }
  return all;
}

std::vector<Verdict> room_verdicts(const std::vector<Condition>& conditions) {
  std::vector<Verdict> rows;
  const auto below = [&](const std::string& group, const std::string& name, double result, double limit,
                         const std::string& unit, bool control = false) {
    rows.push_back({group, name, unit, 0.0, result, limit, control ? !(result <= limit) : result <= limit, control});
  };
  const RoomTable& table = conditions.front().table;
  const auto of_session = [](const RoomTable& t, Session s) -> const DrawnRow& {
    return row_of(t.drawn, session_name(s));
  };
  below("floor", k_true_cells, row_of(table.drawn, k_true_cells).share_of_ambient, 0.5, "of AO");
  below("floor", "nothing seen, against no shadow", of_session(table, Session::nothing).against_none.high, 0.0,
        "upper end");
  below("floor", "nothing seen, against AO", of_session(table, Session::nothing).against_ambient.high, 0.001,
        "upper end");
  below("floor", "one image, against AO", of_session(table, Session::table).against_ambient.high, 0.001, "upper end");
  below("floor", "a glance up, against AO", of_session(table, Session::glance).against_ambient.high, 0.0, "upper end");
  below("floor", "a full turn", of_session(table, Session::full_turn).share_of_ambient, 0.75, "of AO");
  for (const Condition& condition : conditions)
    below(condition.name, "a full turn, against AO",
          of_session(condition.table, Session::full_turn).against_ambient.high, 0.0, "upper end");
  below("direction", "a full turn", table.sessions[static_cast<size_t>(Session::full_turn)].direction_deg.mean, 15.0,
        "degrees");
  for (const ProbeVariant& v : k_probe_variants)
    if (!v.control) below("floor", v.name, row_of(table.drawn, v.name).share_of_ambient, v.limit, "of AO");
  const double level = table.sessions[static_cast<size_t>(Session::full_turn)].level.mean;
  rows.push_back({"level", "a full turn (the aim is 0.35)", "|log ratio|", 0.0, level,
                  std::numeric_limits<double>::infinity(), true, false});
  for (const auto& [session, limit] :
       {std::pair(Session::everything_shorter, 0.12), std::pair(Session::full_turn_shorter, 0.55)})
    below("level", session_name(session), table.sessions[static_cast<size_t>(session)].level.mean, limit,
          "|log ratio|");
  below("level", std::string("control: ") + session_name(k_unguarded) + ", dark bytes believed", table.unguarded.mean,
        0.12, "|log ratio|", true);
  for (const DrawnRow& row : table.drawn)
    if (row.control) below("floor", row.name, row.against_ambient.mean, 0.0, "mean", true);
  return rows;
}

}  // namespace sandglass::host
