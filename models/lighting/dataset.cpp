#include "models/lighting/dataset.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <sstream>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/files/image.h"
#include "models/lighting/lit_view.h"
#include "models/work/progress.h"
#include "models/work/thread_pool.h"

namespace sandglass::host {

namespace fs = std::filesystem;

namespace {

constexpr int k_folds = 5;

// The rows of a .csv file. Commas within quotes do not count.
std::vector<std::vector<std::string>> rows_of(const std::string& text) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::vector<std::string>& fields = rows.emplace_back(1);
    bool quoted = false;
    for (const char c : line) {
      if (c == '"') quoted = !quoted;
      else if (c == ',' && !quoted) fields.emplace_back();
      else if (c != '\r') fields.back() += c;
    }
  }
  return rows;
}

struct Excerpt {
  std::string line;  // its line in the manifest
  bool has_direction;
};

std::vector<Excerpt> excerpts_of(const std::string& path, const Location& location, const DatasetOptions& options) {
  const LitPanorama panorama(path);
  std::vector<Excerpt> result;
  const auto views = views_of(path, options.seed);
  for (size_t k = 0; k < views.size(); ++k) {
    const View view = views[k];
    const LitView cut = panorama.cut(view);
    const LightLabels& labels = cut.labels;
    const std::string name = stem_of(path) + "_" + std::to_string(k);
    write_png(options.folder + "/images/" + name + ".png", cut.image);
    char numbers[512];
    const Vec3 d = labels.direction, c = labels.light, a = labels.ambient;
    std::snprintf(numbers, sizeof numbers, "%d,%.6f,%.6f,%.4f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%d",
                  location.fold, view.theta, view.phi, cut.radius, d.x, d.y, d.z, c.x, c.y, c.z, a.x, a.y, a.z,
                  labels.contrast, labels.has_direction ? 1 : 0);
    result.push_back(
        {"images/" + name + ".png," + fs::path(path).filename().string() + "," + location.name + "," + numbers,
         labels.has_direction});
  }
  return result;
}

}  // namespace

std::string data_folder() {
  const char* data = std::getenv("SANDGLASS_DATA_DIR");
  return data == nullptr ? "" : data;
}

std::vector<std::string> find_panoramas(const std::vector<std::string>& paths) {
  std::vector<std::string> found;
  const auto is_panorama = [](const fs::path& p) { return p.extension() == ".hdr" || p.extension() == ".exr"; };
  for (const std::string& path : paths) {
    try {
      if (!fs::is_directory(path)) {
        found.push_back(path);
        continue;
      }
      for (const auto& entry : fs::recursive_directory_iterator(path))
        if (entry.is_regular_file() && is_panorama(entry.path())) found.push_back(entry.path().string());
    } catch (const fs::filesystem_error& error) {
      throw cannot("read", path, error.code().message(), "Check its permissions and the disk");
    }
  }
  if (found.empty())
    throw cannot("use", paths.at(0), "it has no .hdr or .exr file", "Name panoramas, or folders of them");
  std::sort(found.begin(), found.end());
  return found;
}

void refuse_equal_stems(const std::vector<std::string>& panoramas) {
  std::map<std::string, std::string> seen;
  for (const std::string& path : panoramas) {
    const auto [other, is_new] = seen.emplace(stem_of(path), path);
    if (!is_new)
      throw cannot("use", path,
                   "\"" + other->second + "\" has the same name, and names tell images and estimates apart",
                   "Rename one or leave it out");
  }
}

std::string read_locations(const std::string& path) {
  if (path.empty()) return "";
  std::string text = read_file(path, "manifest", k_text_limit);
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    throw cannot("read", path, "the manifest is empty", "Its first line names the columns file, group and fold");
  return text;
}

Location location_of(const std::string& panorama, const std::string& manifest_text) {
  if (manifest_text.empty()) {
    const std::string name = stem_of(panorama);
    return {name, static_cast<int>(hash_of_name(name, 0) % k_folds)};
  }
  const std::string file = fs::path(panorama).filename().string();
  const auto rows = rows_of(manifest_text);
  const auto column = [&](const char* name) {
    return static_cast<size_t>(std::find(rows[0].begin(), rows[0].end(), name) - rows[0].begin());
  };
  const size_t names = column("file"), groups = column("group"), folds = column("fold");
  const size_t last = std::max({names, groups, folds});
  if (last == rows[0].size())
    throw Failure("cannot read the manifest: it has no columns file, group and fold. Name them in its first line.");
  for (const auto& row : rows) {
    if (&row == &rows[0] || row.size() <= last || fs::path(row[names]).filename() != file) continue;
    const std::string& fold = row[folds];
    if (fold.size() > 1 || (fold.size() == 1 && (fold[0] < '0' || fold[0] > '9')))
      throw Failure("cannot read the manifest: it gives \"" + file + "\" the fold \"" + fold +
                    "\". Write one digit, or nothing.");
    return {row[groups], fold.empty() ? -1 : fold[0] - '0'};
  }
  throw Failure("cannot read the manifest: it has no line for \"" + file + "\". Add one with its group and fold.");
}

DatasetSummary make_dataset(const DatasetOptions& options) {
  const std::vector<std::string> panoramas = find_panoramas(options.panoramas);
  refuse_equal_stems(panoramas);
  const std::string manifest_text = read_locations(options.manifest);
  std::vector<Location> locations;
  for (const std::string& panorama : panoramas) {
    if (!fs::exists(panorama)) throw cannot("read", panorama, "the panorama does not exist", "Check the path");
    locations.push_back(location_of(panorama, manifest_text));
  }
  std::vector<std::vector<Excerpt>> results(panoramas.size());
  // A panorama that cannot be read is reported before any image is written. Reading the panoramas twice costs a
  // hundredth of the time that cutting takes.
  for_all(panoramas.size(), options.threads, "reading panoramas", [&](size_t i) { LitPanorama{panoramas[i]}; });
  if (interrupted()) return {};
  make_folder(options.folder + "/images");
  for_all(panoramas.size(), options.threads, "cutting panoramas",
          [&](size_t i) { results[i] = excerpts_of(panoramas[i], locations[i], options); });
  DatasetSummary summary;
  if (interrupted()) return summary;
  std::string manifest =
      "image,panorama,location,fold,theta,phi,insertion_radius,direction_x,direction_y,direction_z,light_r,light_g,"
      "light_b,"
      "ambient_r,ambient_g,ambient_b,contrast,has_direction\n";
  for (const auto& result : results)
    for (const Excerpt& excerpt : result) {
      manifest += excerpt.line + "\n";
      ++summary.excerpts;
      summary.without_direction += excerpt.has_direction ? 0 : 1;
    }
  summary.panoramas = panoramas.size();
  write_file(options.folder + "/manifest.csv", manifest);
  return summary;
}

std::vector<std::string> images_of_dataset(const std::string& folder) {
  const std::string path = folder + "/manifest.csv", text = read_file(path, "list of images", k_text_limit);
  std::vector<std::string> images;
  const auto rows = rows_of(text);
  for (const auto& row : rows) {
    const bool heading = &row == &rows[0];
    if (heading ? row[0] != "image" : row[0].empty())
      throw cannot("read", path, "it is no data set's list of images", "Make it with sandglass dataset");
    if (!heading) images.push_back(folder + "/" + row[0]);
  }
  if (images.empty()) throw cannot("read", path, "it names no image", "Make the data set again");
  return images;
}

}  // namespace sandglass::host
