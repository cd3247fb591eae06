/* The smallest app, in C: a block of sand falls onto the floor for two seconds. No clock is handed over, so every frame
 * runs all its work and the state is the same on every machine. */
#include <stdio.h>
#include <stdlib.h>

#include "sandglass/sandglass.h"

enum { SIDE = 8, PARTICLES = SIDE * SIDE * SIDE };

static int fail(const char* reason) {
  fprintf(stderr, "hello: %s\n", reason);
  return 1;
}

int main(void) {
  /* The library that is linked must be that of the headers. */
  if (!SANDGLASS_VERSION_FITS()) return fail("the library is of another version than its headers");

  /* What the scene needs room for, and one block of memory of the size that it asks for. */
  const char* reason = NULL;
  sandglass_scene_desc desc;
  sandglass_scene_desc_default(&desc);
  desc.granular.particle_radius = 0.01f;
  desc.granular.particle_capacity = PARTICLES;
  desc.granular.collider_capacity = 1;
  uint64_t bytes = 0;
  if (sandglass_scene_bytes(&desc, &bytes, &reason) != SANDGLASS_OK) return fail(reason);
  char* memory = malloc((size_t)bytes + SANDGLASS_BLOCK_ALIGNMENT);
  if (memory == NULL) return fail("there is not enough memory");
  void* block = memory + (SANDGLASS_BLOCK_ALIGNMENT - (uintptr_t)memory % SANDGLASS_BLOCK_ALIGNMENT);
  sandglass_scene* scene = NULL;
  if (sandglass_scene_create(&desc, block, bytes, &scene, &reason) != SANDGLASS_OK) return fail(reason);

  /* Sand: particles a diameter apart or more, every other layer shifted, 0.2 m above the floor. */
  static float positions[PARTICLES][3];
  for (int i = 0; i < PARTICLES; ++i) {
    const int layer = i / SIDE / SIDE;
    positions[i][0] = 0.02f * (float)(i % SIDE) + 0.01f * (float)(layer % 2);
    positions[i][1] = 0.02f * (float)layer + 0.2f;
    positions[i][2] = 0.02f * (float)(i / SIDE % SIDE) + 0.01f * (float)(layer % 2);
  }
  const sandglass_points sand = {positions[0], NULL, PARTICLES};
  if (sandglass_scene_add(scene, &sand, NULL, &reason) != SANDGLASS_OK) return fail(reason);

  /* Frames: 60 a second, above a floor at height 0. */
  sandglass_collider ground = {.shape = SANDGLASS_SHAPE_HALF_SPACE, .rotation = {0, 0, 0, 1}};
  sandglass_frame_input input;
  sandglass_frame_input_default(&input);
  input.time_step = 1.0f / 60.0f;
  input.colliders = &ground;
  input.collider_count = 1;
  sandglass_frame_report report;
  report.struct_size = sizeof report;
  for (int frame = 0; frame < 120; ++frame)
    if (sandglass_scene_frame(scene, &input, &report, &reason) != SANDGLASS_OK) return fail(reason);

  sandglass_scene_particles(scene, positions[0], NULL);
  float top = 0;
  for (int i = 0; i < PARTICLES; ++i) top = positions[i][1] > top ? positions[i][1] : top;
  printf("%u particles after %.1f s: the pile is %.3f m high, the fastest particle has %.3f m/s\n", report.sand.particles,
         report.time.simulated, (double)top, (double)report.sand.speed_max);
  free(memory); /* the block is the scene: there is nothing else to destroy */
  return 0;
}
