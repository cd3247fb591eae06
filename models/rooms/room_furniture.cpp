// Furniture and what hangs on walls. Blocks stand for tables, chairs, shelves, sofas, beds, cupboards, plants, boxes,
// doors and pictures. Only their shadows, their colours and the dark corners beside them matter.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "models/rooms/panorama.h"
#include "models/rooms/room_builder.h"

namespace sandglass::host {

namespace {

constexpr double k_quarter = 0.5 * std::numbers::pi;
constexpr double k_yaw[4] = {0.0, -k_quarter, 2.0 * k_quarter, k_quarter};  // at each wall, fronts face the room

RoomMaterial wood(RoomBuilder* b) {
  RoomMaterial m;
  m.colour = b->colour({0.05, 0.11}, {0.3, 0.75}, b->log_between(0.05, 0.45));
  m.second = m.colour * 0.6;
  m.pattern = Pattern::planks;
  m.scale = b->between(0.1, 0.4);
  if (b->chance(0.3)) {
    m.coat = 0.04;
    m.coat_blur = b->between(0.05, 0.3);
  }
  return m;
}

RoomMaterial fabric(RoomBuilder* b) {
  RoomMaterial m;
  m.colour = b->colour({0.0, 1.0}, {0.0, 0.7}, b->log_between(0.04, 0.6));
  m.second = m.colour * b->between(0.5, 0.9);
  constexpr Pattern k_patterns[] = {Pattern::plain, Pattern::blotches, Pattern::stripes, Pattern::checker};
  m.pattern = k_patterns[b->pick(4)];
  m.scale = b->between(0.02, 0.3);
  return m;
}

RoomMaterial lacquer(RoomBuilder* b) {
  RoomMaterial m;
  const double bright = b->log_between(0.03, 0.8), saturation = b->chance(0.5) ? 0.08 : b->between(0.2, 0.8);
  m.colour = colour_of_hue(b->between(0.0, 1.0), saturation, bright);
  m.coat = 0.04;
  m.coat_blur = b->log_between(0.02, 0.3);
  return m;
}

// A piece of furniture in its own frame: x to its right, z to its front, turned by yaw about its place on the floor.
struct Piece {
  RoomBuilder* b;
  Vec3 at;
  double yaw;

