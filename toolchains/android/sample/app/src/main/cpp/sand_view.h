// Filament draws the grains as points and the sand's shadow on the floor, in the light of the room, on a transparent
// surface above the camera image. Filament's own lights get the same light, for lit objects of the app. Filament reads
// a vertex buffer some time after it got it, so three take turns. A frame that finds all three in use keeps the last
// picture.
#pragma once

#include <filament/Camera.h>
#include <filament/ColorGrading.h>
#include <filament/Engine.h>
#include <filament/IndexBuffer.h>
#include <filament/IndirectLight.h>
#include <filament/LightManager.h>
#include <filament/Material.h>
#include <filament/MaterialInstance.h>
#include <filament/RenderableManager.h>
#include <filament/Renderer.h>
#include <filament/Scene.h>
#include <filament/SwapChain.h>
#include <filament/Texture.h>
#include <filament/TextureSampler.h>
#include <filament/ToneMapper.h>
#include <filament/TransformManager.h>
#include <filament/VertexBuffer.h>
#include <filament/View.h>
#include <filament/Viewport.h>
#include <math/mat4.h>
#include <math/vec3.h>
#include <math/vec4.h>
#include <utils/Entity.h>
#include <utils/EntityManager.h>

#include <atomic>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "sand_stage.h"

namespace sample {

class SandView {
 public:
  static constexpr int k_buffers = 3;

  // `grain` and `shadow` are grain.filamat and shadow.filamat, compiled from materials/. Returns false and makes
  // nothing if the system gives no engine or no chain of images for the window. Call everything here on one thread: the
  // engine belongs to it.
  bool create(void* window, uint32_t width, uint32_t height, const void* grain, size_t grain_bytes, const void* shadow,
              size_t shadow_bytes) {
    using namespace filament;
    engine_ = Engine::create(Engine::Backend::OPENGL);
    if (engine_ == nullptr) return false;
    swap_chain_ = engine_->createSwapChain(window, SwapChain::CONFIG_TRANSPARENT);
    if (swap_chain_ == nullptr) {
      Engine::destroy(&engine_);
      return false;
    }
    renderer_ = engine_->createRenderer();
    renderer_->setClearOptions({{0, 0, 0, 0}, 0, true, true});
    scene_ = engine_->createScene();
    view_ = engine_->createView();
    camera_entity_ = utils::EntityManager::get().create();
    camera_ = engine_->createCamera(camera_entity_);
    view_->setScene(scene_);
    view_->setCamera(camera_);
    view_->setViewport({0, 0, width, height});
    view_->setBlendMode(View::BlendMode::TRANSLUCENT);
    // Radiance 1 is what the camera shows as white, so there is no exposure and no tone curve.
    camera_->setExposure(1.0f);
    const LinearToneMapper linear;
    grading_ = ColorGrading::Builder().toneMapper(&linear).build(*engine_);
    view_->setColorGrading(grading_);

    material_ = Material::Builder().package(grain, grain_bytes).build(*engine_);
    instance_ = material_->createInstance();
    vertices_ =
        VertexBuffer::Builder()
            .bufferCount(1)
            .vertexCount(k_grains)
            .attribute(VertexAttribute::POSITION, 0, VertexBuffer::AttributeType::FLOAT3, 0, sizeof(sandglass_grain))
            .build(*engine_);
    std::vector<uint32_t>* order = new std::vector<uint32_t>(k_grains);
    std::iota(order->begin(), order->end(), 0u);
    indices_ = IndexBuffer::Builder().indexCount(k_grains).bufferType(IndexBuffer::IndexType::UINT).build(*engine_);
    indices_->setBuffer(
        *engine_, IndexBuffer::BufferDescriptor(
                      order->data(), 4 * k_grains,
                      [](void*, size_t, void* user) { delete static_cast<std::vector<uint32_t>*>(user); }, order));
    sand_ = utils::EntityManager::get().create();
    RenderableManager::Builder(1)
        .boundingBox({{0, 0.5f, 0}, {2, 1, 2}})
        .material(0, instance_)
        .geometry(0, RenderableManager::PrimitiveType::POINTS, vertices_, indices_, 0, k_grains)
        .castShadows(true)
        .build(*engine_, sand_);
    scene_->addEntity(sand_);

    create_shadow(shadow, shadow_bytes);
    light_ = utils::EntityManager::get().create();
    LightManager::Builder(LightManager::Type::DIRECTIONAL).build(*engine_, light_);
    scene_->addEntity(light_);
    for (std::vector<sandglass_grain>& buffer : grains_) buffer.resize(k_grains);
    return true;
  }

