// PLY: vertices, and faces or triangle strips, as text or binary in either order of bytes. Other elements are passed
// over. The format knows neither a unit nor which axis is up.
#include <algorithm>
#include <cstring>

#include "models/mesh/readers.h"
#include "models/mesh/words.h"

namespace sandglass::host {

namespace {

struct Property {
  std::string name;
  char type = 0, count_type = 0;  // f and d for floats; b B h H i I for whole numbers; no count: not a list
};
struct Element {
  std::string name;
  size_t count = 0;
  std::vector<Property> properties;
};

char type_of(std::string_view name) {
  constexpr std::pair<std::string_view, char> k_types[] = {
      {"char", 'b'},   {"int8", 'b'},    {"uchar", 'B'},  {"uint8", 'B'},  {"short", 'h'}, {"int16", 'h'},
      {"ushort", 'H'}, {"uint16", 'H'},  {"int", 'i'},    {"int32", 'i'},  {"uint", 'I'},  {"uint32", 'I'},
      {"float", 'f'},  {"float32", 'f'}, {"double", 'd'}, {"float64", 'd'}};
  for (const auto& [known, type] : k_types)
    if (known == name) return type;
  return 0;
}

size_t bytes_of(char type) {
  return type == 'b' || type == 'B' ? 1 : type == 'h' || type == 'H' ? 2 : type == 'd' ? 8 : 4;
}

class Ply {
 public:
  Ply(std::string_view file, FileMesh* mesh) : file_(file), mesh_(*mesh) {}

  std::string read() {
    if (std::string error = read_header(); !error.empty()) return error;
    bool has_vertices = false;
    for (const Element& element : elements_) {
      std::vector<double> row, list;
      size_t place[3] = {};
      const bool is_vertex = element.name == "vertex", is_strip = element.name == "tristrips";
      const bool is_face = element.name == "face";
      for (size_t k = 0; is_vertex && k < 3; ++k) {
        const char name[] = {static_cast<char>('x' + k), 0};
        const auto found = std::find_if(element.properties.begin(), element.properties.end(),
                                        [&](const Property& p) { return p.name == name && p.count_type == 0; });
        if (found == element.properties.end())
          return std::string("has vertices without ") + name + ". Export it again.";
        place[k] = static_cast<size_t>(found - element.properties.begin());
      }
      if ((is_face || is_strip) && !has_vertices && element.count > 0)
        return "has faces before its vertices. Export it again.";
      has_vertices = has_vertices || is_vertex;
      const size_t bytes_min = row_bytes_min(element);
      if (element.count > k_items_of_file || (bytes_min > 0 && element.count > (file_.size() - at_) / bytes_min))
        return ends_after(bytes_min > 0 ? (file_.size() - at_) / bytes_min : 0, element.count,
                          is_vertex ? "vertices"
                          : is_face ? "faces"
                                    : "rows");
      for (size_t i = 0; i < element.count; ++i) {
        row.assign(element.properties.size(), 0.0);
        for (size_t p = 0; p < element.properties.size(); ++p) {
          const Property& property = element.properties[p];
          const bool is_corners = property.name == "vertex_indices" || property.name == "vertex_index";
          if (property.count_type == 0) {
            if (!value(property.type, &row[p])) return broken(i, element);
            continue;
          }
          double count = 0, item = 0;
          if (!value(property.count_type, &count) || !(count >= 0)) return broken(i, element);
          list.clear();
          for (double k = 0; k < count; ++k) {
            if (!value(property.type, &item)) return broken(i, element);
            if (is_corners) list.push_back(item);
          }
          if (!is_corners || !(is_face || is_strip)) continue;
          if (!(is_strip ? add_strips(list) : add_face(list)))
            return "has a face (" + std::to_string(i) + ") with a vertex that is not there; it has " +
                   std::to_string(mesh_.vertices.size() / 3) + ". Export it again.";
        }
        for (size_t k = 0; is_vertex && k < 3; ++k) mesh_.vertices.push_back(row[place[k]]);
        if (is_text_) end_line();
      }
      if (!is_vertex && !is_face && !is_strip && element.count > 0)
        mesh_.left_out["rows of \"" + element.name + "\""] += element.count;
    }
    return "";
  }

