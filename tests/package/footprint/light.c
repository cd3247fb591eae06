/* An app that only estimates the light of the room. */
#include "sandglass/light.h"

int main(int count, char** arguments) {
  sandglass_light_desc desc;
  sandglass_camera_image image;
  sandglass_light* light = NULL;
  sandglass_light_estimate estimate;
  sandglass_light_filament filament;
  const char* reason = NULL;
  sandglass_light_desc_default(&desc);
  desc.asset = arguments;
  desc.asset_bytes = (uint64_t)count;
  if (sandglass_light_create(&desc, arguments, (uint64_t)count, &light, &reason) != SANDGLASS_OK) return 1;
  sandglass_camera_image_default(&image);
  if (sandglass_light_set_image(light, &image, NULL, &reason) != SANDGLASS_OK) return 1;
  sandglass_light_run(light, 8);
  estimate.struct_size = sizeof estimate;
  sandglass_light_get(light, &estimate);
  filament.struct_size = sizeof filament;
  if (sandglass_light_to_filament(&estimate, SANDGLASS_LIGHT_MODEL_AMBIENT, 30.0f, &filament, &reason) != SANDGLASS_OK)
    return 1;
  return estimate.valid != 1;
}
