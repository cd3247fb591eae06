// The import of the pretrained network, against the outputs of an independent forward pass that lie beside it. Damaged
// .npz files are refused.
#include "models/lighting/densenet.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "tests/refusal.h"
#include "tests/temporary_folder.h"

namespace sandglass::host {
namespace {

std::string pretrained(const char* file) {
  const char* data = std::getenv("SANDGLASS_DATA_DIR");
  const std::string path = data == nullptr ? "" : std::string(data) + "/pretrained/" + file;
  return std::filesystem::exists(path) ? path : "";
}

// A small file of this kind, written by hand: an uncompressed zip with the arrays a (2 floats) and b (3 bytes).
std::string small_npz() {
  const auto little = [](uint32_t value, int bytes) {
    std::string text;
    for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 255);
    return text;
  };
  const auto array = [&](const std::string& header, const std::string& data) {
    return std::string("\x93NUMPY\x01\x00", 8) + little(static_cast<uint32_t>(header.size()), 2) + header + data;
  };
  const std::string names[2] = {"a.npy", "b.npy"};
  const std::string data[2] = {
      array("{'descr': '<f4', 'fortran_order': False, 'shape': (2,), }\n",
            std::string("\x00\x00\x80\x3f\x00\x00\x00\xc0", 8)),
      array("{'descr': '|u1', 'fortran_order': False, 'shape': (1, 3), }\n", std::string("\x00\x07\xff", 3))};
  std::string file, table;
  for (int i = 0; i < 2; ++i) {
    const std::string size = little(static_cast<uint32_t>(data[i].size()), 4),
                      at = little(static_cast<uint32_t>(file.size()), 4);
    const std::string name_size = little(static_cast<uint32_t>(names[i].size()), 2);
    file += little(0x04034B50, 4) + std::string(14, '\0') + size + size + name_size + little(0, 2) + names[i] + data[i];
    table +=
        little(0x02014B50, 4) + std::string(16, '\0') + size + size + name_size + std::string(12, '\0') + at + names[i];
  }
  return file + table + little(0x06054B50, 4) + std::string(4, '\0') + little(2, 2) + little(2, 2) +
         little(static_cast<uint32_t>(table.size()), 4) + little(static_cast<uint32_t>(file.size()), 4) + little(0, 2);
}

class Npz : public ::testing::Test {
 protected:
  tests::TemporaryFolder folder;
  const std::string path = folder / "small.npz";
};

TEST_F(Npz, FloatsAndBytes) {
  write_file(path, small_npz());
  const auto arrays = read_npz(path);
  ASSERT_EQ(arrays.size(), 2u);
  EXPECT_EQ(arrays.at("a").values, (std::vector<float>{1.0f, -2.0f}));
  EXPECT_EQ(arrays.at("b").shape, (std::vector<uint64_t>{1, 3}));
  EXPECT_EQ(arrays.at("b").values, (std::vector<float>{0.0f, 7.0f, 255.0f}));
}

TEST_F(Npz, EveryTruncationIsRefused) {
  const std::string whole = small_npz();
  for (size_t n = 0; n < whole.size(); ++n) {
    write_file(path, std::string_view(whole).substr(0, n));
    EXPECT_THROW(read_npz(path), Failure) << n;
  }
}

TEST_F(Npz, EveryFlippedByteIsRefusedOrRead) {
  const std::string whole = small_npz();
  for (size_t n = 0; n < whole.size(); ++n)
    for (const int bit : {1, 128}) {
      std::string flipped = whole;
      flipped[n] = static_cast<char>(flipped[n] ^ bit);
      write_file(path, flipped);
      try {
        EXPECT_LE(read_npz(path).size(), 2u);
      } catch (const Failure&) {
      }
    }
}

TEST_F(Npz, OtherWeightsAreRefusedByName) {
  write_file(path, small_npz());
  const std::string said = tests::refusal_of([&] { densenet_of(read_npz(path)); });
  EXPECT_NE(said.find("conv1/conv/kernel"), std::string::npos) << said;
}

TEST(DenseNetImport, ReproducesTheReferenceOutputs) {
  const std::string weights = pretrained("densenet121_imagenet_keras_fp32.npz");
  if (weights.empty()) GTEST_SKIP() << "SANDGLASS_DATA_DIR is not set, or has no pretrained network";
  if (SANDGLASS_EMULATED) GTEST_SKIP() << "it takes minutes under emulation";
  const DenseNet net = densenet_of(read_npz(weights));
  EXPECT_NEAR(static_cast<double>(multiplications_of(net, 256, 192)), 2.549e9, 0.001e9);
  const auto truth = read_npz(pretrained("densenet121_reference_outputs.npz"));
  for (const std::string name : {"bird", "parrot", "cat"}) {
    const std::vector<float>& pixels = truth.at(name + "/rgb_u8").values;
    std::vector<uint8_t> rgb(pixels.size());
    std::transform(pixels.begin(), pixels.end(), rgb.begin(), [](float v) { return static_cast<uint8_t>(v); });
    const std::vector<float> features = features_of(net, rgb, 224, 224),
                             probabilities = probabilities_of(net, features);
    const std::vector<float>&expected = truth.at(name + "/feat1024").values,
          &classes = truth.at(name + "/prob1000").values;
    double worst = 0.0, worst_class = 0.0, greatest = 0.0;
    for (size_t i = 0; i < features.size(); ++i) {
      worst = std::max(worst, static_cast<double>(std::fabs(features[i] - expected[i])));
      greatest = std::max(greatest, static_cast<double>(expected[i]));
    }
    for (size_t i = 0; i < classes.size(); ++i)
      worst_class = std::max(worst_class, static_cast<double>(std::fabs(probabilities[i] - classes[i])));
    std::printf("%s: features off by %.2g of %.3g, probabilities by %.2g\n", name.c_str(), worst, greatest,
                worst_class);
    EXPECT_LE(worst, 1e-3) << name;
    EXPECT_LE(worst_class, 1e-3) << name;
    EXPECT_EQ(std::max_element(probabilities.begin(), probabilities.end()) - probabilities.begin(),
              std::max_element(classes.begin(), classes.end()) - classes.begin());
  }
}

TEST(DenseNetImport, OddSizesAreRefused) {
  const std::vector<uint8_t> rgb(3 * 40 * 40);
  EXPECT_THROW(features_of({}, rgb, 40, 40), Failure);
}

}  // namespace
}  // namespace sandglass::host
