// The part of Unity's interface that the sample uses, so that a compiler can check the sample.
using System;

namespace AOT {
public sealed class MonoPInvokeCallbackAttribute : Attribute {
  public MonoPInvokeCallbackAttribute(Type type) {}
}
}

namespace Unity.Collections {
public struct NativeArray<T> where T : struct {}
}

namespace Unity.Collections.LowLevel.Unsafe {
public static class NativeArrayUnsafeUtility {
  public static unsafe void* GetUnsafeReadOnlyPtr<T>(NativeArray<T> array) where T : struct { return null; }
  public static unsafe void* GetUnsafePtr<T>(NativeArray<T> array) where T : struct { return null; }
}
}

namespace UnityEngine {
public struct Vector2 {
  public float x, y;
}
public struct Vector4 {
  public Vector4(float x, float y, float z, float w) {}
  public static Vector4 operator *(float scale, Vector4 v) { return v; }
}
public struct Quaternion {
  public float x, y, z, w;
  public static Quaternion LookRotation(Vector3 forward) { return new Quaternion(); }
  public Quaternion(float x, float y, float z, float w) { this.x = x; this.y = y; this.z = z; this.w = w; }
}
public struct Color {
  public Color(float r, float g, float b, float a) {}
  public Color gamma { get { return this; } }
}
public struct Vector3 {
  public float x, y, z;
  public Vector3(float x, float y, float z) { this.x = x; this.y = y; this.z = z; }
  public static Vector3 one { get { return new Vector3(); } }
  public static Vector3 operator *(float scale, Vector3 v) { return v; }
}
public struct Matrix4x4 {
  public static Matrix4x4 Translate(Vector3 by) { return new Matrix4x4(); }
}
public sealed class GameObject {
  public void SetActive(bool active) {}
}
public struct Bounds {
  public Bounds(Vector3 centre, Vector3 size) {}
}
public class Transform {
  public GameObject gameObject { get { return null; } }
  public Vector3 position { get; set; }
  public Quaternion rotation { get; set; }
}
public class Component {
  public Transform transform { get { return null; } }
}
public class MonoBehaviour : Component {}
public sealed class Light : Component {
  public Color color { get; set; }
  public float intensity { get; set; }
}
public static class RenderSettings {
  public static Rendering.AmbientMode ambientMode { get; set; }
  public static Rendering.SphericalHarmonicsL2 ambientProbe { get; set; }
}
public enum ScreenOrientation { Portrait = 1, PortraitUpsideDown = 2, LandscapeLeft = 3, LandscapeRight = 4 }
public static class Screen {
  public static ScreenOrientation orientation { get; set; }
}
public class Texture {
  public TextureWrapMode wrapMode { get; set; }
}
public enum TextureWrapMode { Repeat, Clamp }
public enum TextureFormat { R8 = 63 }
public sealed class Texture2D : Texture {
  public Texture2D(int width, int height, TextureFormat format, bool mipChain, bool linear) {}
  public void LoadRawTextureData(IntPtr data, int size) {}
  public void Apply(bool updateMipmaps = true) {}
}
public sealed class RangeAttribute : Attribute {
  public RangeAttribute(float low, float high) {}
}
public static class Time {
  public static float deltaTime { get { return 0; } }
}
public class Material {}
public class MaterialPropertyBlock {
  public void SetBuffer(string name, GraphicsBuffer buffer) {}
  public void SetMatrix(string name, Matrix4x4 matrix) {}
  public void SetFloat(string name, float value) {}
  public void SetVector(string name, Vector4 value) {}
  public void SetTexture(string name, Texture value) {}
}
public enum MeshTopology { Triangles }
public struct RenderParams {
  public RenderParams(Material material) { matProps = null; worldBounds = new Bounds(); }
  public MaterialPropertyBlock matProps { get; set; }
  public Bounds worldBounds { get; set; }
}
public static class Graphics {
  public static void RenderPrimitives(RenderParams parameters, MeshTopology topology, int vertexCount, int instanceCount = 1) {}
}
public sealed class GraphicsBuffer : IDisposable {
  [Flags] public enum Target { Structured = 16 }
  [Flags] public enum UsageFlags { None = 0, LockBufferForWrite = 1 }
  public GraphicsBuffer(Target target, UsageFlags usage, int count, int stride) {}
  public Unity.Collections.NativeArray<T> LockBufferForWrite<T>(int first, int count) where T : struct {
    return new Unity.Collections.NativeArray<T>();
  }
  public void UnlockBufferAfterWrite<T>(int count) where T : struct {}
  public void Dispose() {}
}
}

namespace UnityEngine.Rendering {
public enum AmbientMode { Custom = 4 }
public struct SphericalHarmonicsL2 {
  public float this[int rgb, int coefficient] { get { return 0; } set {} }
}
}

// AR Foundation.
namespace UnityEngine.XR.ARSubsystems {
public struct XRCameraIntrinsics {
  public Vector2 focalLength { get { return new Vector2(); } }
  public Vector2 principalPoint { get { return new Vector2(); } }
}
public struct XRCameraFrameExifData {
  public bool TryGetExposureTime(out double exposureTime) { exposureTime = 0; return false; }
  public bool TryGetPhotographicSensitivity(out short photographicSensitivity) { photographicSensitivity = 0; return false; }
}
public struct XRCpuImage : IDisposable {
  public enum Format { Unknown, AndroidYuv420_888, IosYpCbCr420_8BiPlanarFullRange }
  public struct Plane {
    public int rowStride { get { return 0; } }
    public int pixelStride { get { return 0; } }
    public Unity.Collections.NativeArray<byte> data { get { return new Unity.Collections.NativeArray<byte>(); } }
  }
  public int width { get { return 0; } }
  public int height { get { return 0; } }
  public double timestamp { get { return 0; } }
  public Format format { get { return Format.Unknown; } }
  public Plane GetPlane(int planeIndex) { return new Plane(); }
  public void Dispose() {}
}
}

namespace UnityEngine.XR.ARFoundation {
public struct ARCameraFrameEventArgs {
  public bool TryGetExifData(out ARSubsystems.XRCameraFrameExifData exifData) {
    exifData = new ARSubsystems.XRCameraFrameExifData();
    return false;
  }
}
public sealed class ARCameraManager : MonoBehaviour {
  public event Action<ARCameraFrameEventArgs> frameReceived { add {} remove {} }
  public bool TryGetIntrinsics(out ARSubsystems.XRCameraIntrinsics intrinsics) {
    intrinsics = new ARSubsystems.XRCameraIntrinsics();
    return false;
  }
  public bool TryAcquireLatestCpuImage(out ARSubsystems.XRCpuImage image) {
    image = new ARSubsystems.XRCpuImage();
    return false;
  }
}
}
