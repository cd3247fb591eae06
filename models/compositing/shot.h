// A scene seen by a hand-held camera in a room, and lit as that room is. The light comes from one of three sources,
// which report and pictures name.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "models/compositing/image_errors.h"
#include "models/compositing/light_estimate.h"
#include "models/compositing/shot_picture.h"
#include "models/compositing/surroundings.h"
#include "models/mesh/mesh.h"
#include "models/report/pictures.h"
#include "models/simulation/scene_file.h"

namespace sandglass::host {

// room: as a session has seen it that looked around before things were placed, and goes on. truth: as it is. estimate: one light by the network, and
// nothing else. nothing: what is usual in a room, for all that the first image tells.
enum class LightSource { room, truth, estimate, nothing };
const char* name_of(LightSource source);

struct ShotOptions {
  std::string panorama, photo;  // a file, or empty: the scene's room
  std::string later;            // the room from the middle of the run on, such as with a lamp switched off
  double photo_fov_deg = 0.0;   // diagonal
  MeshFile mesh;                // of the standing object; empty: the scene's
  LightSource light = LightSource::room;
  sandglass_isa isa = SANDGLASS_ISA_AUTOMATIC;
  std::string folder;  // keeps the room's panorama; may be empty
  uint32_t threads = 1;
};

// How far a picture is from its truth.
struct ShotErrors {
  double rmse = 0.0, similarity = 0.0, flip = 0.0;
};
ShotErrors shot_errors(const RadianceMap& truth, const RadianceMap& picture);
std::string shot_errors_text(const ShotErrors& errors);

// The scene's first standing object. If `file` is not empty, it replaces the mesh that the scene names. A Failure says
// that the shadow was baked from another shape.
LitObject standing_object(const SceneFile& scene, const MeshFile& file = {});

// The shadows that the scene's standing object and particles of sand cast in a light, complete, as a frame has them.
SceneShadows complete_shadows(const SceneFile& scene, sandglass_isa isa, uint32_t frame,
                              const std::vector<sandglass_collider>& colliders, std::span<const float> particles,
                              const PlacedLight& light);

// A picture as the camera hands it out: as blurred as the room behind it is, with the noise of a small sensor.
Picture developed(const RadianceMap& shown, double blur_pixels, uint64_t seed);

class Shot {
 public:
  Shot(const SceneFile& scene, const ShotOptions& options);

  LightSource source() const { return source_; }
  const Surroundings& surroundings() const { return surroundings_; }
  // What stands behind a frame.
  const Surroundings& around(uint32_t frame) const {
    return later_ && frame >= scene_.frames / 2 ? *later_ : surroundings_;
  }
  ShotCamera camera(uint32_t frame) const;
  // Call before each frame: decides what it is lit by. light() returns that from then on.
  void begin(uint32_t frame);
  const PlacedLight& light(uint32_t frame) const;
  // What the frame is given; null where there is none.
  sandglass_estimator* estimator() const { return network_ ? network_->handle() : nullptr; }
  sandglass_room* room() const { return seen_ ? seen_->handle() : nullptr; }
  const sandglass_camera_image* image() const { return image_; }
  const std::optional<PlacedLight>& truth() const { return truth_; }  // none of a photograph
  // Angle between the middle of the floor's light of a frame and the true one, degrees; below 0 where there is none.
  double angle_deg(uint32_t frame) const;

  // The snapshot as the app composites it.
  Picture paint(const Snapshot& snapshot, int width, int height, uint32_t threads) const;

  // What the others are measured against: the snapshot path traced.
  RadianceMap traced(const Snapshot& snapshot, uint32_t threads) const;
  // The snapshot in one light.
  struct Drawn {
    std::string name;
    RadianceMap picture;
  };
  Drawn drawn(const Snapshot& snapshot, std::string name, const PlacedLight& light, CastShadow cast,
              uint32_t threads) const;
  // What an app could draw instead of the snapshot: without a shadow, with one light.
  std::vector<Drawn> alternatives(const Snapshot& snapshot, uint32_t threads) const;
  // The picture that leads, the truth beside it, and what an app could draw instead below.
  Picture sheet(const Drawn& lead, std::span<const Drawn> beside, const RadianceMap& truth) const;
  Picture developed_as_seen(const RadianceMap& shown, uint64_t seed) const;

 private:
  ShotPicture drawing_of(const Snapshot& snapshot) const;
  Vec3 standing_at(uint32_t frame) const;
  Vec3 sand_at(uint32_t frame) const;

  SceneFile scene_;
  Camera camera_;
  LitObject object_;
  LightSource source_;
  std::unique_ptr<LightEstimate> network_;
  Surroundings surroundings_;
  std::optional<Surroundings> later_;
  std::unique_ptr<SeenLight> seen_;
  std::optional<PlacedLight> truth_;    // of the last frame
  sandglass_room_light shown_[2] = {};  // at the object and at the sand, as the room's light comes in
  const sandglass_camera_image* image_ = nullptr;
  std::vector<PlacedLight> lights_;  // of the frames so far
  sandglass_isa isa_;
};

}  // namespace sandglass::host
