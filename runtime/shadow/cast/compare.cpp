// Whether what is gathered and shown is out of date: where meshes or plane are other ones, or have moved so far that it
// is seen.
#include "runtime/math/app_mesh.h"
#include "runtime/math/math.h"
#include "runtime/shadow/cast/cast.h"

namespace sandglass {
namespace {

constexpr uint32_t k_restarts_max = 4;   // gatherings that other counts end, before a texture
constexpr double k_finest_texel = 1e-5;  // metres

// The farthest that a corner of the mesh's box moves from where it was gathered, in texels of the finest texture. Where
// nothing is seen they have no size; rounding is less than the finest.
bool moved(const CastState& c, const CastMesh& mesh) {
  double now[12], texel = 0;
  cast_place(c.request.frame, mesh.asked.world_from_mesh, now);
  for (const CastTarget& target : c.targets)
    for (const double side : target.front.texel)
      if (target.texels != 0 && side > 0 && (texel == 0 || side < texel)) texel = side;
  texel = texel > k_finest_texel ? texel : k_finest_texel;
  for (uint32_t corner = 0; corner < 8 && !(mesh.low[0] > mesh.high[0]); ++corner) {
    double square = 0;
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const double *a = now + 4 * axis, *b = mesh.plane_from_mesh + 4 * axis;
      double move = a[3] - b[3];
      for (uint32_t k = 0; k < 3; ++k)
        move += (a[k] - b[k]) * static_cast<double>((corner >> k & 1) != 0 ? mesh.high[k] : mesh.low[k]);
      square += move * move;
    }
    if (!(square <= k_cast_still * k_cast_still * texel * texel)) return true;
  }
  return false;
}

// Whether a plane of another extent, as trackers make it from second to second, cuts a texture or did so before.
bool cut_otherwise(const CastState& c) {
  for (const CastTarget& target : c.targets)
    for (uint32_t axis = 0; axis < 2 && target.texels != 0; ++axis) {
      const double low[2] = {static_cast<double>(c.request.frame.low[axis]),
                             static_cast<double>(c.gathered.frame.low[axis])};
      const double high[2] = {static_cast<double>(c.request.frame.high[axis]),
                              static_cast<double>(c.gathered.frame.high[axis])};
      const double texel = target.front.texel[axis], still = k_cast_still * texel;
      const double from = target.front.low[axis], to = from + texel * target.texels;
      if (absolute(low[0] - low[1]) > still && from <= (low[0] > low[1] ? low[0] : low[1]) + still) return true;
      if (absolute(high[0] - high[1]) > still && to >= (high[0] < high[1] ? high[0] : high[1]) - still) return true;
    }
  return false;
}

}  // namespace

void cast_compare(CastState* c) {
  bool other = false, counts = false, anew = false;
  uint32_t triangles = 0;
  for (uint32_t i = 0; i < c->request.mesh_count; ++i) {
    const CastMesh& mesh = c->request.meshes[i];
    triangles += mesh.asked.triangle_count;
    const uint32_t now = mesh.asked.triangle_count, before = mesh.gathered.triangle_count;
    counts = counts || now != before;
    anew = anew || (now > before ? now - before : before - now) > before / 4;
    other = other || !same_arrays(mesh.asked, mesh.gathered) || mesh.asked.version != mesh.gathered.version ||
            mesh.asked.closed != mesh.gathered.closed || mesh.asked.is_real != mesh.gathered.is_real || moved(*c, mesh);
  }
  const bool fewer = triangles < c->comparison.triangles;  // one may have gone
  counts = counts || triangles != c->comparison.triangles;
  anew = anew || (fewer && c->comparison.triangles - triangles > c->comparison.triangles / 4);
  c->comparison.triangles = triangles;
  const bool frame =
      c->request.frame.is_virtual != c->gathered.frame.is_virtual ||
      absolute(static_cast<double>(c->request.frame.bias - c->gathered.frame.bias)) > 0 ||
      (c->desc.layers > 1 && absolute(static_cast<double>(c->request.frame.height - c->gathered.frame.height)) > 0) ||
      cut_otherwise(*c);
  if (!other && !counts && !frame) return;
  c->comparison.stale = true;
  for (CastTarget& target : c->targets) target.asked = target.texels != 0;
  if (anew) c->targets[k_cast_light].draft = true;
  // Where the counts are as they were, it goes on in the new arrays: an engine may hand out other ones in every frame.
  // And after a few with other counts, too, in what both have: a scan grows in every frame.
  if (!counts || c->progress.phase != CastPhase::gather || c->comparison.restarts == k_restarts_max) return;
  ++c->comparison.restarts;
  c->comparison.stale = false;
  cast_begin_gather(&c->gathered, c->request.meshes, c->request);
}

}  // namespace sandglass
