// See scene_shadows.h.
#include "models/simulation/scene_shadows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "models/files/failure.h"
#include "models/files/shipped_file.h"
#include "models/mesh/generated.h"
#include "models/simulation/scene_meshes.h"
#include "runtime/math/hash.h"

namespace sandglass::host {

static sandglass_collider standing_at(const SceneFile& scene, uint32_t collider, uint32_t frame) {
  return collider_over_frame(scene.colliders[collider], frame * scene.frame_step, scene.frame_step);
}
static Quaternion rotation_of(const sandglass_collider& c) {
  return {c.rotation[0], c.rotation[1], c.rotation[2], c.rotation[3]};
}

static std::array<float, 3> floats_of(Vec3 v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

std::string find_shadow(const std::string& name_or_path) {
  std::error_code error;
  if (std::filesystem::is_regular_file(name_or_path, error)) return name_or_path;
  if (const std::string path = shipped_file("shadows", name_or_path + ".shadow"); !path.empty()) return path;
  throw cannot("read", name_or_path, "no file and no shipped shadow has this name", "Bake it with sandglass bake");
}

sandglass_shadow_info inspect_shadow(const AlignedBytes& file, const std::string& path) {
  sandglass_shadow_info info = {};
  const cpp::Status status = cpp::inspect_shadow(file.data(), file.size(), &info);
  if (!status) throw cannot("read", path, status.reason);
  return info;
}

StandingShadows::StandingShadows(const SceneFile& scene, sandglass_isa isa) {
  for (uint32_t i = 0; i < scene.colliders.size(); ++i) {
    const ColliderTrack& track = scene.colliders[i];
    if (track.casts) add_cast(track, i, isa);
    if (track.shadow.empty()) continue;
    const std::string path = find_shadow(track.shadow);
    const AlignedBytes file = read_aligned(path, "baked shadow");
    sandglass_shadow_desc desc;
    sandglass_shadow_desc_default(&desc);
    desc.isa = isa;
    desc.asset = file.data();
    desc.asset_bytes = file.size();
    Object object = {i, track.size.y, inspect_shadow(file, path), {}};
    if (const cpp::Status made = object.shadow.create(desc); !made) throw cannot("read", path, made.reason);
    handles_.push_back(object.shadow.get());
    objects_.push_back(std::move(object));
  }
}

void StandingShadows::add_cast(const ColliderTrack& track, uint32_t collider, sandglass_isa isa) {
  MeshResult made = make_named(track.mesh);
  stand_mesh(&made.mesh, track.size.y, track.mesh);
  sandglass_cast_desc desc = cpp::cast_desc();
  desc.isa = isa;
  desc.texels = 256;
  desc.ambient_texels = 128;
  desc.triangle_capacity = made.mesh.triangle_count();
  Casting casting = {collider, std::move(made.mesh), {}};
  if (const cpp::Status status = casting.cast.create(desc); !status) throw cannot("cast", track.mesh, status.reason);
  cast_handles_.push_back(casting.cast.get());
  casting_.push_back(std::move(casting));
}

void StandingShadows::complete() const {
  sandglass_shadow_run(handles_.data(), static_cast<uint32_t>(handles_.size()), ~0u);
  sandglass_cast_run(cast_handles_.data(), static_cast<uint32_t>(cast_handles_.size()), ~0u);
}

void StandingShadows::set_light(const SceneFile& scene, uint32_t frame, Vec3 towards) {
  for (Object& object : objects_) {
    const Quaternion rotation = rotation_of(standing_at(scene, object.collider, frame));
    const Vec3 local = rotate(conjugate(rotation), towards);
    if (const cpp::Status turned = object.shadow.set_light(floats_of(local)); !turned)
      throw cannot("turn", "light", turned.reason);
  }
  for (Casting& casting : casting_) {
    const sandglass_collider now = standing_at(scene, casting.collider, frame);
    sandglass_cast_mesh mesh = cpp::cast_mesh();
    mesh.positions = casting.mesh.vertices.data();
    mesh.vertex_count = casting.mesh.vertex_count();
    mesh.indices = casting.mesh.indices.data();
    mesh.triangle_count = casting.mesh.triangle_count();
    mesh.closed = 1;  // as all named meshes are
    const Quaternion rotation = rotation_of(now);
    const Vec3 axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (size_t k = 0; k < 3; ++k) to_floats(rotate(rotation, axes[k]), mesh.world_from_mesh + 4 * k);
    std::copy_n(now.position, 3, mesh.world_from_mesh + 12);
    cpp::Status status = casting.cast.set_meshes(&mesh, 1);
    if (status) status = casting.cast.set_light(floats_of(towards));
    if (!status) throw cannot("turn", "light", status.reason);
  }
}

uint64_t StandingShadows::hash() const {
  uint64_t sum = 0;
  for (const sandglass_shadow* shadow : handles_) sum += sandglass_shadow_hash(shadow);
  for (const Casting& casting : casting_)
    for (const sandglass_texture& t : {casting.cast.texture(), casting.cast.ambient()})
      sum += hash_bytes(t.bytes, uint64_t{t.side} * t.side);
  return sum;
}

void StandingShadows::set_cells(const SceneFile& scene, uint32_t frame, const float (&cells)[SANDGLASS_LIGHT_CELLS]) {
  for (Object& object : objects_) {
    const sandglass_collider now = standing_at(scene, object.collider, frame);
    // An upright object is turned about y alone.
    const auto yaw = static_cast<float>(
        2.0 * std::atan2(static_cast<double>(now.rotation[1]), static_cast<double>(now.rotation[3])));
    if (const cpp::Status lit = object.shadow.set_cells(cells, yaw); !lit) throw cannot("set", "cells", lit.reason);
  }
  for (Casting& casting : casting_)
    if (const cpp::Status lit = casting.cast.set_cells(cells); !lit) throw cannot("set", "cells", lit.reason);
}

// A texture as a shadow; `visible`: its bytes are what is left of the light.
static FloorShadow shadow_of(const sandglass_texture& t, bool visible) {
  FloorShadow shadow;
  shadow.collider = ~0u;
  shadow.texels = t.side;
  for (size_t i = 0; i < size_t{t.side} * t.side; ++i)
    shadow.coverage.push_back(visible ? static_cast<uint8_t>(255 - t.bytes[i]) : t.bytes[i]);
  shadow.opacity = t.valid != 0 ? static_cast<double>(t.scale) : 0.0;
  for (size_t axis = 0; axis < 2; ++axis) {
    const float extent = axis == 0 ? t.along[0] : t.across[2];
    shadow.low[axis] = static_cast<double>(t.corner[2 * axis]);
    shadow.high[axis] = static_cast<double>(t.corner[2 * axis] + extent);
  }
  return shadow;
}

void StandingShadows::draw(std::span<const sandglass_collider> colliders, SceneShadows* shadows) const {
  shadows->object.clear();
  shadows->ambient.clear();
  for (const Object& object : objects_) {
    if (object.collider >= colliders.size()) continue;
    const sandglass_collider& now = colliders[object.collider];
    const double scale = object.size / static_cast<double>(object.info.height);
    const auto add = [&](const sandglass_texture& t, bool visible, std::vector<FloorShadow>* to) {
      FloorShadow shadow = shadow_of(t, visible);
      shadow.collider = object.collider;
      shadow.half_angle = 0.5 * static_cast<double>(object.info.angular_diameter);
      shadow.position = from_floats(now.position);
      shadow.rotation = rotation_of(now);
      for (size_t axis = 0; axis < 2; ++axis) {
        const double origin = static_cast<double>(object.info.origin[2 * axis]);
        shadow.low[axis] = (shadow.low[axis] - origin) * scale;
        shadow.high[axis] = (shadow.high[axis] - origin) * scale;
      }
      to->push_back(std::move(shadow));
    };
    add(object.shadow.texture(), false, &shadows->object);
    if (object.shadow.ambient().side != 0) add(object.shadow.ambient(), true, &shadows->ambient);
  }
  constexpr double k_half_angle = 0.17453292519943295;
  for (const Casting& casting : casting_) {
    const auto add = [&](const sandglass_texture& t, bool visible, std::vector<FloorShadow>* to) {
      if (t.valid == 0) return;
      FloorShadow shadow = shadow_of(t, visible);
      shadow.collider = casting.collider;
      shadow.half_angle = k_half_angle;
      to->push_back(std::move(shadow));
    };
    add(casting.cast.texture(), false, &shadows->object);
    add(casting.cast.ambient(), true, &shadows->ambient);
  }
}

static void require(const cpp::Status& status) {
  if (!status) throw cannot("make", "pile_shadow", status.reason != nullptr ? status.reason : status.name());
}

PileShadow::PileShadow(const PileShadowTrack& track, sandglass_isa isa, uint32_t sky_texels) {
  sandglass_pile_shadow_desc desc = cpp::pile_shadow_desc();
  desc.isa = isa;
  desc.texels = track.texels;
  desc.sky_texels = sky_texels;
  for (size_t axis = 0; axis < 2; ++axis) {
    desc.low[axis] = static_cast<float>(track.low[axis]);
    desc.high[axis] = static_cast<float>(track.high[axis]);
  }
  require(shadow_.create(desc));
}

void PileShadow::set_light(Vec3 towards) { require(shadow_.set_light(floats_of(towards))); }

void PileShadow::set_cells(const float (&cells)[SANDGLASS_LIGHT_CELLS]) { require(shadow_.set_cells(cells)); }

void PileShadow::draw(SceneShadows* shadows) const {
  shadows->pile = {shadow_of(shadow_.texture(), false)};
  shadows->pile_on_sand = {shadow_of(shadow_.texture(SANDGLASS_PILE_SHADOW_SAND), false)};
  if (shadow_.texture(SANDGLASS_PILE_SHADOW_SKY_FLOOR).side == 0) return;
  shadows->sky = {shadow_of(shadow_.texture(SANDGLASS_PILE_SHADOW_SKY_FLOOR), true)};
  shadows->sky_on_sand = {shadow_of(shadow_.texture(SANDGLASS_PILE_SHADOW_SKY_SAND), true)};
}

double floor_transparency(const FloorShadow& shadow, double px, double pz) {
  const Vec3 local = rotate(conjugate(shadow.rotation), Vec3{px - shadow.position.x, 0.0, pz - shadow.position.z});
  const double n = shadow.texels;
  const double u = (local.x - shadow.low[0]) / (shadow.high[0] - shadow.low[0]) * n - 0.5;
  const double v = (local.z - shadow.low[1]) / (shadow.high[1] - shadow.low[1]) * n - 0.5;
  if (!(u > -1.0 && v > -1.0 && u < n && v < n)) return 1.0;
  const auto texel = [&](double x, double y) {
    const bool inside = x >= 0.0 && y >= 0.0 && x < n && y < n;
    return inside ? shadow.coverage[static_cast<size_t>(y) * shadow.texels + static_cast<size_t>(x)] / 255.0 : 0.0;
  };
  const double x = std::floor(u), y = std::floor(v), fx = u - x, fy = v - y;
  const double coverage = (1.0 - fy) * ((1.0 - fx) * texel(x, y) + fx * texel(x + 1.0, y)) +
                          fy * ((1.0 - fx) * texel(x, y + 1.0) + fx * texel(x + 1.0, y + 1.0));
  return 1.0 - coverage * shadow.opacity;
}

}  // namespace sandglass::host
