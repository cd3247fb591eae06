// XNNPACK on the lighting network's file, in float and in bytes, operator by operator as an app would set it up: dense
// blocks in place by strides, transitions pooled before their 1x1, a batch normalisation and its rectifier as the
// multiply-add by channel that XNNPACK has for it (a 1x1 convolution of each channel by itself). In float, too,
// everything is in units of the file's bytes, only not rounded. A benchmark's peer, nothing of the project rests on it.
#pragma once

#ifdef SANDGLASS_HAVE_XNNPACK

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "runtime/asset/light_asset.h"

namespace sandglass::host {

class XnnpackLightPeer {
 public:
  XnnpackLightPeer(const LightAsset& asset, bool bytes, uint32_t width, uint32_t height);
  ~XnnpackLightPeer();
  XnnpackLightPeer(const XnnpackLightPeer&) = delete;
  XnnpackLightPeer& operator=(const XnnpackLightPeer&) = delete;

  // The trunk, without the average of all pixels and the heads behind it.
  void run(std::span<const uint8_t> rgb);
  std::vector<float> features() const;

  uint64_t memory_bytes() const;  // that XNNPACK asked for, and the activations
  // Seconds of the last run, by operator.
  struct Time {
    const char* name;
    double seconds;
  };
  const std::vector<Time>& times() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sandglass::host

#endif
