/* The C API from C99, linked by a C compiler: a handful of particles falls on a floor. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "sandglass/sandglass.h"

static int fail(sandglass_status status, const char* reason) {
  fprintf(stderr, "%s: %s\n", sandglass_status_name(status), reason ? reason : "");
  return 1;
}

int main(void) {
  float positions[8][3];
  const char* reason = NULL;
  sandglass_scene_desc desc;
  sandglass_scene* scene = NULL;
  sandglass_collider ground = {SANDGLASS_SHAPE_HALF_SPACE, {0, 0, 0}, {0, 0, 0, 1}, {1, 1, 1}, {0, 0, 0}, {0, 0, 0}, 0, NULL};
  sandglass_frame_input input;
  sandglass_frame_report report;
  sandglass_status status;
  uint64_t bytes = 0;
  char* memory;
  void* block;
  int i;

  for (i = 0; i < 8; ++i) {
    positions[i][0] = 0.03f * (float)(i & 1);
    positions[i][1] = 0.05f + 0.03f * (float)(i >> 1 & 1);
    positions[i][2] = 0.03f * (float)(i >> 2);
  }
  sandglass_scene_desc_default(&desc);
  desc.granular.particle_capacity = 8;
  desc.granular.collider_capacity = 1;
  if ((status = sandglass_scene_bytes(&desc, &bytes, &reason)) != SANDGLASS_OK) return fail(status, reason);
  memory = (char*)malloc((size_t)bytes + SANDGLASS_BLOCK_ALIGNMENT);
  if (!memory) return 1;
  block = memory + (SANDGLASS_BLOCK_ALIGNMENT - (uintptr_t)memory % SANDGLASS_BLOCK_ALIGNMENT);
  if ((status = sandglass_scene_create(&desc, block, bytes, &scene, &reason)) != SANDGLASS_OK) return fail(status, reason);
  status = sandglass_granular_add(scene, positions[0], NULL, 8, NULL, NULL, 0, &reason);
  if (status != SANDGLASS_OK) return fail(status, reason);

  sandglass_frame_input_default(&input);
  input.time_step = 1.0f / 60.0f;
  input.colliders = &ground;
  input.collider_count = 1;
  report.struct_size = sizeof report;
  for (i = 0; i < 60; ++i) {
    status = sandglass_scene_frame(scene, &input, &report, &reason);
    if (status != SANDGLASS_OK) return fail(status, reason);
  }
  sandglass_granular_particles(scene, positions[0], NULL);
  printf("%" PRIu64 " bytes, %s kernels, particle 0 at height %.4f m\n", bytes, sandglass_isa_name(sandglass_scene_isa(scene)),
         (double)positions[0][1]);
  free(memory);
  return report.particles == 8 && positions[0][1] > -0.01f && positions[0][1] < 0.05f ? 0 : 1;
}