 private:
  std::string read_header() {
    bool has_format = false;
    // As its first line ends: the data may begin with any byte.
    const std::string_view line_end = file_.substr(3, 2) == "\r\n" ? "\r\n" : file_.substr(3, 1);
    for (;;) {
      const size_t end = file_.find(line_end, at_);
      if (end == std::string_view::npos) return "ends within its header. Copy or export it again.";
      Words words = {file_.substr(at_, end - at_)};
      at_ = end + line_end.size();
      const std::string_view keyword = words.next(), first = words.next(), second = words.next();
      if (keyword == "end_header") break;
      if (keyword == "format") {
        has_format = true;
        is_text_ = first == "ascii";
        is_big_ = first == "binary_big_endian";
        if (!is_text_ && !is_big_ && first != "binary_little_endian")
          return "is of the unknown format \"" + std::string(first.substr(0, 40)) + "\". Export it again.";
      } else if (keyword == "element") {
        double count = -1;
        if (!number_of(second, &count) || !(count >= 0 && count < 1e15))
          return "has an element without a count. Export it again.";
        elements_.push_back({std::string(first), static_cast<size_t>(count), {}});
      } else if (keyword == "property" && !elements_.empty()) {
        Property property;
        if (first == "list") {
          property.count_type = type_of(second);
          property.type = type_of(words.next());
          property.name = words.next();
        } else {
          property.type = type_of(first);
          property.name = second;
        }
        if (property.type == 0 || (first == "list" && property.count_type == 0) || property.name.empty())
          return "has a property of an unknown type in its header. Export it again.";
        elements_.back().properties.push_back(property);
      }
    }
    return has_format ? "" : "says no format. Export it again.";
  }
  // That one row takes; text has a digit and a space for each value.
  size_t row_bytes_min(const Element& element) const {
    size_t bytes = 0;
    for (const Property& p : element.properties)
      bytes += is_text_ ? 2 : bytes_of(p.count_type != 0 ? p.count_type : p.type);
    return bytes > 0 && is_text_ ? bytes - 1 : bytes;  // the last value may end the file
  }
  bool value(char type, double* out) {
    if (is_text_) {
      Words words = {file_, at_};
      bad_ = words.next();
      at_ = words.at;
      return number_of(bad_, out);
    }
    const size_t size = bytes_of(type);
    if (at_ > file_.size() || file_.size() - at_ < size) return false;
    char bytes[8];
    std::memcpy(bytes, file_.data() + at_, size);
    at_ += size;
    if (is_big_) std::reverse(bytes, bytes + size);
    const auto as = [&bytes](auto number) {
      std::memcpy(&number, bytes, sizeof number);
      return static_cast<double>(number);
    };
    *out = type == 'b'   ? as(int8_t{})
           : type == 'B' ? as(uint8_t{})
           : type == 'h' ? as(int16_t{})
           : type == 'H' ? as(uint16_t{})
           : type == 'i' ? as(int32_t{})
           : type == 'I' ? as(uint32_t{})
           : type == 'f' ? as(float{})
                         : as(double{});
    return true;
  }
  // A row has a line of its own. Some programs write more into it than their header says.
  void end_line() {
    const size_t end = std::min(file_.find_first_of("\r\n", at_), file_.size());
    Words words = {file_.substr(at_, end - at_)};
    for (std::string_view word = words.next(); !word.empty(); word = words.next())
      ++mesh_.left_out["values that its header does not name"];
    at_ = end;
  }
  std::string broken(size_t row, const Element& element) const {
    const char* what = element.name == "vertex" ? "vertices" : element.name == "face" ? "faces" : "rows";
    if (!is_text_ || bad_.empty()) return ends_after(row, element.count, what);
    return "has \"" + std::string(bad_.substr(0, 20)) + "\" among its " + what +
           " where a number must stand. Export it again.";
  }
  bool corner(double value, uint32_t* out) const {
    if (!(value >= 0 && value < static_cast<double>(mesh_.vertices.size() / 3))) return false;
    *out = static_cast<uint32_t>(value);
    return true;
  }
  bool add_face(const std::vector<double>& list) {
    std::vector<uint32_t> corners(list.size());
    for (size_t i = 0; i < list.size(); ++i)
      if (!corner(list[i], &corners[i])) return false;
    if (corners.size() >= 3) add_polygon(corners, &mesh_);
    else ++mesh_.left_out["faces of fewer than three corners"];
    return mesh_.indices.size() <= k_items_of_file;
  }
  // Each of a row: every corner from the third on makes a triangle with the two before it, every second one turned; a
  // negative one begins anew.
  bool add_strips(const std::vector<double>& list) {
    size_t first = 0;
    for (size_t i = 0; i < list.size(); ++i) {
      if (list[i] < 0) {
        first = i + 1;
      } else if (i >= first + 2) {
        uint32_t a, b, c;
        if (!corner(list[i - 2], &a) || !corner(list[i - 1], &b) || !corner(list[i], &c)) return false;
        if ((i - first) % 2 != 0) std::swap(a, b);
        mesh_.indices.insert(mesh_.indices.end(), {a, b, c});
      }
    }
    return true;
  }

  std::string_view file_, bad_;
  FileMesh& mesh_;
  size_t at_ = 0;
  bool is_text_ = false, is_big_ = false;
  std::vector<Element> elements_;
};

Likeness likeness(std::string_view, std::string_view text) {
  return text.starts_with("ply\n") || text.starts_with("ply\r") ? Likeness::sure : Likeness::none;
}

std::string read(const MeshSource& source, FileMesh* mesh) { return Ply(source.file, mesh).read(); }

}  // namespace

extern const MeshFormat k_ply = {"PLY", ".ply", true, likeness, read};

}  // namespace sandglass::host
