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

// labels: of the panorama, what a perfect network would say. estimate: the library's, from the camera's image.
// arbitrary: the light of an app that knows nothing of the room.
enum class LightSource { labels, estimate, arbitrary };
const char* name_of(LightSource source);

struct ShotOptions {
  std::string panorama, photo;       // a file, or empty: the scene's room
  double photo_fov_deg = 0.0;        // diagonal
  std::string mesh;                  // of the standing object; empty: the scene's
  std::optional<LightSource> light;  // not given: an estimate where there is a network, else labels, else arbitrary
  std::string network;               // a lighting network's file; empty: the shipped one, if there is one
  sandglass_isa isa = SANDGLASS_ISA_AUTOMATIC;
  std::string folder;  // keeps the room's panorama; may be empty
  uint32_t threads = 1;
};

// How far a picture is from its truth.
struct ShotErrors {
  ImageErrors image;
  double similarity = 0.0, flip = 0.0;
};
ShotErrors shot_errors(const RadianceMap& truth, const RadianceMap& picture);
std::string shot_errors_text(const ShotErrors& errors);

// The mesh of the scene's first standing object, in the scene's frame. If `file` is not empty, it replaces the mesh
// that the scene names. A Failure says that the shadow was baked from another shape.
Mesh standing_object(const SceneFile& scene, const std::string& file);

// The shadows that the scene's standing object and these grains cast in one light, complete, as a frame has them.
ShotShadows complete_shadows(const SceneFile& scene, sandglass_isa isa, uint32_t frame,
                             const std::vector<sandglass_collider>& colliders, std::span<const float> grains,
                             float grain_radius, Vec3 towards);

class Shot {
 public:
  Shot(const SceneFile& scene, const ShotOptions& options);

  LightSource source() const { return source_; }
  const Surroundings& surroundings() const { return surroundings_; }
  ShotCamera camera(uint32_t frame) const;
  // Call before each frame: decides what it is lit by. light() returns that from then on.
  void begin(uint32_t frame);
  ShotLight light(uint32_t frame) const;
  // The handle for the frame; null unless the light is estimated.
  sandglass_light* estimator() const { return estimate_ ? estimate_->handle() : nullptr; }
  const sandglass_camera_image* image() const { return image_; }
  const ShotLight& labels() const { return labels_; }  // of the panorama; up and black without one
  // Angle between the light of a frame and the labels, degrees; below 0 where there are none.
  double angle_deg(uint32_t frame) const;

  // The snapshot as the app composites it.
  Picture paint(const Snapshot& snapshot, int width, int height, uint32_t threads) const;

  // What `compare` measures against: the snapshot path traced, and written as truth.png into `folder`.
  RadianceMap traced(const Snapshot& snapshot, const std::string& folder, uint32_t threads) const;
  // The snapshot lit so and composited, the truth, their difference times four and FLIP, side by side, into `folder` as
  // beside_truth`name`.png, the composite as composite`name`.png; the errors. The snapshot's shadows must be of this
  // light.
  ShotErrors compare(const Snapshot& snapshot, const ShotLight& light, const RadianceMap& truth,
                     const std::string& folder, const std::string& name, uint32_t threads) const;
  // The snapshot with the shadows that object and sand cast in this light, complete.
  Snapshot relit(const Snapshot& snapshot, Vec3 towards) const;

 private:
  ShotPicture drawing_of(const Snapshot& snapshot) const;
  RadianceMap composite(const Snapshot& snapshot, const ShotLight& light, const ShotPictureOptions& options) const;
  float drawn_radius(const Snapshot& snapshot) const;  // of a grain

  SceneFile scene_;
  Camera camera_;
  Mesh object_;
  LightSource source_;
  std::unique_ptr<LightEstimate> estimate_;
  Surroundings surroundings_;
  ShotLight labels_;
  const sandglass_camera_image* image_ = nullptr;
  std::vector<ShotLight> lights_;  // of the frames so far
  sandglass_isa isa_;
};

}  // namespace sandglass::host
