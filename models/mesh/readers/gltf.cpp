// glTF 2.0: the triangles of the default scene, in metres with y up, as the format defines where they stand: nodes, the
// default pose of skins and morphs, and instances. Buffers may be quantised, sparse, or packed by meshoptimizer or Draco.
// Every number of the file is checked before it is used.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "models/geometry/vec3.h"
#include "models/mesh/packed.h"
#include "models/mesh/readers.h"
#include "models/mesh/readers/gltf_file.h"

namespace sandglass::host {

namespace {

using Json = nlohmann::json;

constexpr int k_triangles = 4, k_strip = 5, k_fan = 6;

// Column by column. The last row is 0 0 0 1 and not kept.
struct Placement {
  Vec3 x = {1, 0, 0}, y = {0, 1, 0}, z = {0, 0, 1}, origin;

  Vec3 direction(Vec3 v) const { return x * v.x + y * v.y + z * v.z; }
  Vec3 place(Vec3 v) const { return direction(v) + origin; }
  Placement operator*(const Placement& b) const {
    return {direction(b.x), direction(b.y), direction(b.z), place(b.origin)};
  }
  bool is_mirrored() const { return dot(cross(x, y), z) < 0; }
};

Placement placement_of(const double* m) {
  return {{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}, {m[12], m[13], m[14]}};
}

Placement placement_of(Vec3 translation, const Quaternion& rotation, Vec3 scale) {
  return {rotate(rotation, {scale.x, 0, 0}), rotate(rotation, {0, scale.y, 0}), rotate(rotation, {0, 0, scale.z}),
          translation};
}

class Gltf : private GltfFile {
 public:
  Gltf(const FileBeside& beside, FileMesh* mesh) : GltfFile(beside), mesh_(*mesh) {}

  std::string read(std::string_view file) {
    if (open(file) && is_readable() && find_parents() && add_scene()) count_left_out();
    return error_;
  }

 private:
  /* ---- meshes ---- */

  // The attributes of a primitive, from its accessors or from what Draco packed.
  struct Source {
    const Json& primitive;
    const Json* packed_names = nullptr;
    DracoMesh packed;
  };
  bool attribute(const Source& from, const std::string& name, size_t parts, std::vector<double>* out) {
    const Json* names = find(from.primitive, "attributes");
    const Json* number = from.packed_names != nullptr ? find(*from.packed_names, name.c_str()) : nullptr;
    if (number != nullptr) {
      uint32_t id = 0;
      if (!whole(*from.packed_names, name.c_str(), &id)) return false;
      bool is_share = false;
      if (!draco_attribute(from.packed, id, parts, out, &is_share))
        return fail("has data packed by Draco that are damaged", "Pack it again");
      size_t index = 0;
      if (names == nullptr || !whole(*names, name.c_str(), &index)) return false;
      const Json* described = item("accessors", index);
      Type type;
      if (described == nullptr || !whole(*described, "componentType", &type.code) || !type.is_good()) return false;
      if (is_normalised(*described) && !is_share)
        for (double& x : *out) x = type.share(x);
      return true;
    }
    out->clear();
    if (names == nullptr || find(*names, name.c_str()) == nullptr) return true;
    size_t index = 0;
    return whole(*names, name.c_str(), &index) && accessor(index, parts, out);
  }
  bool corners(const Source& from, size_t vertices, std::vector<uint32_t>* out) {
    if (from.packed_names != nullptr) {
      draco_triangles(from.packed, out);
    } else if (find(from.primitive, "indices") != nullptr) {
      size_t index = 0;
      std::vector<double> listed;
      if (!whole(from.primitive, "indices", &index) || !accessor(index, 1, &listed)) return false;
      for (const double i : listed) out->push_back(i >= 0 && i < 4294967295.0 ? static_cast<uint32_t>(i) : 0xffffffffu);
    } else {
      for (uint32_t i = 0; i < vertices; ++i) out->push_back(i);
    }
    for (const uint32_t corner : *out)
      if (corner >= vertices)
        return fail("has a triangle with vertex " + std::to_string(corner) + ", but only " + std::to_string(vertices));
    return true;
  }

  bool add_morphs(const Json& primitive, const std::vector<double>& weights, std::vector<double>* places) {
    const Json* targets = find(primitive, "targets");
    for (size_t t = 0; t < std::min(size_of(targets), weights.size()); ++t) {
      if (weights[t] == 0.0 || find((*targets)[t], "POSITION") == nullptr) continue;
      size_t index = 0;
      std::vector<double> moves;
      if (!whole((*targets)[t], "POSITION", &index) || !accessor(index, 3, &moves)) return false;
      if (moves.size() != places->size()) return fail("has a morph target of another size than its mesh");
      for (size_t i = 0; i < moves.size(); ++i) (*places)[i] += weights[t] * moves[i];
    }
    return true;
  }

