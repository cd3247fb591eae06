// Training pairs from panoramas: for each, eight excerpts as a camera would take them and the labels of the light where
// an object would be put. What is written:
//   images/NAME_K.png   256 x 192, tone mapped with the whole panorama's exposure, sRGB
//   manifest.csv        one line an excerpt: image, panorama, location, fold, view, insertion radius, labels (direction
//   in
//                       the camera's frame: x right, y down, z forward; linear colours)
//   sheet.png           excerpts with an arrow where the light is, the warped panorama and the labels as a panorama
// Folds follow locations, never excerpts: two views of one place in training and test would be told apart by memory.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sandglass::host {

struct DatasetOptions {
  std::vector<std::string> panoramas;  // files, or folders that are searched for .hdr and .exr
  std::string folder;                  // to write to
  std::string manifest;  // a .csv with the columns file, group, fold; empty: each file is its own location
  uint64_t seed = 1;
  uint32_t threads = 1;
  uint32_t tiles = 32;  // of the contact sheet
};

struct DatasetSummary {
  size_t panoramas = 0, excerpts = 0, without_direction = 0;
};

DatasetSummary make_dataset(const DatasetOptions& options);

// The images of a data set that was made, by its manifest and in its order.
std::vector<std::string> images_of_dataset(const std::string& folder);

// .hdr and .exr files, in the order of their names, of files and (recursively) folders; a Failure if there is none.
std::vector<std::string> find_panoramas(const std::vector<std::string>& paths);

// A Failure that names two panoramas with one stem: images, estimates and rows of tables are called by it.
void refuse_equal_stems(const std::vector<std::string>& panoramas);

struct Location {
  std::string name;
  int fold = -1;  // -1: only ever for training
};
// A manifest's text; none where no path is given, and a Failure for one without a line.
std::string read_locations(const std::string& path);
// The location of a panorama by its line in a manifest, a Failure where it has none; without a manifest by the
// panorama's own name, with a fold of 0 to 4 from that.
Location location_of(const std::string& panorama, const std::string& manifest_text);

}  // namespace sandglass::host
