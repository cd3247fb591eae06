// Every kind of mesh file that people bring, in one table: it is read right, or refused with the reason. The sizes and
// volumes follow from how each file is made. The page's reader and the fuzzer run the same table: this test leaves it as
// files, with cases.json, in the folder that SANDGLASS_MESH_KINDS names.
#include <gtest/gtest.h>
#ifdef SANDGLASS_HAVE_DRACO
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#endif
#ifdef SANDGLASS_HAVE_MESHOPTIMIZER
#include <meshoptimizer.h>
#endif

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>

#include "models/mesh/readers.h"
#include "sandglass/sandglass.hpp"
#include "tests/mesh/makers.h"
#include "tests/mesh/scenes.h"
#include "tests/temporary_folder.h"

namespace sandglass::tests {

namespace {

using namespace std::string_literals;

struct Kind {
  std::string name, bytes;
  // What it must be: the size of its box, its filled volume (below 0: not asked) and its triangles. Or words of the
  // sentence that refuses it.
  Place size = {1, 1, 1};
  double volume = 1;
  uint32_t triangles = 12;
  std::string refused = {};
  std::string remark = {};  // words of one
  host::MeshUnits units = {};
  bool is_pages = true;  // the page reads it too
};

Kind good(const std::string& name, const std::string& bytes) { return {name, bytes}; }
Kind bad(const std::string& name, const std::string& bytes, const std::string& why) {
  return {name, bytes, {}, 0, 0, why};
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  text.replace(text.find(what), what.size(), by);
  return text;
}

/* ---- glTF ---- */

Kind with(GltfMaker g, const std::string& name, Place size, double volume, uint32_t triangles) {
  return {name, g.glb(), size, volume, triangles};
}

GltfMaker plain() {
  GltfMaker g;
  g.node({{"mesh", g.cube()}});
  return g;
}

std::string moved_twice(Json second) {
  GltfMaker g;
  const size_t cube = g.cube();
  second["mesh"] = cube;
  g.node({{"mesh", cube}});
  g.node(second);
  return g.glb();
}

// Numbers of 16 bits, from 0 to 16,383, in rows of 8 bytes; the node takes them back.
GltfMaker quantised(bool packed) {
  GltfMaker g;
  std::vector<uint16_t> rows;
  for (const Place& p : k_corners) {
    for (const float x : p) rows.push_back(static_cast<uint16_t>(16383 * (x + 0.5f)));
    rows.push_back(0);
  }
  g.require("KHR_mesh_quantization");
  size_t view = 0;
  if (packed) {
#ifdef SANDGLASS_HAVE_MESHOPTIMIZER
    std::string data(meshopt_encodeVertexBufferBound(8, 8), '\0');
    data.resize(
        meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(data.data()), data.size(), rows.data(), 8, 8));
    g.require("EXT_meshopt_compression");
    view = g.view(data);
    const Json& packed_view = g.file["bufferViews"][view];
    // The buffer that a reader without the extension would need is not there.
    const Json described = {{"buffer", 1},
                            {"byteLength", 64},
                            {"byteStride", 8},
                            {"extensions",
                             {{"EXT_meshopt_compression",
                               {{"buffer", 0},
                                {"byteOffset", packed_view["byteOffset"]},
                                {"byteLength", packed_view["byteLength"]},
                                {"byteStride", 8},
                                {"count", 8},
                                {"mode", "ATTRIBUTES"}}}}}};
    g.file["bufferViews"][view] = described;
    g.add("buffers", {{"byteLength", 64}, {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}});
#endif
  } else {
    view = g.view(bytes_of(rows), {{"byteStride", 8}});
  }
  const float s = 1.0f / 16383;
  g.node({{"mesh", g.mesh(g.accessor(view, 5123, 8, "VEC3"), g.triangles(cube_triangles()))}, {"scale", {s, s, s}}});
  return g;
}

#ifdef SANDGLASS_HAVE_DRACO
// `shares`: of 32767, in whole numbers.
GltfMaker packed_by_draco(bool shares) {
  GltfMaker g;
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(12);
  const int position =
      builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, shares ? draco::DT_INT16 : draco::DT_FLOAT32);
  const std::vector<uint16_t> corners = cube_triangles();
  for (uint32_t t = 0; t < 12; ++t) {
    int16_t whole[3][3];
    const void* values[3];
    for (uint32_t k = 0; k < 3; ++k) {
      const Place& p = k_corners[corners[3 * t + k]];
      for (size_t axis = 0; axis < 3; ++axis) whole[k][axis] = static_cast<int16_t>(2 * 32767 * p[axis]);
      values[k] = shares ? static_cast<const void*>(whole[k]) : p.data();
    }
    builder.SetAttributeValuesForFace(position, draco::FaceIndex(t), values[0], values[1], values[2]);
  }
  draco::EncoderBuffer packed;
  EXPECT_TRUE(draco::Encoder().EncodeMeshToBuffer(*builder.Finalize(), &packed).ok());
  g.require("KHR_draco_mesh_compression");
  const size_t view = g.view({packed.data(), packed.size()});
  // Accessors without data say the counts.
  const size_t places = g.add(
      "accessors", {{"componentType", shares ? 5122 : 5126}, {"normalized", shares}, {"count", 8}, {"type", "VEC3"}});
  const size_t indices = g.add("accessors", {{"componentType", 5123}, {"count", 36}, {"type", "SCALAR"}});
  const Json extension = {{"KHR_draco_mesh_compression", {{"bufferView", view}, {"attributes", {{"POSITION", 0}}}}}};
  g.node({{"mesh", g.mesh(places, indices, {{"extensions", extension}})}});
  return g;
}
#endif