  bool shown() const { return engine_ != nullptr; }

  void destroy() {
    if (engine_ == nullptr) return;
    for (const utils::Entity entity : {sand_, floor_, light_}) engine_->destroy(entity);
    engine_->destroyCameraComponent(camera_entity_);
    for (const utils::Entity entity : {sand_, floor_, light_, camera_entity_})
      utils::EntityManager::get().destroy(entity);
    engine_->destroy(floor_vertices_);
    engine_->destroy(floor_indices_);
    engine_->destroy(floor_instance_);
    engine_->destroy(floor_material_);
    for (filament::Texture* texture : {coverage_, sky_, sky_on_sand_}) engine_->destroy(texture);
    if (ambient_ != nullptr) engine_->destroy(ambient_);
    ambient_ = nullptr;
    engine_->destroy(grading_);
    engine_->destroy(vertices_);
    engine_->destroy(indices_);
    engine_->destroy(instance_);
    engine_->destroy(material_);
    engine_->destroy(view_);
    engine_->destroy(scene_);
    engine_->destroy(renderer_);
    engine_->destroy(swap_chain_);
    filament::Engine::destroy(&engine_);  // waits for pending work; engine_ becomes null
  }

  // Takes the room's light, whose radiance is `scale` times what the image shows. The harmonics leave the main light
  // out, which is the directional one.
  void set_light(const sandglass_room_light& light, float scale) {
    using namespace filament;
    sandglass_light_filament filament{};
    filament.struct_size = sizeof filament;
    if (engine_ == nullptr ||
        sandglass_room_to_filament(&light, SANDGLASS_LIGHT_MODEL_AMBIENT, scale, &filament, nullptr) != SANDGLASS_OK)
      return;
    auto& lights = engine_->getLightManager();
    const LightManager::Instance sun = lights.getInstance(light_);
    lights.setDirection(sun, {filament.direction[0], filament.direction[1], filament.direction[2]});
    lights.setColor(sun, {filament.colour[0], filament.colour[1], filament.colour[2]});
    lights.setIntensity(sun, filament.intensity);
    math::float3 sh[9];
    for (int i = 0; i < 9; ++i) sh[i] = {filament.sh[3 * i], filament.sh[3 * i + 1], filament.sh[3 * i + 2]};
    // The light fades a little in every frame. A new IndirectLight is made when a coefficient has moved by 2 %.
    float moved = scale == nits_ ? 0.0f : 1.0f;
    for (int i = 0; i < 27; ++i)
      moved = std::fmax(moved, std::fabs(filament.sh[i] - sh_[i]) / std::fmax(sh_[0], 1e-3f));
    if (ambient_ == nullptr || moved > 0.02f) {
      IndirectLight* ambient =
          IndirectLight::Builder().irradiance(3, sh).intensity(filament.sh_intensity).build(*engine_);
      scene_->setIndirectLight(ambient);
      if (ambient_ != nullptr) engine_->destroy(ambient_);
      ambient_ = ambient, nits_ = scale;
      for (int i = 0; i < 27; ++i) sh_[i] = filament.sh[i];
    }
    // Filament does not light points, so the grains' material gets the light as parameters: what a grain that faces the
    // main light reflects of it, and what one that faces up reflects of all other light.
    const float k = filament.intensity / std::numbers::pi_v<float>, *c = filament.colour;
    instance_->setParameter("to_light",
                            math::float3{-filament.direction[0], -filament.direction[1], -filament.direction[2]});
    instance_->setParameter("sun", math::float3{k * c[0], k * c[1], k * c[2]});
    float rest[3];
    for (int channel = 0; channel < 3; ++channel) {
      const float* of = filament.sh + channel;  // irradiance over pi of the normal (0, 1, 0)
      rest[channel] = filament.sh_intensity * std::fmax(of[0] + of[3] - of[18] - of[24], 0.0f);
    }
    instance_->setParameter("ambient", math::float3{rest[0], rest[1], rest[2]});
  }

