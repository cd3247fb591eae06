// What an app gets when it asks for one instruction set by name, through the API. Prints a line for every instruction
// set of ARM: which kernels sand, a shadow and the light get, or that the set is refused.
//   choice SHADOW_FILE
#include <cstdio>
#include <exception>

#include "models/files/aligned_bytes.h"
#include "models/lighting/light_file.h"
#include "sandglass/sandglass.hpp"

int main(int argument_count, char** arguments) try {
  using sandglass::Status;
  using sandglass::host::AlignedBytes;
  if (argument_count < 2) {
    std::fprintf(stderr, "choice FILE: FILE must be a baked shadow\n");
    return 2;
  }
  const AlignedBytes shadow_file = sandglass::host::read_aligned(arguments[1], "baked shadow");
  const AlignedBytes light_file(sandglass::host::light_file_bytes(sandglass::host::random_light_file(1)));
  for (const sandglass_isa isa :
       {SANDGLASS_ISA_SCALAR, SANDGLASS_ISA_NEON, SANDGLASS_ISA_NEON_DOTPROD, SANDGLASS_ISA_NEON_I8MM}) {
    const char* name = sandglass_isa_name(isa);
    sandglass_scene_desc of_scene = sandglass::scene_desc();
    sandglass_shadow_desc of_shadow = sandglass::shadow_desc();
    sandglass_estimator_desc of_light = sandglass::estimator_desc();
    sandglass_pile_shadow_desc of_pile = sandglass::pile_shadow_desc();
    of_scene.isa = of_shadow.isa = of_light.isa = of_pile.isa = isa;
    of_shadow.asset = shadow_file.data();
    of_shadow.asset_bytes = shadow_file.size();
    of_light.asset = light_file.data();
    of_light.asset_bytes = light_file.size();
    sandglass::Scene scene;
    sandglass::Shadow shadow;
    sandglass::Estimator light;
    sandglass::PileShadow pile;
    const bool available = sandglass_isa_available(isa) != 0;
    for (const Status& status :
         {scene.create(of_scene), shadow.create(of_shadow), light.create(of_light), pile.create(of_pile)})
      if (status.code != (available ? SANDGLASS_OK : SANDGLASS_ERROR_UNSUPPORTED)) {
        std::printf("%s: not the answer of sandglass_isa_available: %s\n", name, status ? "accepted" : status.reason);
        return 1;
      }
    if (available)
      std::printf("%s sand %s shadow %s light %s\n", name, sandglass_isa_name(scene.isa()),
                  sandglass_isa_name(sandglass_shadow_isa(shadow.get())),
                  sandglass_isa_name(sandglass_estimator_isa(light.get())));
    else std::printf("%s refused\n", name);
  }
  return 0;
} catch (const std::exception& e) {
  std::fprintf(stderr, "choice: %s\n", e.what());
  return 2;
}