GltfMaker normalised() {
  GltfMaker g;
  std::vector<int16_t> rows;
  for (const Place& p : k_corners) {
    for (const float x : p) rows.push_back(static_cast<int16_t>(2 * 32767 * x));
    rows.push_back(0);
  }
  g.require("KHR_mesh_quantization");
  const size_t places =
      g.accessor(g.view(bytes_of(rows), {{"byteStride", 8}}), 5122, 8, "VEC3", {{"normalized", true}});
  g.node({{"mesh", g.mesh(places, g.triangles(cube_triangles()))}});
  return g;
}

// Two corners of four are elsewhere in the accessor, and are put right.
GltfMaker sparse() {
  GltfMaker g;
  std::vector<Place> wrong = k_corners;
  wrong[1] = wrong[6] = {9, 9, 9};
  const size_t places = g.places(wrong);
  g.file["accessors"][places]["sparse"] = {
      {"count", 2},
      {"indices", {{"bufferView", g.view(bytes_of<uint8_t>({1, 6}))}, {"componentType", 5121}}},
      {"values", {{"bufferView", g.view(bytes_of(flat({k_corners[1], k_corners[6]})))}}}};
  g.node({{"mesh", g.mesh(places, g.triangles(cube_triangles()))}});
  return g;
}

// A joint that shrinks to a fiftieth: where the mesh's own node stands does not count.
GltfMaker skinned() {
  GltfMaker g;
  const size_t cube = g.cube();
  Json& attributes = g.file["meshes"][cube]["primitives"][0]["attributes"];
  attributes["JOINTS_0"] = g.accessor(g.view(std::string(32, '\0')), 5121, 8, "VEC4");
  std::vector<float> weights;
  for (int i = 0; i < 8; ++i) weights.insert(weights.end(), {1, 0, 0, 0});
  attributes["WEIGHTS_0"] = g.floats(weights, 4, "VEC4");
  const size_t hip = g.node({{"scale", {0.02, 0.02, 0.02}}});
  g.file["skins"] = {{{"joints", {hip}}}};
  g.node({{"mesh", cube}, {"skin", 0}, {"translation", {7, 7, 7}}});
  return g;
}

