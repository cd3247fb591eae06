// The matrix of texels x cells is the product of its singular vectors. The first of them, rounded to bytes, are the
// components. The mixing is then fitted to the matrix again by least squares, so that it makes up for the rounding.
#include "models/baking/ambient.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>

#include "models/baking/light_cells.h"

namespace sandglass::host {
namespace {

constexpr double k_share_min = 1e-6;  // of the greatest singular value: below it is rounding

// Towards the rim of the square what is hidden fades to nothing, because nothing is drawn beyond. It takes the last
// 1/32 of the texels, where an object hides one to four steps of a byte.
double fade(uint32_t u, uint32_t v, uint32_t side) {
  const uint32_t to_rim = std::min({u, v, side - 1 - u, side - 1 - v});
  const double share = std::min(1.0, to_rim / (side / 32.0));
  return share * share * (3 - 2 * share);
}

}  // namespace

FloorSquare ambient_square(const ShadowBox& box, uint32_t side) {
  return {std::max(2 * box.height, box.height + std::max(box.half_x, box.half_z)), side};
}

AmbientPart find_components(const FloorSquare& square, std::span<const float> hidden, uint32_t components) {
  const Eigen::Index size = static_cast<Eigen::Index>(square.side) * square.side, cells = SANDGLASS_LIGHT_CELLS;
  Eigen::MatrixXd all(size, cells);
  for (Eigen::Index t = 0; t < size; ++t) {
    const double share =
        fade(static_cast<uint32_t>(t % square.side), static_cast<uint32_t>(t / square.side), square.side);
    for (Eigen::Index i = 0; i < cells; ++i)
      all(t, i) = share * static_cast<double>(hidden[static_cast<size_t>(t * cells + i)]);
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> parts(all, Eigen::ComputeThinU);
  Eigen::Index count = 1;
  while (count < static_cast<Eigen::Index>(components) &&
         parts.singularValues()[count] > k_share_min * parts.singularValues()[0])
    ++count;

  Eigen::MatrixXd bytes(size, count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::VectorXd texture = parts.matrixU().col(k);
    const double largest = texture.cwiseAbs().maxCoeff();
    for (Eigen::Index t = 0; t < size; ++t) bytes(t, k) = largest > 0 ? std::nearbyint(127 * texture[t] / largest) : 0;
  }
  const Eigen::MatrixXd mixing = (bytes.transpose() * bytes).ldlt().solve(bytes.transpose() * all);  // count x cells

  AmbientPart part;
  part.components = static_cast<uint32_t>(count);
  part.square = square;
  for (Eigen::Index k = 0; k < count; ++k) {
    for (Eigen::Index i = 0; i < cells; ++i) part.mixing.push_back(static_cast<float>(mixing(k, i)));
    for (Eigen::Index t = 0; t < size; ++t) part.texels.push_back(static_cast<int8_t>(bytes(t, k)));
  }
  return part;
}

}  // namespace sandglass::host
