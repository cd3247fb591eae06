// The part of Unity's interface that the sample uses, for a compiler to check against.
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
  public static unsafe void* GetUnsafePtr<T>(NativeArray<T> array) where T : struct { return null; }
}
}

namespace UnityEngine {
public struct Vector3 {
  public static Vector3 one { get { return new Vector3(); } }
  public static Vector3 operator *(float scale, Vector3 v) { return v; }
}
public struct Matrix4x4 {}
public struct Bounds {
  public Bounds(Vector3 centre, Vector3 size) {}
}
public class Transform {
  public Vector3 position { get; set; }
  public Matrix4x4 localToWorldMatrix { get { return new Matrix4x4(); } }
}
public class MonoBehaviour {
  public Transform transform { get { return null; } }
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
