// XNNPACK on a shadow network, as an app would call it: fully connected operators, blocks of rows that fit its caches.
// A benchmark's peer, nothing of the project rests on it.
#pragma once

#ifdef SANDGLASS_HAVE_XNNPACK

#include <memory>

#include "models/baking/network.h"

namespace sandglass::host {

class XnnpackPeer {
 public:
  // `quantised`: int8 weights and activations, one scale a tensor, activations clipped at `clips`; else float.
  XnnpackPeer(const FloatNetwork& network, const std::vector<float>& clips, bool quantised);
  ~XnnpackPeer();
  XnnpackPeer(const XnnpackPeer&) = delete;
  XnnpackPeer& operator=(const XnnpackPeer&) = delete;

  // `input` is k_inputs floats a texel. The int8 network wants bytes: round_inputs(), then run_bytes.
  void run(const float* input, uint32_t texels, float* output);
  // Both arrays are read and written by vectors: 64 values beyond the last texel are there, whatever they are.
  void round_inputs(const float* input, uint32_t texels, int8_t* bytes);
  void run_bytes(const int8_t* input, uint32_t texels, float* output);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sandglass::host

#endif
