// The headers as a Clang module, as Swift sees them: the import alone gives constants, structs and functions.
@import Sandglass;

uint64_t whole_api(void);
uint64_t whole_api(void) {
  sandglass_scene_desc desc;
  sandglass_scene_desc_default(&desc);
  desc.granular.particle_capacity = SANDGLASS_STAGE_COUNT;
  sandglass_sample_options options;
  sandglass_sample_options_default(&options);
  float low[3] = {0, 0, 0}, high[3] = {1, 1, 1};
  uint64_t bytes = 0;
  const char *reason = NULL;
  return sandglass_field_bytes(low, high, 0.1f, &bytes, &reason) == SANDGLASS_OK ? bytes : desc.struct_size;
}
