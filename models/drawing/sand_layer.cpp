#include "models/drawing/sand_layer.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "models/work/thread_pool.h"

namespace sandglass::host {

namespace {

constexpr double k_near = 0.01;                                       // metres: what is nearer is not drawn
constexpr int k_band = 16;                                            // rows
constexpr double k_beside = std::numeric_limits<double>::infinity();  // a depth: not covered

struct Projected {
  double x = 0, y = 0, depth = 0;  // pixels from the upper left corner; metres
};

double area(const Projected& a, const Projected& b, double x, double y) {
  return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

}  // namespace

// Some rows of the picture, drawn by one thread.
struct SandLayer::Band {
  SandLayer& layer;
  const SandShape& shape;
  const CameraFrame& camera;
  KitShading shading;
  int top, bottom;

  double scale() const { return camera.focal * layer.size_.height; }
  Projected projected(Vec3 place) const {
    const Vec3 to = place - camera.eye;
    const double depth = dot(to, camera.forward);
    return {0.5 * layer.size_.width + scale() * dot(to, camera.right) / depth,
            0.5 * layer.size_.height - scale() * dot(to, camera.up) / depth, depth};
  }

  // Calls covers(x, y) for the middle of each sample within the box, gives the sample the depth that it returns, if
  // that is nearer, and then the radiance that `shade` gives for the middle of the pixel.
  template <class Covers, class Shade>
  void draw(double left, double right, double above, double below, const Covers& covers, const Shade& shade) {
    const auto within = [](double v, int lowest, int highest) {
      return static_cast<int>(std::clamp(v, static_cast<double>(lowest), static_cast<double>(highest)));
    };
    const int n = layer.size_.samples, x0 = within(left, 0, layer.size_.width),
              x1 = within(right + 1, 0, layer.size_.width), y0 = within(above, top, bottom),
              y1 = within(below + 1, top, bottom);
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) {
        Sample* samples = const_cast<Sample*>(&layer.at(x, y, 0));
        constexpr int k_samples_max = 64;
        double depths[k_samples_max];
        bool covered = false;
        for (int i = 0; i < n * n; ++i) {
          const double sx = x + (i % n + 0.5) / n, sy = y + (i / n + 0.5) / n;
          depths[i] = covers(sx, sy);
          if (!(depths[i] < static_cast<double>(samples[i].depth))) depths[i] = 0;
          covered = covered || depths[i] > 0;
        }
        if (!covered) continue;
        const std::optional<Vec3> radiance = shade(x + 0.5, y + 0.5);
        if (!radiance) continue;
        for (int i = 0; i < n * n; ++i) {
          if (depths[i] <= 0) continue;
          samples[i].depth = static_cast<float>(depths[i]);
          to_floats(*radiance, samples[i].radiance);
        }
      }
  }

  void triangle(const uint32_t* corners) {
    std::array<Projected, 3> p;
    std::array<Vec3, 3> places;
    for (size_t k = 0; k < 3; ++k) {
      places[k] = shape.position(corners[k]);
      p[k] = projected(places[k]);
      if (p[k].depth < k_near) return;
    }
    // Counter-clockwise from outside, with y downwards.
    const double all = -area(p[0], p[1], p[2].x, p[2].y);
    if (all <= 0) return;
    const auto [x0, x1] = std::minmax({p[0].x, p[1].x, p[2].x});
    const auto [y0, y1] = std::minmax({p[0].y, p[1].y, p[2].y});
    if (y1 < top || y0 > bottom || x1 < 0 || x0 > layer.size_.width) return;
    // Shares of the corners in the picture over depth, which are linear there; and how they change by a pixel.
    const auto weights = [&](double x, double y) {
      std::array<double, 3> w;
      for (size_t k = 0; k < 3; ++k) w[k] = -area(p[(k + 1) % 3], p[(k + 2) % 3], x, y) / all / p[k].depth;
      return w;
    };
    const auto covers = [&](double x, double y) {
      const std::array<double, 3> w = weights(x, y);
      return w[0] >= 0 && w[1] >= 0 && w[2] >= 0 ? 1 / (w[0] + w[1] + w[2]) : k_beside;
    };
    const auto shade = [&](double x, double y) {
      const std::array<double, 3> w = weights(x, y), across = weights(x + 1, y), down = weights(x, y + 1);
      const double sum = w[0] + w[1] + w[2];
      KitShading::Fragment fragment = {};
      for (size_t k = 0; k < 3; ++k) {
        fragment.corners[k] = &shape.vertices[corners[k]];
        fragment.share[k] = w[k] / sum;
        fragment.place = fragment.place + places[k] * fragment.share[k];
      }
      for (size_t k = 0; k < 3; ++k) {
        fragment.right = fragment.right + (places[k] - fragment.place) * ((across[k] - w[k]) / sum);
        fragment.down = fragment.down + (places[k] - fragment.place) * ((down[k] - w[k]) / sum);
      }
      return shading.surface(fragment);
    };
    draw(x0, x1, y0, y1, covers, shade);
  }

