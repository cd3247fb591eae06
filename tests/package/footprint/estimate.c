/* An app that only estimates the light of the room. */
#include "sandglass/renderers.h"

int main(int count, char** arguments) {
  sandglass_estimator_desc desc;
  sandglass_camera_image image;
  sandglass_estimator* estimator = NULL;
  sandglass_estimator_light estimate;
  sandglass_light lighting;
  sandglass_filament_light filament;
  const char* reason = NULL;
  sandglass_estimator_desc_default(&desc);
  desc.asset = arguments;
  desc.asset_bytes = (uint64_t)count;
  if (sandglass_estimator_create(&desc, arguments, (uint64_t)count, &estimator, &reason) != SANDGLASS_OK) return 1;
  sandglass_camera_image_default(&image);
  if (sandglass_estimator_set_image(estimator, &image, NULL, &reason) != SANDGLASS_OK) return 1;
  sandglass_estimator_run(estimator, 8);
  estimate.struct_size = sizeof estimate;
  sandglass_estimator_get(estimator, &estimate);
  lighting.struct_size = sizeof lighting;
  if (sandglass_light_of_estimator(&estimate, &lighting, &reason) != SANDGLASS_OK) return 1;
  filament.struct_size = sizeof filament;
  if (sandglass_light_to_filament(&lighting, SANDGLASS_LIGHT_AMBIENT, 30.0f, &filament, &reason) != SANDGLASS_OK)
    return 1;
  return estimate.valid != 1;
}
