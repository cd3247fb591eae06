#include "tests/lighting/excerpts.h"

#include <gtest/gtest.h>

#include <sstream>

#include "models/host/atomic_file.h"
#include "models/lighting/picture_file.h"
#include "runtime/asset/checksum.h"

namespace sandglass::host {

std::vector<Excerpt> excerpts(size_t step) {
  const std::string folder = SANDGLASS_EXCERPTS_DIR;
  std::istringstream rows(read_file(folder + "/estimates.csv", "table of estimates"));
  std::vector<Excerpt> all;
  std::string row;
  std::getline(rows, row);
  for (size_t i = 0; std::getline(rows, row); ++i) {
    if (i % step != 0) continue;
    std::istringstream fields(row);
    Excerpt excerpt;
    std::string field;
    std::getline(fields, excerpt.name, ',');
    excerpt.rgb = read_excerpt(folder + "/" + excerpt.name).rgb;
    std::getline(fields, field, ',');
    EXPECT_EQ(asset_checksum(excerpt.rgb.data(), excerpt.rgb.size()), std::stoull(field, nullptr, 16))
        << excerpt.name << ": this reader of JPEG gives other bytes than the one that PyTorch's came from";
    for (float& value : excerpt.values) {
      std::getline(fields, field, ',');
      value = std::stof(field);
    }
    all.push_back(excerpt);
  }
  return all;
}

}  // namespace sandglass::host