  // Takes the sand's shadows of this frame: that of the main light, and what the sand leaves of all other light.
  void set_shadow(const sandglass_pile_shadow_texture& shadow, const sandglass_pile_shadow_sky& sky, float strength) {
    if (engine_ == nullptr) return;
    upload(coverage_, shadow.coverage, k_shadow_texels);
    upload(sky_, sky.floor, k_sky_texels);
    upload(sky_on_sand_, sky.on_sand, k_sky_texels);
    const filament::math::float4 rectangle{shadow.low[0], shadow.low[1], shadow.high[0], shadow.high[1]};
    floor_instance_->setParameter("strength", strength);
    floor_instance_->setParameter("rectangle", rectangle);
    instance_->setParameter("rectangle", rectangle);
  }

  // Where the library may write this frame's grains, or null while all buffers are in use.
  sandglass_grain* buffer() { return in_use_[turn_].load(std::memory_order_acquire) ? nullptr : grains_[turn_].data(); }

  // Shows `count` grains about `origin`. Removed grains lie at a place beyond the far plane.
  void draw(bool filled, uint32_t count, const float origin[3], const float projection[16],
            const float camera_to_world[16]) {
    using filament::math::mat4f;
    if (filled && count > 0) {
      in_use_[turn_].store(true, std::memory_order_relaxed);
      vertices_->setBufferAt(*engine_, 0,
                             filament::VertexBuffer::BufferDescriptor(
                                 grains_[turn_].data(), count * sizeof(sandglass_grain),
                                 [](void*, size_t, void* user) {
                                   static_cast<std::atomic<bool>*>(user)->store(false, std::memory_order_release);
                                 },
                                 &in_use_[turn_]));
      turn_ = (turn_ + 1) % k_buffers;
      auto& renderables = engine_->getRenderableManager();
      renderables.setGeometryAt(renderables.getInstance(sand_), 0, filament::RenderableManager::PrimitiveType::POINTS,
                                vertices_, indices_, 0, count);
    }
    auto& transforms = engine_->getTransformManager();
    for (const utils::Entity entity : {sand_, floor_})
      transforms.setTransform(transforms.getInstance(entity),
                              mat4f::translation(filament::math::float3{origin[0], origin[1], origin[2]}));
    mat4f p, m;
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 4; ++row) {
        p[column][row] = projection[4 * column + row];
        m[column][row] = camera_to_world[4 * column + row];
      }
    }
    instance_->setParameter("origin", filament::math::float3{origin[0], origin[1], origin[2]});
    camera_->setCustomProjection(filament::math::mat4(p), k_near, k_far);
    camera_->setModelMatrix(m);
    if (renderer_->beginFrame(swap_chain_)) {
      renderer_->render(view_);
      renderer_->endFrame();
    }
  }

  static constexpr float k_near = 0.05f, k_far = 50.0f;

 private:
  filament::Texture* texture(uint32_t side) {
    using namespace filament;
    return Texture::Builder()
        .width(side)
        .height(side)
        .levels(1)
        .format(Texture::InternalFormat::R8)
        .sampler(Texture::Sampler::SAMPLER_2D)
        .build(*engine_);
  }

  void upload(filament::Texture* texture, const uint8_t* bytes, uint32_t side) {
    using namespace filament;
    auto* copy = new std::vector<uint8_t>(bytes, bytes + side * side);
    texture->setImage(*engine_, 0,
                      Texture::PixelBufferDescriptor(
                          copy->data(), copy->size(), Texture::Format::R, Texture::Type::UBYTE,
                          [](void*, size_t, void* user) { delete static_cast<std::vector<uint8_t>*>(user); }, copy));
  }

  // A floor about the scene's origin, a millimetre above the real one. Its material darkens the camera image.
  void create_shadow(const void* package, size_t bytes) {
    using namespace filament;
    constexpr float h = k_shadow_half, up = 0.001f;
    static const float corners[12] = {-h, up, -h, h, up, -h, -h, up, h, h, up, h};
    static const uint16_t order[6] = {0, 2, 1, 1, 2, 3};
    floor_material_ = Material::Builder().package(package, bytes).build(*engine_);
    floor_instance_ = floor_material_->createInstance();
    floor_vertices_ = VertexBuffer::Builder()
                          .bufferCount(1)
                          .vertexCount(4)
                          .attribute(VertexAttribute::POSITION, 0, VertexBuffer::AttributeType::FLOAT3)
                          .build(*engine_);
    floor_vertices_->setBufferAt(*engine_, 0, VertexBuffer::BufferDescriptor(corners, sizeof corners));
    floor_indices_ = IndexBuffer::Builder().indexCount(6).bufferType(IndexBuffer::IndexType::USHORT).build(*engine_);
    floor_indices_->setBuffer(*engine_, IndexBuffer::BufferDescriptor(order, sizeof order));
    coverage_ = texture(k_shadow_texels);
    sky_ = texture(k_sky_texels);
    sky_on_sand_ = texture(k_sky_texels);
    const TextureSampler linear(TextureSampler::MinFilter::LINEAR, TextureSampler::MagFilter::LINEAR);
    floor_instance_->setParameter("coverage", coverage_, linear);
    floor_instance_->setParameter("sky", sky_, linear);
    instance_->setParameter("sky", sky_on_sand_, linear);
    floor_ = utils::EntityManager::get().create();
    RenderableManager::Builder(1)
        .boundingBox({{0, up, 0}, {h, up, h}})
        .material(0, floor_instance_)
        .geometry(0, RenderableManager::PrimitiveType::TRIANGLES, floor_vertices_, floor_indices_, 0, 6)
        .castShadows(false)
        .build(*engine_, floor_);
    scene_->addEntity(floor_);
  }

  filament::Engine* engine_ = nullptr;
  filament::SwapChain* swap_chain_ = nullptr;
  filament::Renderer* renderer_ = nullptr;
  filament::Scene* scene_ = nullptr;
  filament::View* view_ = nullptr;
  filament::Camera* camera_ = nullptr;
  filament::Material* material_ = nullptr;
  filament::MaterialInstance* instance_ = nullptr;
  filament::VertexBuffer* vertices_ = nullptr;
  filament::IndexBuffer* indices_ = nullptr;
  filament::ColorGrading* grading_ = nullptr;
  filament::IndirectLight* ambient_ = nullptr;
  filament::Texture *coverage_ = nullptr, *sky_ = nullptr, *sky_on_sand_ = nullptr;
  float sh_[27] = {}, nits_ = 0.0f;  // of ambient_
  filament::VertexBuffer* floor_vertices_ = nullptr;
  filament::IndexBuffer* floor_indices_ = nullptr;
  filament::Material* floor_material_ = nullptr;
  filament::MaterialInstance* floor_instance_ = nullptr;
  utils::Entity camera_entity_, sand_, floor_, light_;
  std::vector<sandglass_grain> grains_[k_buffers];
  std::atomic<bool> in_use_[k_buffers] = {};
  int turn_ = 0;
};

}  // namespace sample
