// What is counted of the lighting network: one pass over an image of a quarter of the usual pixels, random weights. How
// many instructions run does not depend on either's values.
//   count_light [ISA]
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "models/lighting/light_file.h"
#include "models/lighting/light_runner.h"

extern "C" {
__attribute__((noinline)) void counting_begins() { __asm__ volatile(""); }
__attribute__((noinline)) void counting_ends() { __asm__ volatile(""); }
}

int main(int argument_count, char** arguments) {
  constexpr uint32_t k_width = 128, k_height = 96;
  const int isa = argument_count > 1 ? std::atoi(arguments[1]) : SANDGLASS_ISA_AUTOMATIC;
  const std::vector<uint8_t> file = sandglass::host::light_file_bytes(sandglass::host::random_light_file(1));
  sandglass::host::LightRunner runner(file, "random", isa, k_width, k_height);
  sandglass::LightNetwork* net = runner.network();
  const std::vector<uint8_t> rgb(size_t{3} * k_width * k_height, 100);
  uint64_t items[sandglass::k_light_kinds], thousand_macs = 0;
  sandglass::light_items_left(*net, 0, items);
  for (const uint64_t of_kind : items) thousand_macs += of_kind;

  counting_begins();
  sandglass::begin_light_network(net, rgb.data());
  for (uint32_t unit = 0; unit < net->units; ++unit) sandglass::run_light_unit(net, unit);
  counting_ends();

  std::printf("isa %s\nthousand_macs %llu\nnarrow_thousand_macs %llu\nwide_thousand_macs %llu\npasses 1\n",
              sandglass_isa_name(net->kernels->isa), static_cast<unsigned long long>(thousand_macs),
              static_cast<unsigned long long>(items[sandglass::k_light_kind_narrow]),
              static_cast<unsigned long long>(items[sandglass::k_light_kind_wide]));
  return 0;
}
