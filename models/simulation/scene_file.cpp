#include "models/simulation/scene_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/files/shipped_file.h"
#include "models/simulation/strict_reader.h"
#include "runtime/math/math.h"

namespace sandglass::host {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr uint32_t k_frame_limit = 100'000'000;

void read_solver(StrictReader reader, sandglass_granular_desc* granular) {
  granular->reference.scheme = reader.choice("scheme", {"small_step", "averaged"}, granular->reference.scheme);
  granular->reference.solver_iterations = reader.integer("iterations", granular->reference.solver_iterations, 1, 64);
  granular->reference.stabilisation_iterations =
      reader.integer("stabilisation", granular->reference.stabilisation_iterations, 0, 8);
  // Averaged corrections may be overdone. A pair's correction ends its overlap at 1; beyond, it throws the pair apart.
  const double relaxation_limit = granular->reference.scheme == SANDGLASS_SCHEME_AVERAGED ? 2.0 : 1.0;
  if (granular->reference.scheme == SANDGLASS_SCHEME_AVERAGED) granular->reference.relaxation = 1.0f;
  granular->reference.relaxation = reader.real("relaxation", granular->reference.relaxation, 1e-3, relaxation_limit);
  granular->substep_max = reader.real("substep_max", granular->substep_max, 0.0, SANDGLASS_SUBSTEP_LIMIT);
  granular->substep_min = reader.real("substep_min", granular->substep_min, 0.0, SANDGLASS_SUBSTEP_LIMIT);
  granular->height_weighting = reader.real("height_weighting", granular->height_weighting, 0.0, 1.5);
  granular->courant = reader.real("courant", granular->courant, 1e-3, 1.0);
  granular->list_margin = reader.real("list_margin", granular->list_margin, 0.1, 1.0);
  granular->reference.blend = reader.choice("blend", {"continuous", "source", "means"}, granular->reference.blend);
  granular->refine_step = reader.real("refine_step", granular->refine_step, 1e-4, 0.1);
  reader.finish();
}

Profile read_profile(StrictReader& reader) {
  if (!reader.has("profile")) reader.refuse("profile", "is missing; give a closed outline [[r, y], ...]");
  return reader.outline("profile");
}

Body read_body(StrictReader& reader) {
  Body body;
  const std::vector<std::string> shapes = {"trefoil", "mesh", "box", "sphere", "lattice", "revolved"};
  body.shape = static_cast<BodyShape>(reader.choice("shape", shapes, -1));
  const bool lattice = body.shape == BodyShape::lattice;
  const std::string shape = "a body of shape \"" + shapes[static_cast<size_t>(body.shape)] + "\"";
  if (body.shape == BodyShape::box) body.size = reader.vector("size", {}, 1e-4, k_length_limit);
  else body.size.y = reader.number("size", 0.0, 1e-4, k_length_limit);
  if (body.shape == BodyShape::revolved) {
    if (body.size.y > 0.0) reader.refuse("size", "does not apply to " + shape + "; its outline has a size");
    body.profile = read_profile(reader);
    const ProfileExtent extent = extent_of(body.profile);
    body.size.y = extent.top - extent.bottom;
    if (!(body.size.y > 0.0)) reader.refuse("profile", "is flat; an outline has a height");
  }
  if (lattice && body.size.y > 0.0)
    reader.refuse("size", "does not apply to " + shape + "; its size follows from \"counts\" and \"spacing\"");
  if (reader.has("counts")) {
    if (!lattice) reader.refuse("counts", "does not apply to " + shape);
    const std::vector<double> counts = reader.numbers("counts", 3, 1, 10000);
    for (size_t i = 0; i < 3; ++i) {
      if (counts[i] != std::floor(counts[i])) reader.refuse("counts", "must be three whole numbers");
      body.counts[i] = static_cast<uint32_t>(counts[i]);
    }
    if (counts[0] * counts[1] * counts[2] > SANDGLASS_PARTICLE_LIMIT)
      reader.refuse("counts", "asks for more than " + number_text(SANDGLASS_PARTICLE_LIMIT) + " particles");
  } else if (lattice) {
    reader.refuse("counts", "is missing; a lattice block needs [x, y, z]");
  }
  body.spacing = reader.number("spacing", body.spacing, 2.0, 10.0);
  body.jitter = reader.number("jitter", 0.0, 0.0, 0.5);
  body.particles = reader.integer("particles", 0, 1, SANDGLASS_PARTICLE_LIMIT);
  if (lattice && body.particles > 0)
    reader.refuse("particles", "does not apply to " + shape + "; \"counts\" says how many");
  if (body.shape == BodyShape::box && body.size.x == 0.0 && body.particles == 0)
    reader.fail(shape, "needs \"size\" [x, y, z] or \"particles\"");
  if (!lattice && body.size.y == 0.0 && body.particles == 0) reader.fail(shape, "needs \"size\" or \"particles\"");
  body.grains = reader.integer("grains", 0, 0, SANDGLASS_GRAIN_LIMIT);
  body.grain_distance = reader.number("grain_distance", 0.0, 1e-5, k_length_limit);
  if (body.grains > 0 && body.grain_distance > 0.0)
    reader.refuse("grain_distance", "and \"grains\" are both given; give one of the two");
  body.grain_grid = reader.choice("grain_fill", {"poisson", "grid"}, lattice ? 1 : 0) == 1;
  if (lattice && !body.grain_grid) reader.refuse("grain_fill", "must be \"grid\" for " + shape);
  if (lattice && body.grain_distance > 0.0)
    reader.refuse("grain_distance", "does not apply to " + shape + "; give \"grains\"");
  body.position = reader.vector("position", {}, -k_length_limit, k_length_limit);
  body.velocity = reader.vector("velocity", {}, -1000.0, 1000.0);
  body.rotation = reader.rotation("rotation");
  body.rigid = reader.number("rigid", 0.0, 1e-3, 1e3);
  body.spin = reader.vector("angular_velocity", {}, -1000.0, 1000.0);
  if (body.rigid > 0.0 && (body.grains > 0 || body.grain_distance > 0.0))
    reader.refuse("grains", "do not apply to a rigid body; leave them out");
  if (body.rigid == 0.0 && length(body.spin) > 0.0)
    reader.refuse("angular_velocity", "applies to rigid bodies only; sand takes \"velocity\"");
  return body;
}

ColliderTrack read_collider(StrictReader& reader) {
  ColliderTrack track;
  const int shape = reader.choice("shape", {"half_space", "sphere", "capsule", "box", "revolved", "mesh"}, -1);
  constexpr int k_revolved = 4, k_mesh = 5;
  track.shape = shape < k_revolved ? shape : SANDGLASS_SHAPE_FIELD;
  track.position = reader.vector("position", {}, -k_length_limit, k_length_limit);
  track.rotation = reader.rotation("rotation");
  const bool sized = reader.has("size"), sizeless = track.shape == SANDGLASS_SHAPE_HALF_SPACE || shape == k_revolved;
  if (sized == sizeless) reader.refuse("size", sized ? "does not apply to this shape" : "is missing");
  if (shape >= k_revolved) {
    track.solid_outside = reader.choice("solid", {"inside", "outside"}, 0) == 1;
    track.field_spacing = reader.number("field_spacing", 0.0, 1e-4, 10.0);
    if (shape == k_revolved) track.profile = read_profile(reader);
    if (shape == k_mesh) track.size.y = reader.number("size", 0.0, 1e-4, k_length_limit);
    if (shape == k_mesh && reader.has("mesh"))
      track.mesh = mesh_names()[static_cast<size_t>(reader.choice("mesh", mesh_names(), -1))];
    if (shape == k_mesh) track.shadow = reader.text("shadow", "");
    if (shape == k_mesh) track.casts = reader.choice("casts", {"nothing", "triangles"}, 0) == 1;
    if (shape == k_mesh) track.metal = reader.choice("surface", {"paint", "metal"}, 0) == 1;
    if (track.metal && !track.casts) reader.refuse("surface", "is metal only where \"casts\" is \"triangles\"");
    if (track.casts && track.mesh.empty()) reader.refuse("casts", "needs a mesh that is named by \"mesh\"");
    if (track.casts && !track.shadow.empty()) reader.refuse("casts", "and \"shadow\" are both given; leave one out");
    const Quaternion& q = track.rotation;
    if (!track.shadow.empty() && std::fabs(q[0]) + std::fabs(q[2]) > 1e-6)
      reader.refuse("shadow", "needs an object that stands upright; turn it about y only");
  }
  if (track.shape == SANDGLASS_SHAPE_SPHERE) track.size.x = reader.number("size", 0.0, 1e-4, k_length_limit);
  if (track.shape == SANDGLASS_SHAPE_CAPSULE) {
    const std::vector<double> size = reader.numbers("size", 2, 1e-4, k_length_limit);
    track.size = {size[0], size[1], 0.0};
  }
  if (track.shape == SANDGLASS_SHAPE_BOX) track.size = reader.vector("size", {}, 1e-4, k_length_limit);
  reader.each("motion", 10000, [&](StrictReader& entry) {
    MotionSegment segment;
    segment.start = entry.number("start", 0.0, 0.0, 1e6);
    segment.end = entry.number("end", 1e6, 0.0, 1e6);
    if (segment.end < segment.start) entry.refuse("end", "lies before \"start\"");
    segment.linear_velocity = entry.vector("linear_velocity", {}, -100.0, 100.0);
    segment.angular_velocity = entry.vector("angular_velocity", {}, -100.0, 100.0);
    track.motion.push_back(segment);
  });
  return track;
}

LightTrack read_light(StrictReader reader) {
  LightTrack light;
  const auto angles = [&](const char* key, double lowest, double highest, double(&out)[2]) {
    if (!reader.has(key)) return;
    if (!reader.is_array(key)) {
      out[0] = out[1] = reader.number(key, 0, lowest, highest);
      return;
    }
    const std::vector<double> ends = reader.numbers(key, 2, lowest, highest);
    out[0] = ends[0];
    out[1] = ends[1];
  };
  angles("polar", 0.0, 180.0, light.polar_deg);
  angles("azimuth", -3600.0, 3600.0, light.azimuth_deg);
  reader.finish();
  return light;
}

ShotTrack read_shot(StrictReader reader) {
  ShotTrack shot;
  shot.turn_deg = reader.number("turn", 0.0, -360.0, 360.0);
  shot.sway_deg = reader.number("sway", 0.0, 0.0, 10.0);
  shot.kept = reader.text("kept", "");
  shot.room = reader.integer("room", 1, 0, ~0u);
  shot.azimuth_deg = reader.number("azimuth", 90.0, -360.0, 360.0);
  reader.finish();
  return shot;
}

PileShadowTrack read_pile_shadow(StrictReader reader) {
  PileShadowTrack track;
  for (const char* key : {"low", "high"})
    if (!reader.has(key))
      reader.refuse(key, "is missing; give the corner [x, z] of the floor that the shadow may reach");
  const std::vector<double> low = reader.numbers("low", 2, -k_length_limit, k_length_limit);
  const std::vector<double> high = reader.numbers("high", 2, -k_length_limit, k_length_limit);
  for (size_t axis = 0; axis < 2; ++axis) {
    track.low[axis] = low[axis];
    track.high[axis] = high[axis];
    if (!(high[axis] > low[axis])) reader.refuse("high", "is not above \"low\" in both coordinates");
  }
  track.texels = reader.integer("texels", track.texels, 32, 256);
  if (track.texels % 32 != 0) reader.refuse("texels", "must be a multiple of 32");
  reader.finish();
  return track;
}

EmitterTrack read_emitter(StrictReader& reader) {
  EmitterTrack track;
  to_floats(reader.vector("position", {}, -k_length_limit, k_length_limit), track.emitter.position);
  const Quaternion rotation = reader.rotation("rotation");
  for (size_t i = 0; i < 4; ++i) track.emitter.rotation[i] = static_cast<float>(rotation[i]);
  if (!reader.has("radius")) reader.refuse("radius", "is missing; give the nozzle's radius in metres");
  track.emitter.radius = reader.real("radius", 0.0f, 1e-4, 100.0);
  track.emitter.speed = reader.real("speed", 0.5f, 1e-3, 100.0);
  track.emitter.grains_per_particle = reader.integer("grains_per_particle", 0, 0, 64);
  track.start = reader.number("start", 0.0, 0.0, 1e6);
  track.end = reader.number("end", 1e6, 0.0, 1e6);
  if (track.end < track.start) reader.refuse("end", "lies before \"start\"");
  return track;
}

Camera read_camera(StrictReader reader) {
  Camera camera;
  camera.eye = reader.vector("eye", {0.5, 0.5, 1.0}, -10.0 * k_length_limit, 10.0 * k_length_limit);
  camera.target = reader.vector("target", {}, -k_length_limit, k_length_limit);
  camera.fov_deg = reader.number("fov_deg", camera.fov_deg, 1.0, 120.0);
  const Vec3 line = camera.target - camera.eye;
  if (std::sqrt(line.x * line.x + line.z * line.z) < 1e-3 * length(line) || length(line) == 0.0)
    reader.refuse("target", "lies straight above or below \"eye\", or in it; move one of the two");
  reader.finish();
  return camera;
}

json parsed(const std::string& text, const std::string& source) {
  std::vector<std::set<std::string>> names;  // of every object that is open
  const auto refuse_twice = [&](int, json::parse_event_t event, const json& value) {
    if (event == json::parse_event_t::object_start) names.emplace_back();
    if (event == json::parse_event_t::object_end) names.pop_back();
    if (event == json::parse_event_t::key && !names.back().insert(value.get<std::string>()).second)
      throw cannot("read", source, "one object has " + in_quotes(value.get<std::string>()) + " twice", "Remove one");
    return true;
  };
  try {
    return json::parse(text, refuse_twice);
  } catch (const json::parse_error& error) {
    size_t line = 1;
    for (size_t i = 0; i + 1 < error.byte && i < text.size(); ++i) line += text[i] == '\n';
    throw cannot("read", source, "line " + std::to_string(line) + " is not valid JSON", "Correct it");
  } catch (const json::exception&) {
    throw cannot("read", source, "it has a number that no double can hold", "Correct it");
  }
}

// What one part of a scene needs of another.
void expect_whole(const SceneFile& scene, const StrictReader& reader) {
  const bool shaded = std::any_of(scene.colliders.begin(), scene.colliders.end(),
                                  [](const ColliderTrack& track) { return !track.shadow.empty() || track.casts; });
  if ((shaded || scene.pile_shadow) && !scene.light && !scene.shot)
    reader.refuse("light", "is missing, but something casts a shadow; give it");
  if (scene.shot && scene.light)
    reader.refuse("light", "and \"shot\" are both given; the light of a shot is its room's");
  if (scene.shot && !scene.camera) reader.refuse("camera", "is missing; a shot is seen by one");
  if (scene.bodies.empty() && scene.emitters.empty())
    reader.refuse("bodies", "is missing or empty; name at least one body to fill with sand, or an emitter");
  const bool pours_grains = std::any_of(scene.emitters.begin(), scene.emitters.end(), [](const EmitterTrack& track) {
    return track.emitter.grains_per_particle > 0;
  });
  if (!scene.emitters.empty() && scene.granular.particle_capacity == 0)
    reader.refuse("particle_capacity", "is missing; say how many particles the emitters may fill the scene with");
  if (pours_grains && scene.granular.grain_capacity == 0)
    reader.refuse("grain_capacity", "is missing; say how many grains the emitters may fill the scene with");
  const bool radius_follows = std::any_of(scene.bodies.begin(), scene.bodies.end(),
                                          [](const Body& body) { return body.size.y > 0.0 && body.particles > 0; });
  if (scene.particle_radius == 0.0 && !radius_follows)
    reader.refuse("particle_radius", "is missing; give it in metres, or give one body both \"size\" and \"particles\"");
  if (scene.particle_radius > 0.0 && radius_follows)
    reader.refuse("particle_radius",
                  "and a body with both \"size\" and \"particles\" contradict each other; leave one of the three out");
}

}  // namespace

