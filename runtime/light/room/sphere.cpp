// Where the sphere stands, and how large it is: directions and places of the world in it. It grows when the camera leaves
// it, and where what is seen is far.
#include "kernels/whole.h"
#include "runtime/light/luminance.h"
#include "runtime/light/room/room.h"
#include "runtime/math/math.h"
#include "runtime/math/turn.h"

namespace sandglass {

namespace {

// A lamp that was seen from elsewhere than the centre lies elsewhere, now that it is known to be far: it changes places
// with what was there. One that is there already, and brighter, is the same.
void move_lamps(Room* room) {
  bool moved[k_room_below] = {};
  for (uint32_t i = k_room_below; i < k_room_parts; ++i) {
    RoomPart* part = &room->parts[i];
    while (!moved[i - k_room_below] && (part->clipped > 0 || luminance(part->radiance) * room->light > room->scale)) {
      double direction[3], squared = 0, row, column;
      const uint32_t row_of = i / k_room_columns, column_of = i % k_room_columns;
      room_direction(row_of + 0.5 + part->up / 254.0, column_of + 0.5 + part->aside / 254.0, direction);
      for (int k = 0; k < 3; ++k) {
        const double from = part->from[k] / 127.0;
        direction[k] -= from;
        squared += from * from;
      }
      const uint32_t to = room_part_at(direction, &row, &column);
      moved[i - k_room_below] = true;
      if (squared < k_parallax * k_parallax || to == i || to < k_room_below) break;
      RoomPart* there = &room->parts[to];
      if (luminance(there->radiance) >= luminance(part->radiance)) {
        *part = {};
        break;
      }
      const RoomPart was = *there;
      *there = *part;
      *part = was;
      there->up = room_towards(0, 2 * room_fraction(row) - 1, 1);
      there->aside = room_towards(0, 2 * room_fraction(column) - 1, 1);
      const uint8_t white = room->white[to - k_room_below];
      room->white[to - k_room_below] = room->white[i - k_room_below];
      room->white[i - k_room_below] = white;
      moved[i - k_room_below] = moved[to - k_room_below];
      moved[to - k_room_below] = true;
    }
  }
}

void grow(Room* room, double factor, const double centre[3]) {
  double moved[3], sphere[3];
  for (int k = 0; k < 3; ++k) moved[k] = (centre[k] - room->centre[k]) / room->radius;
  room_to_sphere(*room, moved, sphere);
  for (RoomPart& part : room->parts)
    for (int k = 0; k < 3; ++k) part.from[k] = room_towards(0, (part.from[k] / 127.0 - sphere[k]) / factor, 1);
  for (int k = 0; k < 3; ++k) room->centre[k] = centre[k];
  room->radius *= factor;
}

// Beyond the walls it is another room, or a larger one: the sphere goes along, and what was seen counts as far away.
void go_along(Room* room, const CameraImage& image) {
  double place[3], squared = 0;
  for (int k = 0; k < 3; ++k) {
    place[k] = static_cast<double>(image.position[k]);
    const double offset = (place[k] - room->centre[k]) / room->radius;
    squared += offset * offset;
  }
  if (!(squared > 1) || room->radius * k_grows > k_radius_max) return;
  ++room->grown;
  grow(room, k_grows, place);
}

}  // namespace

void room_direction(double row, double column, double direction[3]) {
  const SinCos elevation = sin_cos_turns((row / k_room_rows - 0.5) / 2),
               azimuth = sin_cos_turns(column / k_room_columns);
  direction[0] = elevation.cos * azimuth.cos;
  direction[1] = elevation.sin;
  direction[2] = elevation.cos * azimuth.sin;
}

uint32_t room_part_at(const double d[3], double* row, double* column) {
  const double turns = arc_tangent2(d[2], d[0]) / (2 * k_pi);
  *row = (arc_tangent2(d[1], square_root(d[0] * d[0] + d[2] * d[2])) / k_pi + 0.5) * k_room_rows;
  *column = room_fraction(turns) * k_room_columns;
  const auto whole = static_cast<uint32_t>(floor_index(*row)), row_of = whole < k_room_rows ? whole : k_room_rows - 1;
  return row_of * k_room_columns + static_cast<uint32_t>(floor_index(*column)) % k_room_columns;
}

void room_to_sphere(const Room& room, const double world[3], double sphere[3]) {
  const SinCos turn = sin_cos_turns(room.yaw);
  sphere[0] = turn.cos * world[0] + turn.sin * world[2];
  sphere[1] = world[1];
  sphere[2] = turn.cos * world[2] - turn.sin * world[0];
}

void room_to_world(const Room& room, const double sphere[3], double world[3]) {
  const SinCos turn = sin_cos_turns(room.yaw);
  world[0] = turn.cos * sphere[0] - turn.sin * sphere[2];
  world[1] = sphere[1];
  world[2] = turn.sin * sphere[0] + turn.cos * sphere[2];
}

void room_place(const Room& room, const double world[3], double sphere[3], double farthest) {
  double offset[3], squared = 0;
  for (int k = 0; k < 3; ++k) {
    offset[k] = (world[k] - room.centre[k]) / room.radius;
    squared += offset[k] * offset[k];
  }
  if (squared > farthest * farthest)
    for (double& o : offset) o *= farthest / square_root(squared);
  room_to_sphere(room, offset, sphere);
}

double room_meet(const RoomView& view, const double ahead[3], double at[3]) {
  double along = 0, inside = 1;
  for (int k = 0; k < 3; ++k) {
    along += view.position[k] * ahead[k];
    inside -= view.position[k] * view.position[k];
  }
  const double far = square_root(along * along + inside) - along;
  for (int k = 0; k < 3; ++k) at[k] = view.position[k] + far * ahead[k];
  return far;
}

void room_fit_sphere(Room* room, const CameraImage& image) {
  constexpr double k_surely_far = 0.5;
  if (room->farther > k_surely_far) {
    room->far = true;
    room->farther = 0;
    move_lamps(room);
    grow(room, k_far, room->centre);
  }
  go_along(room, image);
}

}  // namespace sandglass
