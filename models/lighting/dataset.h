// Training pairs from panoramas: eight excerpts of each, as a camera would take them, and the labels of the light at
// the place where an object would be put. What is written:
//
//   images/NAME_K.png   256 x 192, tone mapped with the whole panorama's exposure, sRGB
//   manifest.csv        one line for each excerpt: image, panorama, location, fold, view, insertion radius, labels
//                       (direction in the camera's frame: x right, y down, z forward; linear colours)
//
// Folds follow locations, never excerpts: with one view of a place in training and another in the test, the network
// could answer from memory.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sandglass::host {

struct DatasetOptions {
  std::vector<std::string> panoramas;  // files, or folders that are searched for .hdr and .exr
  std::string folder;                  // the folder to write to
  std::string manifest;  // a .csv with the columns file, group, fold; empty: each file is its own location
  uint64_t seed = 1;
  uint32_t threads = 1;
};

// The folder that SANDGLASS_DATA_DIR names; empty where it names none.
std::string data_folder();

struct DatasetSummary {
  size_t panoramas = 0, excerpts = 0, without_direction = 0;
};

DatasetSummary make_dataset(const DatasetOptions& options);

// The images of a finished data set, in the order of its manifest.
std::vector<std::string> images_of_dataset(const std::string& folder);

// The .hdr and .exr files among `paths` and, recursively, in folders among them, in the order of their names. Throws a
// Failure if there is none.
std::vector<std::string> find_panoramas(const std::vector<std::string>& paths);

// Throws a Failure that names two panoramas with the same stem, because images, estimates and rows of tables are named
// by it.
void refuse_equal_stems(const std::vector<std::string>& panoramas);

struct Location {
  std::string name;
  int fold = -1;  // -1: for training only
};
// The text of a manifest; empty if no path is given. Throws a Failure for a manifest without a line.
std::string read_locations(const std::string& path);
// The location of a panorama by its line in a manifest; throws a Failure if it has none. Without a manifest the
// location is the panorama's own name, which also decides the fold, 0 to 4.
Location location_of(const std::string& panorama, const std::string& manifest_text);

}  // namespace sandglass::host