SceneFile parse_scene(const std::string& text, const std::string& source) {
  const json file = parsed(text, source);
  SceneFile scene;
  scene.source = source;
  sandglass_scene_desc defaults;
  sandglass_scene_desc_default(&defaults);
  scene.granular = defaults.granular;

  StrictReader reader(file, source, "");
  scene.name = reader.text("name", fs::path(source).stem().string());
  scene.frames = reader.integer("frames", scene.frames, 1, k_frame_limit);
  scene.frame_step = reader.number("frame_step", scene.frame_step, 1e-4, 0.1);
  scene.budget_ms = reader.number("budget_ms", scene.budget_ms, 0.0, 1e6);
  scene.seed = reader.integer("seed", 1, 0, ~0u);
  scene.particle_radius = reader.number("particle_radius", 0.0, 1e-4, 10.0);
  to_floats(reader.vector("gravity", {0.0, -9.81, 0.0}, -SANDGLASS_GRAVITY_LIMIT, SANDGLASS_GRAVITY_LIMIT),
            scene.gravity);
  if (reader.has("friction")) {
    StrictReader friction = reader.child("friction");
    scene.granular.static_friction =
        friction.real("static", scene.granular.static_friction, 0.0, SANDGLASS_FRICTION_LIMIT);
    scene.granular.kinetic_friction =
        friction.real("kinetic", scene.granular.kinetic_friction, 0.0, SANDGLASS_FRICTION_LIMIT);
    friction.finish();
  }
  if (reader.has("solver")) read_solver(reader.child("solver"), &scene.granular);
  scene.granular.particle_capacity = reader.integer("particle_capacity", 0, 1, SANDGLASS_PARTICLE_LIMIT);
  scene.granular.grain_capacity = reader.integer("grain_capacity", 0, 1, SANDGLASS_GRAIN_LIMIT);
  scene.granular.collider_capacity = reader.integer("collider_capacity", 0, 1, SANDGLASS_COLLIDER_LIMIT);
  uint64_t particles = 0, grains = 0;
  reader.each("bodies", 1000, [&](StrictReader& entry) {
    const Body& body = scene.bodies.emplace_back(read_body(entry));
    particles += body.particles + uint64_t{body.counts[0]} * body.counts[1] * body.counts[2];
    grains += body.grains;
  });
  if (particles > SANDGLASS_PARTICLE_LIMIT)
    reader.refuse("bodies", "ask for more than " + number_text(SANDGLASS_PARTICLE_LIMIT) + " particles");
  if (grains > SANDGLASS_GRAIN_LIMIT)
    reader.refuse("bodies", "ask for more than " + number_text(SANDGLASS_GRAIN_LIMIT) + " grains");
  reader.each("colliders", SANDGLASS_COLLIDER_LIMIT,
              [&](StrictReader& entry) { scene.colliders.push_back(read_collider(entry)); });
  if (reader.has("light")) scene.light = read_light(reader.child("light"));
  if (reader.has("shot")) scene.shot = read_shot(reader.child("shot"));
  if (reader.has("pile_shadow")) scene.pile_shadow = read_pile_shadow(reader.child("pile_shadow"));
  reader.each("emitters", SANDGLASS_FLOW_LIMIT,
              [&](StrictReader& entry) { scene.emitters.push_back(read_emitter(entry)); });
  reader.each("sinks", SANDGLASS_FLOW_LIMIT, [&](StrictReader& entry) {
    scene.sinks.push_back(read_collider(entry));
    if (scene.sinks.back().shape == SANDGLASS_SHAPE_FIELD || !scene.sinks.back().motion.empty())
      entry.refuse("shape", "must be a resting half_space, sphere, capsule or box in a sink");
  });
  if (reader.has("camera")) scene.camera = read_camera(reader.child("camera"));
  reader.finish();
  expect_whole(scene, reader);
  return scene;
}

