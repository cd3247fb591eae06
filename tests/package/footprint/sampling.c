/* An app that only makes points: in a volume and on a surface. */
#include "sandglass/sandglass.h"

int main(int count, char** arguments) {
  static float points[3 * 64];
  const float low[3] = {0, 0, 0}, high[3] = {1, 1, 1};
  const char* reason = NULL;
  uint32_t found = 0;
  sandglass_mesh mesh = {points, 64, (const uint32_t*)(const void*)arguments, (uint32_t)count};
  sandglass_sample_options options;
  sandglass_sample_options_default(&options);
  if (sandglass_sample_volume(low, high, 0.5f, sandglass_mesh_inside_test, arguments, &options, points, 0, points, 64, &found,
                              &reason) != SANDGLASS_OK)
    return 1;
  return sandglass_sample_surface(&mesh, 0.5f, &options, points, 0, points, 64, &found, &reason) != SANDGLASS_OK;
}
