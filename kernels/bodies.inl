// Every kernel body, in one namespace per instruction set. A table_<set>.cpp sets SANDGLASS_SIMD to the namespace of
// its simd header, includes this file, and exports one table.
namespace sandglass::SANDGLASS_SIMD {
#include "kernels/records.inl"

#include "kernels/colliders.inl"
#include "kernels/contact.inl"
#include "kernels/grid_cells.inl"
#include "kernels/motion_grid.inl"
#include "kernels/neighbour_lists.inl"
#include "kernels/pile_light.inl"
#include "kernels/pile_sky.inl"
#include "kernels/refine.inl"
#include "kernels/wake.inl"

extern const Kernels k_table;
const Kernels k_table = {SANDGLASS_SIMD_ISA, k_width
#define SANDGLASS_KERNEL(name, Args, Result) , name
#include "kernels/kernels.inc"
#undef SANDGLASS_KERNEL
};
}  // namespace sandglass::SANDGLASS_SIMD
