// Measures a baked shadow against ray tracing, over lights that it was not trained on (Fig. 6.8 of the dissertation).
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "models/baking/network.h"
#include "models/baking/training_set.h"
#include "models/files/image.h"

namespace sandglass::host {

// The error of one way of evaluating the network, in transparency (0..1).
struct ShadowError {
  double rmse = 0;      // each light has its RMSE; this is their mean
  double rmse_max = 0;  // the RMSE of the worst light
  double psnr = 0;      // dB, from the mean squared error over all lights
  double ssim = 0;      // structural_similarity(), the mean over the whole textures
  double block = 0;     // the largest difference of the means of 16 x 16 texels, over the whole textures
};

struct Validation {
  // `whole` of the lights are measured at all texels. The others are measured at one texel of each 4 x 4.
  uint32_t lights = 0, whole = 0;
  ShadowError network_float, network_int8, network_adaptive;
  double int8_to_float = 0, adaptive_to_float = 0;  // RMSE between two ways of evaluating the same network
  double evaluated = 0;                             // the share of the texels that the adaptive mode evaluates
};

// Lights that training does not use: the ring of ring_directions, turned about the vertical.
std::vector<Direction> unseen_directions(double polar_max, uint32_t count);

// Calls `go_on` with the number of lights done. When that returns false, validate() stops and returns false, and leaves
// `result` as it was.
bool validate(const LightGeometry& geometry, const ShadowCaster& caster, const FloatNetwork& network,
              std::span<const uint8_t> file, uint32_t lights, ThreadPool& pool,
              const std::function<bool(uint32_t)>& go_on, Validation* result);

// Mean structural similarity of two square textures with values in 0..1. The windows are 8 x 8 texels, one every 4
// texels along both axes. The constants are 0.01^2 and 0.03^2.
double structural_similarity(const std::vector<float>& a, const std::vector<float>& b, uint32_t size);

// Adds three pictures: truth, what is drawn, and their difference times 8 around grey. Both have side x side texels.
void append_compared(const std::vector<float>& truth, const std::vector<float>& drawn, uint32_t side,
                     const std::array<std::string, 3>& captions, std::vector<Picture>* pictures);

// A picture of four lights, one per row: ray tracing, the network as the runtime evaluates it, and their difference
// times 8 around grey. Further rows of pictures follow.
Picture shadow_picture(const LightGeometry& geometry, const ShadowCaster& caster, std::span<const uint8_t> file,
                       ThreadPool& pool, const std::vector<Picture>& more);

}  // namespace sandglass::host
