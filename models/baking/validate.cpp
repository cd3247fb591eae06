// See validate.h.
#include "models/baking/validate.h"

#include <algorithm>
#include <cmath>

#include "models/baking/shadow_runner.h"
#include "models/work/random.h"

namespace sandglass::host {

namespace {

constexpr uint32_t k_size = k_native_size, k_stride = 4, k_whole = 16, k_block = 16;
constexpr uint32_t k_task = 5;                          // this many lights share one runner
constexpr uint64_t k_first_stream = uint64_t{1} << 32;  // no training light has these random numbers

// Two rings of different sizes can have a direction in common. The azimuths of an unturned ring are whole golden
// angles. So a ring that is turned by half a golden angle has no direction in common with it.
constexpr double k_turn = 0.5 * 2.399963229728653;

// The errors of one light.
struct LightError {
  double against_truth[3] = {};  // float, int8, adaptive: mean squared error
  double int8_to_float = 0, adaptive_to_float = 0, evaluated = 0;
  double ssim[3] = {}, block[3] = {};
};

double largest_block(const std::vector<float>& a, const std::vector<float>& b) {
  double largest = 0;
  for (uint32_t y = 0; y < k_size; y += k_block)
    for (uint32_t x = 0; x < k_size; x += k_block) {
      double sum = 0;
      for (uint32_t v = y; v < y + k_block; ++v)
        for (uint32_t u = x; u < x + k_block; ++u) sum += static_cast<double>(a[v * k_size + u] - b[v * k_size + u]);
      largest = std::max(largest, std::fabs(sum) / (k_block * k_block));
    }
  return largest;
}

std::vector<float> transparency(const uint8_t* coverage) {
  std::vector<float> values(k_size * k_size);
  for (size_t i = 0; i < values.size(); ++i) values[i] = 1.0f - static_cast<float>(coverage[i]) / 255.0f;
  return values;
}

struct Validator {
  const LightGeometry& geometry;
  const ShadowCaster& caster;
  const FloatNetwork& network;