Vec3 LightTrack::towards(double share) const {
  const auto turns = [&](const double(&ends)[2]) { return (ends[0] + (ends[1] - ends[0]) * share) / 360.0; };
  const SinCos polar = sin_cos_turns(turns(polar_deg)), azimuth = sin_cos_turns(turns(azimuth_deg));
  return {polar.sin * azimuth.cos, polar.cos, polar.sin * azimuth.sin};
}

std::string find_scene(const std::string& name_or_path) {
  std::error_code error;
  if (fs::is_regular_file(name_or_path, error)) return name_or_path;
  std::set<std::string> names;
  if (const std::string path = shipped_file("scenes", name_or_path + ".json"); !path.empty()) return path;
  for (const std::string& folder : shipped_folders("scenes"))
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
      if (entry->path().extension() == ".json") names.insert(entry->path().stem().string());
  if (fs::exists(name_or_path, error)) return name_or_path;  // a folder, pipe or device: read_file says so
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  throw cannot("find", name_or_path, "no file and no shipped scene has this name",
               list.empty() ? "Name a scene file" : "Name a scene file, or one of " + list);
}

SceneFile load_scene(const std::string& name_or_path) {
  const std::string path = find_scene(name_or_path);
  return parse_scene(read_file(path, "scene", k_text_limit), path);
}

