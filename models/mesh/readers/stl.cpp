// STL, as text or binary. The format knows neither a unit nor which axis is up.
#include <algorithm>
#include <cctype>
#include <cstring>

#include "models/mesh/readers.h"
#include "models/mesh/words.h"

namespace sandglass::host {

namespace {

constexpr size_t k_header = 84, k_facet = 50;  // bytes

uint32_t given_facets(std::string_view file) {
  uint32_t count = 0;
  if (file.size() >= k_header) std::memcpy(&count, file.data() + k_header - 4, sizeof count);
  return count;
}

// In lower case.
bool is_word(std::string_view word, std::string_view lower) {
  return std::equal(word.begin(), word.end(), lower.begin(), lower.end(),
                    [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; });
}

std::string read_text(std::string_view file, FileMesh* mesh) {
  Words words = {file};
  size_t facets = 0, corners = 0;
  bool is_open = false, is_in_facet = false;
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    // A name may hold any words.
    const auto skip_line = [&] { words.at = std::min(file.find_first_of("\r\n", words.at), file.size()); };
    if (is_word(word, "solid") && !is_open) {
      is_open = true;
      skip_line();
    } else if (is_word(word, "facet") && is_open) {
      is_in_facet = true;
      corners = 0;
    } else if (is_word(word, "vertex") && is_in_facet) {
      for (int k = 0; k < 3; ++k) {
        const std::string_view place = words.next();
        double number = 0;
        if (place.empty()) return "ends within facet " + std::to_string(facets + 1) + ". Copy or export it again.";
        if (!number_of(place, &number))
          return "has \"" + std::string(place.substr(0, 20)) + "\" in facet " + std::to_string(facets + 1) +
                 " where a number must stand. Export it again.";
        mesh->vertices.push_back(number);
      }
      ++corners;
    } else if (is_word(word, "endfacet") && is_in_facet) {
      if (corners < 3)
        return "has a facet (" + std::to_string(facets + 1) + ") without three corners. Export it again.";
      std::vector<uint32_t> polygon(corners);
      for (size_t i = 0; i < corners; ++i) polygon[i] = static_cast<uint32_t>(mesh->vertices.size() / 3 - corners + i);
      add_polygon(polygon, mesh);
      is_in_facet = false;
      ++facets;
    } else if (is_word(word, "endsolid")) {
      is_open = false;
      skip_line();
    }
  }
  if (is_open) return "ends after " + std::to_string(facets) + " facets without \"endsolid\". Copy or export it again.";
  return "";
}

std::string read_binary(std::string_view file, FileMesh* mesh) {
  const size_t given = given_facets(file), there = (file.size() - k_header) / k_facet;
  if (there < given) return ends_after(there, given, "triangles");
  if (given > k_items_of_file / 3) return "has more than 11 million triangles. Simplify it.";
  for (size_t t = 0; t < given; ++t)
    for (size_t k = 0; k < 9; ++k) {
      float place;
      std::memcpy(&place, file.data() + k_header + k_facet * t + 12 + 4 * k, sizeof place);
      mesh->vertices.push_back(static_cast<double>(place));
      if (k % 3 == 0) mesh->indices.push_back(static_cast<uint32_t>(3 * t + k / 3));
    }
  if (file.size() > k_header + k_facet * given)
    mesh->left_out["bytes behind the last triangle"] = file.size() - k_header - k_facet * given;
  return "";
}

bool is_text_stl(std::string_view file) {
  const size_t first = file.find_first_not_of(" \t\r\n");
  const bool fits = file.size() >= k_header && file.size() == k_header + k_facet * uint64_t{given_facets(file)};
  const bool has_zeros = file.substr(0, 4096).find('\0') != std::string_view::npos;
  return first != std::string_view::npos && is_word(file.substr(first, 5), "solid") && !fits && !has_zeros;
}

// Binary files may begin with "solid" too: their size tells, or a byte that no text has.
Likeness likeness(std::string_view file, std::string_view) {
  const size_t given = given_facets(file);
  const bool has_zeros = file.substr(0, 4096).find('\0') != std::string_view::npos;
  if (is_text_stl(file)) return Likeness::sure;
  return has_zeros && given > 0 && file.size() >= k_header + k_facet && file.size() / k_facet / 4 <= given
             ? Likeness::some
             : Likeness::none;
}

std::string read(const MeshSource& source, FileMesh* mesh) {
  return is_text_stl(source.file) ? read_text(source.file, mesh) : read_binary(source.file, mesh);
}

}  // namespace

extern const MeshFormat k_stl = {"STL", ".stl", true, likeness, read};

}  // namespace sandglass::host
