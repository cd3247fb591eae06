#include "models/program/nearest_name.h"

#include <algorithm>
#include <filesystem>

#include "models/files/failure.h"
#include "models/mesh/generated.h"

namespace sandglass::host {

namespace {

// How many letters are wrong, missing, too many or swapped with their neighbour.
size_t distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<size_t>> d(a.size() + 1, std::vector<size_t>(b.size() + 1));
  for (size_t i = 0; i <= a.size(); ++i)
    for (size_t j = 0; j <= b.size(); ++j) {
      d[i][j] = i + j;
      if (i == 0 || j == 0) continue;
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

}  // namespace

std::string nearest_name(const std::string& word, const std::vector<std::string>& names) {
  constexpr size_t k_prefix = 3;  // so many letters are enough to tell names apart
  std::string nearest;
  size_t least = 2 + word.size() / 4;  // one more than the letters that may be wrong
  for (const std::string& name : names) {
    const bool begins = name.starts_with(word) && word.size() >= k_prefix + name.find_first_not_of('-');
    const size_t wrong = begins ? 1 : distance(word, name);
    if (wrong < least) least = wrong, nearest = name;
  }
  return nearest;
}

std::string suggestion(const std::string& word, const std::vector<std::string>& names) {
  const std::string nearest = nearest_name(word, names);
  return nearest.empty() ? "" : " Did you mean " + in_quotes(nearest) + "?";
}

std::string list_of(const std::vector<std::string>& names, const std::string& last) {
  std::string list;
  for (size_t i = 0; i < names.size(); ++i)
    list += (i == 0 ? "" : i + 1 < names.size() ? ", " : " " + last + " ") + names[i];
  return list;
}

MeshResult named_mesh(const std::string& name_or_file) {
  MeshResult result = make_named(name_or_file);
  if (result) return result;
  if (std::error_code error; !std::filesystem::exists(name_or_file, error))
    throw cannot("find", name_or_file, "no file and no generated mesh has this name",
                 "Name a mesh file, or " + list_of(mesh_names(), "or"));
  result = load_mesh(name_or_file);
  if (!result) throw Failure(result.error);
  return result;
}

}  // namespace sandglass::host
