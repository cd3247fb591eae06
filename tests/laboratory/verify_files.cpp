// `sandglass_lab verify files FOLDER`: every mesh file of a folder, as the program reads it and as trimesh does.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "models/files/atomic_file.h"
#include "models/files/failure.h"
#include "models/mesh/mesh.h"
#include "tests/laboratory/verify.h"

namespace sandglass::host {

namespace {

struct Told {
  std::string name, refused;    // refused: why, or empty
  std::array<double, 6> value;  // the box along x, y and z; area; volume; triangles
  bool has_volume = true;       // closed, and of one orientation
};
constexpr const char* k_names[] = {"x", "y", "z", "area", "volume", "triangles"};

std::vector<Told> told_by_trimesh(const std::string& folder) {
  const std::string script = SANDGLASS_LABORATORY_DIR "/files/other_reader.py";
  std::string quoted;
  for (const char c : folder) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  FILE* pipe = popen(("python3 -B '" + script + "' '" + quoted + "'").c_str(), "r");
  if (pipe == nullptr) throw cannot("start", "python3", "there is no room for another process", "End some");
  std::string text;
  char buffer[65536];
  for (size_t got; (got = fread(buffer, 1, sizeof buffer, pipe)) > 0;) text.append(buffer, got);
  const int status = pclose(pipe);
  if (status != 0)
    throw cannot("compare with", "trimesh", "python3 has no such package, or ended", "Install it: pip install trimesh");
  std::vector<Told> all;
  for (size_t at = 0; at < text.size(); at = text.find('\n', at) + 1) {
    const std::string line = text.substr(at, text.find('\n', at) - at);
    const size_t tab = line.find('\t');
    Told told = {line.substr(0, tab), "", {}};
    auto& v = told.value;
    if (std::sscanf(line.c_str() + tab, "%lf %lf %lf %lf %lf %lf", &v[0], &v[1], &v[2], &v[3], &v[4], &v[5]) != 6)
      told.refused = line.substr(tab + 1);
    all.push_back(told);
  }
  return all;
}

Told told_here(const std::string& folder, const std::string& name) {
  const MeshResult read = load_mesh((std::filesystem::path(folder) / name).string());
  Told told = {name, read.error, {}};
  const auto [low, high] = box_of(read.mesh);
  for (size_t k = 0; k < 3; ++k) told.value[k] = static_cast<double>(high[k]) - static_cast<double>(low[k]);
  told.has_volume = read.report.watertight() && read.report.oriented();
  told.value[3] = surface_area(read.mesh);
  told.value[4] = signed_volume(read.mesh);
  told.value[5] = read.mesh.triangle_count() + read.report.degenerate_triangles;
  return told;
}

struct FilesOptions : VerifyOptions {
  std::string folder;
};

Options options_of(FilesOptions& o) {
  return {required({"FOLDER", &o.folder, "", "Mesh files, also in folders of it"}), json_option(o.json)};
}

int run(const FilesOptions& options) {
  if (!std::filesystem::is_directory(options.folder))
    throw cannot("read", options.folder, "it is no folder", "Name a folder of mesh files");
  constexpr double k_limit = 1e-3;  // relative
  std::vector<Verdict> rows;
  uint32_t refused = 0, both = 0;
  const std::vector<Told> others = told_by_trimesh(options.folder);
  Progress progress("reading", others.size());
  for (const Told& other : others) {
    if (interrupted()) return k_exit_interrupted;
    const Told here = told_here(options.folder, other.name);
    progress.done(rows.size() + 1);
    Verdict row = {other.name, "as trimesh reads it", "1", 0.0, 0.0, k_limit, true, false};
    if (!here.refused.empty()) {
      row.pass = !other.refused.empty();
      row.result = row.pass ? 0.0 : 1.0;
      std::printf("%-40s refused here%s: %s\n", other.name.c_str(), row.pass ? " and there" : "", here.refused.c_str());
      (row.pass ? both : refused) += 1;
    } else if (!other.refused.empty()) {
      std::printf("%-40s refused there: %s\n", other.name.c_str(), other.refused.c_str());
    } else {
      for (size_t k = 0; k < 6; ++k) {
        if (k == 4 && !here.has_volume) continue;
        // A surface with two sides encloses nothing, to the rounding of its places.
        const double box = other.value[0] * other.value[1] * other.value[2], least = k == 4 ? 1e-6 * box : 1e-30;
        const double scale = std::max(std::fabs(other.value[k]), least);
        const double apart = std::fabs(here.value[k] - std::fabs(other.value[k])) / scale;
        row.result = std::max(row.result, apart);
        if (apart > k_limit)
          std::printf("%-40s %-9s %12.6g here, %12.6g there\n", other.name.c_str(), k_names[k], here.value[k],
                      other.value[k]);
      }
      row.pass = row.result <= k_limit;
    }
    rows.push_back(row);
  }
  std::printf("%zu files: %u differ, of which %u are refused here alone; %u are refused by both\n", rows.size(),
              count_failed(rows), refused, both);
  if (!options.json.empty()) write_file(options.json, measurements_json(measurements_of("files", "", 1, rows)));
  return count_failed(rows) > 0 ? k_exit_check_failed : k_exit_done;
}

}  // namespace

Command verify_files_suite() {
  return command<FilesOptions>("files", "Mesh files of a folder: as the program reads them, and as trimesh does",
                               options_of, run);
}

}  // namespace sandglass::host
