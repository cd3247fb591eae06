// Runs the lighting network's file naively, as asset/light.fbs describes it: one sum after another, in integers, or in
// double without any rounding. Shares no code with the runtime.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "models/lighting/light_file.h"

namespace sandglass::tests {

// Value is uint8_t or double.
template <class Value>
struct Map {
  int width, height, channels;
  std::vector<Value> values;
  Map(int w, int h, int c)
      : width(w),
        height(h),
        channels(c),
        values(static_cast<size_t>(w) * static_cast<size_t>(h) * static_cast<size_t>(c)) {}
  Value& at(int x, int y, int c) {
    return values[(static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)) *
                      static_cast<size_t>(channels) +
                  static_cast<size_t>(c)];
  }
  Value at(int x, int y, int c) const { return const_cast<Map*>(this)->at(x, y, c); }
};
using ByteMap = Map<uint8_t>;

inline double requantised(double sum, float multiplier) {
  return std::clamp(sum * static_cast<double>(multiplier), 0.0, 255.0);
}
// The conversion and the product are rounded once each, then the result is rounded to nearest even.
inline uint8_t requantised(int64_t sum, float multiplier) {
  const float scaled = static_cast<float>(sum) * multiplier;
  return static_cast<uint8_t>(std::nearbyint(std::fmin(std::fmax(static_cast<double>(scaled), 0.0), 255.0)));
}

// Windows of size x size, `step` pixels apart. Beyond the edge channel c has the value border[c % 3].
template <class Value>
Map<Value> convolved(const host::ByteConvolution& c, const Map<Value>& in, int size, int step, const uint8_t* border) {
  using Sum = std::conditional_t<std::is_same_v<Value, double>, double, int64_t>;
  const int outputs = static_cast<int>(c.bias.size()), pad = size / 2;
  Map<Value> out(in.width / step, in.height / step, outputs);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      for (int o = 0; o < outputs; ++o) {
        Sum sum = c.bias[static_cast<size_t>(o)];
        const int8_t* weights = c.weights.data() + static_cast<size_t>(o * size * size * in.channels);
        for (int row = 0; row < size; ++row)
          for (int column = 0; column < size; ++column) {
            const int u = x * step + column - pad, v = y * step + row - pad;
            const bool inside = u >= 0 && v >= 0 && u < in.width && v < in.height;
            for (int i = 0; i < in.channels; ++i, ++weights)
              sum += static_cast<Sum>(*weights) *
                     (inside ? in.at(u, v, i) : static_cast<Value>(border == nullptr ? 0 : border[i % 3]));
          }
        out.at(x, y, o) = requantised(sum, c.multiplier[static_cast<size_t>(o)]);
      }
  return out;
}

template <class Value>
Map<Value> clamped(const Map<Value>& in, const std::vector<uint8_t>& low, const std::vector<uint8_t>& high) {
  Map<Value> out = in;
  for (size_t i = 0; i < out.values.size(); ++i) {
    const size_t c = i % low.size();
    out.values[i] = std::clamp(out.values[i], static_cast<Value>(low[c]), static_cast<Value>(high[c]));
  }
  return out;
}

template <class Value>
Map<Value> appended(const Map<Value>& a, const Map<Value>& b) {
  Map<Value> out(a.width, a.height, a.channels + b.channels);
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x)
      for (int c = 0; c < out.channels; ++c)
        out.at(x, y, c) = c < a.channels ? a.at(x, y, c) : b.at(x, y, c - a.channels);
  return out;
}

template <class Value>
Map<Value> averaged(const Map<Value>& in) {
  Map<Value> out(in.width / 2, in.height / 2, in.channels);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      for (int c = 0; c < in.channels; ++c) {
        const auto sum = in.at(2 * x, 2 * y, c) + in.at(2 * x + 1, 2 * y, c) + in.at(2 * x, 2 * y + 1, c) +
                         in.at(2 * x + 1, 2 * y + 1, c);
        if constexpr (std::is_same_v<Value, double>) out.at(x, y, c) = sum / 4;
        else out.at(x, y, c) = static_cast<Value>((sum + 2) / 4);
      }
  return out;
}

template <class Value>
Map<Value> pooled(const Map<Value>& in) {
  Map<Value> out(in.width / 2, in.height / 2, in.channels);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      for (int v = 2 * y - 1; v <= 2 * y + 1; ++v)
        for (int u = 2 * x - 1; u <= 2 * x + 1; ++u)
          for (int c = 0; c < in.channels; ++c)
            if (u >= 0 && v >= 0 && u < in.width && v < in.height)
              out.at(x, y, c) = std::max(out.at(x, y, c), in.at(u, v, c));
  return out;
}

// The 1024 channels, clamped, of which the average is taken.
template <class Value>
Map<Value> last_map(const host::LightFile& file, const std::vector<uint8_t>& rgb, int width, int height) {
  constexpr int k_layers[4] = {6, 12, 24, 16};
  Map<Value> image(width, height, 3);
  image.values.assign(rgb.begin(), rgb.end());
  Map<Value> map = pooled(convolved(file.stem, image, 7, 2, file.border));
  size_t layer = 0;
  for (size_t b = 0; b < 4; ++b) {
    for (int i = 0; i < k_layers[b]; ++i, ++layer) {
      const host::ByteConvolution& narrow = file.narrow[layer];
      const Map<Value> bottleneck = convolved(narrow, clamped(map, narrow.low, narrow.high), 1, 1, nullptr);
      map = appended(map, convolved(file.wide[layer], bottleneck, 3, 1, nullptr));
    }
    if (b == 3) break;
    const host::ByteConvolution& transition = file.transition[b];
    map = convolved(transition, averaged(clamped(map, transition.low, transition.high)), 1, 1, nullptr);
  }
  return clamped(map, file.last_low, file.last_high);
}

// The 1024 averages in steps of 1/256 byte.
inline std::vector<uint32_t> byte_features(const host::LightFile& file, const std::vector<uint8_t>& rgb, int width,
                                           int height) {
  const ByteMap map = last_map<uint8_t>(file, rgb, width, height);
  std::vector<uint32_t> averages;
  const int pixels = map.width * map.height;
  for (int c = 0; c < map.channels; ++c) {
    int sum = 0;
    for (int y = 0; y < map.height; ++y)
      for (int x = 0; x < map.width; ++x) sum += map.at(x, y, c);
    averages.push_back(static_cast<uint32_t>((256 * sum + pixels / 2) / pixels));
  }
  return averages;
}

}  // namespace sandglass::tests
