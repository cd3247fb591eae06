// What a level floor receives beside an object, by rays: the truth that every way to draw a shadow is held against.
//
// The upper hemisphere is split into 1,024 parts of equal cosine-weighted solid angle: the strata of the cells of
// types.h (models/baking/cell_visibility.h).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "models/baking/cell_visibility.h"
#include "models/baking/light_cells.h"
#include "models/mesh/mesh.h"
#include "models/rooms/panorama.h"
#include "models/work/thread_pool.h"

namespace sandglass::host {

constexpr uint32_t k_fine = k_light_cells * k_cell_strata;
using Fine = std::array<double, k_fine>;
using Cells = std::array<double, k_light_cells>;

// The direction in the middle of a part: stratum fine % 16 of cell fine / 16.
Vec3 fine_direction(uint32_t fine);

// The light at a place in a panorama: shares of a level floor's irradiance, and the irradiance itself, in the
// panorama's radiance. `place` is in radii of the panorama's sphere.
struct TrueLight {
  Fine shares;
  Cells cells;
  Vec3 irradiance;
};
TrueLight true_light(const RadianceMap& panorama, Vec3 place);

// An object on the floor, and what of each part of the hemisphere the floor sees beside it.
class FloorObject {
 public:
  static constexpr int k_texels = 48;  // along a side of four object heights

  // The mesh is put onto the floor, its footprint's middle at the centre.
  FloorObject(const std::string& name, const Mesh& mesh, uint64_t seed, ThreadPool* pool);

  // The floor's ratio in this light, by texel: 1 where the object takes nothing away.
  std::vector<float> truth(const TrueLight& light) const;
  // What is drawn in `cells` (all shares beside 1 are light that nothing hides), less `share` times the shadow of a
  // round light of 20 degrees in `direction`.
  std::vector<float> drawn(const Cells& cells, double share = 0.0, Vec3 direction = {0, 1, 0}) const;

 private:
  std::vector<float> hidden(Vec3 direction) const;  // of the round light, by texel
  std::vector<float> hidden_;                       // texels x k_fine: the share that is hidden
  std::vector<float> hidden_cells_;                 // texels x cells: the same of whole cells
};

// Root mean square error of what is drawn.
double error_of(const std::vector<float>& drawn, const std::vector<float>& truth);

}  // namespace sandglass::host
