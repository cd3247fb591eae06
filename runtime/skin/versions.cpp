// A mesh that is complete becomes the shown one, and what differs in it gets a new version: chunks that mesh.cpp has
// marked (k_chunk_changed), and those that were carried since (carry.cpp), which lie where they are again.
#include <cstring>

#include "runtime/sand/granular.h"
#include "runtime/skin/skin.h"

namespace sandglass {

void skin_publish(SkinState* s) {
  SkinMesh &back = s->meshes.back, &front = s->meshes.front;
  SkinShown& shown = s->shown;
  const size_t loose = (back.flying + back.lying) * sizeof *back.loose;
  bool changed = !s->valid || back.flying != shown.flying || back.lying != shown.lying ||
                 memcmp(back.loose, shown.loose, loose) != 0;
  for (uint32_t c = 0; c < s->bricks.chunks.capacity; ++c) {
    sandglass_skin_chunk& chunk = back.chunks[c];
    const bool carried = shown.chunks[c].vertices != front.chunks[c].vertices;
    if (chunk.version == k_chunk_changed || carried) {
      chunk.version = s->shown.version + 1;
      changed = true;
    }
    shown.chunks[c] = chunk;
  }
  memcpy(shown.loose, back.loose, loose);
  shown.flying = back.flying;
  shown.lying = back.lying;
  float* const from = s->carry.from;
  s->carry.from = s->sand.from;
  s->sand.from = from;
  carry_from_here(&s->carry, *s);
  if (changed) ++s->shown.version;
  const SkinMesh swap = front;
  front = back;
  back = swap;
  s->front_version = s->shown.version;
  shown.frame = s->sand.frame;
  shown.substeps = s->sand.substeps;
  shown.lost = false;
  s->progress.in_time = s->progress.begun == s->frame ? s->progress.in_time + 1 : 0;
  s->valid = true;
  s->shown.begun = s->progress.begun;
  s->shown.left_out = s->sand.left_out;
  memcpy(s->progress.usual, s->progress.spent, sizeof s->progress.usual);
}

}  // namespace sandglass
