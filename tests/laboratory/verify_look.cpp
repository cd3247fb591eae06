// `sandglass_lab verify look`: whether drawn sand looks like sand: the kit's picture of a pile beside a path tracing of balls
// of 0.6 mm on the same surface, in three lights, from three distances and from the dark side; how its grains move; what a
// renderer is handed; and controls.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "models/compositing/shot.h"
#include "models/compositing/surroundings.h"
#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/mesh/generated.h"
#include "models/simulation/scene_shadows.h"
#include "models/simulation/simulation.h"
#include "sandglass/sandglass.hpp"
#include "tests/laboratory/shot/shot_stage.h"
#include "tests/laboratory/verify.h"

namespace sandglass::host {

namespace {

struct LookOptions : VerifyOptions {
  std::string plain;
};

constexpr double k_infinity = std::numeric_limits<double>::infinity();
constexpr int k_width = 192, k_height = 160, k_block = 32;  // pixels
constexpr double k_focal = 1236.0;  // pixels: those of a picture 900 high that is 40 degrees high
constexpr int k_paths = 48;         // of each of two truths, whose noise has nothing to do with each other
constexpr int k_scales[] = {1, 2, 4, 8};

struct Light {
  const char* name;
  Vec3 towards, facing, sky;  // radiance of a white surface that faces the main light; of the sky
};
// The kit's constants were chosen in the first one, and in four others that are not here.
const Light k_lights[] = {
    {"sun", normalised(Vec3{-0.51, 0.77, 0.37}), {0.53, 0.49, 0.42}, {0.144, 0.160, 0.188}},
    {"cool side", normalised(Vec3{-0.80, 0.55, -0.20}), {0.38, 0.42, 0.50}, {0.10, 0.11, 0.14}},
    {"noon", normalised(Vec3{0.15, 0.95, 0.25}), {0.45, 0.42, 0.36}, {0.16, 0.17, 0.19}},
};
constexpr double k_distances[] = {0.3, 0.6, 1.1};

struct Seen {
  const Light* light;
  double distance;
  bool dark_side;
  std::string name() const {
    char text[64];
    std::snprintf(text, sizeof text, "%s, %.1f m%s", light->name, distance, dark_side ? ", dark side" : "");
    return text;
  }
};

// The pile alone: without chair, without what lies loose.
struct Pile {
  ShotStage stage;
  SandShape sand;
  SandShaper shaper;
  std::vector<sandglass_collider> floor;
  LitObject nothing;
  Vec3 middle;
  double reach = 0.0;  // from the middle to most of the foot

  Pile() {
    floor = {cpp_floor()};
    sand = shape({0, 0, 0});
    for (const sandglass_skin_vertex& v : sand.vertices)
      middle = middle + from_floats(v.position) * (1.0 / static_cast<double>(sand.vertices.size()));
    for (const sandglass_skin_vertex& v : sand.vertices)
      reach +=
          std::hypot(static_cast<double>(v.position[0]) - middle.x, static_cast<double>(v.position[2]) - middle.z) /
          static_cast<double>(sand.vertices.size());
    const float size[3] = {0.01f, 0.01f, 0.01f};
    nothing.mesh = make_box(size);
    for (float& x : nothing.mesh.vertices) x += 90.0f;
  }

  static sandglass_collider cpp_floor() {
    sandglass_collider collider = {};
    collider.shape = SANDGLASS_SHAPE_HALF_SPACE;
    collider.rotation[3] = 1.0f;
    return collider;
  }

  // As it lies, moved by so much.
  SandShape shape(Vec3 by) {
    std::vector<float> moved = stage.particles;
    for (size_t i = 0; i < moved.size(); i += 3) to_floats(from_floats(&moved[i]) + by, &moved[i]);
    SandShape made = shaper.shape({moved, {}, floor, static_cast<float>(stage.scene.particle_radius)});
    made.loose.clear();
    made.flying = 0;
    return made;
  }

