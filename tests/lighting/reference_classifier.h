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
  // The float network's own features are compared here, as by expect_float_reference.
  explicit ReferenceClassifier(const std::string& data_folder);

  const std::vector<uint8_t>& file() const { return file_; }
  const std::vector<uint8_t>& float_file() const { return float_file_; }  // the file with the float network
  // For each image, features must be within a tenth of the reference's, and the class must be its class.
  void expect_reference(LightRunner* runner) const;
  // Features must be within 1e-3 of the reference's, and the class must be its class.
  void expect_float_reference(LightRunner* runner) const;

 private:
  struct Image {
    std::string name;
    std::vector<uint8_t> rgb;
    std::vector<float> features;  // the reference's
    size_t label;
  };
  void expect_class(const Image& image, const std::vector<float>& features) const;
  void expect_float(const Image& image, const std::vector<float>& features) const;

  std::vector<float> kernel_, bias_;  // from features to 1000 classes
  std::vector<Image> images_;
  std::vector<uint8_t> file_, float_file_;
};

}  // namespace sandglass::host
