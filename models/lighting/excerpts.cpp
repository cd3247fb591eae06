#include "models/lighting/excerpts.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/files/image.h"
#include "models/simulation/metrics.h"
#include "runtime/math/hash.h"

namespace sandglass::host {

LightDifference median_difference(std::span<const LightValues> a, std::span<const LightValues> b) {
  std::vector<double> angles, others;
  for (size_t k = 0; k < a.size(); ++k) {
    double dot = 0, lengths[2] = {}, worst = 0;
    for (size_t i = 0; i < 3; ++i) {
      const double x = static_cast<double>(a[k][i]), y = static_cast<double>(b[k][i]);
      dot += x * y;
      lengths[0] += x * x;
      lengths[1] += y * y;
    }
    for (size_t i = 3; i < a[k].size(); ++i) worst = std::max(worst, static_cast<double>(std::fabs(a[k][i] - b[k][i])));
    angles.push_back(std::acos(std::clamp(dot / std::sqrt(lengths[0] * lengths[1]), -1.0, 1.0)) * 180 /
                     std::numbers::pi);
    others.push_back(worst);
  }
  return {quantile(angles, 0.5), quantile(others, 0.5)};
}

std::vector<Excerpt> read_excerpts(const std::string& folder, size_t step) {
  const std::string table = folder + "/estimates.csv";
  std::istringstream rows(read_file(table, "table of estimates", k_text_limit));
  std::vector<Excerpt> all;
  std::string row;
  std::getline(rows, row);
  for (size_t i = 0; std::getline(rows, row); ++i) {
    if (i % step != 0) continue;
    std::replace(row.begin(), row.end(), ',', ' ');
    std::istringstream fields(row);
    Excerpt excerpt;
    uint64_t expected = 0;
    fields >> excerpt.name >> std::hex >> expected;
    excerpt.rgb = read_excerpt(folder + "/" + excerpt.name).rgb;
    if (expected != hash_bytes(excerpt.rgb.data(), excerpt.rgb.size()))
      throw cannot("read", table, "its row \"" + excerpt.name + "\" is of other pixels than that file has",
                   "Write it again with float_network.py");
    for (float& v : excerpt.values) fields >> v;
    if (!fields)
      throw cannot("read", table, "its row \"" + excerpt.name + "\" has fewer than ten numbers",
                   "Write it again with float_network.py");
    all.push_back(excerpt);
  }
  if (all.empty()) throw cannot("read", table, "it has no excerpts", "Write it again with float_network.py");
  return all;
}

}  // namespace sandglass::host