  // Looks down by 35 degrees at the slope on the side of `from`.
  Camera camera(Vec3 from, double distance) const {
    constexpr double k_down = 35.0 * std::numbers::pi / 180.0;
    const Vec3 side = normalised(Vec3{from.x, 0, from.z}), wanted = middle + side * (0.45 * reach);
    Camera c;
    double nearest = k_infinity;
    for (const sandglass_skin_vertex& v : sand.vertices) {
      const Vec3 p = from_floats(v.position);
      const double away = std::hypot(p.x - wanted.x, p.z - wanted.z);
      if (v.normal[1] > 0 && away < nearest) {
        nearest = away;
        c.target = p;
      }
    }
    c.eye = c.target + (side * std::cos(k_down) + Vec3{0, std::sin(k_down), 0}) * distance;
    c.fov_deg = 2.0 * std::atan(0.5 * k_height / k_focal) * 180.0 / std::numbers::pi;
    return c;
  }
};

// The room of a light: a sky, a disk of 20 degrees, a floor that reflects four tenths. And the light as the library has it.
struct Room {
  Surroundings surroundings;
  PlacedLight light;
};
Room room_of(const Light& light, const Camera& camera) {
  constexpr int k_map = 1024;
  constexpr double k_half_angle = 10.0 * std::numbers::pi / 180.0, k_reflects = 0.4;
  const double sine = std::sin(k_half_angle);
  const Vec3 disk = light.facing * (1.0 / (sine * sine));
  const auto fill = [&](bool with_disk, Vec3 below) {
    return panorama_of(k_map, k_map / 2, [&](Vec3 d) {
      const Vec3 radiance = d.y > 0.0 ? light.sky * (0.8 + 0.4 * d.y) : below;
      return with_disk && dot(d, light.towards) > std::cos(k_half_angle) ? radiance + disk : radiance;
    });
  };
  const Vec3 main = light.facing * (light.towards.y * std::numbers::pi);  // irradiance of the floor
  const Vec3 rest = light.sky * (std::numbers::pi * (0.8 + 0.4 * 2.0 / 3.0));
  const Vec3 floor = (main + rest) * (k_reflects / std::numbers::pi);
  const double azimuth =
      std::atan2(camera.target.z - camera.eye.z, camera.target.x - camera.eye.x) * 180.0 / std::numbers::pi;
  Room room;
  room.surroundings = panorama_surroundings(fill(true, floor), light.name, camera, azimuth, camera.target, 0.0);
  room.surroundings.exposure = 1.0;
  const Surroundings ambient =
      panorama_surroundings(fill(false, floor), light.name, camera, azimuth, camera.target, 0.0);
  ShotLight all = light_above_floor(ambient.warped, ambient.view, floor);
  const ShotLight main_part = one_light(light.towards, 1.0, main);
  for (size_t i = 0; i < std::size(all.sh); ++i) all.sh[i] += main_part.sh[i];
  to_floats(from_floats(all.irradiance) + main, all.irradiance);
  to_floats(light.towards, all.main_direction);
  to_floats(main * (1.0 / luminance(main)), all.main_colour);
  all.main_share = static_cast<float>(luminance(main) / luminance(irradiance_of(all)));
  for (float& cell : all.ambient_cells) cell *= 1.0f - all.main_share;
  room.light = all;
  return room;
}

using Grey = std::vector<double>;
Grey grey(const RadianceMap& map) {
  Grey out;
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) out.push_back(luminance(map.colour(x, y)));
  return out;
}

// Means over squares of so many pixels.
Grey coarser(const Grey& fine, int width, int scale) {
  const int w = width / scale, h = static_cast<int>(fine.size()) / width / scale;
  Grey out(static_cast<size_t>(w) * static_cast<size_t>(h));
  for (int y = 0; y < h * scale; ++y)
    for (int x = 0; x < w * scale; ++x)
      out[static_cast<size_t>(y / scale * w + x / scale)] += fine[static_cast<size_t>(y * width + x)] / (scale * scale);
  return out;
}

// RMS of what squares of `scale` pixels differ from those of 32, over these; with 32, of what those differ from their mean.
// Two pictures of the same: what they have in common, without the noise of either.
double contrast(const Grey& a, const Grey& b, int scale) {
  const Grey block[2] = {coarser(a, k_width, k_block), coarser(b, k_width, k_block)};
  double sum = 0.0;
  if (scale == k_block) {
    double mean[2] = {};
    for (int k = 0; k < 2; ++k)
      for (const double v : block[k]) mean[k] += v / static_cast<double>(block[k].size());
    for (size_t i = 0; i < block[0].size(); ++i) sum += (block[0][i] / mean[0] - 1.0) * (block[1][i] / mean[1] - 1.0);
    return std::sqrt(std::max(0.0, sum / static_cast<double>(block[0].size())));
  }
  const Grey fine[2] = {coarser(a, k_width, scale), coarser(b, k_width, scale)};
  const int w = k_width / scale, per = k_block / scale;
  for (size_t i = 0; i < fine[0].size(); ++i) {
    const int x = static_cast<int>(i) % w, y = static_cast<int>(i) / w;
    const auto at = static_cast<size_t>(y / per * (k_width / k_block) + x / per);
    sum += (fine[0][i] / block[0][at] - 1.0) * (fine[1][i] / block[1][at] - 1.0);
  }
  return std::sqrt(std::max(0.0, sum / static_cast<double>(fine[0].size())));
}

Vec3 mean_of(const RadianceMap& map) {
  Vec3 sum;
  for (size_t i = 0; i < map.rgb.size(); i += 3) sum = sum + from_floats(&map.rgb[i]);
  return sum * (3.0 / static_cast<double>(map.rgb.size()));
}

// Share of pixels that are darker than a tenth of the mean.
double black(const RadianceMap& map) {
  const Grey g = grey(map);
  double mean = 0.0, count = 0.0;
  for (const double v : g) mean += v / static_cast<double>(g.size());
  for (const double v : g) count += v < 0.1 * mean ? 1.0 : 0.0;
  return count / static_cast<double>(g.size());
}

// How much of the speckle two pictures have in common: the correlation of what differs from squares of 8 pixels.
double in_common(const RadianceMap& a, const RadianceMap& b) {
  constexpr int k_smooth = 8;
  const Grey fine[2] = {grey(a), grey(b)},
             smooth[2] = {coarser(fine[0], k_width, k_smooth), coarser(fine[1], k_width, k_smooth)};
  double ab = 0.0, aa = 0.0, bb = 0.0;
  for (size_t i = 0; i < fine[0].size(); ++i) {
    const auto at = static_cast<size_t>(static_cast<int>(i) / k_width / k_smooth * (k_width / k_smooth) +
                                        static_cast<int>(i) % k_width / k_smooth);
    const double x = fine[0][i] - smooth[0][at], y = fine[1][i] - smooth[1][at];
    ab += x * y;
    aa += x * x;
    bb += y * y;
  }
  return ab / std::sqrt(aa * bb);
}

// RMS of what changes between two pictures, over their mean. Of each there may be a second one with noise of its own: then
// it is the change without noise.
double change_over_mean(const std::array<RadianceMap, 2>& a, const std::array<RadianceMap, 2>& b) {
  const Grey a0 = grey(a[0]), a1 = grey(a[1]), b0 = grey(b[0]), b1 = grey(b[1]);
  double sum = 0.0, mean = 0.0;
  for (size_t i = 0; i < a0.size(); ++i) {
    sum += (a0[i] - b0[i]) * (a1[i] - b1[i]);
    mean += a0[i];
  }
  return std::sqrt(std::max(sum, 0.0) * static_cast<double>(a0.size())) / mean;
}

ShotPictureOptions how(const LookOptions& options) {
  ShotPictureOptions o;
  o.width = k_width;
  o.height = k_height;
  o.samples = 2;
  o.paths = k_paths;
  o.threads = options.threads;
  return o;
}

Picture encoded(const RadianceMap& map) {
  Picture shown(map.width, map.height, {0, 0, 0});
  for (size_t i = 0; i < map.rgb.size(); ++i) shown.rgb[i] = srgb_byte(static_cast<double>(map.rgb[i]));
  return shown;
}

struct Judge {
  std::vector<Verdict> rows;
  void add(const std::string& group, const std::string& name, const char* unit, double truth, double result,
           double limit, bool pass, bool control = false) {
    rows.push_back({"look", group + ", " + name, unit, truth, result, limit, control ? !pass : pass, control});
  }
};

SceneShadows shadows_of(const Pile& pile, const PlacedLight& light) {
  return complete_shadows(pile.stage.scene, SANDGLASS_ISA_AUTOMATIC, 0, pile.floor, pile.stage.particles, light);
}

void beside_truth(const LookOptions& options, const Pile& pile, ShotPicture& picture, const Seen& view, Judge* judge) {
  const Vec3 from = view.dark_side ? view.light->towards * -1.0 : Vec3{0.2, 0, 1};
  const Camera camera = pile.camera(from, view.distance);
  const Room room = room_of(*view.light, camera);
  const ShotCamera eye = resting_camera(camera);
  ShotPictureOptions o = how(options);
  RadianceMap truth[2];
  for (int k = 0; k < 2; ++k) {
    o.seed = static_cast<uint64_t>(k);
    truth[k] = picture.truth(room.surroundings, eye, o);
  }
  const SceneShadows shadows = shadows_of(pile, room.light);
  const auto drawn = [&](const KitChange& change) {
    ShotPictureOptions changed = o;
    changed.kit = change;
    return picture.composite(room.surroundings, eye, room.light, shadows, CastShadow::textures, changed);
  };
  const RadianceMap kit = drawn({});
  RadianceMap both = truth[0];
  for (size_t i = 0; i < both.rgb.size(); ++i) both.rgb[i] = 0.5f * (truth[0].rgb[i] + truth[1].rgb[i]);
  const std::string name = view.name();
  const Vec3 mean = mean_of(kit), right = mean_of(both);
  const double level = view.dark_side ? 0.14 : 0.08;
  const struct {
    const char* colour;
    double is, should;
  } colours[] = {{"red", mean.x, right.x}, {"green", mean.y, right.y}, {"blue", mean.z, right.z}};
  for (const auto& [colour, is, should] : colours)
    judge->add(name, std::string("mean, ") + colour, "radiance", should, is, level,
               std::fabs(is / should - 1.0) <= level);
  const Grey a = grey(truth[0]), b = grey(truth[1]), g = grey(kit);
  const auto off = [&](const Grey& of, int scale) {
    return contrast(of, of, scale) / std::max(contrast(a, b, scale), 1e-6) - 1.0;
  };
  for (const int scale : k_scales)
    judge->add(name, "contrast at " + std::to_string(scale) + " px", "", contrast(a, b, scale), contrast(g, g, scale),
               0.15, std::fabs(off(g, scale)) <= 0.15);
  // Nobody sees a contrast of one in a hundred.
  const double wide = contrast(g, g, k_block), wide_truth = contrast(a, b, k_block);
  judge->add(name, "contrast at 32 px", "", wide_truth, wide, 0.2,
             std::fabs(off(g, k_block)) <= 0.2 || std::fabs(wide - wide_truth) < 0.01);
  const double black_max = view.distance < 0.5 ? 0.035 : 0.01;
  judge->add(name, "black pixels", "share", black(both), black(kit), black_max, black(kit) <= black_max);
  const auto control = [&](const char* what, const KitChange& change) {
    const Grey changed = grey(drawn(change));
    double worst = 0.0;
    for (const int scale : k_scales) worst = std::max(worst, std::fabs(off(changed, scale)));
    judge->add(name, std::string("control: ") + what + ", contrast off", "", 0.0, worst, 0.15, worst <= 0.15, true);
  };
  if (view.light != &k_lights[0] || view.distance != k_distances[1]) return;
  control("levels sharper by 1.5", {1.5, 1.0f});
  control("grains twice as large", {0.0, 2.0f});
}

// What moves with the sand, as one sees it.
void in_motion(const LookOptions& options, Pile* pile, Judge* judge) {
  const Light& light = k_lights[0];
  const auto drawn = [&](const SandShape& sand, const Camera& camera) {
    const Room room = room_of(light, camera);
    const ShotPicture picture(pile->nothing, sand);
    return picture.composite(room.surroundings, resting_camera(camera), room.light, {}, CastShadow::textures,
                             how(options));
  };
  const auto moved = [](Camera camera, Vec3 by) {
    camera.eye = camera.eye + by;
    camera.target = camera.target + by;
    return camera;
  };
  const Camera still = pile->camera({0.2, 0, 1}, k_distances[1]);
  const SandShape before = pile->shape({0, 0, 0});
  const RadianceMap first = drawn(before, still);
  const auto fixed = [](SandShape sand) {
    for (sandglass_skin_vertex& v : sand.vertices) std::fill_n(v.origin, 3, uint16_t{0});
    return sand;
  };
  const RadianceMap first_fixed = drawn(fixed(before), still);
  for (const auto& [millimetres, kept_min] : {std::pair(0.5, 0.8), std::pair(2.0, 0.6), std::pair(6.0, 0.45)}) {
    pile->shape({0, 0, 0});
    const Vec3 by = {1e-3 * millimetres, 0, 0};
    const SandShape after = pile->shape(by);
    char name[96];
    std::snprintf(name, sizeof name, "speckle kept when all moves by %.1f mm", millimetres);
    const double kept = in_common(first, drawn(after, moved(still, by)));
    judge->add("motion", name, "", 1.0, kept, kept_min, kept >= kept_min);
    std::snprintf(name, sizeof name, "control: that, of a block that stays, %.1f mm", millimetres);
    const double swum = in_common(first_fixed, drawn(fixed(after), moved(still, by)));
    judge->add("motion", name, "", 0.0, swum, kept_min, swum >= kept_min, true);
  }
  pile->shape({0, 0, 0});
  const SandShape again = pile->shape({0, 0, 0});
  const bool same = drawn(again, still).rgb == drawn(pile->shape({0, 0, 0}), still).rgb;
  judge->add("motion", "at rest the same picture", "", 1.0, same ? 1.0 : 0.0, 1.0, same);
  ShotPicture packed(pile->nothing, before);
  for (const auto& [distance, limit] : {std::pair(0.3, 0.36), std::pair(0.6, 0.33), std::pair(1.1, 0.24)}) {
    const Camera camera = pile->camera({0.2, 0, 1}, distance);
    const Camera after = moved(camera, resting_camera(camera).right * (0.25 * distance / k_focal));
    const RadianceMap drawn_before = drawn(before, camera), drawn_after = drawn(before, after);
    std::array<RadianceMap, 2> truth[2];
    for (size_t k = 0; k < 4; ++k) {
      const Camera& from = k / 2 == 0 ? camera : after;
      ShotPictureOptions o = how(options);
      o.seed = k;
      truth[k / 2][k % 2] = packed.truth(room_of(light, from).surroundings, resting_camera(from), o);
    }
    const double change = change_over_mean({drawn_before, drawn_before}, {drawn_after, drawn_after});
    char name[64];
    std::snprintf(name, sizeof name, "a quarter of a pixel at %.1f m, change", distance);
    judge->add("flicker", name, "of mean", change_over_mean(truth[0], truth[1]), change, limit, change <= limit);
  }
}

Picture plain_picture(uint32_t threads) {
  const Pile pile;
  Camera camera = pile.camera({0.2, 0, 1}, 0.5);
  camera.fov_deg = 24.0;
  const Room room = room_of(k_lights[0], camera);
  const ShotPicture picture(pile.nothing, pile.sand);
  std::vector<Picture> both;
  for (const bool plain : {false, true}) {
    const ShotPictureOptions o = {.width = 400, .height = 320, .threads = threads, .kit = {.plain = plain}};
    both.push_back(encoded(picture.composite(room.surroundings, resting_camera(camera), room.light,
                                             shadows_of(pile, room.light), CastShadow::textures, o)));
  }
  return picture_grid(both, 2, 4);
}

// What a renderer gets of a poured pile and of one asleep: draw calls, vertices, bytes. A pile as a phone would pour it, frame
// by frame; what an app uploads is counted as it would upload it. 16.5 grains would be drawn for each particle otherwise.
std::vector<Verdict> handed_over(uint32_t particles) {
  std::vector<Verdict> rows;
  constexpr float k_radius = 0.006f, k_step = 1.0f / 60.0f;
  constexpr uint32_t k_last_frames = 60;
  sandglass_scene_desc desc = cpp::scene_desc();
  desc.granular.particle_radius = k_radius;
  desc.granular.particle_capacity = particles;
  desc.granular.emitter_capacity = 1;
  Simulation simulation(desc);
  cpp::Skin skin;
  if (const cpp::Status made = skin.create(cpp::skin_desc(desc.granular)); !made)
    throw cannot("make", "skin", made.reason);
  const sandglass_emitter nozzle = cpp::emitter(0.0f, 0.35f, 0.0f, 4 * k_radius, 0.8f);
  const sandglass_collider floor = cpp::floor_at(0.0f);
  sandglass_frame_input input;
  sandglass_frame_input_default(&input);
  input.time_step = k_step;
  input.budget_ns = UINT64_MAX;
  input.colliders = &floor;
  input.collider_count = 1;
  input.emitters = &nozzle;
  input.emitter_count = 1;
  input.skin = skin.get();
  std::vector<uint32_t> versions;
  std::vector<double> bytes;
  sandglass_skin_mesh mesh = {};
  uint32_t version = 0;
  const auto frame = [&] {
    const sandglass_frame_report report = simulation.frame(input);
    mesh = skin.mesh();
    versions.resize(mesh.chunk_count);
    double sum = mesh.version != version ? 32.0 * (mesh.flying_count + mesh.lying_count) : 0.0;
    version = mesh.version;
    for (uint32_t i = 0; i < mesh.chunk_count; ++i) {
      const sandglass_skin_chunk& chunk = mesh.chunks[i];
      if (versions[i] != chunk.version) sum += 24.0 * chunk.vertex_count + 2.0 * chunk.index_count;
      versions[i] = chunk.version;
    }
    bytes.push_back(sum);
    return report;
  };
  const auto tell = [&](const char* what, double value, const char* unit) {
    rows.push_back({"handed over", std::to_string(particles) + " particles, " + what, unit, 0.0, value,
                    std::numeric_limits<double>::infinity(), true, false});
  };
  while (frame().sand.particle_numbers < particles) {
  }
  double sum = 0.0;
  for (size_t i = bytes.size() - std::min<size_t>(k_last_frames, bytes.size()); i < bytes.size(); ++i) sum += bytes[i];
  tell("bytes a frame, poured", sum / k_last_frames, "bytes");
  tell("loose particles, poured", mesh.flying_count + mesh.lying_count, "");
  input.emitter_count = 0;
  for (int i = 0; i < 1500 && frame().sand.awake != 0; ++i) {
  }
  frame();
  frame();
  uint32_t drawn = 0;
  for (uint32_t i = 0; i < mesh.chunk_count; ++i) drawn += mesh.chunks[i].index_count != 0 ? 1 : 0;
  tell("bytes a frame, asleep", bytes.back(), "bytes");
  tell("draw calls", drawn + (mesh.lying_count != 0 ? 1 : 0), "");
  tell("vertices", mesh.vertex_count, "");
  tell("triangles", mesh.index_count / 3, "");
  return rows;
}

// `progress` gets the number of views done, and of all; it returns false to stop.
std::vector<Verdict> verify_look(const LookOptions& options,
                                 const std::function<bool(size_t done, size_t all)>& progress) {
  Pile pile;
  std::vector<Seen> views;
  for (const Light& light : k_lights)
    for (const double distance : k_distances) views.push_back({&light, distance, false});
  views.push_back({&k_lights[1], k_distances[1], true});
  if (options.quick) views = {{&k_lights[0], k_distances[1], false}};
  Judge judge;
  ShotPicture picture(pile.nothing, pile.sand);
  for (size_t i = 0; i < views.size(); ++i) {
    beside_truth(options, pile, picture, views[i], &judge);
    if (!progress(i + 1, views.size() + 1)) return {};
  }
  in_motion(options, &pile, &judge);
  for (const uint32_t particles : {2000u, 6000u})
    for (Verdict& row : handed_over(particles)) judge.rows.push_back(std::move(row));
  progress(views.size() + 1, views.size() + 1);
  return judge.rows;
}

Options options_of(LookOptions& o) {
  return {{"--quick", &o.quick, "", "One light, one distance"},
          {"--plain", &o.plain, "FILE", "JPEG: the pile by the kit on the left, by plain.frag on the right"},
          threads_option(o.threads),
          json_option(o.json)};
}

int run(const LookOptions& options) {
  const auto rows = with_progress("tracing views", [&](const auto& go_on) { return verify_look(options, go_on); });
  if (interrupted()) return k_exit_interrupted;
  if (!options.plain.empty()) write_file(options.plain, jpeg_file(plain_picture(options.threads), 85));
  return tell(options, "look", "automatic", rows);
}

}  // namespace

Command verify_look_suite() {
  return command<LookOptions>("look", "Drawn sand against path traced grains; how its speckle moves", options_of, run);
}

}  // namespace sandglass::host
