// XNNPACK on a shadow network, as an app would call it: fully connected operators on blocks of rows that fit the
// caches. It is here only to be compared with.
#pragma once

#ifdef SANDGLASS_HAVE_XNNPACK

#include <memory>

#include "models/baking/network.h"

namespace sandglass::host {

class XnnpackPeer {
 public:
  // `quantised`: weights and activations are int8 with one scale for each tensor, and activations are clipped at
  // `clips`. If not, all is in float.
  XnnpackPeer(const FloatNetwork& network, const std::vector<float>& clips, bool quantised);
  ~XnnpackPeer();
  XnnpackPeer(const XnnpackPeer&) = delete;
  XnnpackPeer& operator=(const XnnpackPeer&) = delete;

  // `input` has k_inputs floats for each texel. The int8 network takes bytes: round_inputs, then run_bytes.
  void run(const float* input, uint32_t texels, float* output);
  // Both arrays are read and written by whole vectors: they must have 64 more values behind the last texel.
  void round_inputs(const float* input, uint32_t texels, int8_t* bytes);
  void run_bytes(const int8_t* input, uint32_t texels, float* output);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sandglass::host

#endif
