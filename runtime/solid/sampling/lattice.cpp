// Hexagonal close packing in a volume: Alg. 3. One pass asks `inside` once for each site and notes the answer in a bit.
// So the number of points is known before the first one is written.
#include "kernels/whole.h"
#include "runtime/frame/layout.h"
#include "runtime/math/math.h"
#include "runtime/solid/sampling/arguments.h"
#include "runtime/solid/sampling/methods.h"

namespace sandglass {
namespace {

constexpr uint64_t k_progress_interval = 1u << 16;  // sites

struct Lattice {
  double origin[3], far[3];
  double distance;
  uint32_t sites[3];
  uint64_t total;
};

// Alg. 3, lines 1-3. Where the extent is a whole number of spacings there is one more site than the ceiling of the
// dissertation gives: the last layer lies on the far face of the box, which belongs to the box.
sandglass_status measure(const sandglass_sample_desc& desc, Lattice* lattice, const char** reason) {
  if (const sandglass_status status = check_volume(desc, reason)) return status;
  lattice->distance = static_cast<double>(desc.distance);
  const double spacing[3] = {1, square_root(6.0) / 3, square_root(3.0) / 2};
  double total = 1;
  for (int k = 0; k < 3; ++k) {
    lattice->origin[k] = static_cast<double>(desc.bounds_min[k]);
    lattice->far[k] = static_cast<double>(desc.bounds_max[k]);
    const double sites = (lattice->far[k] - lattice->origin[k]) / (spacing[k] * lattice->distance);
    total *= sites + 1;
    if (!(total <= static_cast<double>(k_point_limit)))
      return refuse(reason, "distance is too small: more than 2^30 lattice sites in the bounding box; enlarge it.");
    lattice->sites[k] = to_whole<uint32_t>(sites) + 1;
  }
  lattice->total = static_cast<uint64_t>(lattice->sites[0]) * lattice->sites[1] * lattice->sites[2];
  return accept(reason);
}

uint64_t* lay_out(Layout* layout, const Lattice& lattice) {
  return layout_region<uint64_t>(layout, "sampling.lattice.bits", (lattice.total + 63) / 64);
}

// The place of a site, (3.33), from the minimum of the box. False where the shifts carry the site out of the box.
bool place_site(const Lattice& lattice, uint64_t index, float point[3]) {
  const uint32_t i = static_cast<uint32_t>(index % lattice.sites[0]);
  const uint32_t k = static_cast<uint32_t>(index / lattice.sites[0] % lattice.sites[2]);
  const uint32_t j = static_cast<uint32_t>(index / lattice.sites[0] / lattice.sites[2]);
  const double site[3] = {i + 0.5 * ((j + k) % 2), square_root(6.0) / 3 * j,
                          square_root(3.0) / 2 * (k + (j % 2) / 3.0)};
  for (int axis = 0; axis < 3; ++axis) {
    point[axis] = static_cast<float>(lattice.origin[axis] + site[axis] * lattice.distance);
    if (!(static_cast<double>(point[axis]) <= lattice.far[axis])) return false;
  }
  return true;
}

}  // namespace

sandglass_status sample_on_lattice(const sandglass_sample_desc& desc, SampleCall* call, const char** reason) {
  Lattice lattice;
  if (const sandglass_status status = measure(desc, &lattice, reason)) return status;
  call->enough = static_cast<uint32_t>(lattice.total);
  Layout size;
  lay_out(&size, lattice);
  call->bytes = size.size;
  if (call->points == nullptr) return accept(reason);
  if (const sandglass_status status = check_block(call->scratch, call->scratch_bytes, call->bytes, reason))
    return status;

  Layout layout;
  layout.base = static_cast<uint8_t*>(call->scratch);
  uint64_t* bits = lay_out(&layout, lattice);
  for (uint64_t word = 0; word < (lattice.total + 63) / 64; ++word) bits[word] = 0;
  uint64_t found = 0;
  float point[3];
  for (uint64_t index = 0; index < lattice.total; ++index) {
    if (desc.progress != nullptr && index % k_progress_interval == 0 && index > 0)
      desc.progress(desc.progress_user, index, lattice.total);
    if (!place_site(lattice, index, point) || desc.inside(desc.inside_user, point) == 0) continue;
    bits[index / 64] |= 1ull << (index % 64);
    ++found;
  }
  if (found > call->capacity) return refuse(reason, SANDGLASS_ERROR_CAPACITY, k_beyond_capacity);
  for (uint64_t index = 0; index < lattice.total; ++index)
    if (bits[index / 64] >> (index % 64) & 1) place_site(lattice, index, call->points + 3ull * call->count++);
  return accept(reason);
}

}  // namespace sandglass
