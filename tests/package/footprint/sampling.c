/* An app that only makes points: in a volume and on a surface. */
#include "sandglass/sandglass.h"

int main(int count, char** arguments) {
  static float points[3 * 64];
  const char* reason = NULL;
  uint32_t found = 0;
  sandglass_mesh mesh = {points, 64, (const uint32_t*)(const void*)arguments, (uint32_t)count};
  sandglass_sample_desc desc;
  sandglass_sample_desc_default(&desc);
  desc.mesh = &mesh;
  desc.inside = sandglass_mesh_inside_test;
  desc.inside_user = arguments;
  return sandglass_sample_points(&desc, points, 0, points, 64, &found, &reason) != SANDGLASS_OK;
}
