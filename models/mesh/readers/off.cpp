// OFF as text, with or without normals, colours and texture coordinates behind each place.
#include "models/mesh/readers.h"
#include "models/mesh/words.h"

namespace sandglass::host {

static Likeness likeness(std::string_view, std::string_view text) {
  const std::string_view word = Words{text}.next();
  const size_t kind = word.find("OFF");
  const bool is_off =
      kind != std::string_view::npos && word.substr(0, kind).find_first_not_of("STCN4n") == std::string_view::npos;
  return is_off ? Likeness::sure : Likeness::none;
}

static std::string read(const MeshSource& source, FileMesh* mesh) {
  Words lines = {source.file};
  std::string line;
  size_t number = 0;
  const auto next = [&] {  // the next line that is not empty
    while (lines.line(&line)) {
      ++number;
      if (line.find_first_not_of(" \t\f\v") != std::string::npos) return true;
    }
    return false;
  };
  if (!next()) return "is empty. Export it again.";
  const size_t kind = line.find("OFF");
  if (line.find("BINARY") != std::string::npos || line.substr(0, kind).find_first_of("4n") != std::string::npos)
    return "is OFF in binary or in other than three dimensions. Export it as OFF text, " + offered_formats() + ".";
  line.erase(0, kind + 3);  // the counts may stand behind it
  if (line.find_first_not_of(" \t\f\v") == std::string::npos && !next())
    return "ends in its first line. Copy or export it again.";
  Words words = {line};
  double counts[2] = {};
  for (double& count : counts) {
    const std::string_view word = words.next();
    if (!number_of(word, &count)) return no_number(word, number);
    if (!(count >= 0 && count <= static_cast<double>(k_items_of_file / 3)))
      return "says that it has " + std::string(word) + " vertices or faces. At most 11 million are read: simplify it.";
  }
  const size_t vertices = static_cast<size_t>(counts[0]), faces = static_cast<size_t>(counts[1]);
  for (size_t i = 0; i < vertices; ++i) {
    if (!next()) return ends_after(i, vertices, "vertices");
    words = {line};
    for (int k = 0; k < 3; ++k) {
      const std::string_view word = words.next();
      double place = 0;
      if (!number_of(word, &place)) return no_number(word, number);
      mesh->vertices.push_back(place);
    }
  }
  std::vector<uint32_t> corners;
  for (size_t f = 0; f < faces; ++f) {
    if (!next()) return ends_after(f, faces, "faces");
    words = {line};
    double count = 0, corner = 0;
    const std::string_view first = words.next();
    if (!number_of(first, &count)) return no_number(first, number);
    corners.clear();
    for (double k = 0; k < count; ++k) {
      const std::string_view word = words.next();
      if (word.empty()) return f + 1 == faces ? ends_after(f, faces, "faces") : no_number(word, number);
      if (!number_of(word, &corner)) return no_number(word, number);
      if (!(corner >= 0 && corner < counts[0]))
        return "has a face with vertex " + std::string(word) + " in line " + std::to_string(number) + ", but only " +
               std::to_string(vertices) + " vertices. Export it again.";
      corners.push_back(static_cast<uint32_t>(corner));
    }
    if (corners.size() >= 3) add_polygon(corners, mesh);
    else ++mesh->left_out["faces of fewer than three corners"];
  }
  return "";
}

extern const MeshFormat k_off = {"OFF", ".off", false, likeness, read};

}  // namespace sandglass::host