  Vec3 place(double x, double z) const {
    const Vec3 right = {std::cos(yaw), 0.0, -std::sin(yaw)}, front = {std::sin(yaw), 0.0, std::cos(yaw)};
    return at + right * x + front * z;
  }
  void box(double x, double y, double z, double wide, double tall, double deep, int material) const {
    b->box(place(x, z) + Vec3{0.0, y, 0.0}, {wide, tall, deep}, yaw, material);
  }
  void legs(double wide, double deep, double tall, double thick, int material) const {
    for (const double x : {-0.5, 0.5})
      for (const double z : {-0.5, 0.5}) box(x * (wide - thick), 0.0, z * (deep - thick), thick, tall, thick, material);
  }
};

void clutter(const Piece& p, double wide, double deep, double top, int count) {
  RoomBuilder* b = p.b;
  for (int i = 0; i < count; ++i) {
    const double x = b->between(-0.4, 0.4) * wide, z = b->between(-0.4, 0.4) * deep;
    const double side = b->between(0.04, 0.22), tall = b->between(0.02, 0.3);
    const int skin = b->material(lacquer(b));
    const Vec3 at = p.place(x, z) + Vec3{0.0, top, 0.0};
    if (b->chance(0.6)) {
      const double yaw = b->between(0.0, k_quarter), depth = side * b->between(0.4, 1.4);
      b->box(at, {side, tall, depth}, yaw, skin);
    } else if (b->chance(0.6)) {
      b->cylinder(at, 0.4 * side, tall, 8, skin);
    } else {
      b->sphere(at + Vec3{0.0, 0.4 * side, 0.0}, 0.4 * side, skin);
    }
  }
}

void chair(RoomBuilder* b, Vec3 at, double yaw, int frame, int seat) {
  const Piece p = {b, at, yaw};
  p.legs(0.42, 0.42, 0.45, 0.04, frame);
  p.box(0.0, 0.43, 0.0, 0.44, 0.05, 0.44, seat);
  p.box(0.0, 0.48, -0.2, 0.42, b->between(0.3, 0.5), 0.04, seat);
}

void table(RoomBuilder* b) {
  const double wide = b->between(0.7, 2.0), deep = b->between(0.6, 1.0), tall = b->chance(0.75) ? 0.74 : 0.42;
  const bool turned = b->chance(0.5);
  const double margin = 0.5;
  Vec3 at;
  if (!b->place((turned ? deep : wide) + margin, (turned ? wide : deep) + margin, &at)) return;
  const Piece p = {b, at, turned ? k_quarter : 0.0};
  const int top = b->material(b->chance(0.7) ? wood(b) : lacquer(b)), frame = b->material(lacquer(b));
  p.box(0.0, tall - 0.04, 0.0, wide, 0.04, deep, top);
  p.legs(wide, deep, tall - 0.04, b->between(0.03, 0.08), frame);
  clutter(p, wide, deep, tall, b->pick(9));
  if (tall < 0.5) return;
  const int seat = b->material(b->chance(0.5) ? fabric(b) : wood(b)), chairs = b->pick(5);
  for (int i = 0; i < chairs; ++i) {
    const double side = i % 2 == 0 ? 1.0 : -1.0, x = wide * (chairs <= 2 ? 0.0 : i < 2 ? -0.25 : 0.25);
    const double z = side * (0.5 * deep + b->between(-0.05, 0.2));
    chair(b, p.place(x, z), p.yaw + (side > 0.0 ? std::numbers::pi : 0.0) + b->between(-0.3, 0.3), frame, seat);
  }
}

// Puts a piece with its back to a random wall. Returns false if there is no space.
bool against_wall(RoomBuilder* b, double wide, double deep, Piece* piece) {
  const Vec3 s = b->room.size;
  for (int i = 0; i < 8; ++i) {
    const int side = b->pick(4);
    const bool along_x = side % 2 == 0;
    const double run = along_x ? s.x : s.z;
    if (run < wide + 0.1 || (along_x ? s.z : s.x) < deep + 0.1) continue;
    const double start = b->between(0.02, run - wide - 0.02), mid = start + 0.5 * wide;
    const double near_x[4] = {start, s.x - deep - 0.03, start, 0.03},
                 near_z[4] = {0.03, start, s.z - deep - 0.03, start};
    const double size_x = along_x ? wide : deep, size_z = along_x ? deep : wide;
    if (!b->place_at(near_x[side], near_z[side], near_x[side] + size_x, near_z[side] + size_z)) continue;
    const Vec3 places[4] = {{mid, 0, 0.03 + 0.5 * deep},
                            {s.x - 0.03 - 0.5 * deep, 0, mid},
                            {mid, 0, s.z - 0.03 - 0.5 * deep},
                            {0.03 + 0.5 * deep, 0, mid}};
    *piece = {b, places[side], k_yaw[side]};
    return true;
  }
  return false;
}

void sofa(RoomBuilder* b) {
  const double wide = b->between(0.8, 2.4), deep = b->between(0.75, 1.0);
  Piece p;
  if (!against_wall(b, wide, deep, &p)) return;
  const int cloth = b->material(fabric(b)), cushion = b->material(fabric(b));
  p.box(0, 0.08, 0, wide, 0.34, deep, cloth);
  p.box(0, 0.42, -0.5 * deep + 0.1, wide, 0.4, 0.2, cloth);
  for (const double side : {-0.5, 0.5}) p.box(side * (wide - 0.16), 0.08, 0, 0.16, 0.52, deep, cloth);
  const int cushions = b->pick(4);
  for (int i = 0; i < cushions; ++i) {
    const double tall = b->between(0.2, 0.4), x = b->between(-0.35, 0.35) * wide;
    p.box(x, 0.42, -0.1, 0.4, tall, 0.14, cushion);
  }
}

void bed(RoomBuilder* b) {
  Piece p;
  const double wide = b->between(0.9, 1.8);
  if (!against_wall(b, wide, 2.05, &p)) return;
  const int frame = b->material(wood(b)), cover = b->material(fabric(b)), pillow = b->material({{0.8, 0.79, 0.76}});
  p.box(0, 0, 0, wide, 0.3, 2.0, frame);
  p.box(0, 0.3, 0.02, wide - 0.04, 0.22, 1.95, cover);
  p.box(0, 0.3, -1.0, wide, b->between(0.4, 0.8), 0.05, frame);
  for (const double side : {-0.24, 0.24}) p.box(side * wide, 0.52, -0.75, 0.4 * wide, 0.12, 0.35, pillow);
}

void shelf(RoomBuilder* b) {
  const double wide = b->between(0.6, 2.2), tall = std::min(b->between(0.8, 2.2), b->room.size.y - 0.2), deep = 0.32;
  Piece p;
  if (!against_wall(b, wide, deep, &p)) return;
  const int frame = b->material(b->chance(0.6) ? wood(b) : lacquer(b));
  const int boards = std::max(2, static_cast<int>(tall / b->between(0.3, 0.42)));
  for (const double side : {-0.5, 0.5}) p.box(side * wide, 0, 0, 0.025, tall, deep, frame);
  p.box(0, 0, -0.5 * deep + 0.01, wide, tall, 0.012, frame);
  for (int i = 0; i <= boards; ++i) p.box(0, i * (tall - 0.025) / boards, 0, wide, 0.025, deep, frame);
  int spines[6];
  for (int& spine : spines) spine = b->material(fabric(b));
  const double step = (tall - 0.025) / boards, full = b->between(0.2, 1.0);
  for (int i = 0; i < boards; ++i)
    for (double x = -0.5 * wide + 0.05; x < 0.5 * wide - 0.08;) {
      const double thick = b->between(0.02, 0.07);
      if (b->chance(full)) {
        const int spine = spines[b->pick(6)];
        p.box(x + 0.5 * thick, i * step + 0.025, 0.02, thick, b->between(0.55, 0.9) * (step - 0.03), 0.2, spine);
      }
      x += thick + (b->chance(full) ? 0.003 : 0.1);
    }
}

void cupboard(RoomBuilder* b) {
  const double wide = b->between(0.5, 2.4), tall = std::min(b->between(0.5, 2.2), b->room.size.y - 0.2),
               deep = b->between(0.35, 0.65);
  Piece p;
  if (!against_wall(b, wide, deep, &p)) return;
  const int body = b->material(b->chance(0.5) ? wood(b) : lacquer(b)), gap = b->material({{0.05, 0.05, 0.05}});
  p.box(0, 0, 0, wide, tall, deep, body);
  const int doors = std::max(1, static_cast<int>(wide / 0.5));
  for (int i = 1; i < doors; ++i)
    p.box(wide * (static_cast<double>(i) / doors - 0.5), 0.03, 0.5 * deep, 0.008, tall - 0.05, 0.004, gap);
  if (tall < 1.3) clutter(p, wide, deep, tall, b->pick(7));
}

void plant(RoomBuilder* b) {
  Vec3 at;
  const double tall = b->between(0.5, 1.9);
  if (!b->place(0.5, 0.5, &at)) return;
  const int glaze = b->material(lacquer(b));
  const double pot = b->between(0.15, 0.4);
  b->cylinder(at, b->between(0.1, 0.2), pot, 10, glaze);
  RoomMaterial leaf;
  leaf.colour = b->colour({0.22, 0.38}, {0.5, 0.8}, b->log_between(0.03, 0.2));
  const int green = b->material(leaf);
  for (int i = 0; i < 60; ++i) {
    const double turn = b->between(0.0, 4.0 * k_quarter), reach = b->between(0.05, 0.3),
                 y = b->between(0.3, 1.0) * tall;
    const Vec3 out = {std::cos(turn), b->between(-0.3, 0.8), std::sin(turn)};
    const Vec3 root = at + Vec3{0.3 * reach * out.x, y, 0.3 * reach * out.z};
    b->quad(root, out * reach, cross(out, Vec3{0, 1, 0}) * 0.08, green);
  }
}

void boxes(RoomBuilder* b) {
  Vec3 at;
  const double side = b->between(0.2, 0.7);
  if (!b->place(side + 0.1, side + 0.1, &at)) return;
  double y = 0.0;
  for (int i = 0; i < 1 + b->pick(3); ++i) {
    const double tall = b->between(0.15, 0.6);
    RoomMaterial m = fabric(b);
    if (b->chance(0.5)) {
      m.colour = {0.42, 0.28, 0.16};
      m.pattern = Pattern::plain;
    }
    const double yaw = b->between(0.0, 0.5), wide = side * b->between(0.6, 1.0), deep = side * b->between(0.6, 1.0);
    b->box(at + Vec3{0, y, 0}, {wide, tall, deep}, yaw, b->material(m));
    y += tall;
  }
}

void rug(RoomBuilder* b) {
  const Vec3 s = b->room.size;
  const double wide = b->between(0.4, 0.7) * s.x, deep = b->between(0.4, 0.7) * s.z;
  RoomMaterial m = fabric(b);
  if (b->chance(0.4)) {
    m.pattern = Pattern::mosaic;
    m.scale = b->between(0.05, 0.3);
  }
  b->quad({b->between(0.0, s.x - wide), 0.008, b->between(0.0, s.z - deep)}, {0, 0, deep}, {wide, 0, 0},
          b->material(m));
}

// Hangs a thin box on a wall: a picture, a mirror without its reflection, a notice board or a door. If a window or a
// lamp within 0.3 m of the wall is in the way, it hangs nothing.
void hang(RoomBuilder* b, double wide, double tall, double low, const RoomMaterial& face, bool framed) {
  const Vec3 s = b->room.size;
  const int side = b->pick(4), skin = b->material(face), frame = b->material(wood(b));
  const bool along_x = side % 2 == 0;
  const double run = along_x ? s.x : s.z;
  if (wide > run - 0.2 || low + tall > s.y - 0.1) return;
  const double mid = b->between(0.1 + 0.5 * wide, run - 0.1 - 0.5 * wide);
  const Vec3 places[4] = {{mid, 0, 0.02}, {s.x - 0.02, 0, mid}, {mid, 0, s.z - 0.02}, {0.02, 0, mid}};
  for (const Emitter& e : b->room.emitters) {
    const Vec3 low_corner = e.corner, high_corner = e.corner + e.edge_a + e.edge_b, at = places[side];
    const double reach = 0.5 * wide + 0.05;
    const bool beside =
        along_x ? at.x + reach < std::min(low_corner.x, high_corner.x) ||
                      at.x - reach > std::max(low_corner.x, high_corner.x) || std::fabs(at.z - low_corner.z) > 0.3
                : at.z + reach < std::min(low_corner.z, high_corner.z) ||
                      at.z - reach > std::max(low_corner.z, high_corner.z) || std::fabs(at.x - low_corner.x) > 0.3;
    if (!beside) return;
  }
  const Piece p = {b, places[side], k_yaw[side]};
  p.box(0, low, 0.0, wide, tall, 0.03, framed ? frame : skin);
  if (framed) p.box(0, low + 0.03, 0.01, wide - 0.06, tall - 0.06, 0.03, skin);
}

}  // namespace

void furnish(RoomBuilder* b) {
  const double area = b->room.size.x * b->room.size.z;
  if (b->chance(0.35)) rug(b);
  hang(b, 0.9, 2.05, 0.0, b->chance(0.5) ? wood(b) : lacquer(b), true);
  const int pictures = b->pick(6);
  for (int i = 0; i < pictures; ++i) {
    RoomMaterial art;
    art.colour = b->colour({0.0, 1.0}, {0.0, 0.8}, b->log_between(0.05, 0.7));
    art.second = b->colour({0.0, 1.0}, {0.0, 0.8}, b->log_between(0.05, 0.7));
    art.pattern = b->chance(0.5) ? Pattern::mosaic : Pattern::blotches;
    art.scale = b->between(0.05, 0.4);
    const bool framed = b->chance(0.7);
    const double low = b->between(0.9, 1.5), tall = b->between(0.25, 1.0), wide = b->between(0.25, 1.4);
    hang(b, wide, tall, low, art, framed);
  }
  const int pieces = std::clamp(static_cast<int>(area / b->between(1.5, 5.0)), 1, 26);
  constexpr void (*k_pieces[9])(RoomBuilder*) = {sofa, bed, shelf, shelf, cupboard, plant, boxes, table, table};
  for (int i = 0; i < pieces; ++i) k_pieces[b->pick(9)](b);
}

}  // namespace sandglass::host
