// Every kernel body, in one namespace per instruction set. A table_<set>.cpp sets SANDGLASS_SIMD to the namespace of
// its simd header, includes this file, and so exports its tables.
namespace sandglass::SANDGLASS_SIMD {
#include "kernels/records.inl"

#include "kernels/cast.inl"
#include "kernels/colliders.inl"

#include "kernels/collider_push.inl"

#include "kernels/contact.inl"
#include "kernels/grid_cells.inl"
#include "kernels/motion_grid.inl"
#include "kernels/neighbour_lists.inl"
#include "kernels/own_particle.inl"
#include "kernels/pairs.inl"
#include "kernels/pile_light.inl"
#include "kernels/pile_sky.inl"
#include "kernels/read_flow.inl"
#include "kernels/wake.inl"

#include "kernels/grain_motion.inl"

extern const Kernels k_table, k_sand_table, k_pile_table, k_cast_table;
#define SANDGLASS_KERNEL(user, name, Args, Result) , name
const Kernels k_table = {SANDGLASS_SIMD_ISA, k_width
#include "kernels/kernels.inc"
};
#undef SANDGLASS_KERNEL
#define SANDGLASS_KERNEL(user, name, Args, Result) , KernelUser::user == KernelUser::sand ? name : nullptr
const Kernels k_sand_table = {SANDGLASS_SIMD_ISA, k_width
#include "kernels/kernels.inc"
};
#undef SANDGLASS_KERNEL
#define SANDGLASS_KERNEL(user, name, Args, Result) , KernelUser::user == KernelUser::pile ? name : nullptr
const Kernels k_pile_table = {SANDGLASS_SIMD_ISA, k_width
#include "kernels/kernels.inc"
};
#undef SANDGLASS_KERNEL
#define SANDGLASS_KERNEL(user, name, Args, Result) , KernelUser::user == KernelUser::cast ? name : nullptr
const Kernels k_cast_table = {SANDGLASS_SIMD_ISA, k_width
#include "kernels/kernels.inc"
};
#undef SANDGLASS_KERNEL
}  // namespace sandglass::SANDGLASS_SIMD