double revolved_distance(const Profile& profile, Vec3 point) {
  const double r = std::sqrt(point.x * point.x + point.z * point.z), y = point.y;
  double nearest2 = 1e300;
  bool inside = false;
  for (size_t i = 0; i < profile.size(); ++i) {
    const auto& a = profile[i];
    const auto& b = profile[(i + 1) % profile.size()];
    const double dr = b[0] - a[0], dy = b[1] - a[1], length2 = dr * dr + dy * dy;
    // A line on the axis only closes the outline; it makes no surface.
    if (length2 > 0.0 && (a[0] > 0.0 || b[0] > 0.0)) {
      const double t = std::clamp(((r - a[0]) * dr + (y - a[1]) * dy) / length2, 0.0, 1.0);
      const double er = r - (a[0] + t * dr), ey = y - (a[1] + t * dy);
      nearest2 = std::min(nearest2, er * er + ey * ey);
    }
    if ((a[1] > y) != (b[1] > y) && r < a[0] + dr * (y - a[1]) / dy) inside = !inside;
  }
  return (inside ? -1.0 : 1.0) * std::sqrt(nearest2);
}

sandglass_collider collider_over_frame(const ColliderTrack& track, double time, double frame_step) {
  const double end = time + frame_step, middle = time + 0.5 * frame_step;
  Vec3 position = track.position, linear, angular;
  Quaternion rotation = track.rotation;
  for (const MotionSegment& segment : track.motion) {
    if (end > segment.start) {
      const double moved = std::min(end, segment.end) - segment.start;
      position = position + segment.linear_velocity * moved;
      rotation = normalised(multiply(rotation_by(segment.angular_velocity * moved), rotation));
    }
    if (middle >= segment.start && middle < segment.end) {
      linear = linear + segment.linear_velocity;
      angular = angular + segment.angular_velocity;
    }
  }
  sandglass_collider collider = {};
  collider.shape = track.shape;
  collider.field = track.field;
  to_floats(position, collider.position);
  to_floats(track.size, collider.size);
  to_floats(linear, collider.linear_velocity);
  to_floats(angular, collider.angular_velocity);
  for (size_t i = 0; i < 4; ++i) collider.rotation[i] = static_cast<float>(rotation[i]);
  return collider;
}

