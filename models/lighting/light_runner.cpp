#include "models/lighting/light_runner.h"

#include "models/files/failure.h"
#include "runtime/light/network/backends.h"

namespace sandglass::host {

LightRunner::LightRunner(std::span<const uint8_t> file, const std::string& name, sandglass_isa isa, uint32_t width,
                         uint32_t height, sandglass_estimator_backend choice)
    : file_(file) {
  LightAsset asset;
  const char* reason = nullptr;
  if (open_light_asset(file_.data(), file_.size(), &asset, &reason) != SANDGLASS_OK) throw cannot("read", name, reason);
  const Int8Kernels* kernels = select_int8_kernels(isa);
  if (kernels == nullptr)
    throw Failure("cannot use \"--isa\": this CPU, or this build, has no such kernels. Leave --isa out.");
  const LightBackend* backend = nullptr;
  if (!find_light_backend(choice, &backend, &reason)) throw cannot("run", name, reason);
  Layout size, layout;
  layout_light_network(width, height, &size, backend);
  block_ = new_block(size.size, "the lighting network", "close other programs");
  layout.base = static_cast<uint8_t*>(block_.get());
  network_ = create_light_network(asset, kernels, backend, width, height,
                                  layout_light_network(width, height, &layout, backend), &reason);
  if (network_ == nullptr) throw cannot("run", name, reason);
}

LightOutputs LightRunner::run(std::span<const uint8_t> rgb) {
  if (rgb.size() != size_t{3} * network_->width * network_->height)
    throw Failure("cannot estimate light: the network takes images of " + std::to_string(network_->width) + " x " +
                  std::to_string(network_->height) + " pixels. Resample this one.");
  begin_light_network(network_, rgb.data());
  for (uint32_t unit = 0; unit < network_->units; ++unit) run_light_unit(network_, unit);
  LightOutputs outputs;
  finish_light_network(*network_, &outputs);
  return outputs;
}

std::vector<float> LightRunner::features() const {
  std::vector<float> features(k_light_features);
  light_features(*network_, features.data());
  return features;
}

}  // namespace sandglass::host
