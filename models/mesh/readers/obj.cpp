// Wavefront OBJ: its places and faces. The format knows neither a unit nor which axis is up.
#include "models/mesh/readers.h"
#include "models/mesh/words.h"

namespace sandglass::host {

// The first number of "7", "7/1", "7//3" or "7/1/3". Below 0 it counts from the last vertex on.
static bool corner_of(std::string_view word, size_t vertices, uint32_t* corner) {
  double number = 0;
  if (!number_of(word.substr(0, word.find('/')), &number) || number != std::floor(number)) return false;
  const double count = static_cast<double>(vertices), index = number < 0 ? count + number : number - 1;
  if (!(index >= 0 && index < count)) return false;
  *corner = static_cast<uint32_t>(index);
  return true;
}

// Words that an OBJ may begin with; one of its first lines is a place.
static Likeness likeness(std::string_view file, std::string_view) {
  constexpr size_t k_lines = 10000;
  Words lines = {file};
  std::string line;
  for (size_t i = 0; i < k_lines && lines.line(&line); ++i) {
    Words words = {line};
    const std::string_view keyword = words.next();
    double number = 0;
    if ((keyword == "v" || keyword == "vn" || keyword == "vt") && number_of(words.next(), &number))
      return Likeness::some;
    if (line.find('\0') != std::string::npos) break;
  }
  return Likeness::none;
}

static std::string read(const MeshSource& source, FileMesh* mesh) {
  std::string_view file = source.file;
  if (file.starts_with("\xEF\xBB\xBF")) file.remove_prefix(3);
  Words lines = {file};
  std::string line;
  std::vector<uint32_t> corners;
  for (size_t number = 1; lines.line(&line); ++number) {
    Words words = {line};
    const std::string_view keyword = words.next();
    // A file that is cut off within a line may still parse, without its last face or vertex.
    const bool is_cut = lines.at > file.size();
    const auto wrong = [&](const std::string& what) {
      return is_cut ? "is cut off in its last line. Copy or export it again."
                    : "has " + what + " in line " + std::to_string(number) + ". Export it again.";
    };
    if (keyword == "v") {
      for (int k = 0; k < 3; ++k) {
        const std::string_view word = words.next();
        double place = 0;
        if (!number_of(word, &place)) return is_cut ? wrong("") : no_number(word, number);
        mesh->vertices.push_back(place);
      }
    } else if (keyword == "f") {
      corners.clear();
      for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
        uint32_t corner = 0;
        if (!corner_of(word, mesh->vertices.size() / 3, &corner))
          return wrong("a face with the corner \"" + std::string(word.substr(0, 20)) + "\", which is no vertex of it,");
        corners.push_back(corner);
      }
      if (corners.size() >= 3) add_polygon(corners, mesh);
      else if (is_cut) return wrong("");
      else ++mesh->left_out["faces of fewer than three corners"];
    } else if (keyword == "l" || keyword == "p") {
      ++mesh->left_out[keyword == "l" ? "lines" : "points"];
    } else if (keyword == "curv" || keyword == "curv2" || keyword == "surf") {
      ++mesh->left_out["curves and curved surfaces"];
    } else if (keyword == "usemtl") {
      ++mesh->left_out["uses of materials"];
    } else if (is_cut && keyword == "vn" && (words.next(), words.next(), words.next()).empty()) {
      return wrong("");
    }
    if (mesh->vertices.size() > 3 * k_items_of_file || mesh->indices.size() > k_items_of_file)
      return "has more than 33 million vertices or corners. Simplify it.";
  }
  return "";
}

extern const MeshFormat k_obj = {"OBJ", ".obj", true, likeness, read};

}  // namespace sandglass::host
