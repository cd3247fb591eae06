// The pretrained classifier of the data folder as a lighting file, and the three reference images on which it is
// tested.
#pragma once

#include <string>
#include <vector>

#include "models/lighting/light_net.h"
#include "models/lighting/light_runner.h"

namespace sandglass::host {

constexpr uint32_t k_reference_side = 224;  // pixels of an image

class ReferenceClassifier {
 public:
  explicit ReferenceClassifier(const std::string& data_folder);

  const std::vector<uint8_t>& file() const { return file_; }
  const std::vector<uint8_t>& float_file() const { return float_file_; }  // the file with the float network
  // For each image, features must be within a tenth of the reference's, and the class must be its class.
  void expect_reference(LightRunner* runner) const;
  // Features and probabilities must be within 1e-3, as for the project's float network.
  void expect_float_reference(LightRunner* runner) const;

 private:
  std::string folder_;
  LightNet net_;
  std::vector<std::vector<uint8_t>> images_;
  std::vector<uint8_t> file_, float_file_;
};

}  // namespace sandglass::host
