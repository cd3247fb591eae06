/* An app that simulates sand: points and fields come from files. */
#include "sandglass/sandglass.h"

int main(int count, char** arguments) {
  sandglass_scene_desc desc;
  sandglass_scene* scene = NULL;
  sandglass_frame_input input;
  const char* reason = NULL;
  sandglass_scene_desc_default(&desc);
  desc.clock = sandglass_clock_system();
  if (sandglass_scene_create(&desc, arguments, (uint64_t)count, &scene, &reason) != SANDGLASS_OK) return 1;
  if (sandglass_scene_add(scene, NULL, NULL, &reason) != SANDGLASS_OK) return 1;
  sandglass_frame_input_default(&input);
  return sandglass_scene_frame(scene, &input, NULL, &reason) != SANDGLASS_OK;
}
