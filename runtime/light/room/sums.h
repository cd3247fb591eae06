// All sums over the sphere of a room, at a place, of what was seen and what is to be expected elsewhere.
//
// Each part of the sphere counts with
//   X = seen * L * (1 + boost * clipped) + (1 - seen) * fill * (1 + what the network says)
// where L is its radiance beside the geometric mean of all that was seen. It is moved to the object: a part in the
// direction D of the sphere lies in the direction q = D - x from the object at x (in radii), and its solid angle there
// is that of the sphere times (1 - D . x) / |q|^3, by (5.15) to (5.17) of the dissertation. A cell is the mean of X
// over it, weighted by the cosine.
#pragma once

#include "runtime/light/harmonics.h"
#include "runtime/light/room/room.h"

namespace sandglass {

// All sums over the sphere.
struct RoomSums {
  double cells[k_light_cells][3];         // irradiance of the level floor from each cell
  double even[k_light_cells];             // the same of an even sky of radiance 1, as far as the pieces fill the cell
  double seen[k_light_cells];             // luminance of the part of `cells` that was seen
  double moments[k_light_cells][3];       // the same times the direction
  double even_moments[k_light_cells][3];  // `even` times the direction
  double sh[3 * k_harmonics];
  // Luminance of `cells`, and the seen part of the even sky, where what was seen counts for longer (estimate.cpp).
  double lasting[k_light_cells];
  double all_lasting;
  // The even sky, and the seen part of it.
  double all_even, all_seen;
  double clipped;  // luminance that comes through clipped pixels
};

// What was seen, on the whole.
struct RoomOverview {
  double level;      // geometric mean of the luminance
  double colour[3];  // of luminance 1
  double floor;      // mean luminance of what lies below; 0: not seen
};

// How much of each part counts as seen: the share that the camera has seen, as far as it is remembered; and what a
// probe adds.
struct RoomMemory {
  double seen[k_room_parts];
  double confidence, probe_scale[3];

  double with_probe(double share) const { return share + (1 - share) * confidence; }
  double known(uint32_t i) const { return with_probe(seen[i]); }
};
void room_remember(const Room& room, RoomMemory* memory);
// A part in the white balance of the last image.
RoomPart room_part_of(const Room& room, const RoomMemory& memory, uint32_t i);
RoomOverview room_overview(const Room& room, const RoomMemory& memory);

// The direction of the network's light in the sphere's frame, and how much it counts.
struct RoomHint {
  double direction[3], weight;
};
RoomHint room_hint(const Room& room, const RoomModel& model, const sandglass_estimator_light* estimate);

// A part as it is known.
struct KnownPart {
  // What it sends out where it was seen, over the geometric mean of all; and the luminance of that.
  double lit[3], bright;
  double clipped;  // share of the pixels that were clipped
  // The share of it that counts as seen: for its direction, and for the level.
  double seen, lasting;
  double up, aside;  // see RoomPart
};
KnownPart room_known_part(const Room& room, const RoomMemory& memory, uint32_t i, const RoomModel& model,
                          const RoomOverview& all);

// The plane whose light is asked for: a level one, whose azimuth 0 is `yaw` turns away; or its axes (along, normal,
// across) in the sphere's frame.
struct RoomFacing {
  bool level;
  double yaw, axes[3][3];

  void turn(const double sphere[3], double local[3]) const {
    for (int k = 0; k < 3; ++k)
      local[k] = level ? sphere[k] : axes[k][0] * sphere[0] + axes[k][1] * sphere[1] + axes[k][2] * sphere[2];
  }
};
// The cell in whose direction something is, where azimuth 0 is `yaw` turns away.
uint32_t room_cell_of(const double direction[3], double yaw);

void sums_add_sphere(const Room& room, const RoomMemory& memory, const RoomModel& model, const RoomOverview& all,
                     const RoomHint& hint, const double at[3], const RoomFacing& plane, RoomSums* sums);
// Turns the sums of each cell into its mean, however many pieces of the sphere lie in it. A cell without a piece, as
// may be far from the sphere's middle, gets the values of the next cell around that has some.
void sums_even_out(RoomSums* sums);
// The far light of a probe (probe.cpp), as far as the camera has not seen where it is. It is no piece of the sphere, so
// it does not fill a cell: it is added to cells that were evened out. It moves with the place where the app gives how
// far away the walls are.
void sums_add_far_light(const Room& room, const RoomMemory& memory, const RoomOverview& all, const RoomFacing& plane,
                        const double at[3], RoomSums* sums);

}  // namespace sandglass