  // Where each vertex goes by the joints that hold it.
  bool skinned(const Source& from, const std::vector<Placement>& joints, size_t vertices, std::vector<Placement>* out) {
    std::vector<double> total(vertices, 0.0);
    out->assign(vertices, {{}, {}, {}, {}});
    for (int set = 0;; ++set) {
      std::vector<double> names, weights;
      const std::string number = std::to_string(set);
      if (!attribute(from, "JOINTS_" + number, 4, &names) || !attribute(from, "WEIGHTS_" + number, 4, &weights))
        return false;
      if (names.empty() && weights.empty()) break;
      if (names.size() != 4 * vertices || weights.size() != 4 * vertices)
        return fail("has a skin of another size than its mesh");
      for (size_t i = 0; i < names.size(); ++i) {
        if (weights[i] == 0.0) continue;
        if (!(names[i] >= 0 && names[i] < static_cast<double>(joints.size())))
          return fail("has a skin with a joint that is not there");
        const Placement& joint = joints[static_cast<size_t>(names[i])];
        Placement& sum = (*out)[i / 4];
        sum = {sum.x + joint.x * weights[i], sum.y + joint.y * weights[i], sum.z + joint.z * weights[i],
               sum.origin + joint.origin * weights[i]};
        total[i / 4] += weights[i];
      }
    }
    for (size_t v = 0; v < vertices; ++v) {
      if (!(total[v] > 0)) return fail("has a vertex whose skin weighs nothing");
      const double s = 1 / total[v];
      Placement& p = (*out)[v];
      p = {p.x * s, p.y * s, p.z * s, p.origin * s};
    }
    return true;
  }

  // `joints`: nothing for a mesh without a skin, which stands at each of `places`.
  bool add_primitive(const Json& primitive, const std::vector<double>& weights, const std::vector<Placement>& places,
                     const std::vector<Placement>& joints) {
    int mode = k_triangles;
    if (!whole(primitive, "mode", &mode, 6)) return false;
    if (mode < k_triangles) {
      ++mesh_.left_out[mode == 0 ? "sets of points" : "sets of lines"];
      return true;
    }
    Source from = {primitive, nullptr, {}};
    if (const Json* packed = reads_draco() ? find(primitive, "KHR_draco_mesh_compression", nullptr) : nullptr) {
      size_t number = 0, stride = 0;
      std::string_view bytes;
      from.packed_names = find(*packed, "attributes");
      if (from.packed_names == nullptr || !whole(*packed, "bufferView", &number) || !view(number, &bytes, &stride))
        return fail("has data packed by Draco that are incomplete");
      if (!unpack_draco(bytes, &from.packed)) return fail("has data packed by Draco that are damaged", "Pack it again");
      mode = k_triangles;
    }
    std::vector<double> own;
    std::vector<uint32_t> listed;
    if (!attribute(from, "POSITION", 3, &own)) return false;
    const size_t vertices = own.size() / 3;
    if (!corners(from, vertices, &listed) || !add_morphs(primitive, weights, &own)) return false;
    std::vector<Placement> held;
    if (!joints.empty() && !skinned(from, joints, vertices, &held)) return false;
    const size_t triangles = mode == k_triangles ? listed.size() / 3 : listed.size() < 3 ? 0 : listed.size() - 2;
    for (const Placement& place : places) {
      const size_t first = mesh_.vertices.size() / 3;
      if (first + vertices > k_items_of_file || mesh_.indices.size() + 3 * triangles > k_items_of_file)
        return fail("has more than 33 million vertices or corners", "Simplify it");
      for (size_t v = 0; v < vertices; ++v) {
        const Vec3 p = (held.empty() ? place : held[v]).place({own[3 * v], own[3 * v + 1], own[3 * v + 2]});
        mesh_.vertices.insert(mesh_.vertices.end(), {p.x, p.y, p.z});
      }
      for (size_t t = 0; t < triangles; ++t) {
        // A strip turns every second triangle; a mirrored one is seen from its other side.
        std::array<size_t, 3> at = {3 * t, 3 * t + 1, 3 * t + 2};
        if (mode == k_strip) at = {t, t + 1 + t % 2, t + 2 - t % 2};
        if (mode == k_fan) at = {0, t + 1, t + 2};
        if ((held.empty() ? place : held[listed[at[0]]]).is_mirrored()) std::swap(at[1], at[2]);
        for (const size_t k : at) mesh_.indices.push_back(static_cast<uint32_t>(first + listed[k]));
      }
    }
    return true;
  }

