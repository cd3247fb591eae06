// The lighting network with XNNPACK's convolutions, in float or in bytes. It reads the same file as the project's own
// kernels and has the same units. What lies between convolutions is here: clamps, averages, and the greatest of nine.
//
// A unit is a slice of rows. All slices of an operator have one size, so that XNNPACK prepares each operator once. A
// window reaches above and below its slice: those rows lie in the slice itself (stem), or in the bottleneck, which has
// a row of zeros at either end. In float a value is a byte that was not rounded or, in a file with float parameters,
// the network's own value. In bytes it is stored as byte - 128.
#include <cstring>
#include <type_traits>

#include "kernels/whole.h"
#include "platform/xnnpack.h"
#include "runtime/light/network/backends.h"

namespace sandglass {
namespace {

// XNNPACK takes multipliers below 256. With this one, as with all greater ones, any sum but 0 gives 255 or 0.
constexpr float k_multiplier_min = 1e-9f, k_multiplier_max = 255.5f;

float value_of(uint8_t byte, float) { return static_cast<float>(byte); }
int8_t value_of(uint8_t byte, int8_t) { return static_cast<int8_t>(byte - 128); }
template <class Value>
Value value_of(uint8_t byte) {
  return value_of(byte, Value{});
}

// The input of a slice. While the network is created: the weights and biases of the largest convolution in float, that
// of the last transition.
constexpr uint64_t k_slice_values = uint64_t{k_light_features} * k_light_features / 2 + k_light_features / 2;

uint32_t block_side(uint32_t image_side, uint32_t block) { return image_side >> (2 + block); }

template <class Value>
struct State {
  XnnpackOperator *stem, *narrow[k_dense_layer_count], *wide[k_dense_layer_count], *transition[k_transition_count];
  Value *maps[2], *stem_rows, *bottleneck, *slice;
  Value low[k_light_features], high[k_light_features];  // of the unit's operator
};

template <class Value>
State<Value>* state_of(const LightNetwork& net) {
  return static_cast<State<Value>*>(net.backend_state);
}

// ---------------------------------------------------------------------------------------------------- between them

// Whether the values are the float network's own.
template <class Value>
bool in_float(const LightNetwork& net) {
  return std::is_same_v<Value, float> && net.asset.float_parameters != nullptr;
}

// Of the operator's inputs.
template <class Value>
void load_clamp(const LightNetwork& net, const LightOperator& op, const uint8_t* low, const uint8_t* high,
                State<Value>* s) {
  if (in_float<Value>(net)) {
    const LightFloats floats = light_floats(net, op);
    memcpy(s->low, floats.low, op.inputs * sizeof(float));
    memcpy(s->high, floats.high, op.inputs * sizeof(float));
    return;
  }
  for (uint32_t c = 0; c < op.inputs; ++c) {
    s->low[c] = value_of<Value>(low[c]);
    s->high[c] = value_of<Value>(high[c]);
  }
}

// In float, NaN becomes the lower end: forged weights may make one.
template <class Value>
Value clamped(Value value, Value low, Value high) {
  const Value above = value > low ? value : low;
  return above < high ? above : high;
}

template <class Value>
void clamp_pixels(const Value* in, uint32_t stride, uint32_t pixels, uint32_t channels, const Value* __restrict low,
                  const Value* __restrict high, Value* __restrict out) {
  for (uint32_t p = 0; p < pixels; ++p, in += stride, out += channels)
    for (uint32_t c = 0; c < channels; ++c) out[c] = clamped(in[c], low[c], high[c]);
}

float average(const float four[4]) { return 0.25f * ((four[0] + four[1]) + (four[2] + four[3])); }
// The mean of four bytes is (sum + 2) / 4. They are stored as byte - 128, so the sum is shifted to be positive first.
int8_t average(const int8_t four[4]) {
  return static_cast<int8_t>((four[0] + four[1] + four[2] + four[3] + 4 * 128 + 2) / 4 - 128);
}

// The means of a row of 2x2 pixels.
template <class Value>
void average_pixels(const Value* in, uint32_t stride, uint32_t pitch, uint32_t pixels, const Value* __restrict low,
                    const Value* __restrict high, Value* __restrict out) {
  for (uint32_t p = 0; p < pixels; ++p, in += 2 * stride, out += stride)
    for (uint32_t c = 0; c < stride; ++c) {
      const Value four[4] = {clamped(in[c], low[c], high[c]), clamped(in[stride + c], low[c], high[c]),
                             clamped(in[pitch + c], low[c], high[c]), clamped(in[pitch + stride + c], low[c], high[c])};
      out[c] = average(four);
    }
}

// Beyond the edge there is no pixel: the middle row or column is taken again.
template <class Value>
void pool_row(const Value* rows, uint32_t width, uint32_t height, uint32_t y, Value* out, uint32_t out_stride) {
  for (uint32_t x = 0; x < width / 2; ++x, out += out_stride) {
    const Value* nine[9];
    for (uint32_t i = 0; i < 9; ++i) {
      const uint32_t v = 2 * y + i / 3, u = 2 * x + i % 3;  // plus 1
      const uint32_t row = v == 0 || v > height ? 2 * y : v - 1, column = u == 0 || u > width ? 2 * x : u - 1;
      nine[i] = rows + (uint64_t{row} * width + column) * k_light_stem;
    }
    for (uint32_t c = 0; c < k_light_stem; ++c) {
      Value largest = nine[0][c];
      for (uint32_t i = 1; i < 9; ++i) largest = nine[i][c] > largest ? nine[i][c] : largest;
      out[c] = largest;
    }
  }
}

// ---------------------------------------------------------------------------------------------------- units

template <class Value>
void run_stem(const LightNetwork& net, State<Value>* s, uint32_t first, uint32_t count) {
  constexpr uint32_t k_pad = k_stem_size / 2;
  Value border[3], *out = s->slice;
  for (uint32_t c = 0; c < 3; ++c) border[c] = value_of<Value>(net.asset.border[c]);
  if (in_float<Value>(net)) memcpy(border, light_floats(net, net.operators[0]).border, sizeof border);
  const auto fill = [&](uint32_t pixels) {
    for (uint32_t x = 0; x < pixels; ++x, out += 3) memcpy(out, border, sizeof border);
  };
  for (uint32_t v = 2 * first; v < 2 * (first + count - 1) + k_stem_size; ++v) {  // of the image, plus k_pad
    if (v < k_pad || v >= net.height + k_pad) {
      fill(net.width + 2 * k_pad);
      continue;
    }
    fill(k_pad);
    const uint8_t* row = net.rgb + uint64_t{3} * (v - k_pad) * net.width;
    for (uint32_t i = 0; i < 3 * net.width; ++i) out[i] = value_of<Value>(row[i]);
    out += 3 * net.width;
    fill(k_pad);
  }
  xnnpack_run(s->stem, s->slice, s->stem_rows + uint64_t{first} * (net.width / 2) * k_light_stem);
}

template <class Value>
void fill_zero(Value* out, uint64_t count) {
  for (uint64_t i = 0; i < count; ++i) out[i] = value_of<Value>(0);
}

template <class Value>
void run_rows(LightNetwork* net, const LightOperator& op, uint32_t first, uint32_t count) {
  State<Value>* s = state_of<Value>(*net);
  const uint32_t width = block_side(net->width, op.block), stride = light_channels_after(op.block);
  Value *map = s->maps[op.block % 2], *next = s->maps[(op.block + 1) % 2];
  const uint64_t line = uint64_t{width} * k_light_bottleneck, place = uint64_t{first} * width;
  switch (op.kind) {
    case k_light_kind_stem:
      return run_stem(*net, s, first, count);
    case k_light_kind_pool:
      for (uint32_t y = first; y < first + count; ++y)
        pool_row(s->stem_rows, net->width / 2, net->height / 2, y, map + uint64_t{y} * width * stride, stride);
      return;
    case k_light_kind_narrow: {
      const AssetConvolution& file = net->asset.narrow[op.layer];
      load_clamp(*net, op, file.low, file.high, s);
      clamp_pixels(map + place * stride, stride, count * width, op.inputs, s->low, s->high, s->slice);
      if (first == 0) fill_zero(s->bottleneck, line);
      if (first + count == op.rows) fill_zero(s->bottleneck + (op.rows + 1) * line, line);
      return xnnpack_run(s->narrow[op.layer], s->slice, s->bottleneck + (first + 1) * line);
    }
    case k_light_kind_wide:
      return xnnpack_run(s->wide[op.layer], s->bottleneck + first * line, map + place * stride + op.inputs);
    default: {
      const AssetConvolution& file = net->asset.transition[op.block];
      load_clamp(*net, op, file.low, file.high, s);
      for (uint32_t i = 0; i < count; ++i)
        average_pixels(map + uint64_t{2} * (first + i) * width * stride, stride, width * stride, width / 2, s->low,
                       s->high, s->slice + uint64_t{i} * (width / 2) * stride);
      const uint32_t to = light_channels_after(op.block + 1);
      return xnnpack_run(s->transition[op.block], s->slice, next + uint64_t{first} * (width / 2) * to);
    }
  }
}

// Averages as the heads take them: in steps of 1/256 byte, or as features of the float network.
template <class Value>
void average_features(LightNetwork* net) {
  State<Value>* s = state_of<Value>(*net);
  const uint32_t pixels = block_side(net->width, 3) * block_side(net->height, 3);
  const Value* map = s->maps[1];
  const LightOperator& heads = net->operators[k_light_operators - 1];
  load_clamp(*net, heads, net->asset.last_low, net->asset.last_high, s);
  float* sums = reinterpret_cast<float*>(s->slice);
  for (uint32_t c = 0; c < k_light_features; ++c) sums[c] = 0;
  const float zero = static_cast<float>(value_of<Value>(0));
  for (uint32_t p = 0; p < pixels; ++p, map += k_light_features)
    for (uint32_t c = 0; c < k_light_features; ++c)
      sums[c] += static_cast<float>(clamped(map[c], s->low[c], s->high[c])) - zero;
  if (in_float<Value>(*net)) {
    const LightFloats floats = light_floats(*net, heads);
    for (uint32_t c = 0; c < k_light_features; ++c)
      net->features[c] = floats.feature_scale[c] * (sums[c] / static_cast<float>(pixels)) + floats.feature_shift[c];
    return;
  }
  for (uint32_t c = 0; c < k_light_features; ++c) {
    const auto steps = to_whole<uint32_t>(256.0f * sums[c] / static_cast<float>(pixels) + 0.5f);
    net->pooled_high[c] = static_cast<uint8_t>(steps >> 8);
    net->pooled_low[c] = static_cast<uint8_t>(steps);
  }
}

// ---------------------------------------------------------------------------------------------------- creation

template <class Value>
void lay_out(uint32_t width, uint32_t height, Layout* layout, LightMemory* memory) {
  constexpr uint64_t k_slack = k_xnnpack_slack_bytes / sizeof(Value);
  uint64_t maps[2] = {};
  for (uint32_t b = 0; b < k_dense_blocks; ++b) {
    const uint64_t values = uint64_t{block_side(width, b)} * block_side(height, b) * light_channels_after(b);
    if (values > maps[b % 2]) maps[b % 2] = values;
  }
  memory->state = layout_region<State<Value>>(layout, "light.operators", 1);
  for (uint32_t i = 0; i < 2; ++i)
    memory->maps[i] = layout_region<Value>(layout, i == 0 ? "light.even" : "light.odd", maps[i] + k_slack);
  memory->stem =
      layout_region<Value>(layout, "light.stem", uint64_t{width / 2} * (height / 2) * k_light_stem + k_slack);
  memory->bottleneck =
      layout_region<Value>(layout, "light.bottleneck",
                           uint64_t{block_side(width, 0)} * (block_side(height, 0) + 2) * k_light_bottleneck + k_slack);
  memory->slice = layout_region<Value>(layout, "light.slice", k_slice_values + k_slack);
}

XnnpackOperator* create(const XnnpackConvolution& shape, const LightNetwork& net, const LightOperator& op,
                        const AssetConvolution& file, float* scratch, const char** reason) {
  if (in_float<float>(net)) {
    constexpr float k_infinity = __builtin_inff();
    const LightFloats floats = light_floats(net, op);
    const bool rectified = op.kind == k_light_kind_stem || op.kind == k_light_kind_narrow;
    return xnnpack_create(shape, floats.weights, floats.bias, rectified ? 0.0f : -k_infinity, k_infinity, reason);
  }
  const uint64_t places = uint64_t{shape.size} * shape.size * shape.inputs;
  float* bias = scratch + shape.outputs * places;
  for (uint32_t o = 0; o < shape.outputs; ++o) {
    for (uint64_t i = 0; i < places; ++i)
      scratch[o * places + i] = static_cast<float>(file.weights[o * places + i]) * file.multiplier[o];
    bias[o] = static_cast<float>(file.bias[o]) * file.multiplier[o];
  }
  return xnnpack_create(shape, scratch, bias, 0.0f, 255.0f, reason);
}

XnnpackOperator* create(const XnnpackConvolution& shape, const LightNetwork&, const LightOperator&,
                        const AssetConvolution& file, int8_t* scratch, const char** reason) {
  float* multipliers = reinterpret_cast<float*>(scratch);
  for (uint32_t o = 0; o < shape.outputs; ++o)
    multipliers[o] = clamped(file.multiplier[o], k_multiplier_min, k_multiplier_max);
  return xnnpack_create(shape, file.weights, file.bias, multipliers, reason);
}

template <class Value>
bool create_operators(LightNetwork* net, State<Value>* s, const char** reason) {
  for (const LightOperator& op : net->operators) {
    const uint32_t width = block_side(net->width, op.block), stride = light_channels_after(op.block),
                   rows = op.unit_rows;
    XnnpackOperator* made = nullptr;
    switch (op.kind) {
      case k_light_kind_stem:
        made = s->stem = create({k_stem_size, 2, 0, 3, k_light_stem, 3, k_light_stem, net->width + k_stem_size - 1,
                                 2 * (rows - 1) + k_stem_size},
                                *net, op, net->asset.stem, s->slice, reason);
        break;
      case k_light_kind_narrow:
        made = s->narrow[op.layer] =
            create({1, 1, 0, op.inputs, k_light_bottleneck, op.inputs, k_light_bottleneck, width, rows}, *net, op,
                   net->asset.narrow[op.layer], s->slice, reason);
        break;
      case k_light_kind_wide:
        made = s->wide[op.layer] =
            create({3, 1, 1, k_light_bottleneck, k_light_growth, k_light_bottleneck, stride, width, rows + 2}, *net, op,
                   net->asset.wide[op.layer], s->slice, reason);
        break;
      case k_light_kind_transition:
        made = s->transition[op.block] =
            create({1, 1, 0, op.inputs, op.inputs / 2, op.inputs, light_channels_after(op.block + 1), width / 2, rows},
                   *net, op, net->asset.transition[op.block], s->slice, reason);
        break;
      default:
        continue;  // the pool and the heads have none
    }
    if (made == nullptr) return false;
  }
  return true;
}

template <class Value>
void release(LightNetwork* net) {
  State<Value>* s = state_of<Value>(*net);
  const auto give_up = [](XnnpackOperator*& op) {
    xnnpack_release(op);
    op = nullptr;
  };
  give_up(s->stem);
  for (XnnpackOperator*& op : s->narrow) give_up(op);
  for (XnnpackOperator*& op : s->wide) give_up(op);
  for (XnnpackOperator*& op : s->transition) give_up(op);
}

template <class Value>
bool create(LightNetwork* net, const LightMemory& memory, const char** reason) {
  if (!xnnpack_begin(reason)) return false;
  auto* s = static_cast<State<Value>*>(memory.state);
  memset(static_cast<void*>(s), 0, sizeof *s);
  net->backend_state = s;
  for (uint32_t i = 0; i < 2; ++i) s->maps[i] = static_cast<Value*>(memory.maps[i]);
  s->stem_rows = static_cast<Value*>(memory.stem);
  s->bottleneck = static_cast<Value*>(memory.bottleneck);
  s->slice = static_cast<Value*>(memory.slice);
  net->even = reinterpret_cast<uint8_t*>(s->maps[0]);
  if (create_operators(net, s, reason)) return true;
  release<Value>(net);
  return false;
}

}  // namespace

constexpr LightBackend k_light_xnnpack_f32 = {
    true, lay_out<float>, create<float>, run_rows<float>, average_features<float>, release<float>, xnnpack_region_used};
constexpr LightBackend k_light_xnnpack_int8 = {
    false,           lay_out<int8_t>,    create<int8_t>, run_rows<int8_t>, average_features<int8_t>,
    release<int8_t>, xnnpack_region_used};

}  // namespace sandglass
