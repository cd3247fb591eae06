/* An app that only turns a mesh into a signed-distance field. */
#include "sandglass/field.h"
#include "sandglass/sandglass.h"

int main(int count, char** arguments) {
  const char* reason = NULL;
  sandglass_field* field = NULL;
  sandglass_mesh mesh = {(const float*)(const void*)arguments, 64, (const uint32_t*)(const void*)arguments, (uint32_t)count};
  sandglass_field_desc desc;
  sandglass_field_desc_default(&desc);
  desc.mesh = &mesh;
  desc.inside = sandglass_mesh_inside_test;
  desc.inside_user = arguments;
  return sandglass_field_create(&desc, arguments, 0, &field, &reason) != SANDGLASS_OK;
}