  void loose(const sandglass_skin_loose& particle, bool flies) {
    const Vec3 middle = from_floats(particle.position);
    const Projected at = projected(middle);
    if (at.depth < k_near) return;
    const double reach = scale() / at.depth * (4.0 * static_cast<double>(shape.particle_radius) + (flies ? 0.1 : 0.0));
    if (at.y + reach < top || at.y - reach > bottom) return;
    const uint32_t count = shading.grains(flies, at.depth);
    for (uint32_t i = 0; i < count; ++i)
      if (const std::optional<KitShading::Grain> grain = shading.grain(particle, flies, i)) draw_grain(*grain);
  }

  void draw_grain(const KitShading::Grain& grain) {
    const double x = 0.5 * layer.size_.width + grain.x, y = 0.5 * layer.size_.height + grain.y;
    const double area = grain.right[0] * grain.over[1] - grain.right[1] * grain.over[0];
    if (grain.depth < k_near || area == 0) return;
    // A place in the square, from -1 to 1 along and across.
    const auto along = [&](double u, double v) { return ((u - x) * grain.over[1] - (v - y) * grain.over[0]) / area; };
    const auto across = [&](double u, double v) {
      return ((v - y) * grain.right[0] - (u - x) * grain.right[1]) / area;
    };
    const double wide = std::fabs(grain.right[0]) + std::fabs(grain.over[0]),
                 high = std::fabs(grain.right[1]) + std::fabs(grain.over[1]);
    draw(
        x - wide, x + wide, y - high, y + high,
        [&](double u, double v) {
          return std::max(std::fabs(along(u, v)), std::fabs(across(u, v))) <= 1 ? grain.depth : k_beside;
        },
        [&](double u, double v) { return shading.grain_at(grain, along(u, v), across(u, v)); });
  }
};

SandLayer::SandLayer(const SandShape& shape, const SandLight& light, const CameraFrame& camera, Size size,
                     uint32_t threads, const KitChange& change)
    : size_(size),
      samples_(static_cast<size_t>(size.width) * static_cast<size_t>(size.height) *
               static_cast<size_t>(size.samples * size.samples)) {
  const KitShading shading(light, camera, shape, camera.focal * size.height, change);
  const int bands = (size.height + k_band - 1) / k_band;
  ThreadPool(threads).run(static_cast<uint32_t>(bands), [&](uint32_t i) {
    const int top = static_cast<int>(i) * k_band;
    Band band = {*this, shape, camera, KitShading(shading), top, std::min(top + k_band, size.height)};
    for (size_t t = 0; t + 2 < shape.indices.size(); t += 3) band.triangle(&shape.indices[t]);
    for (size_t k = 0; k < shape.loose.size(); ++k) band.loose(shape.loose[k], k < shape.flying);
  });
}

}  // namespace sandglass::host
