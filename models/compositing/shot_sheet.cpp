// The sheet of a shot: the composite leads; beside it stand what an app could draw instead and the truth; below, what
// the session has seen, as a globe from both sides.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "models/compositing/shot.h"
#include "runtime/room/room.h"

namespace sandglass::host {

namespace {

constexpr Colour k_paper = {250, 250, 248}, k_ink = {24, 28, 34}, k_unseen = {176, 178, 182}, k_line = {150, 152, 156};
constexpr int k_gap = 12, k_caption = 26, k_text = 2;  // pixels, and their size in the font's pixels

void paste(Picture* onto, const Picture& picture, int left, int top) {
  for (int y = 0; y < picture.height; ++y)
    std::copy_n(picture.at(0, y), 3 * static_cast<size_t>(picture.width), onto->at(left, top + y));
}

// The sphere around the session from outside, seen along `towards` and from a little above: each part in the colour that
// was seen there, grey where nothing was.
void draw_globe(Picture* picture, const sandglass::Room& room, double exposure, Vec3 towards, int left, int top,
                int size) {
  const Vec3 forward = normalised(Vec3{towards.x, -0.35, towards.z});
  const Vec3 right = normalised(cross(forward, Vec3{0, 1, 0})), up = cross(right, forward);
  constexpr double k_edge = 0.06;  // of a part: its border
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const double u = 2.0 * (x + 0.5) / size - 1.0, v = 1.0 - 2.0 * (y + 0.5) / size, square = u * u + v * v;
      if (square > 1.0) continue;
      const Vec3 d = right * u + up * v - forward * std::sqrt(1.0 - square);
      const double turns = std::atan2(d.z, d.x) / (2.0 * std::numbers::pi) - room.yaw;
      const double column = (turns - std::floor(turns)) * k_room_columns;
      const double row = (std::asin(std::clamp(d.y, -1.0, 1.0)) / std::numbers::pi + 0.5) * k_room_rows;
      const auto index = std::min(static_cast<uint32_t>(row), k_room_rows - 1) * k_room_columns +
                         static_cast<uint32_t>(column) % k_room_columns;
      const RoomPart& part = room.parts[index];
      const double seen = static_cast<double>(part.seen);
      const bool line = std::min({row - std::floor(row), column - std::floor(column)}) < k_edge;
      const uint8_t grey[3] = {k_unseen.r, k_unseen.g, k_unseen.b}, lines[3] = {k_line.r, k_line.g, k_line.b};
      for (size_t c = 0; c < 3; ++c) {
        const double shown =
            linear_of(grey[c]) * (1.0 - seen) + seen * exposure * static_cast<double>(part.radiance[c]);
        picture->at(left + x, top + y)[c] = line ? lines[c] : srgb_byte(shown);
      }
    }
}

}  // namespace

Picture Shot::sheet(const Drawn& lead, std::span<const Drawn> beside, const RadianceMap& truth) const {
  const Picture large = developed_as_seen(lead.picture, 2);
  std::vector<std::pair<std::string, Picture>> small;
  for (const Drawn& other : beside) small.emplace_back(other.name, halved(developed_as_seen(other.picture, 3)));
  small.emplace_back("truth, path traced", halved(developed_as_seen(truth, 1)));
  const int cell_width = large.width / 2, cell_height = large.height / 2;
  const auto columns = static_cast<int>(small.size() + 1) / 2;
  const int globe = seen_ ? 132 : 0, strip = seen_ ? globe + k_gap : 0;
  Picture sheet(large.width + columns * (cell_width + k_gap) + 2 * k_gap,
                2 * cell_height + 2 * k_caption + 2 * k_gap + k_gap + strip, k_paper);
  const int lead_top = k_gap + (2 * (cell_height + k_caption) + k_gap - large.height - k_caption) / 2;
  paste(&sheet, large, k_gap, lead_top);
  draw_text(&sheet, k_gap, lead_top + large.height + 8, k_text, lead.name + ", composited", k_ink);
  for (size_t i = 0; i < small.size(); ++i) {
    const int left = large.width + 2 * k_gap + static_cast<int>(i) % columns * (cell_width + k_gap);
    const int top = k_gap + static_cast<int>(i) / columns * (cell_height + k_caption + k_gap);
    paste(&sheet, small[i].second, left, top);
    draw_text(&sheet, left, top + cell_height + 8, k_text, small[i].first, k_ink);
  }
  if (seen_) {
    const int top = sheet.height - globe - k_gap;
    const sandglass::Room& seen = seen_->handle()->room;
    const Vec3 ahead = resting_camera(camera_).forward;
    draw_globe(&sheet, seen, surroundings_.exposure, ahead * -1.0, k_gap, top, globe);
    draw_globe(&sheet, seen, surroundings_.exposure, ahead, 2 * k_gap + globe, top, globe);
    char text[160];
    std::snprintf(text, sizeof text, "seen by the phone: %.0f %% of the usual light",
                  100.0 * static_cast<double>(lights_.back().object.seen));
    const int left = 2 * globe + 4 * k_gap;
    draw_text(&sheet, left, top + 30, k_text, text, k_ink);
    std::snprintf(text, sizeof text, "%u images, ahead and behind. Grey: not seen", seen.images);
    draw_text(&sheet, left, top + 60, k_text, text, k_ink);
  }
  return sheet;
}

}  // namespace sandglass::host
