#include "models/lighting/xnnpack_peer.h"

#ifdef SANDGLASS_HAVE_XNNPACK

#include <xnnpack.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>

#include "models/host/failure.h"

namespace sandglass::host {

namespace {

constexpr int8_t k_zero = -128;  // a byte q is the int8 q - 128
// XNNPACK takes multipliers below 256: of 256 and more, as of this one, any sum but 0 gives 255 or 0.
constexpr float k_least_scale = 1e-9f, k_greatest_scale = 255.5f;

void check(xnn_status status) {
  if (status != xnn_status_success) throw Failure("XNNPACK refused an operator of the lighting network");
}

double seconds_now() {  // of this thread
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// The memory that XNNPACK asks for, counted.
uint64_t g_allocated = 0;
void* allocate(void*, size_t size) { return g_allocated += size, std::malloc(size); }
void* reallocate(void*, void* p, size_t size) { return g_allocated += size, std::realloc(p, size); }
void deallocate(void*, void* p) { std::free(p); }
void* allocate_aligned(void*, size_t alignment, size_t size) {
  g_allocated += size;
  return std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}
constexpr xnn_allocator k_counting = {nullptr, allocate, reallocate, deallocate, allocate_aligned, deallocate};

// One convolution in the words of both kinds of operator.
struct Shape {
  uint32_t size, step, pad, groups, inputs, outputs;  // of a group
  uint32_t in_stride, out_stride;
};

}  // namespace

struct XnnpackLightPeer::State {
  bool bytes;
  uint32_t width, height;
  const LightAsset& asset;
  std::vector<xnn_operator_t> operators;
  std::vector<Time> times;
  std::vector<float> floats[4];  // image, the two blocks, what lies between
  std::vector<int8_t> int8s[4];
  uint64_t allocated = 0;

  State(const LightAsset& a, bool b, uint32_t w, uint32_t h) : bytes(b), width(w), height(h), asset(a) {}

  // `values`: channel `offset` of buffer `from`, likewise `to`.
  void* at(size_t buffer, uint32_t offset) {
    return bytes ? static_cast<void*>(int8s[buffer].data() + offset) : floats[buffer].data() + offset;
  }

  void convolution(const char* name, const Shape& s, const std::vector<int8_t>& weights,
                   const std::vector<int32_t>& bias, const std::vector<float>& multiplier, int8_t in_zero,
                   uint32_t in_width, uint32_t in_height, void* in, void* out) {
    xnn_operator_t op = nullptr;
    if (bytes) {
      check(xnn_create_convolution2d_nhwc_qc8(s.pad, s.pad, s.pad, s.pad, s.size, s.size, s.step, s.step, 1, 1,
                                              s.groups, s.inputs, s.outputs, s.in_stride, s.out_stride, in_zero, 1.0f,
                                              multiplier.data(), weights.data(), bias.data(), k_zero, 1.0f, -128, 127,
                                              0, &op));
      check(xnn_setup_convolution2d_nhwc_qc8(op, 1, in_height, in_width, static_cast<const int8_t*>(in),
                                             static_cast<int8_t*>(out), nullptr));
    } else {
      std::vector<float> kernel, shift;
      const size_t places = weights.size() / bias.size();
      for (size_t i = 0; i < weights.size(); ++i)
        kernel.push_back(static_cast<float>(weights[i]) * multiplier[i / places]);
      for (size_t i = 0; i < bias.size(); ++i) shift.push_back(static_cast<float>(bias[i]) * multiplier[i]);
      check(xnn_create_convolution2d_nhwc_f32(s.pad, s.pad, s.pad, s.pad, s.size, s.size, s.step, s.step, 1, 1,
                                              s.groups, s.inputs, s.outputs, s.in_stride, s.out_stride, kernel.data(),
                                              shift.data(), 0.0f, 255.0f, 0, &op));
      check(xnn_setup_convolution2d_nhwc_f32(op, 1, in_height, in_width, static_cast<const float*>(in),
                                             static_cast<float*>(out), nullptr));
    }
    operators.push_back(op), times.push_back({name, 0});
  }

  // byte - low, or high - byte, and zero where that is negative: one of a clamp's ends is that of all bytes.
  void rectifier(const uint8_t* low, const uint8_t* high, uint32_t channels, uint32_t stride, uint32_t w, uint32_t h,
                 void* in, void* out) {
    std::vector<int8_t> weights;
    std::vector<int32_t> bias;
    for (uint32_t c = 0; c < channels; ++c) {
      weights.push_back(high[c] < 255 ? int8_t{-1} : int8_t{1});
      bias.push_back(high[c] < 255 ? high[c] : -low[c]);
    }
    convolution("BN-ReLU", {1, 1, 0, channels, 1, 1, stride, channels}, weights, bias,
                std::vector<float>(channels, 1.0f), k_zero, w, h, in, out);
  }

