// The workload on which the lighting network is counted: one pass over an image with a quarter of the usual pixels,
// with random weights. The number of instructions does not depend on the values of weights or pixels.
//   count_light [ISA [WIDTH HEIGHT]]
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "models/lighting/light_file.h"
#include "models/lighting/light_runner.h"
#include "tests/bench/counting.h"

int main(int argument_count, char** arguments) {
  const auto argument = [&](int at, int otherwise) {
    return at < argument_count ? std::atoi(arguments[at]) : otherwise;
  };
  const int isa = argument(1, SANDGLASS_ISA_AUTOMATIC);
  const auto width = static_cast<uint32_t>(argument(2, 128)), height = static_cast<uint32_t>(argument(3, 96));
  const std::vector<uint8_t> file = sandglass::host::light_file_bytes(sandglass::host::random_light_file(1));
  sandglass::host::LightRunner runner(file, "random", isa, width, height);
  sandglass::LightNetwork* net = runner.network();
  const std::vector<uint8_t> rgb(size_t{3} * width * height, 100);
  uint64_t items[sandglass::k_light_kinds], thousand_macs = 0;
  sandglass::light_items_left(*net, 0, items);
  for (const uint64_t of_kind : items) thousand_macs += of_kind;

  counting_begins();
  sandglass::begin_light_network(net, rgb.data());
  for (uint32_t unit = 0; unit < net->units; ++unit) sandglass::run_light_unit(net, unit);
  counting_ends();

  std::printf("isa %s\nthousand_macs %llu\npasses 1\n", sandglass_isa_name(net->kernels->isa),
              static_cast<unsigned long long>(thousand_macs));
  constexpr const char* k_names[sandglass::k_light_kinds] = {"stem_thousand_macs",       "pool_thousand_bytes",
                                                             "narrow_thousand_macs",     "wide_thousand_macs",
                                                             "transition_thousand_macs", "dot_thousand_macs"};
  for (uint32_t kind = 0; kind < sandglass::k_light_kinds; ++kind)
    std::printf("%s %llu\n", k_names[kind], static_cast<unsigned long long>(items[kind]));
  return 0;
}
