// A lighting network with a right checksum and wrong content: it is refused, or its estimate is finite, and the fastest
// kernels make the same one as others. Not the scalar ones: under sanitizers they take a minute for it.
#include <bit>

#include "models/lighting/light_file.h"
#include "runtime/asset/light_asset.h"
#include "sandglass/sandglass.hpp"
#include "tests/fuzz/edits.h"
#include "tests/fuzz/other_kernels.h"
#include "tests/light/light_fixture.h"

namespace {

using namespace sandglass;

constexpr size_t k_of_which_one_runs = 64;  // an estimate takes a hundred times as long as loading

// A random network with the errors that it claims; `with_floats`, with its float copy, too, every byte of which differs
// between seeds.
std::vector<uint8_t> network(uint64_t seed, bool with_floats) {
  host::LightFile file = host::random_light_file(seed);
  file.angle_deg = 12.0f;
  file.difference = 0.25f;
  constexpr uint32_t k_floats[] = {0x3e010101, 0x3f020202, 0x40030303};
  if (with_floats) file.float_parameters.assign(k_light_float_parameters, std::bit_cast<float>(k_floats[seed % 3]));
  return host::light_file_bytes(file);
}

// What describes the network lies between its millions of bytes of weights: it is what random networks have in common.
// Of the weights there are some.
struct Base {
  tests::AssetFile file;
  std::vector<size_t> places;
  explicit Base(bool with_floats) : file(network(6, with_floats)) {
    constexpr size_t k_between_weights = 65521;
    const std::vector<uint8_t> another = network(7, with_floats), third = network(8, with_floats);
    for (size_t i = 0; i < file.bytes; ++i)
      if ((file.data()[i] == another[i] && file.data()[i] == third[i]) || i % k_between_weights == 0)
        places.push_back(i);
  }
};

struct Estimate {
  bool taken = false, made = false;
  uint64_t hash = 0;
  sandglass_estimator_light light = {};
};

Estimate estimate_of(const tests::AssetFile& file, sandglass_isa isa, bool run) {
  Estimate estimate;
  sandglass_estimator_desc desc = estimator_desc();
  desc.asset = file.data();
  desc.asset_bytes = file.bytes;
  desc.isa = isa;
  Estimator light;
  static const tests::TestImage image(3);
  estimate.taken = static_cast<bool>(light.create(desc));
  if (!estimate.taken || !run || !light.estimate(image.image)) return estimate;
  sandglass_estimator_run(light.get(), UINT32_MAX);
  sandglass_estimator_get_latest(light.get(), &estimate.light);
  estimate.made = true;
  estimate.hash = sandglass_estimator_hash(light.get());
  return estimate;
}

void check(const sandglass_estimator_light& estimate) {
  if (estimate.valid == 0) return;
  for (const float d : estimate.direction) fuzz::expect(std::isfinite(d));
  for (const float c : estimate.light) fuzz::expect(std::isfinite(c));
  fuzz::expect(std::isfinite(estimate.contrast) && std::isfinite(estimate.confidence));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const Base bases[] = {Base(false), Base(true)};
  static tests::AssetFile files[] = {bases[0].file, bases[1].file};
  const size_t which = size % 16 == 1;  // files with floats take five times as long
  const std::vector<size_t>& places = bases[which].places;
  tests::AssetFile& file = files[which];
  std::vector<uint8_t> changed(places.size());
  for (size_t i = 0; i < places.size(); ++i) changed[i] = bases[which].file.data()[places[i]];
  fuzz::apply_edits(data, size, &changed);
  if (changed.size() < places.size()) return 0;
  for (size_t i = 0; i < places.size(); ++i) file.data()[places[i]] = changed[i];
  file.repair_checksum();
  const Estimate estimate = estimate_of(file, SANDGLASS_ISA_AUTOMATIC, size % k_of_which_one_runs == 8);
  fuzz::expect(estimate.taken || size >= fuzz::k_edit_bytes);
  if (!estimate.made) return 0;
  check(estimate.light);
  fuzz::expect(estimate_of(file, fuzz::other_kernels(data, size), true).hash == estimate.hash);
  return 0;
}
