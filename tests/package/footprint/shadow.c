/* An app that only shows the baked shadows of an object and shades it. */
#include "sandglass/shadow.h"
#include "sandglass/renderers.h"

int main(int count, char** arguments) {
  const float up[3] = {0, 1, 0}, upright[4] = {0, 0, 0, 1};
  float cells[SANDGLASS_LIGHT_CELLS] = {0}, sh[27] = {0}, transfer[9];
  sandglass_texture ambient;
  sandglass_shadow_desc desc;
  sandglass_shadow* shadow = NULL;
  sandglass_texture texture;
  const char* reason = NULL;
  sandglass_shadow_desc_default(&desc);
  desc.asset = arguments;
  desc.asset_bytes = (uint64_t)count;
  if (sandglass_shadow_create(&desc, arguments, (uint64_t)count, &shadow, &reason) != SANDGLASS_OK) return 1;
  if (sandglass_shadow_set_light(shadow, 0, up, 1.0f, &reason) != SANDGLASS_OK) return 1;
  if (sandglass_shadow_set_cells(shadow, cells, 0.0f, &reason) != SANDGLASS_OK) return 1;
  if (sandglass_shadow_transfer(arguments, (uint64_t)count, up, up, 1, transfer, &reason) != SANDGLASS_OK) return 1;
  if (sandglass_harmonics_turn(sh, upright, sh, &reason) != SANDGLASS_OK) return 1;
  sandglass_shadow_run(&shadow, 1, 8);
  ambient.struct_size = sizeof ambient;
  sandglass_shadow_get_ambient(shadow, &ambient);
  texture.struct_size = sizeof texture;
  sandglass_shadow_get_texture(shadow, 0, &texture);
  return texture.valid != 1 || ambient.valid != 1;
}
