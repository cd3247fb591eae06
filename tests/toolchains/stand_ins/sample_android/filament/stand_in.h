#pragma once
// The part of Filament's C++ interface that the sample uses: names, arguments and types, so that a compiler can check
// the sample.
#include <stddef.h>
#include <stdint.h>

namespace utils {
struct Entity {};
struct EntityManager {
  static EntityManager& get();
  Entity create();
  void destroy(Entity entity);
};
}  // namespace utils

namespace filament {
namespace math {
struct float3 {
  float x, y, z;
};
struct float4 {
  float x, y, z, w;
};
template <class T>
struct Matrix {
  struct Column {
    T v[4];
    T& operator[](int row) { return v[row]; }
  } columns[4];
  Matrix();
  template <class U>
  explicit Matrix(const Matrix<U>& other);
  Column& operator[](int column) { return columns[column]; }
  static Matrix translation(const float3& t);
};
using mat4f = Matrix<float>;
using mat4 = Matrix<double>;
}  // namespace math

namespace backend {
class BufferDescriptor {
 public:
  using Callback = void (*)(void* buffer, size_t size, void* user);
  BufferDescriptor(void const* buffer, size_t size, Callback callback = nullptr, void* user = nullptr);
};
}  // namespace backend

using LinearColor = math::float3;
enum VertexAttribute : uint8_t { POSITION = 0 };
struct Box {
  math::float3 center, halfExtent;
};
struct Viewport {
  int32_t left, bottom;
  uint32_t width, height;
};
class Engine;
class IndirectLight {
 public:
  class Builder {
   public:
    Builder& irradiance(uint8_t bands, math::float3 const* sh);
    Builder& intensity(float intensity);
    IndirectLight* build(Engine& engine) const;
  };
};
class ToneMapper {};
class LinearToneMapper final : public ToneMapper {};
class ColorGrading {
 public:
  class Builder {
   public:
    Builder& toneMapper(const ToneMapper* mapper);
    ColorGrading* build(Engine& engine);
  };
};
class Texture {
 public:
  enum class Sampler : uint8_t { SAMPLER_2D };
  enum class InternalFormat : uint16_t { R8 };
  enum class Format : uint8_t { R };
  enum class Type : uint8_t { UBYTE };
  class PixelBufferDescriptor {
   public:
    PixelBufferDescriptor(void const* buffer, size_t size, Format format, Type type,
                          backend::BufferDescriptor::Callback callback = nullptr, void* user = nullptr);
  };
  class Builder {
   public:
    Builder& width(uint32_t width);
    Builder& height(uint32_t height);
    Builder& levels(uint8_t levels);
    Builder& sampler(Sampler target);
    Builder& format(InternalFormat format);
    Texture* build(Engine& engine);
  };
  void setImage(Engine& engine, size_t level, PixelBufferDescriptor&& buffer) const;
};
class TextureSampler {
 public:
  enum class MinFilter : uint8_t { NEAREST, LINEAR };
  enum class MagFilter : uint8_t { NEAREST, LINEAR };
  TextureSampler(MinFilter min, MagFilter mag);
};
class Scene {
 public:
  void setIndirectLight(IndirectLight* light);
  void addEntity(utils::Entity entity);
};
class SwapChain {
 public:
  static const uint64_t CONFIG_TRANSPARENT;
};
class Camera {
 public:
  void setCustomProjection(math::mat4 const& projection, double near, double far);
  void setExposure(float exposure);
  void setModelMatrix(const math::mat4f& matrix);
};
class View {
 public:
  enum class BlendMode : uint8_t { OPAQUE, TRANSLUCENT };
  void setScene(Scene* scene);
  void setCamera(Camera* camera);
  void setViewport(Viewport const& viewport);
  void setBlendMode(BlendMode mode);
  void setColorGrading(ColorGrading* grading);
};
class Renderer {
 public:
  struct ClearOptions {
    math::float4 clearColor;
    uint8_t clearStencil;
    bool clear, discard;
  };
  void setClearOptions(const ClearOptions& options);
  bool beginFrame(SwapChain* swap_chain, uint64_t vsync_time = 0);
  void render(View const* view);
  void endFrame();
};
class MaterialInstance {
 public:
  template <class T>
  void setParameter(const char* name, T const& value);
  void setParameter(const char* name, Texture const* texture, TextureSampler const& sampler);
};
class Material {
 public:
  class Builder {
   public:
    Builder& package(const void* payload, size_t size);
    Material* build(Engine& engine);
  };
  MaterialInstance* createInstance(const char* name = nullptr) const;
};
class VertexBuffer {
 public:
  enum class AttributeType : uint8_t { FLOAT3 };
  using BufferDescriptor = backend::BufferDescriptor;
  class Builder {
   public:
    Builder& bufferCount(uint8_t count);
    Builder& vertexCount(uint32_t count);
    Builder& attribute(VertexAttribute attribute, uint8_t buffer, AttributeType type, uint32_t offset = 0,
                       uint8_t stride = 0);
    VertexBuffer* build(Engine& engine);
  };
  void setBufferAt(Engine& engine, uint8_t buffer, BufferDescriptor&& data, uint32_t offset = 0);
};
class IndexBuffer {
 public:
  enum class IndexType : uint8_t { USHORT, UINT };
  using BufferDescriptor = backend::BufferDescriptor;
  class Builder {
   public:
    Builder& indexCount(uint32_t count);
    Builder& bufferType(IndexType type);
    IndexBuffer* build(Engine& engine);
  };
  void setBuffer(Engine& engine, BufferDescriptor&& data, uint32_t offset = 0);
};
class RenderableManager {
 public:
  struct Instance {};
  enum class PrimitiveType : uint8_t { POINTS = 0, TRIANGLES = 4 };
  class Builder {
   public:
    explicit Builder(size_t count);
    Builder& geometry(size_t index, PrimitiveType type, VertexBuffer* vertices, IndexBuffer* indices, size_t offset,
                      size_t count);
    Builder& material(size_t index, MaterialInstance const* material);
    Builder& boundingBox(const Box& box);
    Builder& castShadows(bool enable);
    enum Result { Error = -1, Success = 0 };
    Result build(Engine& engine, utils::Entity entity);
  };
  Instance getInstance(utils::Entity entity) const;
  void setGeometryAt(Instance instance, size_t primitive, PrimitiveType type, VertexBuffer* vertices,
                     IndexBuffer* indices, size_t offset, size_t count);
};
class TransformManager {
 public:
  struct Instance {};
  Instance getInstance(utils::Entity entity) const;
  void setTransform(Instance instance, const math::mat4f& transform);
};
class LightManager {
 public:
  enum class Type : uint8_t { SUN, DIRECTIONAL };
  class Builder {
   public:
    explicit Builder(Type type);
    enum Result { Error = -1, Success = 0 };
    Result build(Engine& engine, utils::Entity entity);
  };
  struct Instance {};
  Instance getInstance(utils::Entity entity) const;
  void setDirection(Instance instance, const math::float3& direction);
  void setColor(Instance instance, const LinearColor& color);
  void setIntensity(Instance instance, float intensity);
};
class Engine {
 public:
  enum class Backend : uint8_t { DEFAULT, OPENGL, VULKAN };
  static Engine* create(Backend backend = Backend::DEFAULT);
  static void destroy(Engine** engine);
  SwapChain* createSwapChain(void* window, uint64_t flags = 0);
  Renderer* createRenderer();
  Scene* createScene();
  View* createView();
  Camera* createCamera(utils::Entity entity);
  void destroyCameraComponent(utils::Entity entity);
  RenderableManager& getRenderableManager();
  TransformManager& getTransformManager();
  LightManager& getLightManager();
  void destroy(utils::Entity entity);
  bool destroy(const VertexBuffer* p);
  bool destroy(const IndexBuffer* p);
  bool destroy(const MaterialInstance* p);
  bool destroy(const Material* p);
  bool destroy(const View* p);
  bool destroy(const Scene* p);
  bool destroy(const Renderer* p);
  bool destroy(const SwapChain* p);
  bool destroy(const Texture* p);
  bool destroy(const IndirectLight* p);
  bool destroy(const ColorGrading* p);
};
}  // namespace filament
