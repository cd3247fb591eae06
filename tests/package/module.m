// The headers as a Clang module, as Swift sees them: the import alone gives constants, structs and functions.
@import Sandglass;

uint64_t whole_api(void);
uint64_t whole_api(void) {
  sandglass_scene_desc desc;
  sandglass_scene_desc_default(&desc);
  desc.granular.particle_capacity = SANDGLASS_STAGE_COUNT;
  sandglass_field_desc field;
  sandglass_field_desc_default(&field);
  field.inside = sandglass_mesh_inside_test;
  uint64_t bytes = 0;
  const char *reason = NULL;
  return sandglass_field_bytes(&field, &bytes, &reason) == SANDGLASS_OK ? bytes : desc.struct_size;
}
