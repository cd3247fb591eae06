// The sheet of a shot: the composite, the truth beside it at the same size, and below what an app could draw instead.
#include "models/compositing/shot.h"

namespace sandglass::host {

Picture Shot::sheet(const Drawn& lead, std::span<const Drawn> beside, const RadianceMap& truth) const {
  constexpr Colour k_paper = {250, 250, 248};
  constexpr int k_gap = 8;  // pixels
  std::vector<Picture> pictures = {developed_as_seen(lead.picture, 2), developed_as_seen(truth, 1)};
  for (const Drawn& other : beside) pictures.push_back(developed_as_seen(other.picture, 3));
  const int width = pictures[0].width + k_gap, height = pictures[0].height + k_gap;
  const auto rows = static_cast<int>(pictures.size() + 1) / 2;
  Picture sheet(2 * width - k_gap, rows * height - k_gap, k_paper);
  for (int i = 0; i < static_cast<int>(pictures.size()); ++i)
    paste(&sheet, pictures[static_cast<size_t>(i)], i % 2 * width, i / 2 * height);
  return sheet;
}

}  // namespace sandglass::host
