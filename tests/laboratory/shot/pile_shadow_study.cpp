// Compares the sand's own shadow with rays that are cast at the grains.
#include <algorithm>
#include <cmath>
#include <memory>

#include "models/compositing/shot_picture.h"
#include "models/rooms/probe_scene.h"
#include "tests/laboratory/shot/shot_stage.h"
#include "tests/laboratory/shot/verify_shot.h"

namespace sandglass::host {

namespace {

using PilePart = PileShadowError::Part;

// The errors of each texture at a place, or at several together: first the shadow itself, then the controls.
constexpr size_t k_textures = 3;
constexpr double PilePart::*k_errors_of[k_textures] = {&PilePart::rmse, &PilePart::particles, &PilePart::mirrored};

void add_texel(PilePart* part, double truth, const double (&shown)[k_textures], double places) {
  const double real = truth / places;
  const auto square = [&](double seen) { return (seen - real) * (seen - real); };
  for (size_t t = 0; t < k_textures; ++t) part->*k_errors_of[t] += square(shown[t] / places);
  part->without += square(1.0), part->bias += shown[0] / places - real, ++part->texels;
}

void finish(PilePart* sums) {
  const double n = std::max(1, sums->texels);
  for (double PilePart::*sum : {&PilePart::rmse, &PilePart::particles, &PilePart::mirrored, &PilePart::without})
    sums->*sum = std::sqrt(sums->*sum / n);
  sums->bias /= n;
}

}  // namespace

std::vector<PileShadowError> study_pile_shadow() {
  constexpr double k_degree = 3.141592653589793 / 180.0, k_lit = 0.98;
  constexpr uint32_t k_stride = 3;         // texels
  constexpr int k_places = 3, k_rays = 4;  // places a texel and rays a place, along each axis
  const ShotStage stage;
  const ShotPicture picture(stage.object, stage.grains, stage.grain_radius);
  std::vector<PileShadowError> all;
  // All lights are within 70 degrees of the vertical, the range that textures are made for.
  for (const double polar : {20.0, 45.0, 65.0})
    for (const double azimuth : {30.0, 150.0, 270.0}) {
      const Vec3 towards = {std::sin(polar * k_degree) * std::cos(azimuth * k_degree), std::cos(polar * k_degree),
                            std::sin(polar * k_degree) * std::sin(azimuth * k_degree)};
      const std::unique_ptr<PileShadow> piles[k_textures] = {
          stage.pile_for(towards, ShotStage::Sand::grains), stage.pile_for(towards, ShotStage::Sand::particles),
          stage.pile_for({-towards.x, towards.y, -towards.z}, ShotStage::Sand::grains)};
      FloorShadow on_floor[k_textures], on_sand[k_textures];
      for (size_t t = 0; t < k_textures; ++t) on_floor[t] = piles[t]->drawn(false), on_sand[t] = piles[t]->drawn(true);
      const FloorShadow& texture = on_floor[0];
      PileShadowError e = {polar, azimuth, {}, {}, {}};
      for (uint32_t v = 0; v < texture.texels; v += k_stride)
        for (uint32_t u = 0; u < texture.texels; u += k_stride) {
          double truth = 0.0, seen = 0.0, lit = 0.0, facing = 0.0, shown[k_textures] = {}, drawn[k_textures] = {};
          for (int i = 0; i < k_places * k_places; ++i) {
            const double across = (u + (i % k_places + 0.5) / k_places) / texture.texels,
                         along = (v + (i / k_places + 0.5) / k_places) / texture.texels;
            const double x = texture.low[0] + across * (texture.high[0] - texture.low[0]);
            const double z = texture.low[1] + along * (texture.high[1] - texture.low[1]);
            if (picture.grains_leave(x, z, {0, 1, 0}, 0.0, 1) == 0.0) {  // under a grain
              double cosine = 0.0;
              const double open = picture.grain_lit(x, z, towards, k_light_half_angle_deg * k_degree, k_rays, &cosine);
              lit += cosine * open, facing += cosine;
              for (size_t t = 0; t < k_textures; ++t) drawn[t] += cosine * floor_transparency(on_sand[t], x, z);
              continue;
            }
            truth += picture.grains_leave(x, z, towards, k_light_half_angle_deg * k_degree, k_rays);
            seen += 1.0;
            for (size_t t = 0; t < k_textures; ++t) shown[t] += floor_transparency(on_floor[t], x, z);
          }
          if (facing > 0.0) add_texel(&e.on_sand, lit, drawn, facing);
          if (seen == 0.0 || (truth > k_lit * seen && shown[0] > k_lit * seen)) continue;
          add_texel(seen == k_places * k_places ? &e.clear : &e.among_grains, truth, shown, seen);
        }
      for (PilePart* part : {&e.clear, &e.among_grains, &e.on_sand}) finish(part);
      all.push_back(e);
    }
  return all;
}

}  // namespace sandglass::host