  LightError judge(const Direction& light, uint32_t number, bool whole, ShadowRunner* full,
                   ShadowRunner* adaptive) const {
    const uint32_t stride = whole ? 1 : k_stride, side = k_size / stride;
    std::vector<uint32_t> uv;
    for (uint32_t v = 0; v < side; ++v)
      for (uint32_t u = 0; u < side; ++u) {
        const uint64_t pick = random_mix((uint64_t{number} << 20) + v * side + u) % (stride * stride);
        uv.push_back(u * stride + static_cast<uint32_t>(pick % stride));
        uv.push_back(v * stride + static_cast<uint32_t>(pick / stride));
      }
    const uint32_t count = side * side;
    std::vector<float> truth(count), results[3];
    caster.texels(geometry.rectangle(light), light, k_first_stream + number, k_size, k_size, uv.data(), count,
                  truth.data());
    results[0].resize(count);
    evaluate_texels(network, light, k_size, uv.data(), count, results[0].data());
    const sandglass_texture refined = adaptive->texture(light);
    const std::vector<float> textures[2] = {transparency(full->texture(light).bytes), transparency(refined.bytes)};
    for (uint32_t method = 0; method < 2; ++method)
      for (uint32_t i = 0; i < count; ++i)
        results[1 + method].push_back(textures[method][size_t{uv[2 * i + 1]} * k_size + uv[2 * i]]);

    LightError error;
    const auto mean_square = [&](const std::vector<float>& a, const std::vector<float>& b) {
      double sum = 0;
      for (uint32_t i = 0; i < count; ++i) sum += std::pow(static_cast<double>(a[i] - b[i]), 2);
      return sum / count;
    };
    for (uint32_t method = 0; method < 3; ++method) {
      error.against_truth[method] = mean_square(results[method], truth);
      if (!whole) continue;
      error.ssim[method] = structural_similarity(results[method], truth, k_size);
      error.block[method] = largest_block(results[method], truth);
    }
    error.int8_to_float = mean_square(results[1], results[0]);
    error.adaptive_to_float = mean_square(results[2], results[0]);
    error.evaluated = adaptive->evaluated() / static_cast<double>(k_size * k_size);
    return error;
  }
};

}  // namespace

double structural_similarity(const std::vector<float>& a, const std::vector<float>& b, uint32_t size) {
  constexpr uint32_t k_window = 8, k_step = 4;
  constexpr double k_mean = 1e-4, k_spread = 9e-4, k_count = k_window * k_window;
  double sum = 0;
  uint64_t windows = 0;
  for (uint32_t y = 0; y + k_window <= size; y += k_step)
    for (uint32_t x = 0; x + k_window <= size; x += k_step, ++windows) {
      double sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
      for (uint32_t v = y; v < y + k_window; ++v)
        for (uint32_t u = x; u < x + k_window; ++u) {
          const double p = static_cast<double>(a[size_t{v} * size + u]),
                       q = static_cast<double>(b[size_t{v} * size + u]);
          sa += p;
          sb += q;
          saa += p * p;
          sbb += q * q;
          sab += p * q;
        }
      const double ma = sa / k_count, mb = sb / k_count;
      const double va = saa / k_count - ma * ma, vb = sbb / k_count - mb * mb, covariance = sab / k_count - ma * mb;
      sum +=
          (2 * ma * mb + k_mean) * (2 * covariance + k_spread) / ((ma * ma + mb * mb + k_mean) * (va + vb + k_spread));
    }
  return sum / static_cast<double>(windows);
}

std::vector<Direction> unseen_directions(double polar_max, uint32_t count) {
  std::vector<Direction> directions = ring_directions(polar_max, count);
  const double c = std::cos(k_turn), s = std::sin(k_turn);
  for (Direction& d : directions) d = {c * d[0] - s * d[2], d[1], s * d[0] + c * d[2]};
  return directions;
}

bool validate(const LightGeometry& geometry, const ShadowCaster& caster, const FloatNetwork& network,
              std::span<const uint8_t> file, uint32_t lights, ThreadPool& pool,
              const std::function<bool(uint32_t)>& go_on, Validation* result) {
  const std::vector<Direction> directions = unseen_directions(geometry.polar_max, lights);
  const Validator validator = {geometry, caster, network};
  const uint32_t every = std::max(1u, lights / k_whole);
  std::vector<LightError> errors(lights);
  for (uint32_t begin = 0; begin < lights;) {
    const uint32_t end = std::min(lights, begin + 8 * k_task);
    pool.run((end - begin + k_task - 1) / k_task, [&](uint32_t task) {
      ShadowRunner full(file, "baked", SANDGLASS_ISA_AUTOMATIC, SANDGLASS_SHADOW_FULL);
      ShadowRunner adaptive(file, "baked", SANDGLASS_ISA_AUTOMATIC, SANDGLASS_SHADOW_ADAPTIVE);
      for (uint32_t i = begin + task * k_task; i < std::min(end, begin + (task + 1) * k_task); ++i)
        errors[i] = validator.judge(directions[i], i, i % every == 0, &full, &adaptive);
    });
    begin = end;
    if (!go_on(begin) && begin < lights) return false;
  }
  *result = {};
  result->lights = lights;
  ShadowError* methods[3] = {&result->network_float, &result->network_int8, &result->network_adaptive};
  for (uint32_t method = 0; method < 3; ++method) {
    double square = 0;
    for (uint32_t i = 0; i < lights; ++i) {
      const double rmse = std::sqrt(errors[i].against_truth[method]);
      square += errors[i].against_truth[method];
      methods[method]->rmse += rmse / lights;
      methods[method]->rmse_max = std::max(methods[method]->rmse_max, rmse);
      methods[method]->ssim += errors[i].ssim[method];
      methods[method]->block = std::max(methods[method]->block, errors[i].block[method]);
    }
    methods[method]->psnr = -10 * std::log10(std::max(square / lights, 1e-12));
  }
  for (uint32_t i = 0; i < lights; ++i) {
    result->int8_to_float += std::sqrt(errors[i].int8_to_float) / lights;
    result->adaptive_to_float += std::sqrt(errors[i].adaptive_to_float) / lights;
    result->evaluated += errors[i].evaluated / lights;
    result->whole += i % every == 0 ? 1 : 0;
  }
  for (ShadowError* method : methods) method->ssim /= result->whole;
  return true;
}

void append_compared(const std::vector<float>& truth, const std::vector<float>& drawn, uint32_t side,
                     const std::array<std::string, 3>& captions, std::vector<Picture>* pictures) {
  constexpr int k_caption = 14, k_pixels = static_cast<int>(k_size);
  for (size_t column = 0; column < 3; ++column) {
    Picture picture(k_pixels, k_pixels + k_caption, {255, 255, 255});
    for (int y = 0; y < k_pixels; ++y)
      for (int x = 0; x < k_pixels; ++x) {
        const size_t texel = static_cast<size_t>(y) * side / k_size * side + static_cast<size_t>(x) * side / k_size;
        const double t = static_cast<double>(truth[texel]), d = static_cast<double>(drawn[texel]);
        const double grey = column == 0 ? t : column == 1 ? d : 0.5 + 8 * (d - t);
        std::fill_n(picture.at(x, y + k_caption), 3, static_cast<uint8_t>(255 * std::clamp(grey, 0.0, 1.0) + 0.5));
      }
    draw_text(&picture, 2, 3, 1, captions[column], {0, 0, 0});
    pictures->push_back(std::move(picture));
  }
}

Picture shadow_picture(const LightGeometry& geometry, const ShadowCaster& caster, std::span<const uint8_t> file,
                       ThreadPool& pool, const std::vector<Picture>& more) {
  constexpr double k_share[4] = {0.05, 0.45, 0.75, 0.98}, k_azimuth[4] = {0.0, 0.8, 2.6, 4.4};
  ShadowRunner runner(file, "baked", SANDGLASS_ISA_AUTOMATIC, SANDGLASS_SHADOW_ADAPTIVE);
  std::vector<Picture> cells;
  for (uint32_t row = 0; row < 4; ++row) {
    const double polar = k_share[row] * geometry.polar_max;
    const Direction light = {std::sin(polar) * std::cos(k_azimuth[row]), std::cos(polar),
                             std::sin(polar) * std::sin(k_azimuth[row])};
    const std::vector<float> truth =
        caster.texture(geometry.rectangle(light), light, k_first_stream + row, k_size, pool);
    const std::vector<float> network = transparency(runner.texture(light).bytes);
    double square = 0;
    for (size_t i = 0; i < truth.size(); ++i) square += std::pow(static_cast<double>(truth[i] - network[i]), 2);
    char traced[64], difference[64];
    std::snprintf(traced, sizeof traced, "ray traced, light %.0f deg from zenith", polar * 180 / k_pi);
    std::snprintf(difference, sizeof difference, "difference x 8, RMSE %.4f",
                  std::sqrt(square / static_cast<double>(truth.size())));
    append_compared(truth, network, k_size, {traced, "network, int8 adaptive", difference}, &cells);
  }
  cells.insert(cells.end(), more.begin(), more.end());
  return picture_grid(cells, 3, 6);
}

}  // namespace sandglass::host
