// Numbers of a file may be anything; a statement that makes no sense is as if it were not there.
#include "models/files/picture_colour.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "models/files/image.h"

namespace sandglass::host {

namespace {

using Matrix = std::array<double, 9>;     // row by row
using Primaries = std::array<double, 8>;  // x and y of white, red, green and blue, in the order of cHRM
using Curve = PictureColour::Curve;

constexpr Primaries k_bt709 = {0.3127, 0.3290, 0.64, 0.33, 0.30, 0.60, 0.15, 0.06};
constexpr Primaries k_p3 = {0.3127, 0.3290, 0.680, 0.320, 0.265, 0.690, 0.150, 0.060};
constexpr Primaries k_bt2020 = {0.3127, 0.3290, 0.708, 0.292, 0.170, 0.797, 0.131, 0.046};

uint32_t number(std::string_view bytes, size_t at, size_t count) {
  uint32_t value = 0;
  for (size_t i = 0; i < count; ++i)
    value = value << 8 | (at + i < bytes.size() ? static_cast<uint8_t>(bytes[at + i]) : 0u);
  return value;
}

Matrix inverse(const Matrix& m) {
  const auto minor_of = [&](size_t a, size_t b, size_t c, size_t d) { return m[a] * m[d] - m[b] * m[c]; };
  Matrix out = {minor_of(4, 5, 7, 8), minor_of(2, 1, 8, 7), minor_of(1, 2, 4, 5),
                minor_of(5, 3, 8, 6), minor_of(0, 2, 6, 8), minor_of(2, 0, 5, 3),
                minor_of(3, 4, 6, 7), minor_of(1, 0, 7, 6), minor_of(0, 1, 3, 4)};
  const double determinant = m[0] * out[0] + m[1] * out[3] + m[2] * out[6];
  for (double& x : out) x /= determinant;
  return out;
}

// Linear colours of these primaries as CIE XYZ, with a white of luminance 1.
Matrix to_xyz(const Primaries& p) {
  Matrix m;
  for (size_t k = 0; k < 3; ++k) {
    const double x = p[2 + 2 * k], y = p[3 + 2 * k];
    m[k] = x;
    m[3 + k] = y;
    m[6 + k] = 1.0 - x - y;
  }
  const Matrix of = inverse(m);
  const double white[3] = {p[0] / p[1], 1.0, (1.0 - p[0] - p[1]) / p[1]};
  for (size_t k = 0; k < 3; ++k) {
    const double share = of[3 * k] * white[0] + of[3 * k + 1] * white[1] + of[3 * k + 2] * white[2];
    for (size_t row = 0; row < 3; ++row) m[3 * row + k] *= share;
  }
  return m;
}

// Leaves the matrix as it is where the primaries make no sense.
void set_primaries(const Primaries& primaries, PictureColour* colour) {
  constexpr double k_entry_max = 10.0;  // of any that a person sees: 2.1
  if (primaries == k_bt709) return;
  const Matrix from = to_xyz(primaries), to = inverse(to_xyz(k_bt709));
  Matrix m = {};
  for (size_t row = 0; row < 3; ++row) {
    for (size_t column = 0; column < 3; ++column)
      for (size_t k = 0; k < 3; ++k) m[3 * row + column] += to[3 * row + k] * from[3 * k + column];
    const double white = m[3 * row] + m[3 * row + 1] + m[3 * row + 2];
    for (size_t column = 0; column < 3; ++column) m[3 * row + column] /= white;
  }
  if (std::all_of(m.begin(), m.end(), [](double x) { return std::fabs(x) < k_entry_max; })) colour->to_bt709 = m;
}

// Codes of ITU-T H.273: primaries, transfer, matrix, and whether black is 0.
bool set_cicp(std::string_view chunk, PictureColour* colour) {
  constexpr struct {
    uint32_t code;
    Curve curve;
    double exponent;
  } k_transfers[] = {{1, Curve::bt709, 1},   {6, Curve::bt709, 1},   {14, Curve::bt709, 1}, {15, Curve::bt709, 1},
                     {4, Curve::power, 2.2}, {5, Curve::power, 2.8}, {8, Curve::power, 1},  {13, Curve::srgb, 1},
                     {16, Curve::pq, 1},     {18, Curve::hlg, 1}};
  const uint32_t primaries = number(chunk, 0, 1), code = number(chunk, 1, 1);
  const bool known = primaries == 1 || primaries == 9 || primaries == 12;
  if (chunk.size() != 4 || number(chunk, 2, 2) != 1 || !known) return false;
  for (const auto& transfer : k_transfers) {
    if (transfer.code != code) continue;
    colour->curve = transfer.curve;
    colour->exponent = transfer.exponent;
    set_primaries(primaries == 1 ? k_bt709 : primaries == 9 ? k_bt2020 : k_p3, colour);
    return true;
  }
  return false;
}

/* ---- ICC ---- */

double fixed(std::string_view bytes, size_t at) { return static_cast<int32_t>(number(bytes, at, 4)) / 65536.0; }

// The content of a tag; of a file that ends early, what there is of it.
std::string_view tag(std::string_view icc, std::string_view name) {
  constexpr size_t k_head = 128, k_entry = 12;
  const size_t count = number(icc, k_head, 4);
  for (size_t i = 0, at = k_head + 4; i < count && at + k_entry <= icc.size(); ++i, at += k_entry)
    if (icc.substr(at, 4) == name)
      return icc.substr(std::min<size_t>(number(icc, at + 4, 4), icc.size()), number(icc, at + 8, 4));
  return {};
}

// The linear value of x in 0..1 by a curve, which is a formula or a table; below 0 where it is neither.
double curve_at(std::string_view curve, double x) {
  constexpr size_t k_numbers = 12;
  if (curve.starts_with("para")) {  // of the kinds that profiles use: (a x + b)^g + e from d on, and c x + f below
    const uint32_t kind = number(curve, 8, 2);
    double p[7] = {};  // g a b c d e f
    for (size_t i = 0; i < 7; ++i) p[i] = fixed(curve, k_numbers + 4 * i);
    if (kind == 0) return std::pow(x, p[0]);
    if (kind != 3 && kind != 4) return -1.0;
    if (kind == 3) p[5] = p[6] = 0.0;
    return x >= p[4] ? std::pow(p[1] * x + p[2], p[0]) + p[5] : p[3] * x + p[6];
  }
  if (!curve.starts_with("curv")) return -1.0;
  const size_t count = number(curve, 8, 4);
  if (count == 0) return x;
  if (count == 1) return std::pow(x, number(curve, k_numbers, 2) / 256.0);
  const double place = x * static_cast<double>(count - 1), low = std::floor(place);
  const size_t at = k_numbers + 2 * static_cast<size_t>(low);
  const double a = number(curve, at, 2), b = number(curve, at + 2, 2);
  return (a + (b - a) * (place - low)) / 65535.0;
}

// The primaries of a profile that is sRGB or Display P3: colours as those profiles have them, seen under D50, and
// curves near sRGB's, which some round to a power of 2.2.
std::optional<Primaries> primaries_of(std::string_view icc) {
  constexpr double k_same_colour = 0.005, k_same_curve = 0.012;
  constexpr uint8_t k_tried[] = {26, 64, 128, 192, 230};
  constexpr struct {
    Primaries primaries;
    double xyz[3][3];
  } k_known[] = {{k_bt709, {{0.4361, 0.2225, 0.0139}, {0.3851, 0.7169, 0.0971}, {0.1431, 0.0606, 0.7141}}},
                 {k_p3, {{0.5151, 0.2412, -0.0011}, {0.2920, 0.6922, 0.0419}, {0.1571, 0.0666, 0.7841}}}};
  if (icc.size() < 132 || icc.substr(16, 4) != "RGB ") return {};
  for (const char* name : {"rTRC", "gTRC", "bTRC"})
    for (const uint8_t byte : k_tried)
      if (!(std::fabs(curve_at(tag(icc, name), byte / 255.0) - linear_of(byte)) < k_same_curve)) return {};
  for (const auto& known : k_known) {
    bool is_this = true;
    const char* names[] = {"rXYZ", "gXYZ", "bXYZ"};
    for (size_t k = 0; k < 3; ++k)
      for (size_t i = 0; i < 3; ++i)
        is_this = is_this && std::fabs(fixed(tag(icc, names[k]), 8 + 4 * i) - known.xyz[k][i]) < k_same_colour;
    if (is_this) return known.primaries;
  }
  return {};
}

double linear_light(const PictureColour& colour, double x) {
  switch (colour.curve) {
    case Curve::power:
      return std::pow(x, colour.exponent);
    case Curve::bt709:
      return x < 0.081 ? x / 4.5 : std::pow((x + 0.099) / 1.099, 1.0 / 0.45);
    case Curve::pq: {  // SMPTE ST 2084
      constexpr double k_white = 203.0 / 10000.0;
      const double root = std::pow(x, 32.0 / 2523.0);
      const double light = std::max(root - 0.8359375, 0.0) / (18.8515625 - 18.6875 * root);
      return std::pow(light, 8192.0 / 1305.0) / k_white;
    }
    case Curve::hlg: {  // ITU-R BT.2100
      constexpr double k_a = 0.17883277, k_b = 1.0 - 4.0 * k_a, k_c = 0.55991073, k_white = 0.26496256;
      return (x <= 0.5 ? x * x / 3.0 : (std::exp((x - k_c) / k_a) + k_b) / 12.0) / k_white;
    }
    default:
      return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
  }
}

}  // namespace

PictureColour picture_colour(const PictureHead& head, std::string_view icc) {
  PictureColour colour;
  if (!head.cicp.empty()) {
    if (set_cicp(head.cicp, &colour)) return colour;
    colour.remark =
        "its cICP chunk names a colour space that is not known here, and is not applied. Convert it to sRGB";
  }
  if (!head.icc.empty()) {
    if (const std::optional<Primaries> known = primaries_of(icc)) {
      set_primaries(*known, &colour);
      return colour;
    }
    colour.remark = "its colour profile is neither sRGB nor Display P3, and is not applied. Convert it to sRGB";
  }
  if (head.says_srgb) return colour;
  if (const uint32_t gamma = number(head.gamma, 0, 4); head.gamma.size() == 4 && gamma > 0) {
    colour.curve = Curve::power;
    colour.exponent = 1e5 / gamma;
  }
  if (Primaries given; head.chromaticities.size() == 4 * given.size()) {
    for (size_t i = 0; i < given.size(); ++i) given[i] = number(head.chromaticities, 4 * i, 4) / 1e5;
    set_primaries(given, &colour);
  }
  return colour;
}

std::vector<uint8_t> srgb_bytes(std::span<const uint16_t> numbers, const PictureColour& colour) {
  std::vector<double> light(65536);
  for (size_t i = 0; i < light.size(); ++i) light[i] = linear_light(colour, static_cast<double>(i) / 65535.0);
  std::vector<uint8_t> bytes(numbers.size());
  const Matrix& m = colour.to_bt709;
  for (size_t i = 0; i + 2 < numbers.size(); i += 3) {
    const double r = light[numbers[i]], g = light[numbers[i + 1]], b = light[numbers[i + 2]];
    for (size_t k = 0; k < 3; ++k) bytes[i + k] = srgb_byte(m[3 * k] * r + m[3 * k + 1] * g + m[3 * k + 2] * b);
  }
  return bytes;
}

}  // namespace sandglass::host
