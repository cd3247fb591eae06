// Transfer functions: sRGB (IEC 61966-2-1), HLG and PQ (ITU-R BT.2100), linear, and a curve of the app's.
#include "runtime/light/camera/transfer.h"

#include "runtime/math/math.h"

namespace sandglass {

namespace {

// (c + 0.055) / 1.055 to the power 2.4, by Newton's fifth root: x^2.4 = x^2 (x^2)^(1/5).
constexpr double srgb(double value) {
  if (value <= 0.04045) return value / 12.92;
  const double x = (value + 0.055) / 1.055, square = x * x;
  double root = 1.0;
  for (int step = 0; step < 60; ++step) root = root - (root - square / (root * root * root * root)) * 0.2;
  return square * root;
}

constexpr double linear(double value) { return value; }

constexpr double hlg_scene(double value) {
  constexpr double k_a = 0.17883277, k_b = 0.28466892, k_c = 0.55991073;
  return value <= 0.5 ? value * value / 3 : (exponential((value - k_c) / k_a) + k_b) / 12;
}

// Reference white: 75 % of HLG, 203 of the 10,000 cd/m^2 of PQ (ITU-R BT.2408).
constexpr double hlg(double value) { return hlg_scene(value) / hlg_scene(0.75); }

constexpr double power(double x, double exponent) { return x > 0 ? exponential(exponent * logarithm(x)) : 0.0; }

constexpr double pq(double value) {
  constexpr double k_m1 = 0.1593017578125, k_m2 = 78.84375, k_c1 = 0.8359375, k_c2 = 18.8515625, k_c3 = 18.6875;
  const double root = power(value, 1 / k_m2), above = root > k_c1 ? root - k_c1 : 0.0;
  return power(above / (k_c2 - k_c3 * root), 1 / k_m1) * (10000.0 / 203.0);
}

struct LightTable {
  float light[256];
};
constexpr LightTable table_of(double (*light)(double)) {
  LightTable table = {};
  for (int i = 0; i < 256; ++i) table.light[i] = static_cast<float>(light(i / 255.0));
  return table;
}
// By sandglass_transfer.
constexpr LightTable k_tables[] = {table_of(srgb), table_of(linear), table_of(hlg), table_of(pq)};

// The light of a value on the straight lines between the points (light, value), which never fall.
float curve_light(const CameraImage& image, float value) {
  const float *at = image.curve, *last = at + 2 * (image.curve_points - 1);
  if (!(value > at[1])) return at[0];
  for (; at != last; at += 2)
    if (value <= at[3]) return at[0] + (at[2] - at[0]) * ((value - at[1]) / (at[3] - at[1]));
  return last[0];
}

}  // namespace

double srgb_light(uint8_t value) { return static_cast<double>(k_tables[SANDGLASS_TRANSFER_SRGB].light[value]); }

const float* camera_light_table(const CameraImage& image) {
  return image.transfer == SANDGLASS_TRANSFER_CURVE ? nullptr : k_tables[image.transfer].light;
}

float camera_light(const CameraImage& image, const float* table, uint8_t value) {
  return table != nullptr ? table[value] : curve_light(image, static_cast<float>(value) / 255.0f);
}

void camera_to_srgb(const CameraImage& image, uint8_t* values, uint32_t count) {
  if (image.transfer == SANDGLASS_TRANSFER_SRGB) return;
  const float *srgb_table = k_tables[SANDGLASS_TRANSFER_SRGB].light, *table = camera_light_table(image);
  uint8_t nearest[256];
  for (uint32_t i = 0, byte = 0; i < 256; ++i) {  // neither table falls
    const float light = camera_light(image, table, static_cast<uint8_t>(i));
    while (byte < 255 && light > 0.5f * (srgb_table[byte] + srgb_table[byte + 1])) ++byte;
    nearest[i] = static_cast<uint8_t>(byte);
  }
  for (uint32_t i = 0; i < count; ++i) values[i] = nearest[values[i]];
}

}  // namespace sandglass
