// A glTF file as it lies there: its description, its buffers, which may be packed by meshoptimizer, and the numbers
// that its accessors name. Every number is checked before it is used. What they mean: gltf.cpp.
#pragma once

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "models/mesh/packed.h"
#include "models/mesh/readers.h"

namespace sandglass::host {

// Extensions that a file may require, because they are read here or change nothing that a collider or a shadow is of.
inline bool is_known_to_gltf(const std::string& name) {
  constexpr const char* k_read[] = {"KHR_mesh_quantization", "EXT_meshopt_compression", "EXT_mesh_gpu_instancing",
                                    "KHR_draco_mesh_compression", "KHR_node_visibility"};
  constexpr const char* k_appearance[] = {
      "KHR_texture_transform", "KHR_texture_basisu", "KHR_lights_punctual", "KHR_animation_pointer",
      "KHR_xmp_json_ld",       "EXT_texture_webp",   "EXT_texture_avif",    "EXT_texture_astc",
      "MSFT_texture_dds",      "MSFT_lod",           "EXT_lights_ies",      "EXT_lights_image_based",
      "KHR_techniques_webgl"};
  const auto is = [&](const char* other) { return name == other; };
  if (!reads_draco() && name == "KHR_draco_mesh_compression") return false;
  return std::any_of(std::begin(k_read), std::end(k_read), is) || name.starts_with("KHR_materials_") ||
         std::any_of(std::begin(k_appearance), std::end(k_appearance), is);
}

inline std::string percent_decoded(const std::string& text) {
  std::string out;
  for (size_t i = 0; i < text.size(); ++i) {
    const auto is_digit = [&](size_t k) {
      return k < text.size() && std::isxdigit(static_cast<unsigned char>(text[k]));
    };
    if (text[i] == '%' && is_digit(i + 1) && is_digit(i + 2)) {
      out += static_cast<char>(std::stoi(text.substr(i + 1, 2), nullptr, 16));
      i += 2;
    } else {
      out += text[i];
    }
  }
  return out;
}

inline std::string base64_decoded(std::string_view text) {
  constexpr std::string_view k_digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::array<int8_t, 256> value;
  value.fill(-1);
  for (size_t i = 0; i < k_digits.size(); ++i) value[static_cast<uint8_t>(k_digits[i])] = static_cast<int8_t>(i);
  std::string out;
  uint32_t bits = 0, count = 0;
  for (const char digit : text) {
    const int8_t v = value[static_cast<uint8_t>(digit)];
    if (v < 0) continue;  // the end, or white space
    bits = bits << 6 | static_cast<uint32_t>(v);
    if ((count += 6) >= 8) out += static_cast<char>(bits >> (count -= 8) & 255);
  }
  return out;
}

class GltfFile {
 protected:
  using Json = nlohmann::json;

  explicit GltfFile(const FileBeside& beside) : beside_(beside) {}

  // One sentence: the first fault.
  bool fail(const std::string& what, const std::string& help = "Export it again") {
    if (error_.empty()) error_ = what + ". " + help + ".";
    return false;
  }

  /* ---- numbers and lists of the description ---- */

  static const Json* find(const Json& in, const char* key) {
    if (!in.is_object()) return nullptr;
    const auto found = in.find(key);
    return found == in.end() ? nullptr : &*found;
  }
  static const Json* find(const Json& in, const char* extension, const char* key) {
    const Json* all = find(in, "extensions");
    const Json* object = all != nullptr ? find(*all, extension) : nullptr;
    return object == nullptr || key == nullptr ? object : find(*object, key);
  }
  static size_t size_of(const Json* list) { return list != nullptr && list->is_array() ? list->size() : 0; }

  // A whole number; what is left out keeps its value.
  template <class Number>
  bool whole(const Json& in, const char* key, Number* value, double highest = 4294967295.0) {
    const Json* found = find(in, key);
    if (found == nullptr) return true;
    const double number = found->is_number() ? found->get<double>() : -1.0;
    if (!(number >= 0.0 && number <= highest && number == std::floor(number)))
      return fail(std::string("has a \"") + key + "\" that is no whole number in its range");
    *value = static_cast<Number>(number);
    return true;
  }
  template <size_t count>
  bool numbers(const Json& in, const char* key, std::array<double, count>* values) {
    const Json* found = find(in, key);
    if (found == nullptr) return true;
    bool good = size_of(found) == count;
    for (size_t i = 0; good && i < count; ++i) {
      good = (*found)[i].is_number();
      if (good) (*values)[i] = (*found)[i].template get<double>();
    }
    return good || fail(std::string("has a \"") + key + "\" that is no list of " + std::to_string(count) + " numbers");
  }
  // Item `index` of a list of the file.
  const Json* item(const char* list, size_t index) {
    const Json* items = find(file_, list);
    if (index < size_of(items) && (*items)[index].is_object()) return &(*items)[index];
    fail(std::string("names number ") + std::to_string(index) + " of its \"" + list + "\", which is not there");
    return nullptr;
  }

  /* ---- the file ---- */