  // The 1x1 behind it, whose weights and bias undo the sign and the shift.
  void narrow(const char* name, const AssetConvolution& c, uint32_t channels, uint32_t outputs, uint32_t stride,
              uint32_t w, uint32_t h, void* in, void* out) {
    std::vector<int8_t> weights(c.weights, c.weights + size_t{channels} * outputs);
    std::vector<int32_t> bias(c.bias, c.bias + outputs);
    for (size_t i = 0; i < weights.size(); ++i) {
      const size_t input = i % channels;
      const bool turned = c.high[input] < 255;
      bias[i / channels] += weights[i] * (turned ? c.high[input] : c.low[input]);
      if (turned) weights[i] = static_cast<int8_t>(-weights[i]);
    }
    convolution(name, {1, 1, 0, 1, channels, outputs, channels, stride}, weights, bias, scales(c, outputs), k_zero, w,
                h, in, out);
  }

  std::vector<float> scales(const AssetConvolution& c, uint32_t outputs) const {
    std::vector<float> multiplier(c.multiplier, c.multiplier + outputs);
    for (float& m : multiplier) m = std::clamp(m, k_least_scale, bytes ? k_greatest_scale : m + k_least_scale);
    return multiplier;
  }

  void build();
  void pool(uint32_t w, uint32_t h, void* in, void* out);
  void average(uint32_t channels, uint32_t w, uint32_t h, void* in, void* out);
};

void XnnpackLightPeer::State::pool(uint32_t w, uint32_t h, void* in, void* out) {
  xnn_operator_t op = nullptr;
  const size_t stride = light_channels_after(0);
  if (bytes) {
    check(xnn_create_max_pooling2d_nhwc_s8(1, 1, 1, 1, 3, 3, 2, 2, 1, 1, k_light_stem, k_light_stem, stride, -128, 127,
                                           0, &op));
    check(xnn_setup_max_pooling2d_nhwc_s8(op, 1, h, w, static_cast<const int8_t*>(in), static_cast<int8_t*>(out),
                                          nullptr));
  } else {
    check(xnn_create_max_pooling2d_nhwc_f32(1, 1, 1, 1, 3, 3, 2, 2, 1, 1, k_light_stem, k_light_stem, stride, 0.0f,
                                            255.0f, 0, &op));
    check(xnn_setup_max_pooling2d_nhwc_f32(op, 1, h, w, static_cast<const float*>(in), static_cast<float*>(out),
                                           nullptr));
  }
  operators.push_back(op), times.push_back({"pool", 0});
}

void XnnpackLightPeer::State::average(uint32_t channels, uint32_t w, uint32_t h, void* in, void* out) {
  if (bytes) {  // no pooling in int8: a convolution of each channel by itself
    convolution("transitions", {2, 2, 0, channels, 1, 1, channels, channels},
                std::vector<int8_t>(4 * size_t{channels}, 1), std::vector<int32_t>(channels, 0),
                std::vector<float>(channels, 0.25f), k_zero, w, h, in, out);
    return;
  }
  xnn_operator_t op = nullptr;
  check(xnn_create_average_pooling2d_nhwc_f32(0, 0, 0, 0, 2, 2, 2, 2, channels, channels, channels, 0.0f, 255.0f, 0,
                                              &op));
  check(xnn_setup_average_pooling2d_nhwc_f32(op, 1, h, w, static_cast<const float*>(in), static_cast<float*>(out),
                                             nullptr));
  operators.push_back(op), times.push_back({"transitions", 0});
}

void XnnpackLightPeer::State::build() {
  enum : size_t { k_image, k_even, k_odd, k_between };
  uint64_t most[4] = {uint64_t{3} * width * height, 0, 0, uint64_t{width / 2} * (height / 2) * k_light_stem};
  for (uint32_t b = 0; b < k_dense_blocks; ++b) {
    const uint64_t pixels = uint64_t{width >> (2 + b)} * (height >> (2 + b));
    uint64_t& block = most[b % 2 == 0 ? k_even : k_odd];
    block = std::max(block, pixels * light_channels_after(b));
    // What a rectifier leaves, and the bottleneck or the averages behind it.
    most[k_between] = std::max(most[k_between], pixels * (light_channels_after(b) +
                                                          std::max(light_channels_after(b) / 4, k_light_bottleneck)));
  }
  for (size_t i = 0; i < 4; ++i) {
    if (bytes) int8s[i].resize(most[i] + XNN_EXTRA_BYTES);
    else floats[i].resize(most[i] + XNN_EXTRA_BYTES / sizeof(float));
  }
  // The border counts as zero: in float it is taken off the image, in bytes there is one zero point for three channels.
  std::vector<int32_t> bias(asset.stem.bias, asset.stem.bias + k_light_stem);
  const size_t places = 3 * k_stem_size * k_stem_size;
  const auto zero = static_cast<int8_t>(asset.border[1] - 128);
  for (size_t i = 0; i < places * k_light_stem; ++i)
    bias[i / places] += asset.stem.weights[i] * (bytes ? asset.border[1] : asset.border[i % 3]);
  const std::vector<int8_t> weights(asset.stem.weights, asset.stem.weights + places * k_light_stem);
  convolution("stem", {k_stem_size, 2, 3, 1, 3, k_light_stem, 3, k_light_stem}, weights, bias,
              scales(asset.stem, k_light_stem), zero, width, height, at(k_image, 0), at(k_between, 0));
  pool(width / 2, height / 2, at(k_between, 0), at(k_even, 0));
  uint32_t layer = 0;
  for (uint32_t b = 0; b < k_dense_blocks; ++b) {
    const size_t block = b % 2 == 0 ? k_even : k_odd, next = b % 2 == 0 ? k_odd : k_even;
    const uint32_t w = width >> (2 + b), h = height >> (2 + b), stride = light_channels_after(b);
    uint32_t channels = light_channels_before(b);
    void *rectified = at(k_between, 0), *behind = at(k_between, w * h * stride);
    for (uint32_t i = 0; i < k_block_layers[b]; ++i, ++layer, channels += k_light_growth) {
      const AssetConvolution &narrow_file = asset.narrow[layer], &wide_file = asset.wide[layer];
      rectifier(narrow_file.low, narrow_file.high, channels, stride, w, h, at(block, 0), rectified);
      narrow("1x1", narrow_file, channels, k_light_bottleneck, k_light_bottleneck, w, h, rectified, behind);
      convolution("3x3", {3, 1, 1, 1, k_light_bottleneck, k_light_growth, k_light_bottleneck, stride},
                  {wide_file.weights, wide_file.weights + size_t{9} * k_light_bottleneck * k_light_growth},
                  {wide_file.bias, wide_file.bias + k_light_growth}, scales(wide_file, k_light_growth), k_zero, w, h,
                  behind, at(block, channels));
    }
    if (b == k_transition_count) break;
    const AssetConvolution& file = asset.transition[b];
    rectifier(file.low, file.high, channels, stride, w, h, at(block, 0), rectified);
    average(channels, w, h, rectified, behind);
    narrow("transitions", file, channels, channels / 2, light_channels_after(b + 1), w / 2, h / 2, behind, at(next, 0));
  }
}

XnnpackLightPeer::XnnpackLightPeer(const LightAsset& asset, bool bytes, uint32_t width, uint32_t height)
    : state_(std::make_unique<State>(asset, bytes, width, height)) {
  check(xnn_initialize(&k_counting));
  const uint64_t before = g_allocated;
  state_->build();
  state_->allocated = g_allocated - before;
}

XnnpackLightPeer::~XnnpackLightPeer() {
  for (const xnn_operator_t op : state_->operators) xnn_delete_operator(op);
}

void XnnpackLightPeer::run(std::span<const uint8_t> rgb) {
  State& s = *state_;
  for (size_t i = 0; i < rgb.size(); ++i) {
    if (s.bytes) s.int8s[0][i] = static_cast<int8_t>(rgb[i] - 128);
    else s.floats[0][i] = static_cast<float>(rgb[i] - s.asset.border[i % 3]);
  }
  for (size_t i = 0; i < s.operators.size(); ++i) {
    const double from = seconds_now();
    check(xnn_run_operator(s.operators[i], nullptr));
    s.times[i].seconds = seconds_now() - from;
  }
}

std::vector<float> XnnpackLightPeer::features() const {
  const State& s = *state_;
  std::vector<float> features(k_light_features, 0.0f);
  const size_t pixels = size_t{s.width / 32} * (s.height / 32);
  for (size_t c = 0; c < k_light_features; ++c) {
    float sum = 0;
    for (size_t p = 0; p < pixels; ++p) {
      const size_t i = p * k_light_features + c;
      const float byte = s.bytes ? static_cast<float>(s.int8s[2][i]) + 128 : s.floats[2][i];
      sum += std::clamp(byte, static_cast<float>(s.asset.last_low[c]), static_cast<float>(s.asset.last_high[c]));
    }
    features[c] = s.asset.feature_scale[c] * (sum / static_cast<float>(pixels)) + s.asset.feature_shift[c];
  }
  return features;
}

uint64_t XnnpackLightPeer::memory_bytes() const {
  uint64_t bytes = state_->allocated;
  for (size_t i = 0; i < 4; ++i) bytes += state_->int8s[i].size() + 4 * state_->floats[i].size();
  return bytes;
}

const std::vector<XnnpackLightPeer::Time>& XnnpackLightPeer::times() const { return state_->times; }

}  // namespace sandglass::host

#endif