  /* ---- the scene ---- */

  // A list of nodes' numbers; none where it is left out.
  bool nodes_of(const Json& in, const char* key, std::vector<size_t>* nodes) {
    const Json* listed = find(in, key);
    for (size_t i = 0; i < size_of(listed); ++i) {
      const double number = (*listed)[i].is_number() ? (*listed)[i].get<double>() : -1;
      if (!(number >= 0 && number < static_cast<double>(parents_.size())))
        return fail(std::string("names a node in its \"") + key + "\" that is not there");
      nodes->push_back(static_cast<size_t>(number));
    }
    return true;
  }

  // Every node has at most one node above it; a chain that never ends at a root is refused.
  bool find_parents() {
    const Json* nodes = find(file_, "nodes");
    parents_.assign(size_of(nodes), k_none);
    for (size_t n = 0; n < parents_.size(); ++n) {
      std::vector<size_t> children;
      if (!nodes_of((*nodes)[n], "children", &children)) return false;
      for (const size_t child : children) {
        if (parents_[child] != k_none) return fail("has a node that stands below two others");
        parents_[child] = n;
      }
    }
    placements_.assign(parents_.size(), std::nullopt);
    return true;
  }
  bool own_placement(const Json& node, Placement* placement) {
    std::array<double, 3> translation = {0, 0, 0}, scale = {1, 1, 1};
    std::array<double, 4> rotation = {0, 0, 0, 1};
    std::array<double, 16> matrix;
    if (find(node, "matrix") != nullptr) {
      if (!numbers(node, "matrix", &matrix)) return false;
      *placement = placement_of(matrix.data());
      return true;
    }
    if (!numbers(node, "translation", &translation) || !numbers(node, "rotation", &rotation) ||
        !numbers(node, "scale", &scale))
      return false;
    *placement = placement_of({translation[0], translation[1], translation[2]}, normalised(Quaternion(rotation)),
                              {scale[0], scale[1], scale[2]});
    return true;
  }
  // With those of the nodes above it.
  bool placement(size_t node, Placement* out) {
    std::vector<size_t> chain;
    size_t at = node;
    while (at != k_none && !placements_[at]) {
      chain.push_back(at);
      if (chain.size() > parents_.size()) return fail("has a node that stands below itself");
      at = parents_[at];
    }
    Placement above = at == k_none ? Placement{} : *placements_[at];
    for (size_t i = chain.size(); i-- > 0;) {
      const Json* described = item("nodes", chain[i]);
      Placement own;
      if (described == nullptr || !own_placement(*described, &own)) return false;
      above = above * own;
      placements_[chain[i]] = above;
    }
    *out = above;
    return true;
  }

  bool instances(const Json& node, const Placement& place, std::vector<Placement>* out) {
    const Json* attributes = find(node, "EXT_mesh_gpu_instancing", "attributes");
    if (attributes == nullptr) {
      *out = {place};
      return true;
    }
    std::vector<double> translations, rotations, scales;
    const auto read = [&](const char* name, size_t parts, std::vector<double>* values) {
      size_t index = 0;
      return find(*attributes, name) == nullptr || (whole(*attributes, name, &index) && accessor(index, parts, values));
    };
    if (!read("TRANSLATION", 3, &translations) || !read("ROTATION", 4, &rotations) || !read("SCALE", 3, &scales))
      return false;
    const size_t count = std::max({translations.size() / 3, rotations.size() / 4, scales.size() / 3});
    const auto fits = [count](const std::vector<double>& values, size_t parts) {
      return values.empty() || values.size() == parts * count;
    };
    if (!fits(translations, 3) || !fits(rotations, 4) || !fits(scales, 3))
      return fail("has instances with lists of different lengths");
    for (size_t i = 0; i < count; ++i) {
      const auto three = [i](const std::vector<double>& v, Vec3 none) {
        return v.empty() ? none : Vec3{v[3 * i], v[3 * i + 1], v[3 * i + 2]};
      };
      Quaternion turn = k_no_rotation;
      if (!rotations.empty())
        turn =
            normalised(Quaternion{rotations[4 * i], rotations[4 * i + 1], rotations[4 * i + 2], rotations[4 * i + 3]});
      out->push_back(place * placement_of(three(translations, {}), turn, three(scales, {1, 1, 1})));
    }
    return true;
  }