  bool open(std::string_view file) {
    const auto number = [&](size_t at) {
      uint32_t value = 0;
      if (at + 4 <= file.size()) std::memcpy(&value, file.data() + at, 4);
      return value;
    };
    constexpr uint32_t k_magic = 0x46546c67, k_json = 0x4e4f534a, k_binary = 0x004e4942;
    if (number(0) != k_magic) return parse(file);
    if (number(4) != 2) return fail("is of glTF version " + std::to_string(number(4)), "Export it as glTF 2.0");
    const uint32_t given = number(8);
    if (given > file.size())
      return fail("ends after " + std::to_string(file.size()) + " of " + std::to_string(given) + " bytes",
                  "Copy or export it again");
    bool has_description = false;
    for (size_t at = 12; at + 8 <= given;) {
      const uint32_t length = number(at), kind = number(at + 4);
      if (length > given - at - 8) return fail("ends within a chunk", "Copy or export it again");
      const std::string_view chunk = file.substr(at + 8, length);
      if (kind == k_json && !has_description) {
        has_description = true;
        if (!parse(chunk)) return false;
      }
      if (kind == k_binary && !binary_) binary_ = chunk;
      at += 8 + length;
    }
    return has_description || fail("has no description");
  }
  bool parse(std::string_view text) {
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    while (!text.empty() && text.back() == '\0') text.remove_suffix(1);
    file_ = Json::parse(text.begin(), text.end(), nullptr, false);
    return file_.is_object() || fail("has a description that is no JSON", "Copy or export it again");
  }
  bool is_readable() {
    const Json* asset = find(file_, "asset");
    const Json* version = asset != nullptr ? find(*asset, "version") : nullptr;
    if (version == nullptr || !version->is_string()) return fail("says no version of glTF");
    const std::string is = version->get<std::string>();
    if (!is.starts_with("2.")) return fail("is of glTF version " + is, "Export it as glTF 2.0");
    const Json* required = find(file_, "extensionsRequired");
    for (size_t i = 0; i < size_of(required); ++i) {
      const std::string name = (*required)[i].is_string() ? (*required)[i].get<std::string>() : "";
      if (!is_known_to_gltf(name))
        return fail("requires the extension \"" + name + "\", which is not read here", "Export it without");
    }
    return true;
  }

  /* ---- buffers ---- */

  bool buffer(size_t index, std::string_view* bytes) {
    const Json* described = item("buffers", index);
    uint64_t length = 0;
    if (described == nullptr || !whole(*described, "byteLength", &length, 1e15)) return false;
    const Json* uri = find(*described, "uri");
    if (uri == nullptr && index == 0 && binary_) {
      *bytes = *binary_;
    } else {
      if (uri == nullptr || !uri->is_string()) return fail("has a buffer without data");
      auto known = buffers_.find(index);
      if (known == buffers_.end()) {
        std::string content;
        if (!load(uri->get<std::string>(), &content)) return false;
        known = buffers_.emplace(index, std::move(content)).first;
      }
      *bytes = known->second;
    }
    if (bytes->size() < length)
      return fail(
          "has a buffer that ends after " + std::to_string(bytes->size()) + " of " + std::to_string(length) + " bytes",
          "Copy or export it again");
    *bytes = bytes->substr(0, length);
    return true;
  }
  bool load(const std::string& uri, std::string* content) {
    constexpr std::string_view k_base64 = ";base64,";
    if (uri.starts_with("data:")) {
      const size_t comma = uri.find(',');
      if (comma == std::string::npos) return fail("has a buffer that is damaged");
      const bool is_base64 = comma >= 7 && std::string_view(uri).substr(comma - 7, 8) == k_base64;
      *content =
          is_base64 ? base64_decoded(std::string_view(uri).substr(comma + 1)) : percent_decoded(uri.substr(comma + 1));
      return true;
    }
    if (beside_(uri, content) || beside_(percent_decoded(uri), content)) return true;
    return fail("needs the file \"" + percent_decoded(uri) + "\" beside it, which cannot be read",
                "Put it there, or export it as .glb, in one file");
  }
  // The bytes of a view, decoded.
  bool view(size_t index, std::string_view* bytes, size_t* stride) {
    const Json* described = item("bufferViews", index);
    if (described == nullptr || !whole(*described, "byteStride", stride, 252)) return false;
    const Json* packed = find(*described, "EXT_meshopt_compression", nullptr);
    const Json& where = packed != nullptr ? *packed : *described;
    size_t number = 0;
    uint64_t offset = 0, length = 0;
    std::string_view all;
    if (!whole(where, "buffer", &number) || !whole(where, "byteOffset", &offset, 1e15) ||
        !whole(where, "byteLength", &length, 1e15) || !buffer(number, &all))
      return false;
    if (offset > all.size() || length > all.size() - offset)
      return fail("has a buffer view that reaches beyond its buffer");
    *bytes = all.substr(offset, length);
    if (packed == nullptr) return true;
    auto known = unpacked_.find(index);
    if (known == unpacked_.end()) {
      MeshoptView asked;
      const Json* mode = find(*packed, "mode");
      const Json* filter = find(*packed, "filter");
      if (!whole(*packed, "count", &asked.count, k_items_of_file) || !whole(*packed, "byteStride", &asked.stride, 256))
        return false;
      if (mode != nullptr && mode->is_string()) asked.mode = mode->get<std::string>();
      if (filter != nullptr && filter->is_string()) asked.filter = filter->get<std::string>();
      std::string content;
      if (!unpack_meshopt(*bytes, asked, &content))
        return fail("has data packed by meshoptimizer that are damaged", "Pack it again");
      known = unpacked_.emplace(index, std::move(content)).first;
    }
    size_t packed_stride = 0;
    if (!whole(*packed, "byteStride", &packed_stride, 256)) return false;
    *bytes = known->second;
    *stride = packed_stride;
    return true;
  }

