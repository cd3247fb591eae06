// What a camera inside a panorama sees, and the panorama as it looks from the place where an object is put. There are
// three frames: the panorama's (y up), the rotated one (y up, +z where the camera looks), and the camera's (x right, y
// down, z forward). A direction (x, y, z) of the rotated frame is (-x, -y, z) in the camera's: a lamp on the ceiling
// has camera y < 0, one on the right x > 0. Equation numbers are the dissertation's; runtime/README.md lists the
// corrections.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "models/rooms/panorama.h"

namespace sandglass::host {

constexpr int k_excerpt_width = 256, k_excerpt_height = 192;
constexpr double k_excerpt_fov_deg = 85.0;  // diagonal
constexpr int k_excerpts = 8;               // of a panorama
constexpr int k_warped_width = 1024, k_warped_height = 512;
constexpr double k_unknown_depth_insertion = 0.8, k_farthest_insertion = 0.95;

struct View {
  double theta, phi;  // where the camera looks, in the panorama's frame
  Vec3 direction() const { return direction_of_angles(theta, phi); }
};

// The azimuth is uniform. The polar angle is normal about the horizon with a deviation of 15 degrees, cut off at 30: a
// closed range needs a cut, which (5.13) does not name. No two views are closer than 10 degrees, with differences of
// azimuth wrapped (correction to 5.13).
std::array<View, k_excerpts> choose_views(uint64_t seed);

// R = R_y(-(phi - pi/2)) R_x(theta - pi/2) takes the rotated frame to the panorama's frame, and +z to the view
// direction. It corrects (5.9), which counts the turn about y twice.
struct ViewRotation {
  explicit ViewRotation(View view);
  Vec3 to_panorama(Vec3 d) const { return columns[0] * d.x + columns[1] * d.y + columns[2] * d.z; }
  Vec3 to_rotated(Vec3 d) const { return {dot(columns[0], d), dot(columns[1], d), dot(columns[2], d)}; }
  Vec3 columns[3];
};

constexpr Vec3 rotated_to_camera(Vec3 d) { return {-d.x, -d.y, d.z}; }
constexpr Vec3 camera_to_rotated(Vec3 d) { return {-d.x, -d.y, d.z}; }

// The focal length in pixels of an image with this diagonal field of view (2.15). The principal point is its middle.
double focal_length(int width, int height, double diagonal_fov_deg);

// What a camera sees of a panorama, interpolated bilinearly (5.10 - 5.12).
RadianceMap cut_excerpt(const RadianceMap& panorama, View view, int width = k_excerpt_width,
                        int height = k_excerpt_height, double diagonal_fov_deg = k_excerpt_fov_deg);

// How far an object stands in the view direction, in panorama radii: 1 - d_max / 10 m over the excerpt's depths (5.22),
// clamped to [0, 0.95]; 0.8 for an empty depth map.
double insertion_radius(std::span<const float> depth, int depth_width, View view);

// The panorama as seen from radius * view direction, as if everything were on the unit sphere, turned so that the view
// is the centre (5.14 - 5.21, where the middle coefficient of (5.17) must be 2 (d . x_c) / |d|^2). Each pixel is the
// mean of four places, because the part behind the camera shrinks.
RadianceMap warp(const RadianceMap& panorama, View view, double radius, int width = k_warped_width,
                 int height = k_warped_height);

// What of a panorama whose centre looks along `view` lies above the horizon; the rest is black.
RadianceMap above_horizon(const RadianceMap& panorama, View view);

}  // namespace sandglass::host
