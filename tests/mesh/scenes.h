// One figure, 0.2 m wide, 1.8 high and 0.4 deep, in formats that say their unit and which axis is up.
#pragma once

#include "tests/mesh/makers.h"

namespace sandglass::tests {

inline std::string figure_places(bool z_up, double units_a_metre, const char* between) {
  std::string out;
  for (const Place& p : k_corners) {
    const double x = 0.2 * p[0], y = 1.8 * (p[1] + 0.5), z = 0.4 * p[2];
    for (const double v : {x, z_up ? -z : y, z_up ? y : z})
      out += (out.empty() ? "" : between) + std::to_string(units_a_metre * v);
  }
  return out;
}

// `skinned`: all of it hangs on a bone that stands twice as large as where it was bound.
inline std::string fbx(bool z_up, double centimetres_a_unit, bool skinned = false) {
  std::string corners;
  for (const auto& f : k_faces)
    for (size_t k = 0; k < 4; ++k) corners += (corners.empty() ? "" : ",") + std::to_string(k < 3 ? f[k] : -f[k] - 1);
  const auto whole = [](const char* name, int value) {
    return std::string("P: \"") + name + "\", \"int\", \"Integer\", \"\"," + std::to_string(value) + "\n";
  };
  const std::string ones = "1,1,1,1,1,1,1,1", still = "1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1";
  const std::string bone =
      "Model: 2002, \"Model::Bone\", \"LimbNode\" {\nVersion: 232\nProperties70:  {\n"
      "P: \"Lcl Scaling\", \"Lcl Scaling\", \"\", \"A\",2,2,2\n}\n}\n"
      "Deformer: 3001, \"Deformer::\", \"Skin\" {\nVersion: 101\n}\n"
      "Deformer: 3002, \"SubDeformer::\", \"Cluster\" {\nVersion: 100\nIndexes: *8 {\na: 0,1,2,3,4,5,6,7\n}\n"
      "Weights: *8 {\na: " +
      ones + "\n}\nTransform: *16 {\na: " + still + "\n}\nTransformLink: *16 {\na: " + still + "\n}\n}\n";
  const std::string hung = "C: \"OO\",2002,0\nC: \"OO\",3001,1001\nC: \"OO\",3002,3001\nC: \"OO\",2002,3002\n";
  return "; FBX 7.4.0 project file\nFBXHeaderExtension:  {\nFBXHeaderVersion: 1003\nFBXVersion: 7400\n}\n"
         "GlobalSettings:  {\nVersion: 1000\nProperties70:  {\n" +
         whole("UpAxis", z_up ? 2 : 1) + whole("UpAxisSign", 1) + whole("FrontAxis", z_up ? 1 : 2) +
         whole("FrontAxisSign", z_up ? -1 : 1) + whole("CoordAxis", 0) + whole("CoordAxisSign", 1) +
         "P: \"UnitScaleFactor\", \"double\", \"Number\", \"\"," + std::to_string(centimetres_a_unit) + "\n}\n}\n" +
         "Objects:  {\nGeometry: 1001, \"Geometry::Figure\", \"Mesh\" {\nVertices: *24 {\na: " +
         figure_places(z_up, 100 / centimetres_a_unit, ",") + "\n}\nPolygonVertexIndex: *24 {\na: " + corners +
         "\n}\nGeometryVersion: 124\n}\nModel: 2001, \"Model::Figure\", \"Mesh\" {\nVersion: 232\n}\n" +
         (skinned ? bone : "") + "}\n" + "Connections:  {\nC: \"OO\",2001,0\nC: \"OO\",1001,2001\n" +
         (skinned ? hung : "") + "}\n";
}

inline std::string collada(bool z_up) {
  std::string corners;
  for (const auto& f : k_faces)
    for (const uint16_t k : f) corners += std::to_string(k) + " ";
  return "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n"
         "<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\"><asset>"
         "<unit name=\"centimetre\" meter=\"0.01\"/><up_axis>" +
         std::string(z_up ? "Z" : "Y") +
         "_UP</up_axis></asset>\n<library_geometries><geometry id=\"b\"><mesh>"
         "<source id=\"p\"><float_array id=\"a\" count=\"24\">" +
         figure_places(z_up, 100, " ") +
         "</float_array><technique_common><accessor source=\"#a\" count=\"8\" stride=\"3\"><param name=\"X\" "
         "type=\"float\"/>"
         "<param name=\"Y\" type=\"float\"/><param name=\"Z\" type=\"float\"/></accessor></technique_common></source>"
         "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices><polylist count=\"6\">"
         "<input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><vcount>4 4 4 4 4 4</vcount><p>" +
         corners +
         "</p></polylist></mesh></geometry></library_geometries><library_visual_scenes><visual_scene id=\"s\"><node "
         "id=\"n\">"
         "<instance_geometry url=\"#b\"/></node></visual_scene></library_visual_scenes><scene>"
         "<instance_visual_scene url=\"#s\"/></scene></COLLADA>";
}

}  // namespace sandglass::tests
