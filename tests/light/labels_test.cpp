// Excerpts, warp and labels against panoramas whose labels have a closed form.
#include "models/lighting/labels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "models/files/atomic_file.h"
#include "models/files/npy.h"
#include "models/lighting/dataset.h"
#include "models/rooms/excerpt.h"
#include "models/rooms/panorama_file.h"
#include "tests/light/made_panorama.h"
#include "tests/refusal.h"
#include "tests/temporary_folder.h"

namespace sandglass::host {
namespace {

using tests::panorama_of;
constexpr double k_pi = std::numbers::pi;
constexpr double k_degree = k_pi / 180.0;
constexpr Vec3 k_up = {0, 1, 0};

RadianceMap gaussian_on_constant(Vec3 axis, double sharpness, double peak, double rest) {
  return panorama_of(512, [=](Vec3 d) {
    const double value = rest + peak * std::exp(sharpness * (dot(axis, d) - 1.0));
    return Vec3{value, value, value};
  });
}

double angle_deg(Vec3 a, Vec3 b) { return std::atan2(length(cross(a, b)), dot(a, b)) / k_degree; }

// The labels of one view, in the camera's frame as in the data set.
LightLabels camera_labels(const RadianceMap& panorama, View view, double radius) {
  const RadianceMap warped = warp(panorama, view, radius, 512, 256);
  LightLabels labels = labels_of(warped, ViewRotation(view).to_rotated(k_up), greatest_luminance(panorama));
  labels.direction = rotated_to_camera(labels.direction);
  return labels;
}

TEST(Views, SpreadAsAskedAndNeverClose) {
  double sum = 0.0, squares = 0.0;
  int count = 0;
  for (uint64_t seed = 0; seed < 400; ++seed) {
    const auto views = choose_views(seed);
    for (size_t i = 0; i < views.size(); ++i) {
      ASSERT_GE(views[i].theta, k_pi / 3.0);
      ASSERT_LE(views[i].theta, 2.0 * k_pi / 3.0);
      ASSERT_GE(views[i].phi, -k_pi / 2.0);
      ASSERT_LT(views[i].phi, 1.5 * k_pi);
      const double tilt = views[i].theta - k_pi / 2.0;
      sum += tilt;
      squares += tilt * tilt;
      ++count;
      for (size_t j = 0; j < i; ++j)
        ASSERT_GE(std::hypot(views[i].theta - views[j].theta, std::remainder(views[i].phi - views[j].phi, 2 * k_pi)),
                  10.0 * k_degree);
    }
  }
  // A normal distribution that is cut off at two deviations keeps 0.7737 of its variance.
  EXPECT_NEAR(sum / count, 0.0, 0.02);
  EXPECT_NEAR(squares / count, 0.7737 * std::pow(k_pi / 12.0, 2.0), 0.03 * std::pow(k_pi / 12.0, 2.0));
}

TEST(ViewRotation, TakesForwardToTheViewAndIsProper) {
  for (const View view : choose_views(7)) {
    const ViewRotation rotation(view);
    EXPECT_LT(length(rotation.to_panorama({0, 0, 1}) - view.direction()), 1e-14);
    const Vec3* c = rotation.columns;
    EXPECT_NEAR(dot(cross(c[0], c[1]), c[2]), 1.0, 1e-14);
    EXPECT_NEAR(c[0].y, 0.0, 1e-15);  // the horizon stays level
    EXPECT_LT(length(rotation.to_rotated(rotation.to_panorama({0.3, -0.5, 0.8})) - Vec3{0.3, -0.5, 0.8}), 1e-14);
  }
}

// A spot in the panorama appears where the camera model puts it: right of the view direction is right in the image,
// above is above.
TEST(Excerpt, ShowsDirectionsWhereTheCameraModelPutsThem) {
  for (const View view : choose_views(3)) {
    const ViewRotation rotation(view);
    const Vec3 camera = normalised(Vec3{0.3, -0.2, 1.0});  // right and up
    const Vec3 spot = rotation.to_panorama(camera_to_rotated(camera));
    const RadianceMap panorama = gaussian_on_constant(spot, 2000.0, 1.0, 0.0);
    const RadianceMap image = cut_excerpt(panorama, view);
    double x = 0.0, y = 0.0, weight = 0.0;
    for (int v = 0; v < image.height; ++v)
      for (int u = 0; u < image.width; ++u) {
        const double w = luminance(image.colour(u, v));
        x += w * u;
        y += w * v;
        weight += w;
      }
    const double focal = focal_length(image.width, image.height, k_excerpt_fov_deg);
    EXPECT_NEAR(x / weight, 127.5 + 0.3 * focal, 0.5);
    EXPECT_NEAR(y / weight, 95.5 - 0.2 * focal, 0.5);
  }
}

TEST(Labels, GaussianOnConstantHasItsDirectionToATenthOfADegree) {
  for (const double sharpness : {20.0, 300.0, 3000.0})
    for (const Vec3 axis : {Vec3{0.2, 0.9, 0.1}, Vec3{-0.7, 0.3, -0.6}, Vec3{0.0, 0.05, -1.0}, Vec3{0.02, 1.0, 0.0}}) {
      const LightLabels labels = labels_of(gaussian_on_constant(normalised(axis), sharpness, 40.0, 0.3), k_up, 40.3);
      ASSERT_TRUE(labels.has_direction);
      EXPECT_LE(angle_deg(labels.direction, axis), 0.1) << sharpness;
    }
}

// A lamp on the right has camera x > 0, one on the ceiling y < 0. The mirrored image has the mirrored direction.
TEST(Labels, RightIsPositiveUpIsNegativeMirrorMirrors) {
  const View ahead = {k_pi / 2.0, k_pi / 2.0};
  const RadianceMap lamp_right = gaussian_on_constant(normalised(Vec3{-1.0, 0.4, 0.5}), 100.0, 40.0, 0.3);
  RadianceMap mirrored = lamp_right;
  for (int v = 0; v < mirrored.height; ++v)
    for (int u = 0; u < mirrored.width; ++u) mirrored.set(u, v, lamp_right.colour(mirrored.width - 1 - u, v));
  for (const double radius : {0.0, 0.5}) {
    const LightLabels labels = camera_labels(lamp_right, ahead, radius), other = camera_labels(mirrored, ahead, radius);
    EXPECT_GT(labels.direction.x, 0.5);
    EXPECT_LT(labels.direction.y, -0.1);
    EXPECT_LT(angle_deg(other.direction, {-labels.direction.x, labels.direction.y, labels.direction.z}), 0.01);
    const RadianceMap image = cut_excerpt(lamp_right, ahead), mirror_image = cut_excerpt(mirrored, ahead);
    for (int u = 0; u < 256; u += 15) EXPECT_NEAR(image.colour(u, 40).x, mirror_image.colour(255 - u, 40).x, 1e-4);
  }
}

// A small lamp at p of the unit sphere, seen from x_c, lies along p - x_c.
TEST(Warp, LampMovesAsGeometrySays) {
  for (size_t i = 0; i < 3; ++i)
    for (const double radius : {0.0, 0.3, 0.8}) {
      const View view = choose_views(5)[i];
      const Vec3 lamp = normalised(Vec3{0.3, 0.8, -0.2}), seen = lamp - view.direction() * radius;
      const LightLabels labels = camera_labels(gaussian_on_constant(lamp, 5000.0, 1000.0, 0.01), view, radius);
      const Vec3 expected = rotated_to_camera(ViewRotation(view).to_rotated(seen));
      EXPECT_LE(angle_deg(labels.direction, expected), radius > 0.0 ? 0.3 : 0.1);
    }
}

TEST(Warp, RadiusZeroIsARotationAndConstantsStay) {
  const View view = choose_views(9)[2];
  const auto linear = [](Vec3 d) { return Vec3{2 + d.x, 2 + d.y, 2 + d.z}; };
  const RadianceMap warped = warp(panorama_of(256, linear), view, 0.0, 128, 64);
  const ViewRotation rotation(view);
  for (int v = 0; v < 64; v += 5)
    for (int u = 0; u < 128; u += 5) {
      const Vec3 d = rotation.to_panorama(panorama_direction(u, v, 128, 64));
      EXPECT_LT(length(warped.colour(u, v) - linear(d)), 3e-3);
    }
  const RadianceMap even = warp(panorama_of(64, [](Vec3) { return Vec3{0.5, 0.5, 0.5}; }), view, 0.9, 64, 32);
  for (const float value : even.rgb) EXPECT_NEAR(value, 0.5f, 1e-6f);
}

// A lamp that fills a cone evenly, in an even room: colours and contrasts in closed form.
TEST(Labels, ConeOfLight) {
  const Vec3 axis = normalised(Vec3{0.3, 0.7, 0.4}), lamp = {30, 20, 10}, rest = {0.2, 0.3, 0.6};
  const double half = 20.0 * k_degree, white = luminance(lamp);
  const RadianceMap map = panorama_of(1024, [=](Vec3 d) { return dot(d, axis) > std::cos(half) ? lamp : rest; });
  const LightLabels labels = labels_of(map, k_up, white);
  EXPECT_LE(angle_deg(labels.direction, axis), 0.1);
  EXPECT_NEAR(labels.light.x, 1.0, 1e-9);
  EXPECT_NEAR(labels.light.x / labels.light.z, 3.0, 1e-9);
  EXPECT_LT(length(labels.ambient - tone_mapped(rest, white)), 1e-7);

  const double solid_angle = 2.0 * k_pi * (1.0 - std::cos(half)), l = luminance(lamp), b = luminance(rest);
  const double ratio = b * (4.0 * k_pi - solid_angle) / (l * solid_angle);
  EXPECT_LT(1.0 - std::tanh(ratio / 0.05), 0.02) << "(5.24) as it is printed gives even this light almost no contrast";
  // Irradiance per radiance. The whole cone is above the floor.
  const double cone = k_pi * std::pow(std::sin(half), 2.0) * axis.y;
  const double physical = l * cone / (l * cone + b * (k_pi - cone));
  EXPECT_NEAR(labels.contrast, physical, 2e-3);
}

TEST(Labels, TheAmbientColourIsWeightedBySolidAngle) {
  const RadianceMap map = panorama_of(256, [](Vec3 d) {
    const double value = dot(d, normalised(Vec3{0, 1, 1})) > 0.98 ? 100.0 : d.x > 0.0 ? 1.0 : 0.25;
    return Vec3{value, value, value};
  });
  const double bright = tone_mapped_luminance(1.0, 100.0), dark = tone_mapped_luminance(0.25, 100.0);
  EXPECT_NEAR(labels_of(map, k_up, 100.0).ambient.x, 0.5 * (bright + dark), 2e-3);
}

TEST(Labels, LightFromBelowTheFloorCastsNoShadowOnIt) {
  const RadianceMap map = gaussian_on_constant(normalised(Vec3{0.1, -1.0, 0.2}), 300.0, 40.0, 0.3);
  const LightLabels labels = labels_of(map, k_up, 40.3);
  EXPECT_NEAR(labels.contrast, 0.0, 1e-9);
}

TEST(Labels, EvenMapSaysThatItHasNoDirection) {
  const LightLabels labels = labels_of(panorama_of(256, [](Vec3) { return Vec3{0.8, 0.4, 0.2}; }), k_up, 0.5);
  EXPECT_FALSE(labels.has_direction);
  EXPECT_EQ(labels.contrast, 0.0);
  EXPECT_EQ(labels.direction.y, 1.0);
  for (const double value : {labels.ambient.x, labels.ambient.y, labels.ambient.z, labels.light.x})
    EXPECT_TRUE(std::isfinite(value) && value > 0.0);
}

TEST(Depth, InsertionRadius) {
  const View ahead = {k_pi / 2.0, k_pi / 2.0};
  EXPECT_EQ(insertion_radius({}, 0, ahead), 0.8);
  std::vector<float> depth(64 * 32, 4.0f);
  EXPECT_NEAR(insertion_radius(depth, 64, ahead), 0.6, 1e-6);
  depth[16 * 64 + 32] = 7.5f;  // in view
  depth[16 * 64 + 0] = 9.5f;   // behind the camera
  EXPECT_NEAR(insertion_radius(depth, 64, ahead), 0.25, 1e-6);
  EXPECT_EQ(insertion_radius(std::vector<float>(64 * 32, 20.0f), 64, ahead), 0.0);
  EXPECT_EQ(insertion_radius(std::vector<float>(64 * 32, 0.1f), 64, ahead), 0.95);
}

TEST(DatasetFiles, EveryExcerptHasItsLineAndItsPicture) {
  if (SANDGLASS_EMULATED)
    GTEST_SKIP() << "it takes a minute under emulation, and nothing here depends on the instruction set";
  const tests::TemporaryFolder folder;
  std::filesystem::create_directories(folder / "in");
  write_hdr(folder / "in/a.hdr", gaussian_on_constant(normalised(Vec3{1, 1, 0}), 100.0, 10.0, 0.2));
  write_hdr(folder / "in/b.hdr", gaussian_on_constant(normalised(Vec3{0, 1, 1}), 100.0, 10.0, 0.2));
  write_file(folder / "groups.csv",
             std::string_view("file,group,fold,notes\nx/a.hdr,kitchen,3,\"lamp, on\"\nb.hdr,hall,,\n"));
  DatasetOptions options;
  options.panoramas = {folder / "in"};
  options.manifest = folder / "groups.csv";
  options.folder = folder / "out";
  const DatasetSummary made = make_dataset(options);
  EXPECT_EQ(made.panoramas, 2u);
  EXPECT_EQ(made.excerpts, 16u);
  EXPECT_EQ(made.without_direction, 0u);
  const std::string manifest = read_file(folder / "out/manifest.csv", "manifest");
  EXPECT_EQ(std::count(manifest.begin(), manifest.end(), '\n'), 17);
  EXPECT_NE(manifest.find("\nimages/a_0.png,a.hdr,kitchen,3,"), std::string::npos);
  EXPECT_NE(manifest.find("\nimages/b_7.png,b.hdr,hall,-1,"), std::string::npos);
  for (const char* name : {"a_0", "a_7", "b_3"})
    EXPECT_TRUE(std::filesystem::exists(folder / ("out/images/" + std::string(name) + ".png")));
  options.threads = 3;
  options.panoramas = {folder / "in/a.hdr"};
  options.folder = folder / "again";
  make_dataset(options);
  const std::string again = read_file(folder / "again/manifest.csv", "manifest");
  EXPECT_EQ(manifest.substr(0, again.size()), again);
}

TEST(DatasetFiles, BadInputIsOneSentence) {
  const tests::TemporaryFolder folder;
  std::filesystem::create_directories(folder / "in");
  DatasetOptions options;
  const auto refused = [&](const char* words) { tests::expect_refusal(words, [&] { make_dataset(options); }); };
  options.folder = folder / "out";
  options.panoramas = {folder / "in"};
  refused("no .hdr or .exr");
  write_hdr(folder / "in/a.hdr", gaussian_on_constant({0, 1, 0}, 100.0, 10.0, 0.2));
  options.manifest = folder / "groups.csv";
  write_file(options.manifest, std::string_view("name,place\na.hdr,kitchen\n"));
  refused("columns file, group and fold");
  write_file(options.manifest, std::string_view("file,group,fold\na.hdr,kitchen,many\n"));
  refused("\"many\"");
  options.manifest.clear();
  write_npy(folder / "in/a_depth.npy", std::vector<float>(9, 1.0f), 3, 3);
  refused("a_depth.npy");
  EXPECT_FALSE(std::filesystem::exists(folder / "out/manifest.csv"));
}

}  // namespace
}  // namespace sandglass::host
