/* An app that only shows the baked shadow of an object. */
#include "sandglass/shadow.h"

int main(int count, char** arguments) {
  const float up[3] = {0, 1, 0};
  sandglass_shadow_desc desc;
  sandglass_shadow* shadow = NULL;
  sandglass_shadow_texture texture;
  const char* reason = NULL;
  sandglass_shadow_desc_default(&desc);
  desc.asset = arguments;
  desc.asset_bytes = (uint64_t)count;
  if (sandglass_shadow_create(&desc, arguments, (uint64_t)count, &shadow, &reason) != SANDGLASS_OK) return 1;
  if (sandglass_shadow_set_light(shadow, 0, up, 1.0f, &reason) != SANDGLASS_OK) return 1;
  sandglass_shadow_run(&shadow, 1, 8);
  texture.struct_size = sizeof texture;
  sandglass_shadow_get_texture(shadow, 0, &texture);
  return texture.valid != 1;
}
