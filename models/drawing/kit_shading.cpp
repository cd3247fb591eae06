#include "models/drawing/kit_shading.h"

#define GLM_FORCE_SWIZZLE
#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <vector>

#include "models/kit/grain_block.h"

namespace sandglass::host {

namespace {

using glm::mat3;
using glm::mat4;
using glm::uint;
using glm::vec2;
using glm::vec3;
using glm::vec4;

constexpr float k_block_side = 0.0084f, k_narrow = 0.3f;

vec3 to_vec(Vec3 v) { return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)}; }
Vec3 from_vec(vec3 v) { return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)}; }

// One of the block's two textures, with its levels.
struct sampler3D {
  std::vector<const uint8_t*> levels;

  vec4 level_at(vec3 at, size_t level) const {
    const int side = kit::k_side >> level;
    const vec3 texel = (at - glm::floor(at)) * static_cast<float>(side) - 0.5f, low = glm::floor(texel);
    const vec3 share = texel - low;
    vec4 sum(0);
    for (int c = 0; c < 8; ++c) {
      const int x = (static_cast<int>(low.x) + (c & 1) + side) % side,
                y = (static_cast<int>(low.y) + (c >> 1 & 1) + side) % side,
                z = (static_cast<int>(low.z) + (c >> 2) + side) % side;
      const float weight = ((c & 1) != 0 ? share.x : 1 - share.x) * ((c >> 1 & 1) != 0 ? share.y : 1 - share.y) *
                           ((c >> 2) != 0 ? share.z : 1 - share.z);
      const uint8_t* p = levels[level] + 4 * static_cast<size_t>(x + side * (y + side * z));
      sum += weight * vec4(p[0], p[1], p[2], p[3]);
    }
    return sum * (1.0f / 255.0f);
  }
};
using sampler2D = const std::vector<float>*;  // of bed_of_grains

// As levels.glsl.
vec4 block_level(const sampler3D& texture, vec3 at, float level) {
  const float last = static_cast<float>(texture.levels.size() - 1), l = std::clamp(level, 0.0f, last);
  const auto fine = static_cast<size_t>(l);
  const float share = l - static_cast<float>(fine);
  const vec4 a = texture.level_at(at, fine);
  return share > 0.0f ? glm::mix(a, texture.level_at(at, fine + 1), share) : a;
}

vec4 block_mean(const sampler3D& texture) { return block_level(texture, vec3(0), 6); }

const std::vector<uint8_t>& block() {
  static const std::vector<uint8_t> bytes = kit::sand_block(kit::k_beach);
  return bytes;
}

sampler3D texture_of_block(size_t which) {
  sampler3D texture;
  const uint8_t* at = block().data();
  for (int side = kit::k_side; side >= 1; side /= 2) {
    const auto bytes = 4 * static_cast<size_t>(side) * static_cast<size_t>(side) * static_cast<size_t>(side);
    texture.levels.push_back(at + which * bytes);
    at += 2 * bytes;
  }
  return texture;
}

// The functions of GLSL that the kit calls.
using glm::clamp;
using glm::cross;
using glm::dot;
using glm::fract;
using glm::inversesqrt;
using glm::length;
using glm::log;
using glm::log2;
using glm::max;
using glm::mix;
using glm::normalize;
using glm::pow;
using glm::reflect;
using glm::smoothstep;
using glm::sqrt;
using glm::step;
using std::abs;
using std::cos;
using std::sin;

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wfloat-conversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wdouble-promotion"
#pragma GCC diagnostic ignored "-Wshadow"

// The uniforms, with light.glsl by the program's own functions.
struct Lit {
#include "kit/uniforms.glsl.inc"
  const SandLight* light = nullptr;
  bool discarded = false;
  vec3 around(vec3 n) const { return to_vec(light->around(from_vec(n))); }
  vec3 around_below(vec3 n) const { return to_vec(light->around_below(from_vec(n))); }
  float pile_passed(vec3 place) const { return light->pile_passed(from_vec(place)); }
  float object_passed(vec3 place) const { return light->object_passed(from_vec(place)); }
  float under_sky(vec3 place) const { return light->under_sky(from_vec(place)); }
};

struct SurfaceVertex : Lit {
  vec4 gl_Position;
#include "kit/surface.vert.inc"
};

struct SurfaceFragment : Lit {
  vec3 to_right, to_below;
  vec3 dFdx(vec3) const { return to_right; }
  vec3 dFdy(vec3) const { return to_below; }
#include "kit/sand.glsl.inc"
#include "kit/surface.glsl.inc"
};

