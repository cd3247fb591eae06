// The column in Bullet. Positions are converted back to metres, and the same code as for our own measures overlaps.
// It runs between frames and is not part of the times.
#include "tests/laboratory/sand/peer_bullet.h"

#include "models/files/failure.h"

#if defined(SANDGLASS_HAVE_BULLET)

#include <btBulletDynamicsCommon.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <vector>

#include "models/simulation/metrics.h"
#include "models/simulation/scene_fill.h"
#include "models/simulation/simulation.h"

namespace sandglass::host {

namespace {

constexpr double k_scale = 100.0;         // units of length in Bullet for one metre
constexpr double k_longest_step = 0.005;  // seconds
constexpr int k_contacts_per_particle =
    12;  // pairs of a close packing count 6; the rest is room for AABBs that overlap

btVector3 scaled(const float* v) {
  const auto part = [&](int k) { return static_cast<btScalar>(k_scale * static_cast<double>(v[k])); };
  return {part(0), part(1), part(2)};
}

// The engine and the objects that it only refers to. Members are destroyed in reverse order.
struct World {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  std::vector<std::unique_ptr<btCollisionShape>> shapes;
  std::vector<std::unique_ptr<btRigidBody>> bodies;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};

  explicit World(int particles) : configuration(pools(particles)) {}
  ~World() {
    for (const std::unique_ptr<btRigidBody>& body : bodies) world.removeRigidBody(body.get());
  }

  static btDefaultCollisionConstructionInfo pools(int particles) {
    btDefaultCollisionConstructionInfo info;
    info.m_defaultMaxPersistentManifoldPoolSize = k_contacts_per_particle * particles;
    info.m_defaultMaxCollisionAlgorithmPoolSize = k_contacts_per_particle * particles;
    return info;
  }

  void add(btCollisionShape* shape, btScalar mass, const btTransform& pose, double friction) {
    btVector3 inertia(0, 0, 0);
    if (mass > 0) shape->calculateLocalInertia(mass, inertia);
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape, inertia);
    info.m_startWorldTransform = pose;
    info.m_friction = static_cast<btScalar>(std::sqrt(friction));  // Bullet multiplies the two values of a pair
    bodies.push_back(std::make_unique<btRigidBody>(info));
    world.addRigidBody(bodies.back().get());
  }
};

}  // namespace

bool bullet_available() { return true; }

BenchRow bench_bullet(SceneFile scene, uint32_t frames, const BenchStep& step) {
  for (Body& body : scene.bodies) {
    body.grains = 0;
    body.grain_distance = 0.0;
  }
  const Material material = fill_scene(&scene, {});
  const uint32_t count = material.particles();

  World engine(static_cast<int>(count));
  engine.world.setGravity(scaled(scene.gravity));
  const double friction = static_cast<double>(scene.granular.kinetic_friction);
  for (const ColliderTrack& track : scene.colliders) {
    const sandglass_collider plane = collider_over_frame(track, 0.0, scene.frame_step);
    engine.shapes.push_back(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), btScalar(0)));
    engine.add(engine.shapes.back().get(), 0,
               btTransform(btQuaternion(plane.rotation[0], plane.rotation[1], plane.rotation[2], plane.rotation[3]),
                           scaled(plane.position)),
               friction);
  }
  const size_t first = engine.bodies.size();
  engine.shapes.push_back(std::make_unique<btSphereShape>(static_cast<btScalar>(k_scale * scene.particle_radius)));
  btCollisionShape* sphere = engine.shapes.back().get();
  for (uint32_t i = 0; i < count; ++i)
    engine.add(sphere, 1, btTransform(btQuaternion::getIdentity(), scaled(&material.particle_positions[3ull * i])),
               friction);

  BenchRow row;
  OverlapOverRun overlap;
  std::vector<float> positions(3ull * count);
  const int parts = static_cast<int>(std::ceil(scene.frame_step / k_longest_step - 1e-6));
  const btScalar part = static_cast<btScalar>(scene.frame_step / parts);
  for (uint32_t frame = 0; frame < frames; ++frame) {
    const auto from = std::chrono::steady_clock::now();
    for (int i = 0; i < parts; ++i) engine.world.stepSimulation(part, 0);  // 0: exactly this step
    row.ms_per_frame += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - from).count();
    for (uint32_t i = 0; i < count; ++i) {
      const btVector3& at = engine.bodies[first + i]->getWorldTransform().getOrigin();
      for (int k = 0; k < 3; ++k)
        positions[3ull * i + static_cast<size_t>(k)] = static_cast<float>(static_cast<double>(at[k]) / k_scale);
    }
    overlap.add(measure_overlap(positions, scene.particle_radius));
    ++row.frames;
    if (!step()) break;
  }
  row.ms_per_frame /= row.frames;
  row.ms_solver = row.ms_per_frame;
  row.overlap_p99 = overlap.p99();
  row.overlap_mean = overlap.mean();
  row.overlap_max = overlap.max;
  row.angle_deg = measure_pile(positions, scene.particle_radius).angle_deg;
  return row;
}

}  // namespace sandglass::host

#else

namespace sandglass::host {

bool bullet_available() { return false; }

BenchRow bench_bullet(SceneFile, uint32_t, const BenchStep&) {
  throw Failure(
      "cannot compare with Bullet: this build lacks it. Install libbullet-dev (Debian's name), configure and "
      "build again.");
}

}  // namespace sandglass::host

#endif
