// An app in augmented reality. The camera looks around a room. In the light that it has seen stand a chair and a heap
// of sand on the real floor, lit, with soft and sharp shadows: 4 ms a frame. The camera is made up; copy the rest.
#include <cmath>

#include "models/examples/made_up_phone.h"
#include "sandglass/sandglass.hpp"

int main(int argc, char** argv) {
  if (argc != 3) return fails("usage", "camera_app chair.shadow saved.room");
  const Asset baked(argv[1]), saved(argv[2]);
  sandglass::Room room;  // an earlier session may have looked around already
  sandglass::Status status = room.create();
  if (saved.bytes > 0) status = room.restore(saved.words.data(), saved.bytes);
  if (!status) return fails(argv[2], status.reason);
  // The chair's shadows, and how the points of its mesh see the room past the chair itself: here one, on its seat.
  const sandglass_shadow_desc shadow_desc = sandglass::shadow_desc(baked.words.data(), baked.bytes);
  sandglass::Shadow shadow;
  std::vector<float> seat = {0, 0.46f, 0}, normal = {0, 1, 0}, transfer;  // nine for each point
  status = shadow.create(shadow_desc);                                    // a shadow from the first frame on
  shadow.run();
  if (status) status = sandglass::shadow_transfer(shadow_desc, seat, normal, &transfer);
  if (!status) return fails(argv[1], status.reason);
  // Sand is poured beside the chair: particles that collide, grains that are drawn, and the shadow that they cast.
  const sandglass_emitter nozzle = sandglass::emitter(0.32f, 0.3f, 0.08f, 0.04f, 0.5f, 8);
  sandglass_scene_desc desc = sandglass::scene_desc();
  desc.clock = sandglass_clock_system();
  desc.granular.particle_capacity = 1000;
  desc.granular.grain_capacity = 8 * 1000;
  desc.granular.emitter_capacity = 1;
  sandglass_pile_shadow_desc pile_desc = sandglass::pile_shadow_desc();  // one square metre around the origin
  pile_desc.sky_texels = 64;
  sandglass::Scene scene;
  sandglass::PileShadow pile;
  status = scene.create(desc);
  if (status) status = pile.create(pile_desc);
  std::vector<sandglass_grain> drawn(desc.granular.grain_capacity);  // stands for a mapped vertex buffer
  const sandglass_collider floor = sandglass::floor_at(0.0f);        // the plane that ARCore or ARKit found
  sandglass_shadow* const shadows[] = {shadow.get()};
  sandglass_frame_input input = sandglass::frame_input(1.0f / 60.0f, 4'000'000);
  input.emitters = &nozzle;
  input.emitter_count = 1;
  input.colliders = &floor;
  input.collider_count = 1;
  input.grains = drawn.data();
  input.grain_capacity = desc.granular.grain_capacity;
  input.shadows = shadows;
  input.shadow_count = 1;
  input.pile_shadow = pile.get();
  input.room = room.get();
  MadeUpCamera camera;
  const float turn = 0.4f, place[3] = {0, 0, 0};                     // of the chair
  sandglass_room_light light = room.light_at(place), known = light;  // before any image: what is usual in a room
  const float s = std::sin(turn), c = std::cos(turn), *d = light.main_direction;
  const float rotation[4] = {0, std::sin(turn / 2), 0, std::cos(turn / 2)};
  float sh[27], green = 0.0f;
  int hints = 0;
  for (int frame = 0; status && frame < MadeUpCamera::k_frames; ++frame) {
    input.camera = camera.next_image();  // NULL where the camera, slower than the display, has no new one
    status = shadow.set_light({c * d[0] - s * d[2], d[1], s * d[0] + c * d[2]});  // the light in the chair's frame
    if (status) status = shadow.set_cells(light.ambient_cells, turn);
    if (status) status = pile.set_light({d[0], d[1], d[2]});
    if (status) status = pile.set_cells(light.ambient_cells);
    if (status) status = scene.frame(input);
    if (input.camera != nullptr) known = room.light_at(place, &light);
    sandglass_room_fade(&light, &known, input.time_step);  // no shadow jumps
    // Draw here: `drawn`; the camera's image times what ambient(), texture() and sky() of both shadows leave of it; the
    // chair, as a vertex shader does: nine products a colour (runtime/shadow/README.md).
    if (status) status.code = sandglass_harmonics_turn(light.sh, rotation, sh, &status.reason);
    if (known.seen < 0.5f) ++hints;  // show an arrow to known.look: "please look there"
    if (known.short_exposure < 1 && frame % 16 == 0) camera.expose_shortly(known.short_exposure);
  }
  for (size_t j = 0; status && j < 9; ++j) green += light.white * transfer[j] * sh[3 * j + 1];  // of the seat
  std::vector<std::byte> kept;
  if (status) status = room.save(&kept);
  if (!status) return fails(status.name(), status.reason);
  std::printf("seen %.2f, main (%.2f %.2f %.2f), %.2f of the floor's %.2f; %d hints, %d short images; seat %.2f\n",
              light.seen, d[0], d[1], d[2], light.main_share, light.irradiance[1] * light.white, hints, camera.asked,
              green);
  return save(argv[2], kept) ? 0 : 1;
}
