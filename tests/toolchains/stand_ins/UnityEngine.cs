// The part of Unity's interface and of AR Foundation's that the sample uses, so that a compiler can check the sample.
using System;

namespace Unity.Collections {
public struct NativeArray<T> where T : struct {}
}
namespace Unity.Collections.LowLevel.Unsafe {
public static class NativeArrayUnsafeUtility {
  public static unsafe void* GetUnsafeReadOnlyPtr<T>(NativeArray<T> array) where T : struct { return null; }
}
}

namespace UnityEngine {
using Unity.Collections;
public struct Vector2 { public float x, y; }
public struct Vector3 {
  public float x, y, z;
  public static Vector3 one;
  public float magnitude;
  public static Vector3 operator *(float scale, Vector3 v) { return v; }
  public static Vector3 operator -(Vector3 a, Vector3 b) { return a; }
}
public struct Vector4 {
  public Vector4(float x, float y, float z, float w) {}
  public static Vector4 operator *(float scale, Vector4 v) { return v; }
  public static implicit operator Vector4(Vector3 v) { return new Vector4(); }
}
public struct Quaternion { public float x, y, z, w; }
public struct Bounds { public Bounds(Vector3 centre, Vector3 size) {} }
public struct Matrix4x4 { public float this[int row, int column] { get { return 0; } } }
public class Transform {
  public Matrix4x4 localToWorldMatrix { get { return new Matrix4x4(); } }
  public Vector3 position { get; set; }
  public Quaternion rotation { get; set; }
}
public class MonoBehaviour { public Transform transform { get { return null; } } }
public enum ScreenOrientation { Portrait = 1, PortraitUpsideDown = 2, LandscapeLeft = 3, LandscapeRight = 4 }
public static class Screen { public static ScreenOrientation orientation { get; set; } }
public sealed class RangeAttribute : Attribute { public RangeAttribute(float low, float high) {} }
public static class Time { public static float deltaTime { get { return 0; } } }
public class Material {
  public Material(Material source) {}
  public void EnableKeyword(string keyword) {}
}
public sealed class Mesh {
  public Vector3[] vertices { get { return null; } }
  public int[] triangles { get { return null; } }
}
public sealed class MeshFilter : MonoBehaviour { public Mesh sharedMesh { get { return null; } } }
public class Texture {}
public enum TextureFormat { R8 = 63 }
public sealed class Texture2D : Texture {
  public Texture2D(int width, int height, TextureFormat format, bool mipChain, bool linear) {}
  public int width { get { return 0; } }
  public void LoadRawTextureData(IntPtr data, int size) {}
  public void Apply() {}
}
public class MaterialPropertyBlock {
  public void SetBuffer(string name, GraphicsBuffer buffer) {}
  public void SetFloat(string name, float value) {}
  public void SetTexture(string name, Texture texture) {}
  public void SetVector(string name, Vector4 value) {}
}
public enum MeshTopology { Triangles }
public struct RenderParams {
  public RenderParams(Material material) { matProps = null; worldBounds = new Bounds(); }
  public MaterialPropertyBlock matProps { get; set; }
  public Bounds worldBounds { get; set; }
}
public static class Graphics {
  public static void RenderMesh(RenderParams parameters, Mesh mesh, int submesh, Matrix4x4 pose) {}
  public static void RenderPrimitives(RenderParams parameters, MeshTopology topology, int vertexCount, int instanceCount = 1) {}
}
public sealed class GraphicsBuffer : IDisposable {
  [Flags] public enum Target { Structured = 16 }
  public GraphicsBuffer(Target target, int count, int stride) {}
  public void SetData(Array data) {}
  public void Dispose() {}
}
}

namespace UnityEngine.XR.ARSubsystems {
public enum NotTrackingReason { None, Relocalizing }
public struct XRCameraIntrinsics { public Vector2 focalLength, principalPoint; }
public struct XRCameraFrameExifData {
  public bool TryGetExposureTime(out double exposureTime) { exposureTime = 0; return false; }
  public bool TryGetPhotographicSensitivity(out short photographicSensitivity) { photographicSensitivity = 0; return false; }
}
public struct XRCpuImage : IDisposable {
  public enum Format { Unknown, AndroidYuv420_888, IosYpCbCr420_8BiPlanarFullRange }
  public struct Plane {
    public int rowStride, pixelStride;
    public Unity.Collections.NativeArray<byte> data { get { return new Unity.Collections.NativeArray<byte>(); } }
  }
  public int width, height;
  public double timestamp;
  public Format format;
  public Plane GetPlane(int planeIndex) { return new Plane(); }
  public void Dispose() {}
}
}
namespace UnityEngine.XR.ARFoundation {
using ARSubsystems;
public enum ARSessionState { SessionTracking = 7 }
public sealed class ARSession : MonoBehaviour {
  public static ARSessionState state { get { return ARSessionState.SessionTracking; } }
  public static NotTrackingReason notTrackingReason { get { return NotTrackingReason.None; } }
}
public struct ARCameraFrameEventArgs {
  public bool TryGetExifData(out XRCameraFrameExifData exifData) { exifData = new XRCameraFrameExifData(); return false; }
}
public sealed class ARCameraManager : MonoBehaviour {
  public event Action<ARCameraFrameEventArgs> frameReceived { add {} remove {} }
  public bool TryGetIntrinsics(out XRCameraIntrinsics intrinsics) { intrinsics = new XRCameraIntrinsics(); return false; }
  public bool TryAcquireLatestCpuImage(out XRCpuImage image) { image = new XRCpuImage(); return false; }
}
}