struct Loose : Lit {
#include "kit/loose.glsl.inc"
#include "kit/sand.glsl.inc"
};

struct PlainFragment {
  float wide;  // texels that a pixel is: it shows their mean, as levels give it
  vec4 texture(sampler2D image, vec2 at) const {
    const float n = std::ceil(wide), side = kit::k_bed_side;
    vec3 sum(0);
    for (float x = 0.5f; x < n; ++x)
      for (float y = 0.5f; y < n; ++y) {
        const vec2 place = fract(at + (vec2(x, y) / n - 0.5f) * (wide / side)) * side;
        const size_t texel = static_cast<size_t>(place.x) % kit::k_bed_side +
                             kit::k_bed_side * (static_cast<size_t>(place.y) % kit::k_bed_side);
        for (int k = 0; k < 3; ++k) sum[k] += (*image)[3 * texel + k];
      }
    return vec4(sum / (n * n), 1);
  }
#include "kit/plain.frag.inc"
};

#pragma GCC diagnostic pop

}  // namespace

struct KitShading::State {
  SurfaceVertex vertex;
  SurfaceFragment fragment;
  Loose loose;
  std::optional<PlainFragment> plain;
  double finer = 1.0;  // steps from pixel to pixel are taken for so much of themselves
};

KitShading::KitShading(const SandLight& light, const CameraFrame& camera, const SandShape& shape, double pixels,
                       const KitChange& change)
    : state_(std::make_unique<State>()) {
  const vec3 right = to_vec(camera.right), up = to_vec(camera.up), back = to_vec(camera.forward * -1.0),
             at = to_vec(camera.eye);
  const mat4 view(vec4(right.x, up.x, back.x, 0), vec4(right.y, up.y, back.y, 0), vec4(right.z, up.z, back.z, 0),
                  vec4(-dot(right, at), -dot(up, at), -dot(back, at), 1));
  const sampler3D grains = texture_of_block(0), facets = texture_of_block(1);
  for (Lit* lit :
       {static_cast<Lit*>(&state_->vertex), static_cast<Lit*>(&state_->fragment), static_cast<Lit*>(&state_->loose)}) {
    lit->light = &light;
    lit->view = view;
    lit->projection = mat4(vec4(1, 0, 0, 0), vec4(0, 1, 0, 0), vec4(0, 0, 1, -1), vec4(0));
    lit->eye = at;
    lit->to_light = to_vec(light.to_light);
    lit->sun = to_vec(light.sun);
    lit->wet = static_cast<float>(light.wet);
    lit->grains = grains;
    lit->facets = facets;
    lit->block_side = k_block_side;
    lit->particle_radius = shape.particle_radius;
    lit->pixels = static_cast<float>(pixels);
    lit->frame_seconds = static_cast<float>(shape.seconds);
    lit->stream_narrow = k_narrow;
    float share = 0;
    for (int m = 0; m < 4; ++m) {
      const kit::Mineral& mineral = kit::k_beach[m];
      share += mineral.share;
      lit->minerals[m] = {mineral.albedo[0], mineral.albedo[1], mineral.albedo[2], share};
    }
    for (size_t i = 0; i < std::size(lit->streams); ++i) {
      lit->streams[i] = lit->stream_ways[i] = vec4(0);
      if (i >= shape.nozzles.size()) continue;
      const sandglass_emitter& nozzle = shape.nozzles[i];
      const Quaternion turn = {nozzle.rotation[0], nozzle.rotation[1], nozzle.rotation[2], nozzle.rotation[3]};
      lit->streams[i] = {nozzle.position[0], nozzle.position[1], nozzle.position[2], nozzle.radius};
      lit->stream_ways[i] = vec4(to_vec(rotate(turn, {0, -1, 0})), nozzle.speed);
    }
  }
  state_->fragment.block_side *= change.coarser;
  state_->finer = std::exp2(-change.sharper);
  if (!change.plain) return;
  static const std::vector<float> bed = kit::bed_of_grains(kit::k_beach);
  PlainFragment& plain = state_->plain.emplace();
  plain.sand = &bed;
  plain.side = k_block_side * kit::k_bed_blocks;
}
KitShading::~KitShading() = default;
KitShading::KitShading(const KitShading& other) : state_(std::make_unique<State>(*other.state_)) {}

