// How well the grains that are drawn stand for the particles that are simulated: whether they are where the particles
// are, and whether they go there without jumps. Points are 3 floats each; r is the particles' radius.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace sandglass::host {

// At one instant.
struct Placement {
  double bare = 0.0;             // % of particles with under a quarter of the mean number of grains within 1.5 r
  double beyond = 0.0;           // % of grains without a particle within 1.5 r
  double half = 0.0, p95 = 0.0;  // radius about the particles' vertical axis that holds 50 or 95 % of the grains, over
                                 // that of the particles
  double wrong = 0.0;            // % of the sand that is drawn in the wrong cell
};
// Wrong cell: half the sum of |share of the grains - share of the particles| over cells with edges of 4 r, the mean of
// four origins, less what as many grains at random in balls of 1 r about their particles have: so 0 is as good as that.
Placement measure_placement(std::span<const float> particles, std::span<const float> grains, double radius,
                            uint64_t seed);

// From frame to frame. A move is a grain's way in a frame above 0.3 r. It is a jump where it is more than 1 r longer
// than the way of every particle within 3 r, and where there is one.
class GrainMoves {
 public:
  // `seconds`: of the frame. New points may have come at the end of the arrays.
  void frame(std::span<const float> particles, std::span<const float> grains, double radius, double seconds);
  double jumps_per_million() const { return moves_ > 0.0 ? 1e6 * jumps_ / moves_ : 0.0; }
  // The longest move, in r, of a grain that was slower than 0.1 m/s in the frame before, while all particles within 3 r
  // are: one sees it.
  double slow_displacement() const { return slow_displacement_; }

 private:
  std::vector<float> particles_, grains_, before_;  // of the last frame; `before_`: grains of the one before it
  double moves_ = 0.0, jumps_ = 0.0, slow_displacement_ = 0.0;
};

}  // namespace sandglass::host