  bool joints_of(const Json& node, std::vector<Placement>* joints) {
    size_t number = 0;
    if (find(node, "skin") == nullptr) return true;
    if (!whole(node, "skin", &number)) return false;
    const Json* skin = item("skins", number);
    std::vector<size_t> nodes;
    if (skin == nullptr || !nodes_of(*skin, "joints", &nodes)) return false;
    if (nodes.empty()) return fail("has a skin without joints");
    std::vector<double> inverse;
    if (find(*skin, "inverseBindMatrices") != nullptr) {
      size_t index = 0;
      if (!whole(*skin, "inverseBindMatrices", &index) || !accessor(index, 16, &inverse)) return false;
      if (inverse.size() < 16 * nodes.size()) return fail("has a skin with fewer matrices than joints");
    }
    for (size_t j = 0; j < nodes.size(); ++j) {
      Placement place;
      if (!placement(nodes[j], &place)) return false;
      joints->push_back(inverse.empty() ? place : place * placement_of(&inverse[16 * j]));
    }
    return true;
  }

  bool add_node(size_t number) {
    const Json* node = item("nodes", number);
    if (node == nullptr) return false;
    if (find(*node, "mesh") == nullptr) return true;
    size_t index = 0;
    Placement place;
    std::vector<Placement> places, joints;
    if (!whole(*node, "mesh", &index) || !placement(number, &place) || !instances(*node, place, &places) ||
        !joints_of(*node, &joints))
      return false;
    const Json* described = item("meshes", index);
    if (described == nullptr) return false;
    const Json* listed = find(*node, "weights") != nullptr ? find(*node, "weights") : find(*described, "weights");
    std::vector<double> weights;
    for (size_t i = 0; i < size_of(listed); ++i)
      weights.push_back((*listed)[i].is_number() ? (*listed)[i].get<double>() : 0.0);
    const Json* primitives = find(*described, "primitives");
    for (size_t p = 0; p < size_of(primitives); ++p)
      if (!add_primitive((*primitives)[p], weights, places, joints)) return false;
    return true;
  }

  bool add_scene() {
    std::vector<size_t> open;
    if (find(file_, "scenes") == nullptr) {
      for (size_t n = 0; n < parents_.size(); ++n)
        if (parents_[n] == k_none) open.push_back(n);
    } else {
      size_t index = 0;
      if (!whole(file_, "scene", &index)) return false;
      const Json* scene = item("scenes", index);
      if (scene == nullptr || !nodes_of(*scene, "nodes", &open)) return false;
    }
    std::reverse(open.begin(), open.end());
    std::vector<bool> is_done(parents_.size(), false);
    while (!open.empty()) {
      const size_t node = open.back();
      open.pop_back();
      if (is_done[node]) return fail("has a node that stands in its scene twice");
      is_done[node] = true;
      if (const Json* shown = find((*find(file_, "nodes"))[node], "KHR_node_visibility", "visible"); shown != nullptr) {
        if (!shown->is_boolean()) return fail("has a \"visible\" that is neither true nor false");
        if (!shown->get<bool>()) {  // nor is what stands below it
          ++mesh_.left_out["hidden nodes"];
          continue;
        }
      }
      if (!add_node(node)) return false;
      std::vector<size_t> children;
      nodes_of((*find(file_, "nodes"))[node], "children", &children);
      open.insert(open.end(), children.rbegin(), children.rend());
    }
    return true;
  }

  void count_left_out() {
    for (const char* name : {"materials", "animations", "cameras"})
      if (const size_t count = size_of(find(file_, name))) mesh_.left_out[name] += count;
    if (const size_t count = size_of(find(file_, "KHR_lights_punctual", "lights"))) mesh_.left_out["lights"] += count;
  }

  static constexpr size_t k_none = SIZE_MAX;
  FileMesh& mesh_;
  std::vector<size_t> parents_;
  std::vector<std::optional<Placement>> placements_;
};

// The binary one, or JSON with an object "asset", which every glTF has.
Likeness likeness(std::string_view file, std::string_view text) {
  constexpr std::string_view k_space = " \t\r\n", k_name = "\"asset\"";
  if (text.starts_with("glTF")) return Likeness::sure;
  if (!text.starts_with("{")) return Likeness::none;
  for (size_t at = file.find(k_name); at != std::string_view::npos; at = file.find(k_name, at + 1)) {
    const size_t colon = file.find_first_not_of(k_space, at + k_name.size());
    if (colon == std::string_view::npos || file[colon] != ':') continue;
    const size_t value = file.find_first_not_of(k_space, colon + 1);
    if (value != std::string_view::npos && file[value] == '{') return Likeness::sure;
  }
  return Likeness::none;
}

std::string read(const MeshSource& source, FileMesh* mesh) { return Gltf(source.beside, mesh).read(source.file); }

}  // namespace

extern const MeshFormat k_gltf = {"glTF", ".glb,.gltf", true, likeness, read};

}  // namespace sandglass::host
