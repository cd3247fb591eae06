// A baked shadow against ray tracing, over lights that it was not trained on (Fig. 6.8 of the dissertation).
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "models/baking/network.h"
#include "models/baking/training_set.h"
#include "models/files/image.h"

namespace sandglass::host {

// Of one way of evaluating the network, in transparency (0..1).
struct ShadowError {
  double rmse = 0;      // the mean over the lights of each light's
  double rmse_max = 0;  // of the worst light
  double psnr = 0;      // dB, of the mean squared error over all lights
  double ssim = 0;      // mean over the whole textures: windows of 8 x 8 texels, every fourth
  double block = 0;     // largest difference of the means of 16 x 16 texels, over the whole textures
};

struct Validation {
  uint32_t lights = 0, whole = 0;  // of which `whole` with all texels; of the others one texel in 4 x 4
  ShadowError network_float, network_int8, network_adaptive;
  double int8_to_float = 0, adaptive_to_float = 0;  // RMSE between two ways of evaluating the same network
  double evaluated = 0;                             // share of the texels that the adaptive mode asks for
};

// Lights that training has none of: the ring of ring_directions, turned about the vertical.
std::vector<Direction> unseen_directions(double polar_max, uint32_t count);

// `go_on` gets the lights done; false: interrupted, the result is not complete.
bool validate(const LightGeometry& geometry, const ShadowCaster& caster, const FloatNetwork& network,
              std::span<const uint8_t> file, uint32_t lights, ThreadPool& pool,
              const std::function<bool(uint32_t)>& go_on, Validation* result);

// Mean structural similarity of two square textures in 0..1: windows of 8 x 8, every fourth, constants 0.01^2 and
// 0.03^2.
double structural_similarity(const std::vector<float>& a, const std::vector<float>& b, uint32_t size);

// Four lights, one a row: ray tracing, the network as the runtime evaluates it, their difference times 8 around grey.
Picture shadow_picture(const LightGeometry& geometry, const ShadowCaster& caster, std::span<const uint8_t> file,
                       ThreadPool& pool);

}  // namespace sandglass::host