Flow flow_over_frame(const SceneFile& scene, double time) {
  Flow flow;
  for (const EmitterTrack& track : scene.emitters)
    if (time >= track.start && time < track.end) flow.emitters.push_back(track.emitter);
  for (const ColliderTrack& track : scene.sinks)
    flow.sinks.push_back(collider_over_frame(track, time, scene.frame_step));
  return flow;
}

float drawn_grain_radius(double particle_radius, uint32_t particles, uint32_t grains) {
  // A factor on the radius, so that grains have less than the particles' own volume: they also lie in the pores between
  // particles.
  constexpr double k_fill = 0.9;
  // Enough steps from 1 down to the cube root of 1e-8. libm's cbrt is not used, because it differs between machines.
  constexpr int k_newton_steps = 200;
  if (grains <= particles) return static_cast<float>(particle_radius);
  const double ratio = static_cast<double>(particles) / grains;
  double root = 1.0;
  for (int i = 0; i < k_newton_steps; ++i) root = (2.0 * root + ratio / (root * root)) / 3.0;
  return static_cast<float>(k_fill * particle_radius * root);
}

sandglass_scene_desc describe_scene(const SceneFile& scene, uint32_t particles, uint32_t grains) {
  sandglass_scene_desc desc;
  sandglass_scene_desc_default(&desc);
  std::copy_n(scene.gravity, 3, desc.gravity);
  desc.granular = scene.granular;
  desc.granular.particle_radius = static_cast<float>(scene.particle_radius);
  desc.granular.emitter_capacity = static_cast<uint32_t>(scene.emitters.size());
  desc.granular.sink_capacity = static_cast<uint32_t>(scene.sinks.size());
  // Grains lie on the floor with the radius that they are drawn with.
  uint32_t standing_for = particles, drawn = grains;
  for (const EmitterTrack& track : scene.emitters) {
    ++standing_for;
    drawn += track.emitter.grains_per_particle;
    const float r = desc.granular.particle_radius, radius = track.emitter.radius;
    if (!(radius >= r && radius <= 100.0f * r))  // sandglass_emitter: the library would leave it out
      throw cannot("use", scene.source, "\"radius\" of an emitter is not 1 to 100 particle radii",
                   "Make it wider or narrower");
  }
  if (drawn > 0) desc.granular.grain_radius = drawn_grain_radius(scene.particle_radius, standing_for, drawn);
  const auto fit = [&](uint32_t* capacity, uint32_t need, const char* key) {
    if (*capacity == 0) *capacity = need;
    if (*capacity < need)
      throw cannot("use", scene.source,
                   "\"" + std::string(key) + "\" is " + std::to_string(*capacity) + ", and the scene holds " +
                       std::to_string(need),
                   "Raise it or leave it out");
  };
  fit(&desc.granular.particle_capacity, particles, "particle_capacity");
  fit(&desc.granular.grain_capacity, grains, "grain_capacity");
  fit(&desc.granular.collider_capacity, static_cast<uint32_t>(scene.colliders.size()), "collider_capacity");
  expect_taken(scene, desc);
  return desc;
}

void expect_taken(const SceneFile& scene, const sandglass_scene_desc& desc) {
  uint64_t bytes = 0;
  const char* reason = nullptr;
  if (sandglass_scene_bytes(&desc, &bytes, &reason) != SANDGLASS_OK) throw cannot("use", scene.source, reason);
}

}  // namespace sandglass::host
