// Thin layers of sand: grains finer than a texel, fewer than would cover it.
//
// Seen from a receiver on the floor, a column at a distance hides light by the share of the texel's width that its
// grains block. The receiver's own column has no distance: its grains stand as near as one grain to the next, and hide
// light of every elevation. How much they hide follows from the layer as a whole. Let grains that stand on the floor
// lie independently of each other. From a floor point that no grain covers, a light at one elevation is then seen with
// the probability exp(-(grains per area) * A), where A is the area of a grain's shadow outside the grain's own outline.
// The steps along an azimuth account for a part of A; the own column gets the rest.
#pragma once

#include "runtime/shadow/pile/pile.h"

namespace sandglass {

constexpr float k_half_face = 0.8862269f;  // radii: half the side of a square as large as a sphere's silhouette
// The same as height of a sphere that is finer than a texel: the mean of its upper half over its outline. Next to it in
// the texel there is none as high.
constexpr float k_fine_rise = 2.0f / 3;

// Whether spheres are smaller than texels along both sides.
inline bool is_finer_than_texels(const Pile& p) {
  return p.request.source.radius < 0.5f * p.rectangle.texel[0] && p.request.source.radius < 0.5f * p.rectangle.texel[1];
}

// The share of its texel by which a sphere fills the column of its centre.
float sphere_share(const Pile& pile);

// The area of the shadow of a sphere that stands on the floor, outside the sphere's own outline, for a light whose
// elevation has this sine. Radii squared.
double shadow_beyond_outline(double sine);

// Sets what the own column leaves of an azimuth (PileAzimuth::own and what follows). `steps` are the azimuth's, the
// nearest first.
void thin_own_column(const Pile& pile, const PileStep* steps, uint32_t count, PileAzimuth* azimuth);

}  // namespace sandglass
