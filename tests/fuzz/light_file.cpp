// A lighting network with a right checksum and wrong content: it is refused, or its estimate is finite.
#include "sandglass/sandglass.hpp"
#include "tests/fuzz/edits.h"
#include "tests/lighting/light_fixture.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace sandglass;
  const tests::AssetFile& base = tests::random_light();
  // What describes the network lies at the ends of the file, its weights between them: most changes go to the ends.
  constexpr size_t k_end = 8192;
  std::vector<uint8_t> ends(base.data(), base.data() + k_end);
  ends.insert(ends.end(), base.data() + base.bytes - k_end, base.data() + base.bytes);
  fuzz::apply_edits(data, size, &ends);
  if (ends.size() < 2 * k_end) return 0;
  static tests::AssetFile file = base;
  std::memcpy(file.data(), ends.data(), k_end);
  std::memcpy(file.data() + file.bytes - k_end, ends.data() + k_end, k_end);
  file.repair_checksum();
  sandglass_light_desc desc = light_desc();
  desc.asset = file.data(), desc.asset_bytes = file.bytes;
  Light light;
  if (!light.create(desc)) return 0;
  if (size % 64 != 8) return 0;  // an estimate takes a hundred times as long as loading
  static const tests::TestImage image(3);
  if (!light.estimate(image.image)) return 0;
  sandglass_light_run(light.get(), UINT32_MAX);
  sandglass_light_estimate estimate = {};
  sandglass_light_get_latest(light.get(), &estimate);
  if (estimate.valid == 0) return 0;
  for (const float d : estimate.direction) fuzz::expect(std::isfinite(d));
  for (const float c : estimate.light) fuzz::expect(std::isfinite(c));
  fuzz::expect(std::isfinite(estimate.contrast) && std::isfinite(estimate.confidence));
  return 0;
}
