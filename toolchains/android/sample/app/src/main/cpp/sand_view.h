// Filament's side: grains as points under one directional light, on a transparent surface above the camera image.
// Filament reads a vertex buffer some time after it was handed over, so three take turns; a frame that finds all three
// in use keeps the last picture.
#pragma once

#include <filament/Camera.h>
#include <filament/Engine.h>
#include <filament/IndexBuffer.h>
#include <filament/LightManager.h>
#include <filament/Material.h>
#include <filament/MaterialInstance.h>
#include <filament/RenderableManager.h>
#include <filament/Renderer.h>
#include <filament/Scene.h>
#include <filament/SwapChain.h>
#include <filament/TransformManager.h>
#include <filament/VertexBuffer.h>
#include <filament/View.h>
#include <filament/Viewport.h>
#include <math/mat4.h>
#include <math/vec3.h>
#include <utils/Entity.h>
#include <utils/EntityManager.h>

#include <atomic>
#include <numeric>
#include <vector>

#include "sand_stage.h"

namespace sample {

class SandView {
 public:
  static constexpr int k_buffers = 3;

  // `material` is grain.filamat, compiled from materials/grain.mat.
  void create(void* window, uint32_t width, uint32_t height, const void* material, size_t material_bytes) {
    using namespace filament;
    engine_ = Engine::create(Engine::Backend::OPENGL);
    swap_chain_ = engine_->createSwapChain(window, SwapChain::CONFIG_TRANSPARENT);
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

    material_ = Material::Builder().package(material, material_bytes).build(*engine_);
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

    // Until the library estimates it: the sun at 45 degrees. Sandglass gives directions towards the light, Filament
    // wants where it shines. A plane with the library's shadow texture, as material alpha, would go beside the sand.
    light_ = utils::EntityManager::get().create();
    LightManager::Builder(LightManager::Type::DIRECTIONAL)
        .color({1, 1, 1})
        .intensity(80'000.0f)
        .direction({-0.5f, -0.7f, -0.5f})
        .build(*engine_, light_);
    scene_->addEntity(light_);
    for (std::vector<sandglass_grain>& buffer : grains_) buffer.resize(k_grains);
  }

  void destroy() {
    if (engine_ == nullptr) return;
    for (const utils::Entity entity : {sand_, light_}) engine_->destroy(entity);
    engine_->destroyCameraComponent(camera_entity_);
    for (const utils::Entity entity : {sand_, light_, camera_entity_}) utils::EntityManager::get().destroy(entity);
    engine_->destroy(vertices_);
    engine_->destroy(indices_);
    engine_->destroy(instance_);
    engine_->destroy(material_);
    engine_->destroy(view_);
    engine_->destroy(scene_);
    engine_->destroy(renderer_);
    engine_->destroy(swap_chain_);
    filament::Engine::destroy(&engine_);  // waits for what is in flight; engine_ becomes null
  }

  // Where the library may write this frame's grains, or null while all buffers are in use.
  sandglass_grain* buffer() { return in_use_[turn_].load(std::memory_order_acquire) ? nullptr : grains_[turn_].data(); }

  // Shows the sand (`count` grains; fewer leave the rest at the removed place, beyond the far plane) about `origin`.
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
    transforms.setTransform(transforms.getInstance(sand_),
                            mat4f::translation(filament::math::float3{origin[0], origin[1], origin[2]}));
    mat4f p, m;
    for (int column = 0; column < 4; ++column) {
      for (int row = 0; row < 4; ++row) {
        p[column][row] = projection[4 * column + row];
        m[column][row] = camera_to_world[4 * column + row];
      }
    }
    camera_->setCustomProjection(filament::math::mat4(p), k_near, k_far);
    camera_->setModelMatrix(m);
    if (renderer_->beginFrame(swap_chain_)) {
      renderer_->render(view_);
      renderer_->endFrame();
    }
  }

  static constexpr float k_near = 0.05f, k_far = 50.0f;

 private:
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
  utils::Entity camera_entity_, sand_, light_;
  std::vector<sandglass_grain> grains_[k_buffers];
  std::atomic<bool> in_use_[k_buffers] = {};
  int turn_ = 0;
};

}  // namespace sample
