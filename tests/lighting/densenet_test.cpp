// Weights are read from .npz files. Damaged ones, and those of another network, are refused. network_test.cpp compares
// the pretrained network with its reference outputs.
#include "models/lighting/densenet.h"

#include <gtest/gtest.h>

#include "models/files/atomic_file.h"
#include "tests/damaged_file.h"
#include "tests/temporary_folder.h"

namespace sandglass::host {
namespace {

// A small file of this kind, written by hand: an uncompressed zip with the arrays a (2 floats) and b (3 bytes). Its
// table of contents may name each of them several times.
std::string small_npz(uint32_t times = 1) {
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
    for (uint32_t k = 0; k < times; ++k)
      table += little(0x02014B50, 4) + std::string(16, '\0') + size + size + name_size + std::string(12, '\0') + at +
               names[i];
  }
  return file + table + little(0x06054B50, 4) + std::string(4, '\0') + little(2 * times, 2) + little(2 * times, 2) +
         little(static_cast<uint32_t>(table.size()), 4) + little(static_cast<uint32_t>(file.size()), 4) + little(0, 2);
}

TEST(Npz, FloatsAndBytes) {
  const tests::TemporaryFolder folder;
  const std::string path = folder / "small.npz";
  write_file(path, small_npz());
  const auto arrays = read_npz(path);
  ASSERT_EQ(arrays.size(), 2u);
  EXPECT_EQ(arrays.at("a").values, (std::vector<float>{1.0f, -2.0f}));
  EXPECT_EQ(arrays.at("b").shape, (std::vector<uint64_t>{1, 3}));
  EXPECT_EQ(arrays.at("b").values, (std::vector<float>{0.0f, 7.0f, 255.0f}));
  tests::expect_refusal("conv1/conv/kernel", [&] { densenet_of(arrays); });
}

TEST(Npz, DamagedOnesAreRefusedOrRead) {
  const tests::TemporaryFolder folder;
  const std::string path = folder / "damaged.npz";
  tests::expect_damage_refused(small_npz(), path, [&] { EXPECT_LE(read_npz(path).size(), 2u); });
}

// A table of contents that names the same bytes again and again would ask for memory without end.
TEST(Npz, EntriesThatOverlapAreRefused) {
  const tests::TemporaryFolder folder;
  const std::string path = folder / "bomb.npz";
  write_file(path, small_npz(20));
  tests::expect_refusal("overlap", [&] { read_npz(path); });
}

TEST(DenseNet, OddSizesAreRefused) {
  const std::vector<uint8_t> rgb(3 * 40 * 40);
  tests::expect_refusal("32 pixels", [&] { features_of({}, rgb, 40, 40); });
}

}  // namespace
}  // namespace sandglass::host
