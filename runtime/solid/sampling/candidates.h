// Candidates of Alg. 1: random points spread evenly over the triangles, (3.15)-(3.21). A stream can be drawn twice with
// the same result. So the candidate grid is filled in two passes, count and place, without a copy of the points.
#pragma once

#include "runtime/solid/sampling/streams.h"
#include "sandglass/sampling.h"

namespace sandglass {

struct Candidate {
  float position[3];
  uint32_t triangle;
};

// The area of the mesh. Where `running` is not null it gets the running sum, one entry a triangle, by which triangles
// are chosen.
double sum_areas(const sandglass_mesh& mesh, double* running);

struct CandidateStream {
  const sandglass_mesh* mesh;
  const double* running;
  double area;
  Random random;
};

CandidateStream candidate_stream(const sandglass_mesh& mesh, const double* running, double area, uint64_t seed);
Candidate draw_candidate(CandidateStream* stream);

// max(tries, tries*A/(pi l^2)). An object smaller than a disk gets as many candidates as one disk.
double candidate_count(double area, float distance, uint32_t tries);

}  // namespace sandglass
