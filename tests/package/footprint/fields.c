/* An app that only turns a mesh into a signed-distance field. */
#include "sandglass/field.h"
#include "sandglass/sandglass.h"

int main(int count, char** arguments) {
  const float low[3] = {0, 0, 0}, high[3] = {1, 1, 1};
  const char* reason = NULL;
  sandglass_field* field = NULL;
  sandglass_mesh mesh = {(const float*)(const void*)arguments, 64, (const uint32_t*)(const void*)arguments, (uint32_t)count};
  return sandglass_field_from_mesh(&mesh, sandglass_mesh_inside_test, arguments, low, high, 0.1f, 0.3f, SANDGLASS_SOLID_INSIDE,
                                   arguments, 0, &field, &reason) != SANDGLASS_OK;
}
