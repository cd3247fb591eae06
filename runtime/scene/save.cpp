// A scene to bytes and back, for an app that goes to the background.
#include "platform/floating_point.h"
#include "runtime/frame/refuse.h"
#include "runtime/scene/scene.h"

using namespace sandglass;

uint64_t sandglass_scene_save_bytes(const sandglass_scene* scene) {
  return scene == nullptr ? 0 : granular_save_bytes(scene->granular);
}

sandglass_status sandglass_scene_save(sandglass_scene* scene, void* data, uint64_t bytes, uint64_t* written,
                                      const char** reason) {
  if (scene == nullptr) return refuse(reason, k_no_scene);
  const ExactFloatingPoint exact;
  return granular_save(&scene->granular, data, bytes, written, reason);
}

sandglass_status sandglass_scene_restore(sandglass_scene* scene, const void* data, uint64_t bytes,
                                         const char** reason) {
  if (scene == nullptr) return refuse(reason, k_no_scene);
  return granular_restore(&scene->granular, data, bytes, reason);
}
