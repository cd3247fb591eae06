// See candidates.h.
#include "runtime/solid/sampling/candidates.h"

#include "runtime/math/math.h"

namespace sandglass {
namespace {

const float* corner(const sandglass_mesh& mesh, uint32_t triangle, int k) {
  return mesh.vertices + 3ull * mesh.indices[3ull * triangle + k];
}

double triangle_area(const float* a, const float* b, const float* c) {  // (3.17)
  double e[3], f[3];
  for (int k = 0; k < 3; ++k) {
    e[k] = static_cast<double>(b[k]) - static_cast<double>(a[k]);
    f[k] = static_cast<double>(c[k]) - static_cast<double>(a[k]);
  }
  const double x = e[1] * f[2] - e[2] * f[1], y = e[2] * f[0] - e[0] * f[2], z = e[0] * f[1] - e[1] * f[0];
  return 0.5 * square_root(x * x + y * y + z * z);
}

}  // namespace

double sum_areas(const sandglass_mesh& mesh, double* running) {
  double sum = 0;
  for (uint32_t t = 0; t < mesh.triangle_count; ++t) {
    sum += triangle_area(corner(mesh, t, 0), corner(mesh, t, 1), corner(mesh, t, 2));
    if (running != nullptr) running[t] = sum;
  }
  return sum;
}

CandidateStream candidate_stream(const sandglass_mesh& mesh, const double* running, double area, uint64_t seed) {
  return {&mesh, running, area, random_stream(seed, k_stream_candidates)};
}

Candidate draw_candidate(CandidateStream* stream) {
  const sandglass_mesh& mesh = *stream->mesh;
  // The first triangle whose running sum exceeds the drawn area. So a triangle without area is never drawn.
  const double target = stream->random.uniform() * stream->area;
  uint32_t low = 0, high = mesh.triangle_count - 1;
  while (low < high) {
    const uint32_t middle = low + (high - low) / 2;
    if (stream->running[middle] > target) high = middle;
    else low = middle + 1;
  }
  const double root = square_root(stream->random.uniform());
  const double u = 1 - root, v = stream->random.uniform() * root, w = 1 - u - v;  // (3.19)-(3.21)
  Candidate candidate;
  const float *a = corner(mesh, low, 0), *b = corner(mesh, low, 1), *c = corner(mesh, low, 2);
  for (int k = 0; k < 3; ++k)
    candidate.position[k] = static_cast<float>(u * static_cast<double>(a[k]) + v * static_cast<double>(b[k]) +
                                               w * static_cast<double>(c[k]));
  candidate.triangle = low;
  return candidate;
}

double candidate_count(double area, float distance, uint32_t tries) {
  const double disk = k_pi * static_cast<double>(distance) * static_cast<double>(distance);
  const double count = tries * area / disk;
  return count > tries ? static_cast<double>(ceiling_index(count < 1e18 ? count : 1e18)) : tries;
}

}  // namespace sandglass
