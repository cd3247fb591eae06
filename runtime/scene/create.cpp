// Making a scene: the description is checked, one walk over it lays out the block, and the same walk counts its bytes.
#include "runtime/frame/create.h"
#include "runtime/frame/refuse.h"
#include "runtime/scene/scene.h"

namespace sandglass {
namespace {

sandglass_status check(const sandglass_scene_desc& desc, const char** reason) {
  if (!gravity_fits(desc.gravity)) return refuse(reason, "desc.gravity must be finite and at most 1000 m/s^2.");
  if (desc.unit_items < 16 || desc.unit_items > 65536 || desc.unit_items % 16 != 0) {
    return refuse(reason, "desc.unit_items must be a multiple of 16 from 16 to 65536.");
  }
  if (desc.isa < SANDGLASS_ISA_AUTOMATIC || desc.isa > SANDGLASS_ISA_WASM) {
    return refuse(reason, "desc.isa must be a SANDGLASS_ISA value.");
  }
  if (select_sand_kernels(desc.isa) == nullptr)
    return refuse(reason, SANDGLASS_ERROR_UNSUPPORTED,
                  "desc.isa is not available on this CPU or in this build: use SANDGLASS_ISA_AUTOMATIC.");
  if (desc.finest_level >= SANDGLASS_LEVEL_COUNT)
    return refuse(reason, "desc.finest_level must be below SANDGLASS_LEVEL_COUNT; 0 is best.");
  const char* granular = granular_refuse(desc.granular);
  return granular == nullptr ? SANDGLASS_OK : refuse(reason, granular);
}

// The one walk: the scene itself, then the regions of its sand.
sandglass_scene* walk(const sandglass_scene_desc& desc, Layout* layout, Granular* granular) {
  sandglass_scene* scene = layout_region<sandglass_scene>(layout, "scene", 1);
  granular_layout(granular, desc.granular, layout);
  return scene;
}

sandglass_scene* lay_out(const sandglass_scene_desc& desc, Layout* layout) {
  Granular granular = {};
  sandglass_scene* scene = walk(desc, layout, &granular);
  if (scene != nullptr) scene->layout = *layout;
  return scene;
}

// All but what the regions hold, as in a new block: nothing reads there what it has not written since.
void begin(sandglass_scene* scene) {
  Layout layout;
  layout.base = scene->layout.base;
  Granular granular = {};
  walk(scene->desc, &layout, &granular);
  scene->granular = granular;
  granular_configure(&scene->granular, scene->desc, scene->kernels);
  granular_reset(&scene->granular);
  governor_init(&scene->governor, scene->desc.clock, scene->desc.trace, SANDGLASS_LEVEL_COUNT);
  scene->governor.finest_level = scene->desc.finest_level;
  scene->frame = 0;
}

sandglass_status build(const sandglass_scene_desc& desc, sandglass_scene* scene, const char** reason) {
  scene->desc = desc;
  scene->kernels = select_sand_kernels(desc.isa);
  begin(scene);
  return accept(reason);
}

using Maker = MakerOf<check, lay_out, build>;

}  // namespace
}  // namespace sandglass

using namespace sandglass;

sandglass_status sandglass_scene_bytes(const sandglass_scene_desc* desc, uint64_t* bytes, const char** reason) {
  return bytes_of<Maker>(desc, bytes, reason);
}

sandglass_status sandglass_scene_create(const sandglass_scene_desc* desc, void* block, uint64_t bytes,
                                        sandglass_scene** scene, const char** reason) {
  return create_in<Maker>(desc, block, bytes, scene, "scene is NULL: pass where to store it.", reason);
}

void sandglass_scene_reset(sandglass_scene* scene) {
  if (scene != nullptr) begin(scene);
}

uint32_t sandglass_scene_regions(const sandglass_scene* scene, sandglass_region* regions, uint32_t capacity) {
  if (scene == nullptr) return 0;
  const Layout& layout = scene->layout;
  for (uint32_t i = 0; regions != nullptr && i < layout.region_count && i < capacity; ++i)
    regions[i] = layout.regions[i];
  return layout.region_count;
}

sandglass_isa sandglass_scene_isa(const sandglass_scene* scene) {
  return scene == nullptr ? SANDGLASS_ISA_AUTOMATIC : scene->kernels->isa;
}
