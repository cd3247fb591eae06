/* An app that only gathers the light of a room and asks for it. */
#include "sandglass/room.h"
#include "sandglass/camera.h"

int main(int count, char** arguments) {
  sandglass_room_place place;
  sandglass_room_desc desc;
  sandglass_camera_image image;
  sandglass_room* room = NULL;
  sandglass_room_light light, shown;
  const char* reason = NULL;
  sandglass_room_desc_default(&desc);
  if (sandglass_room_create(&desc, arguments, (uint64_t)count, &room, &reason) != SANDGLASS_OK) return 1;
  sandglass_camera_image_default(&image);
  if (sandglass_room_set_image(room, &image, NULL, &reason) != SANDGLASS_OK) return 1;
  light.struct_size = sizeof light;
  sandglass_room_place_default(&place);
  if (sandglass_room_get(room, &place, &light, &reason) != SANDGLASS_OK) return 1;
  shown = light;
  sandglass_room_fade(&shown, &light, 0.016f);
  return shown.valid != 1;
}