// By half of a target that is 3 m higher at the four upper corners.
GltfMaker morphed() {
  GltfMaker g;
  std::vector<Place> moves;
  for (const Place& p : k_corners) moves.push_back({0, p[1] > 0 ? 3.0f : 0.0f, 0});
  const size_t cube = g.cube();
  g.file["meshes"][cube]["primitives"][0]["targets"] = {{{"POSITION", g.places(moves)}}};
  g.file["meshes"][cube]["weights"] = {0.5};
  g.node({{"mesh", cube}});
  return g;
}

GltfMaker instanced() {
  GltfMaker g;
  g.require("EXT_mesh_gpu_instancing");
  const size_t at = g.places({{0, 0, 0}, {2, 0, 0}, {4, 0, 0}}), sizes = g.places({{1, 1, 1}, {1, 1, 1}, {-1, 1, 1}});
  g.node({{"mesh", g.cube()},
          {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", at}, {"SCALE", sizes}}}}}}}});
  return g;
}

// Two meshes of one vertex buffer. The second cube's corners are 50 m higher, and its node takes it back beside the first.
GltfMaker shared_vertices() {
  GltfMaker g;
  std::vector<Place> both = k_corners;
  for (const Place& p : k_corners) both.push_back({p[0], p[1] + 50, p[2]});
  const size_t places = g.places(both);
  g.node({{"mesh", g.mesh(places, g.triangles(cube_triangles()))}});
  g.node({{"mesh", g.mesh(places, g.triangles(cube_triangles(8)))}, {"translation", {0, -49, 0}}});
  return g;
}

GltfMaker two_parts(Place second, bool inward) {
  GltfMaker g;
  std::vector<Place> both = k_corners;
  for (const Place& p : k_corners)
    both.push_back({0.5f * p[0] + second[0], 0.5f * p[1] + second[1], 0.5f * p[2] + second[2]});
  std::vector<uint16_t> corners = cube_triangles(), others = cube_triangles(8, inward);
  corners.insert(corners.end(), others.begin(), others.end());
  g.node({{"mesh", g.mesh(g.places(both), g.triangles(corners))}});
  return g;
}

// A cube far away and hidden, with another one below it that says nothing of itself; and one in sight.
GltfMaker hidden(const Json& visible) {
  GltfMaker g = plain();
  const size_t below = g.add("nodes", {{"mesh", 0}, {"translation", {0, 9, 0}}});
  g.node({{"mesh", 0},
          {"translation", {7, 0, 0}},
          {"children", {below}},
          {"extensions", {{"KHR_node_visibility", {{"visible", visible}}}}}});
  g.require("KHR_node_visibility");
  return g;
}

std::string requiring(const char* extension) {
  GltfMaker g = plain();
  g.require(extension);
  return g.glb();
}

std::vector<Kind> gltf_kinds() {
  GltfMaker lit = plain();
  lit.file["materials"] = {{{"name", "a"}}, {{"name", "b"}}};
  lit.file["animations"] = Json::array({Json::object()});
  Kind counted = good("counted.glb", lit.glb());
  counted.remark = "animations (1), materials (2)";
  Kind beside = with(two_parts({2, 0, 0}, true), "inside_out_beside.glb", {2.75f, 1, 1}, 1.125, 24);
  beside.remark = "1 of its 2 parts";
  Kind unseen = good("hidden.glb", hidden(false).glb());
  unseen.remark = "hidden nodes (1)";
  GltfMaker round = plain();
  round.file["nodes"][0]["children"] = {0};
  GltfMaker older = plain();
  older.file["asset"]["version"] = "1.0";
  return {
      good("plain.glb", plain().glb()),
      counted,
      with(quantised(false), "quantised.glb", {1, 1, 1}, 1, 12),
      with(normalised(), "normalised.glb", {2, 2, 2}, 8, 12),
      with(sparse(), "sparse.glb", {1, 1, 1}, 1, 12),
      with(skinned(), "skinned.glb", {.02f, .02f, .02f}, 8e-6, 12),
      with(morphed(), "morphed.glb", {1, 2.5f, 1}, 2.5, 12),
      with(instanced(), "instanced.glb", {5, 1, 1}, 3, 36),
      with(shared_vertices(), "shared_vertices.glb", {1, 2, 1}, 2, 24),
      {"mirrored.glb", moved_twice({{"scale", {-1, 1, 1}}, {"translation", {2, 0, 0}}}), {3, 1, 1}, 2, 24},
      {"overlapping.glb", moved_twice({{"translation", {.5, 0, 0}}}), {1.5f, 1, 1}, 1.5, 24},
      {"named_twice.glb", moved_twice({}), {1, 1, 1}, 1, 24},
      beside,
      with(two_parts({0, 0, 0}, true), "hollow.glb", {1, 1, 1}, 0.875, 24),
      unseen,
      with(hidden(true), "shown.glb", {8, 10, 1}, 3, 36),
      bad("half_hidden.glb", hidden("no").glb(), "neither true nor false"),
      good("known_required.glb", requiring("KHR_materials_unlit")),
      bad("unknown_required.glb", requiring("ACME_mesh_folding"), "ACME_mesh_folding"),
      bad("below_itself.glb", round.glb(), "below itself"),
      bad("version_1.glb", older.glb(), "version 1.0"),
      bad("cut.glb", plain().glb().substr(0, 600), "ends after 600 of"),
#ifdef SANDGLASS_HAVE_MESHOPTIMIZER
      with(quantised(true), "meshopt.glb", {1, 1, 1}, 1, 12),
#endif
  };
}

/* ---- the others ---- */

// 23 rows of a property of 10 bytes each: the first byte of the data is a newline.
std::string ply_newline() {
  return "ply\nformat binary_little_endian 1.0\nelement vertex 8\nproperty uchar kind\nproperty float x\nproperty "
         "float y\nproperty float z\n"
         "element face 6\nproperty list uchar int vertex_index\nend_header\n" +
         [] {
           std::string out;
           for (const Place& p : k_corners) out += "\n" + bytes_of(flat({p}));
           for (const auto& f : k_faces) out += "\x04" + bytes_of<int32_t>({f[0], f[1], f[2], f[3]});
           return out;
         }();
}

// Three strips of a cube's faces: around it, and each lid.
std::string ply_strips() {
  return ply_head("binary_little_endian", "tristrips 1\nproperty list int int vertex_indices") +
         bytes_of(flat(k_corners)) +
         bytes_of<int32_t>({20, 2, 0, 3, 1, 7, 5, 6, 4, 2, 0, -1, 2, 3, 6, 7, -1, 0, 4, 1, 5});
}

std::string returns_alone(std::string text) {
  std::replace(text.begin(), text.end(), '\n', '\r');
  return text;
}
std::string ply_data() { return ply_binary(false).substr(ply_head("binary_little_endian").size()); }

std::vector<Kind> other_kinds() {
  const std::string places = obj_places(), faces = obj_faces();
  Kind loose = good("loose.obj", places + "v 0 40 0\nv 0 -30 0\nl 9 10\np 9\n" + faces);
  loose.remark = "lines (1), points (1)";
  std::string survey;
  for (const Place& p : k_corners)
    survey +=
        "v " + std::to_string(5.5e6 + p[0]) + " " + std::to_string(p[1]) + " " + std::to_string(2e5 + p[2]) + "\n";
  Kind far = good("survey.obj", survey + faces);
  far.remark = "moved by";
  Kind behind = good("behind.stl", stl_binary() + std::string(70, '\0'));
  behind.remark = "bytes behind the last triangle (70)";
  Kind millimetres = good("millimetres.obj", places + faces);
  millimetres.units.metres = 0.001;
  millimetres.size = {.001f, .001f, .001f};
  millimetres.volume = 1e-9;
  millimetres.remark = "0.001 m";
  millimetres.is_pages = false;
  Kind z_up = {
      "z_up.obj", "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 4\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n", {1, 4, 2}, 8.0 / 6, 4};
  z_up.units.z_up = true;
  z_up.is_pages = false;
  std::string shouted = stl_text();
  std::transform(shouted.begin(), shouted.end(), shouted.begin(),
                 [](char c) { return static_cast<char>(std::toupper(c)); });
  return {
      good("plain.obj", places + faces),
      loose,
      far,
      millimetres,
      z_up,
      good("comments.obj", "\xEF\xBB\xBF# a cube\r\n" + places + obj_faces("", " # behind\r\n")),
      good("slashes.obj", places + obj_faces("//")),
      good("slash.obj", places + obj_faces("/")),
      good("lines_go_on.obj", places + replaced(faces, " 4 3", " \\\n4 3")),
      good("returns.obj", returns_alone(places + faces)),
      bad("msvc_nan.obj", replaced(places, "v 0", "v -1.#IND") + faces, "-1.#IND"),
      bad("index.obj", places + "f 1 2 9\n", "9"),
      bad("pointer.obj", "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n", "Git LFS pointer"),
      bad("cut.obj", places + faces + "f 1 3", "cut off"),
      good("plain.ply", ply_text()),
      good("returns.ply", returns_alone(ply_head("binary_little_endian")) + ply_data()),
      good("little.ply", ply_binary(false)),
      good("big.ply", ply_binary(true)),
      good("newline.ply", ply_newline()),
      good("strips.ply", ply_strips()),
      bad("cut.ply", ply_binary(false).substr(0, ply_binary(false).size() - 20), "ends after 4 of 6 faces"),
      bad("cut_text.ply", ply_text().substr(0, ply_text().size() - 9), "ends after 5 of 6 faces"),
      good("plain.stl", stl_binary()),
      good("text.stl", stl_text()),
      good("shouted.stl", shouted),
      good("named.stl", replaced(stl_text(), "solid cube", "solid facet vertex endfacet")),
      behind,
      bad("cut.stl", stl_binary().substr(0, 84 + 50 * 6), "ends after 6 of 12 triangles"),
      bad("cut_text.stl", stl_text().substr(0, stl_text().size() - 14), "without \"endsolid\""),
      good("plain.off", off_text()),
      good("joined.off", off_text("OFF ")),
      bad("cut.off", off_text().substr(0, off_text().size() - 17), "ends after 5 of 6 faces"),
      bad("figure.3mf", std::string("PK\x03\x04", 4) + std::string(100, '\0'), "3MF"),
      bad("figure.amf", "<?xml version=\"1.0\"?><amf unit=\"millimeter\"></amf>", "AMF"),
      bad("notes.obj", "no mesh at all", "no kind of mesh"),
  };
}

std::vector<Kind> assimp_kinds() {
  std::vector<Kind> kinds;
  for (const bool z_up : {false, true}) {
    for (const double unit : {1.0, 100.0, 2.54})
      kinds.push_back({(z_up ? "z_" : "y_") + std::to_string(unit) + ".fbx", fbx(z_up, unit), {.2f, 1.8f, .4f}, .144});
    kinds.push_back({z_up ? "z_up.dae" : "y_up.dae", collada(z_up), {.2f, 1.8f, .4f}, .144});
  }
  kinds.push_back({"skin.fbx", fbx(false, 1, true), {.4f, 3.6f, .8f}, 8 * .144});
  for (Kind& kind : kinds) kind.is_pages = false;
#ifndef SANDGLASS_HAVE_ASSIMP
  for (Kind& kind : kinds) kind.refused = "not read here";
#endif
  return kinds;
}

// The page has sentences of its own for these.
std::vector<Kind> broken_kinds() {
  const std::string places = obj_places(), faces = obj_faces();
  std::vector<Kind> kinds = {
      bad("empty.obj", "", "is empty"),
      bad("no_faces.obj", places, "no triangles"),
      bad("infinite.obj", replaced(places, "v 0.500000", "v inf") + faces, "inf"),
      bad("degenerate.obj", places + "f 1 2 2\n", "degenerate"),
      bad("cut_vertex.obj", "v 0 0 0\nv 1 0 0\nv 0 1", "cut off"),
  };
  for (Kind& kind : kinds) kind.is_pages = false;
  return kinds;
}

std::vector<Kind> all_kinds() {
  std::vector<Kind> all = gltf_kinds();
#ifdef SANDGLASS_HAVE_DRACO
  for (const bool shares : {false, true}) {
    const float side = shares ? 2.0f : 1.0f;
    all.push_back(with(packed_by_draco(shares), shares ? "draco_shares.glb" : "draco.glb", {side, side, side},
                       side * side * side, 12));
    all.back().is_pages = false;
  }
#endif
  for (const auto& more : {other_kinds(), broken_kinds(), assimp_kinds()})
    all.insert(all.end(), more.begin(), more.end());
  return all;
}

// The share of a grid of points in the mesh's box that lie inside, times the box.
double filled_volume(const host::MeshResult& read) {
  const host::MeshBox box = host::box_of(read.mesh);
  const sandglass_mesh view = read.mesh.view();
  MeshInside inside;
  EXPECT_TRUE(inside.create(view, host::inside_rule(read.report)));
  constexpr int k_points = 40;  // along each axis
  int within = 0;
  for (int i = 0; i < k_points * k_points * k_points; ++i) {
    float p[3];
    const int at[] = {i % k_points, i / k_points % k_points, i / k_points / k_points};
    for (int k = 0; k < 3; ++k)
      p[k] = box.low[k] + (box.high[k] - box.low[k]) * (static_cast<float>(at[k]) + 0.5f) / k_points;
    within += inside(p) ? 1 : 0;
  }
  double volume = static_cast<double>(within) / (k_points * k_points * k_points);
  for (int k = 0; k < 3; ++k) volume *= static_cast<double>(box.high[k] - box.low[k]);
  return volume;
}

std::string written(const std::filesystem::path& folder, const std::string& name, const std::string& bytes) {
  std::ofstream(folder / name, std::ios::binary) << bytes;
  return (folder / name).string();
}

void expect_kind(const Kind& kind, const std::string& path) {
  SCOPED_TRACE(kind.name);
  const host::MeshResult read = host::load_mesh({path, kind.units});
  if (!kind.refused.empty()) {
    EXPECT_FALSE(read);
    EXPECT_NE(read.error.find(kind.refused), std::string::npos) << read.error;
    EXPECT_NE(read.error.find(path), std::string::npos) << read.error;
    EXPECT_EQ(read.error.find('\n'), std::string::npos) << read.error;
    EXPECT_TRUE(read.error.ends_with(".")) << read.error;
    return;
  }
  ASSERT_TRUE(read) << read.error;
  EXPECT_EQ(read.mesh.triangle_count(), kind.triangles);
  EXPECT_GT(host::signed_volume(read.mesh), 0);
  const host::MeshBox box = host::box_of(read.mesh);
  for (size_t k = 0; k < 3; ++k) EXPECT_NEAR(box.high[k] - box.low[k], kind.size[k], 1e-4f * kind.size[k]) << k;
  // Half of the points' faces may lie on the wrong side of a slope.
  EXPECT_NEAR(filled_volume(read), kind.volume, 0.04 * kind.volume);
  std::string remarks;
  for (const std::string& remark : read.remarks) remarks += remark + "; ";
  if (kind.remark.empty()) EXPECT_EQ(remarks, "");
  else EXPECT_NE(remarks.find(kind.remark), std::string::npos) << remarks;
}

TEST(MeshKinds, EveryFormatHasAFile) {
  std::set<const host::MeshFormat*> found;
  for (const Kind& kind : all_kinds()) {
    const host::MeshFormat* format = host::mesh_kind(kind.bytes).format;
    if (format != nullptr && std::strstr(format->endings, kind.name.substr(kind.name.rfind('.')).c_str()) != nullptr)
      found.insert(format);
  }
  for (const host::MeshFormat* format : host::mesh_formats()) EXPECT_TRUE(found.contains(format)) << format->name;
}

TEST(MeshKinds, AreReadRightOrRefusedWithTheReason) {
  const TemporaryFolder folder;
  for (const Kind& kind : all_kinds()) expect_kind(kind, written(folder.path, kind.name, kind.bytes));
}

// A file that ends early has lost faces. An OBJ does not say how many it has: a hole in its surface is then reported.
TEST(MeshKinds, NoPartOfAFileIsTakenForTheWhole) {
  const TemporaryFolder folder;
  for (const Kind& kind : all_kinds()) {
    if (!kind.refused.empty() || !kind.is_pages) continue;
    // Padding, the colour of the last face and what is said behind it may be missing.
    const size_t said = std::min(kind.bytes.rfind(" 255 0 0"), kind.bytes.rfind(" # behind"));
    const size_t whole = std::min(said, kind.bytes.find_last_not_of(" \n\0"s) + 1);
    const bool says_its_length = !kind.name.ends_with(".obj");
    for (size_t length = 0; length < whole; length += kind.bytes.size() / 60 + 1) {
      const host::MeshResult read = host::load_mesh(written(folder.path, kind.name, kind.bytes.substr(0, length)));
      EXPECT_TRUE(!read || (!says_its_length && read.report.boundary_edges > 0)) << kind.name << " " << length;
    }
  }
}

TEST(MeshKinds, WhatIsNotThereOrNoFileIsRefused) {
  for (const auto& [path, why] : {std::pair("/no/such/mesh.obj", "does not exist"), {"/", "is not a file"}})
    expect_kind(bad("", "", why), path);
}

TEST(MeshKinds, AGltfFindsItsFilesByTheirNamesAsUrisWriteThem) {
  const TemporaryFolder folder;
  const GltfMaker g = plain();
  for (const char* name : {"my data.bin", "100%25.bin"}) written(folder.path, name, g.buffer);
  for (const char* uri : {"my%20data.bin", "my data.bin", "100%25.bin"}) {
    GltfMaker of = g;
    expect_kind(good("plain.gltf", ""), written(folder.path, "plain.gltf", of.gltf(uri)));
  }
  GltfMaker of = g;
  expect_kind(bad("lost.gltf", "", "lost.bin"), written(folder.path, "lost.gltf", of.gltf("lost.bin")));
}

// A dart, a quad with one corner that goes in: a fan from its first corner would leave its outline.
TEST(MeshKinds, AConcavePolygonIsCutWithinItself) {
  const TemporaryFolder folder;
  const host::MeshResult read =
      host::load_mesh(written(folder.path, "dart.obj", "v 4 3 0\nv 1 0 0\nv 4 -3 0\nv 0 0 0\nf 1 2 3 4\n"));
  ASSERT_TRUE(read) << read.error;
  double area = 0;
  for (size_t t = 0; t + 2 < read.mesh.indices.size(); t += 3) {
    const auto at = [&](size_t k, size_t axis) {
      return static_cast<double>(read.mesh.vertices[3 * read.mesh.indices[t + k] + axis]);
    };
    area +=
        0.5 * std::fabs((at(1, 0) - at(0, 0)) * (at(2, 1) - at(0, 1)) - (at(1, 1) - at(0, 1)) * (at(2, 0) - at(0, 0)));
  }
  EXPECT_DOUBLE_EQ(area, 3);
}

// For the page's reader, tests/page/mesh_files_test.mjs, and the fuzzer.
TEST(MeshKinds, AreLeftForOthers) {
  const char* folder = std::getenv("SANDGLASS_MESH_KINDS");
  if (folder == nullptr) GTEST_SKIP() << "SANDGLASS_MESH_KINDS names no folder";
  std::filesystem::create_directories(folder);
  Json cases = Json::array();
  for (const Kind& kind : all_kinds()) {
    if (!kind.is_pages) continue;
    written(folder, kind.name, kind.bytes);
    cases.push_back(
        {{"name", kind.name}, {"size", kind.size}, {"triangles", kind.triangles}, {"refused", kind.refused}});
  }
  written(folder, "cases.json", cases.dump(1));
}

}  // namespace

}  // namespace sandglass::tests