  /* ---- accessors ---- */

  struct Type {
    uint32_t code = 5126;  // float
    size_t bytes() const { return code <= 5121 ? 1 : code <= 5123 ? 2 : 4; }
    bool is_good() const { return (code >= 5120 && code <= 5123) || code == 5125 || code == 5126; }
    // A whole number that stands for a share of the most.
    double share(double value) const {
      constexpr double k_whole_max[4] = {127, 255, 32767, 65535};
      return code <= 5123 ? std::max(value / k_whole_max[code - 5120], -1.0) : value;
    }
    double read(const char* at) const {
      const auto as = [at](auto value) {
        std::memcpy(&value, at, sizeof value);
        return value;
      };
      switch (code) {
        case 5120:
          return as(int8_t{});
        case 5121:
          return as(uint8_t{});
        case 5122:
          return as(int16_t{});
        case 5123:
          return as(uint16_t{});
        case 5125:
          return as(uint32_t{});
        default:
          return static_cast<double>(as(float{}));
      }
    }
  };

  static bool is_normalised(const Json& accessor) {
    const Json* normalised = find(accessor, "normalized");
    return normalised != nullptr && normalised->is_boolean() && normalised->get<bool>();
  }

  // `count` items of `parts` numbers each.
  bool elements(const Json& where, Type type, bool normalised, size_t parts, size_t count, std::vector<double>* out) {
    size_t number = 0, stride = 0;
    uint64_t offset = 0;
    std::string_view bytes;
    if (!whole(where, "bufferView", &number) || !whole(where, "byteOffset", &offset, 1e15) ||
        !view(number, &bytes, &stride))
      return false;
    const size_t size = parts * type.bytes();
    if (stride == 0) stride = size;
    if (stride < size || (count > 0 && (offset > bytes.size() || stride * (count - 1) + size > bytes.size() - offset)))
      return fail("has an accessor that reaches beyond its data");
    out->resize(parts * count);
    for (size_t i = 0; i < count; ++i)
      for (size_t k = 0; k < parts; ++k)
        (*out)[parts * i + k] = type.read(bytes.data() + offset + stride * i + k * type.bytes());
    if (normalised)
      for (double& x : *out) x = type.share(x);
    return true;
  }

  bool accessor(size_t index, size_t parts, std::vector<double>* out) {
    const Json* a = item("accessors", index);
    Type type;
    size_t count = 0;
    if (a == nullptr || !whole(*a, "componentType", &type.code) || !whole(*a, "count", &count, k_items_of_file))
      return false;
    const Json* kind = find(*a, "type");
    const char* wanted = parts == 1 ? "SCALAR" : parts == 3 ? "VEC3" : parts == 4 ? "VEC4" : "MAT4";
    if (!type.is_good() || kind == nullptr || *kind != wanted) return fail("has an accessor of the wrong type");
    const bool shares = is_normalised(*a);
    numbers_ += parts * count;  // a list may be read many times over
    if (numbers_ > 16 * k_items_of_file) return fail("has more than 500 million numbers", "Simplify it");
    out->assign(parts * count, 0.0);
    if (find(*a, "bufferView") != nullptr && !elements(*a, type, shares, parts, count, out)) return false;
    const Json* sparse = find(*a, "sparse");
    if (sparse == nullptr) return true;
    const Json* places = find(*sparse, "indices");
    const Json* values = find(*sparse, "values");
    size_t changed = 0;
    Type place_type;
    std::vector<double> at, value;
    if (places == nullptr || values == nullptr || !whole(*sparse, "count", &changed, static_cast<double>(count)) ||
        !whole(*places, "componentType", &place_type.code) || !place_type.is_good())
      return fail("has a sparse accessor that is incomplete");
    if (!elements(*places, place_type, false, 1, changed, &at) ||
        !elements(*values, type, shares, parts, changed, &value))
      return false;
    for (size_t i = 0; i < changed; ++i) {
      if (!(at[i] >= 0 && at[i] < static_cast<double>(count)))
        return fail("has a sparse accessor that changes what is not there");
      std::copy_n(&value[parts * i], parts, &(*out)[parts * static_cast<size_t>(at[i])]);
    }
    return true;
  }

  const FileBeside& beside_;
  std::string error_;
  Json file_;
  size_t numbers_ = 0;
  std::optional<std::string_view> binary_;
  std::map<size_t, std::string> buffers_, unpacked_;
};

}  // namespace sandglass::host