std::optional<Vec3> KitShading::surface(const Fragment& seen) {
  SurfaceVertex& vertex = state_->vertex;
  SurfaceFragment& fragment = state_->fragment;
  vec3 normal(0);
  vec2 dent_and_height(0);
  for (int k = 0; k < 3; ++k) {
    const sandglass_skin_vertex& v = *seen.corners[k];
    vertex.normal = vec3(v.normal[0], v.normal[1], v.normal[2]) * (1.0f / 127.0f);
    vertex.hollow = static_cast<float>(v.hollow) / 255.0f;
    vertex.origin = vec3(v.origin[0], v.origin[1], v.origin[2]) * (1.0f / 65535.0f);
    vertex.over = static_cast<float>(v.over) / 32767.0f;
    vertex.main();
    const auto share = static_cast<float>(seen.share[k]);
    normal += share * vertex.smooth_normal;
    dent_and_height += share * vertex.dent_and_height;
  }
  fragment.to_right = to_vec(seen.right * state_->finer);
  fragment.to_below = to_vec(seen.down * state_->finer);
  fragment.discarded = false;
  if (state_->plain) {
    PlainFragment& plain = *state_->plain;
    plain.position = to_vec(seen.place);
    plain.normal = normalize(normal);
    plain.hollow = 0.5f + 0.5f * dent_and_height.x;
    plain.origin = vertex.origin / static_cast<float>(kit::k_bed_blocks);  // the skin's is of a block
    plain.wide = std::max(length(fragment.to_right), length(fragment.to_below)) / plain.side * kit::k_bed_side;
    plain.main();
    const float direct = fragment.pile_passed(plain.position) * fragment.object_passed(plain.position);
    const vec3 sun = fragment.sun * direct * std::max(dot(plain.normal, fragment.to_light), 0.0f);
    const float open = plain.occlusion * fragment.under_sky(plain.position);
    return from_vec(plain.colour * (sun + fragment.around(plain.normal) * open));
  }
  const vec3 shown =
      fragment.sand_surface(to_vec(seen.place), normal, dent_and_height.x, dent_and_height.y, vertex.begins);
  return fragment.discarded ? std::nullopt : std::optional(from_vec(shown));
}

std::optional<KitShading::Grain> KitShading::grain(const sandglass_skin_loose& particle, bool flies, uint32_t which) {
  Loose& loose = state_->loose;
  loose.flies = flies ? 1.0f : 0.0f;
  const float* p = particle.position;
  const float* v = particle.vector;
  double corners[3][2];
  for (uint32_t k = 0; k < 3; ++k) {
    loose.loose_grain(4 * which + k, {p[0], p[1], p[2], particle.weight}, {v[0], v[1], v[2]}, particle.number);
    const vec4 at = loose.grain_position;
    if (at.z > 0.0f) return std::nullopt;  // behind the eye: it is not there
    const double per_pixel = static_cast<double>(loose.pixels) / static_cast<double>(at.w);
    corners[k][0] = static_cast<double>(at.x) * per_pixel;
    corners[k][1] = -static_cast<double>(at.y) * per_pixel;
  }
  // The corners lie at (-1, -1), (1, -1) and (-1, 1).
  Grain grain;
  for (int k = 0; k < 2; ++k) {
    grain.right[k] = (corners[1][k] - corners[0][k]) / 2;
    grain.over[k] = (corners[2][k] - corners[0][k]) / 2;
  }
  grain.x = corners[0][0] + grain.right[0] + grain.over[0];
  grain.y = corners[0][1] + grain.right[1] + grain.over[1];
  grain.depth = static_cast<double>(loose.grain_position.w);
  grain.pixels = static_cast<double>(loose.grain_across);
  // Of the middle, without what grain_at says of each place.
  const vec3 shown = loose.grain_shown(vec2(0), loose.grain_across, loose.grain_stands, loose.grain_up, loose.grain_own,
                                       loose.grain_seed);
  grain.colour = from_vec(shown / loose.grain_lit(vec2(0), loose.grain_across));
  return grain;
}

uint32_t KitShading::grains(bool flies, double away) const {
  const float limit = flies ? Loose::k_lines : Loose::k_points;
  const float pixels = flies ? Loose::k_line_pixels : Loose::k_point_pixels;
  const float wide = 2.0f * k_block_side / 28.0f * state_->loose.pixels / std::max(static_cast<float>(away), 0.02f);
  return static_cast<uint32_t>(std::ceil(std::clamp(limit * wide * wide / (pixels * pixels), 1.0f, limit)));
}

std::optional<Vec3> KitShading::grain_at(const Grain& grain, double along, double across) {
  const float across_ball = static_cast<float>(grain.pixels);
  const double lit = static_cast<double>(state_->loose.grain_lit(vec2(along, across), across_ball));
  return lit > 0 ? std::optional(grain.colour * lit) : std::nullopt;
}

}  // namespace sandglass::host
