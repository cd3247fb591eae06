#include "tests/laboratory/shadow/anything.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <string>

#include "models/files/failure.h"
#include "models/mesh/generated.h"
#include "models/simulation/scene_meshes.h"
#include "models/tracing/directions.h"
#include "models/tracing/embree_scene.h"
#include "models/work/random.h"
#include "tests/laboratory/cpu_time.h"
#include "tests/laboratory/shadow/app_cast.h"

namespace sandglass::host {

namespace {

constexpr double k_degree = std::numbers::pi / 180, k_half = 10 * k_degree;  // of the light
constexpr double k_reported = std::numeric_limits<double>::infinity();
constexpr double k_top = 0.15, k_around = 0.1, k_object = 0.45;  // metres
constexpr int k_points = 20000;                                  // of an object's surface
constexpr int k_rays = 256;                                      // of each of two sets
constexpr std::array<int, 3> k_polar = {20, 40, 60};             // degrees from the zenith
constexpr std::array<int, 4> k_azimuths = {34, 124, 214, 304};

Mesh box_mesh(float x, float y, float z) {
  const float size[3] = {x, y, z};
  Mesh mesh = make_box(size);
  for (size_t i = 1; i < mesh.vertices.size(); i += 3) mesh.vertices[i] += 0.5f * y;
  return mesh;
}

// A ramp of 15 cm over 25 cm: a box whose top goes down to the table.
Mesh slope_mesh() {
  Mesh mesh = box_mesh(0.25f, static_cast<float>(k_top), 0.2f);
  for (size_t i = 0; i < mesh.vertices.size(); i += 3)
    if (mesh.vertices[i] < 0) mesh.vertices[i + 1] = 0;
  return mesh;
}

// What stands on a table, by its triangles' areas.
struct Thing {
  Mesh mesh;
  std::vector<double> areas;  // summed up
  Vec3 size;                  // of its box, to each side of the middle; y is its height
  explicit Thing(Mesh made) : mesh(std::move(made)) {
    for (size_t i = 0; i < mesh.vertices.size(); i += 3) {
      const Vec3 p = from_floats(mesh.vertices.data() + i);
      size = {std::max(size.x, std::fabs(p.x)), std::max(size.y, p.y), std::max(size.z, std::fabs(p.z))};
    }
    double all = 0;
    for (size_t t = 0; t < mesh.indices.size(); t += 3) {
      const auto [a, b, c] = corners(t);
      areas.push_back(all += length(cross(b - a, c - a)));
    }
  }
  std::array<Vec3, 3> corners(size_t t) const {
    std::array<Vec3, 3> found;
    for (size_t i = 0; i < 3; ++i)
      found[i] = from_floats(mesh.vertices.data() + 3 * static_cast<size_t>(mesh.indices[t + i]));
    return found;
  }
};

std::vector<Thing> things() {
  std::vector<Thing> all;
  for (Mesh& mesh : table_meshes()) all.emplace_back(std::move(mesh));
  return all;
}

struct Place {
  Vec3 at, normal;
};

// Where places are looked for: what the object's shadow reaches, and a little around it.
struct Area {
  double low[2], high[2];
};

// A point of a surface by area, and how it faces.
Place point_of(const Thing& thing, Random* random) {
  const double pick = random->uniform() * thing.areas.back();
  const size_t t =
      3 * static_cast<size_t>(std::lower_bound(thing.areas.begin(), thing.areas.end(), pick) - thing.areas.begin());
  const auto [a, b, c] = thing.corners(std::min(t, thing.mesh.indices.size() - 3));
  double u = random->uniform(), v = random->uniform();
  if (u + v > 1) {
    u = 1 - u;
    v = 1 - v;
  }
  return {a + (b - a) * u + (c - a) * v, normalised(cross(b - a, c - a))};
}

// Of a thing that stands somewhere, where none of `taken` is in its box.
Place place_on(const Thing& thing, const std::vector<Vec3>& taken, const Area& area, Random* random) {
  const Place place = point_of(thing, random);
  for (;;) {
    const double turn = 2 * std::numbers::pi * random->uniform(), cosine = std::cos(turn), sine = std::sin(turn);
    const Vec3 middle = {area.low[0] + random->uniform() * (area.high[0] - area.low[0]), 0,
                         area.low[1] + random->uniform() * (area.high[1] - area.low[1])};
    const bool is_free = std::none_of(taken.begin(), taken.end(), [&](Vec3 p) {
      const Vec3 d = p - middle;
      return d.y < thing.size.y && std::fabs(cosine * d.x + sine * d.z) < thing.size.x &&
             std::fabs(cosine * d.z - sine * d.x) < thing.size.z;
    });
    if (!is_free) continue;
    const auto turned = [&](Vec3 p) { return Vec3{cosine * p.x - sine * p.z, p.y, sine * p.x + cosine * p.z}; };
    return {middle + turned(place.at), turned(place.normal)};
  }
}

struct Object {
  Mesh mesh;
  bool closed;
  double low[3], high[3];
  std::vector<Vec3> near_table;  // points of its surface where things may stand
  EmbreeScene scene;
  explicit Object(const CastMeshFile& file)
      : mesh([&] {
          Mesh made = file.mesh;
          stand_mesh(&made, k_object, file.name);
          return made;
        }()),
        closed(file.closed),
        scene(EmbreeScene::triangles(mesh.vertices, mesh.indices)) {
    for (size_t axis = 0; axis < 3; ++axis) {
      low[axis] = 1e9;
      high[axis] = -1e9;
      for (size_t i = axis; i < mesh.vertices.size(); i += 3) {
        low[axis] = std::min(low[axis], static_cast<double>(mesh.vertices[i]));
        high[axis] = std::max(high[axis], static_cast<double>(mesh.vertices[i]));
      }
    }
    const Thing surface(mesh);
    Random random = random_stream(3, 0);
    for (int i = 0; i < k_points; ++i)
      if (const Vec3 p = point_of(surface, &random).at; p.y < k_top) near_table.push_back(p);
  }
  // Of the floor: what a light's shadow reaches.
  Area shadow(const Vec3& light, double around) const {
    Area area;
    const double slope[2] = {light.x / light.y, light.z / light.y};
    for (size_t side = 0; side < 2; ++side) {
      area.low[side] = low[2 * side] - std::max(slope[side], 0.0) * high[1] - around;
      area.high[side] = high[2 * side] - std::min(slope[side], 0.0) * high[1] + around;
    }
    return area;
  }
};

// The share that the object hides of a light or, without one, of an even sky, from a surface: by two sets of rays.
std::array<double, 2> hidden(const Object& object, const Place& place, const Vec3* light, Random* random) {
  std::array<double, 2> shares = {};
  for (double& share : shares) {
    double all = 0, hid = 0;
    const double start[2] = {random->uniform(), random->uniform()};
    for (int i = 0; i < k_rays; ++i) {
      const double a = lattice_point(start[0], i, k_plane_steps[0]), b = lattice_point(start[1], i, k_plane_steps[1]);
      const Vec3 d =
          light != nullptr ? cap_direction(*light, std::cos(k_half), a, b) : cosine_direction({0, 1, 0}, a, b);
      const double weight = light != nullptr ? std::max(dot(d, place.normal), 0.0) : 1;
      all += weight;
      if (object.scene.occluded(place.at + place.normal * 1e-5, d, 100)) hid += weight;
    }
    share = all > 0 ? hid / all : 0;
  }
  return shares;
}

struct Made {
  Cast cast;
  uint32_t units = 0;
  double ms = 0;
};

// Of the light, and of an even sky. `lift`: metres of the plane above the table.
Made made_cast(const Object& object, const Vec3& light, uint32_t layers, double lift = 0) {
  Made made;
  sandglass_cast_desc desc = cast_desc();
  desc.triangle_capacity = object.mesh.triangle_count();
  desc.layers = layers;
  sandglass_cast_plane plane = cast_plane();
  plane.origin[1] = static_cast<float>(lift);
  plane.height = static_cast<float>(k_top);
  sandglass_cast_mesh mesh = cast_mesh_of(object.mesh, object.closed, false);
  std::array<float, 3> towards;
  to_floats(light, towards.data());
  if (const Status status = made.cast.create(desc); !status) throw Failure(status.reason);
  for (const Status& status : {made.cast.set_plane(plane), made.cast.set_meshes(&mesh, 1),
                               made.cast.set_light(towards, static_cast<float>(2 * k_half))})
    if (!status) throw Failure(status.reason);
  const double from = cpu_ms_now();
  made.units = made.cast.run();
  made.ms = cpu_ms_now() - from;
  if (made.cast.report().left_out != 0) throw Failure("triangles were left out: the cast is too small");
  return made;
}

// Products of the errors against two sets of rays, so that their noise cancels.
struct Error {
  double sum = 0;
  uint32_t count = 0;
  void add(double value, const std::array<double, 2>& truth) {
    sum += (value - truth[0]) * (value - truth[1]);
    ++count;
  }
  double root() const { return std::sqrt(std::max(sum, 0.0) / std::max(1u, count)); }
};

struct Study {
  std::map<std::string, Error> errors;
  double units[2] = {}, apart = 0, ms[2] = {};  // of one layer and of four; of four casts
};

Vec3 light_at(int polar, int azimuth) {
  const double p = polar * k_degree, a = azimuth * k_degree;
  return {std::sin(p) * std::cos(a), std::cos(p), std::sin(p) * std::sin(a)};
}

uint32_t places_of(const AnythingOptions& options) { return options.quick ? 200 : 600; }

// One light on one object.
void study_light(const Object& object, const std::vector<Thing>& table, int polar, int azimuth,
                 const AnythingOptions& options, uint64_t stream, ThreadPool& pool, Study* study) {
  const Vec3 light = light_at(polar, azimuth);
  const Made one = made_cast(object, light, 1), two = made_cast(object, light, 2), four = made_cast(object, light, 4);
  std::array<Made, 4> apart;
  for (size_t i = 0; i < apart.size(); ++i) {
    apart[i] = made_cast(object, light, 1, k_top * static_cast<double>(i) / 3);
    study->apart += apart[i].units;
  }
  study->units[0] += one.units;
  study->units[1] += four.units;
  study->ms[0] += one.ms;
  study->ms[1] += four.ms;
  struct Row {
    Place place;
    std::array<double, 2> truth;
    bool upright, used;
  };
  std::vector<Row> rows(places_of(options));
  const Area area = object.shadow(light, k_around);
  pool.run(static_cast<uint32_t>(rows.size()), [&](uint32_t i) {
    Random random = random_stream(options.seed + 1, stream * rows.size() + i);
    Row& row = rows[i];
    row.place = place_on(table[i % table.size()], object.near_table, area, &random);
    row.upright = std::fabs(row.place.normal.y) < 0.5;
    row.used = row.place.normal.y > -0.1 && dot(row.place.normal, light) > 0.2;
    if (row.used) row.truth = hidden(object, row.place, &light, &random);
  });
  const std::string at = (std::to_string(polar) + " degrees, ");
  for (const Row& row : rows) {
    if (!row.used) continue;
    const Vec3 p = row.place.at;
    const auto add = [&](const std::string& name, double value) {
      study->errors[at + (row.upright ? "upright, " : "lying, ") + name].add(value, row.truth);
    };
    add("one layer", sampled(one.cast.texture(), p, 0));
    add("one layer, slid", slid(one.cast.texture(), p, 0));
    add("2 layers", slid(two.cast.texture(), p, 0));
    add("4 layers", slid(four.cast.texture(), p, 0));
    const double height = std::clamp(p.y / k_top, 0.0, 1.0) * 3;
    double four_casts = 0;
    for (size_t k = 0; k < 4; ++k) {
      const Vec3 there = p - light * ((p.y - k_top * static_cast<double>(k) / 3) / light.y);
      const double share = std::max(0.0, 1 - std::fabs(height - static_cast<double>(k)));
      if (share > 0) four_casts += share * sampled(apart[k].cast.texture(), there, 0);
    }
    add("four casts", four_casts);
  }
}

// An even sky, on what lies.
void study_sky(const Object& object, const std::vector<Thing>& table, const AnythingOptions& options, uint64_t stream,
               ThreadPool& pool, Study* study) {
  const Made one = made_cast(object, {0, 1, 0}, 1), two = made_cast(object, {0, 1, 0}, 2),
             four = made_cast(object, {0, 1, 0}, 4);
  std::vector<std::pair<Place, std::array<double, 2>>> rows(3 * places_of(options));
  const Area area = object.shadow({0, 1, 0}, 0.5 * k_object);
  pool.run(static_cast<uint32_t>(rows.size()), [&](uint32_t i) {
    Random random = random_stream(options.seed + 2, stream * rows.size() + i);
    auto& [place, truth] = rows[i];
    do place = place_on(table[i % table.size()], object.near_table, area, &random);
    while (place.normal.y < 0.5);
    place.normal = {0, 1, 0};
    truth = hidden(object, place, nullptr, &random);
    for (double& share : truth) share = 1 - share;
  });
  for (const auto& [place, truth] : rows) {
    study->errors["even sky, one layer"].add(sampled(one.cast.ambient(), place.at, 1), truth);
    study->errors["even sky, 2 layers"].add(slid(two.cast.ambient(), place.at, 1), truth);
    study->errors["even sky, 4 layers"].add(slid(four.cast.ambient(), place.at, 1), truth);
  }
}

// Of a further mesh the controls are reported: whether they fail depends on its shape.
std::vector<Verdict> rows_of(const Study& study, const std::string& group, bool further) {
  std::vector<Verdict> rows;
  const auto add = [&](const std::string& name, const char* unit, double value, double limit, bool control = false) {
    const bool judged = control && !further;
    const double most = control && further ? k_reported : limit;
    rows.push_back(
        {group, further ? group + ", " + name : name, unit, 0, value, most, (value <= most) != judged, judged});
  };
  const auto error = [&](const std::string& name, double limit, bool control = false) {
    add(name, "rmse", study.errors.at(name).root(), limit, control);
  };
  constexpr double k_lying[] = {0.03, 0.03, 0.055}, k_upright[] = {0.04, 0.04, 0.06};
  for (size_t i = 0; i < k_polar.size(); ++i)
    for (const bool upright : {false, true}) {
      const std::string name = std::to_string(k_polar[i]) + (upright ? " degrees, upright, " : " degrees, lying, ");
      const double limit = upright ? k_upright[i] : k_lying[i];
      error(name + "4 layers", limit);
      error(name + "one layer", limit, true);
      for (const char* other : {"one layer, slid", "2 layers", "four casts"}) error(name + other, k_reported);
    }
  error("even sky, 2 layers", 0.02);
  error("even sky, 4 layers", k_reported);
  error("even sky, one layer", 0.02, true);
  add("work units, 4 layers over one", "times", study.units[1] / study.units[0], 3.5);
  add("work units, four casts over one", "times", study.apart / study.units[0], 3.5, true);
  add("both textures, one layer", "ms", study.ms[0], k_reported);
  add("both textures, 4 layers", "ms", study.ms[1], k_reported);
  return rows;
}

// Times and units are means of the lights. False: stopped.
bool study_meshes(const std::vector<CastMeshFile>& meshes, const AnythingOptions& options, uint64_t* stream,
                  ThreadPool& pool, const std::function<bool()>& go_on, Study* study) {
  const std::vector<Thing> table = things();
  uint32_t lights = 0;
  for (const CastMeshFile& file : meshes) {
    const Object object(file);
    study_sky(object, table, options, ++*stream, pool, study);
    if (!go_on()) return false;
    for (const int polar : k_polar) {
      const size_t one = *stream % k_azimuths.size(), first = options.quick ? one : 0,
                   end = options.quick ? one + 1 : k_azimuths.size();
      for (size_t i = first; i < end; ++i, ++lights) {
        study_light(object, table, polar, k_azimuths[i], options, ++*stream, pool, study);
        if (!go_on()) return false;
      }
    }
  }
  for (double& ms : study->ms) ms /= lights;
  return true;
}

}  // namespace

std::vector<Mesh> table_meshes() {
  return {box_mesh(0.24f, 0.03f, 0.17f),
          box_mesh(0.2f, 0.07f, 0.13f),
          make_revolved(bucket_profile(0.1, 0.035, 0.042, 0.004), 48),
          make_revolved(bucket_profile(0.06, 0.04, 0.09, 0.004), 48),
          slope_mesh(),
          box_mesh(0.02f, static_cast<float>(k_top), 0.2f)};
}

size_t anything_steps(const AnythingOptions& options) {
  return (options.meshes.size() + options.further.size()) *
         (1 + k_polar.size() * (options.quick ? 1 : k_azimuths.size()));
}

std::vector<Verdict> verify_anything(const AnythingOptions& options, ThreadPool& pool,
                                     const std::function<bool()>& go_on) {
  uint64_t stream = 0;
  std::vector<Verdict> rows;
  const auto take = [&](const std::vector<CastMeshFile>& meshes, const std::string& group, bool further) {
    Study study;
    if (!study_meshes(meshes, options, &stream, pool, go_on, &study)) return false;
    const std::vector<Verdict> more = rows_of(study, group, further);
    rows.insert(rows.end(), more.begin(), more.end());
    return true;
  };
  if (!take(options.meshes, "anything", false)) return {};
  for (const CastMeshFile& file : options.further)
    if (!take({file}, file.name, true)) return {};
  return rows;
}

}  // namespace sandglass::host
