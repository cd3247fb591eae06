// Sand in a Unity scene: put this on an object that stands where the sand shall fall (an anchor on a real plane, with AR
// Foundation); its floor is the plane y = 0 of that object. Once a frame the library writes the grains straight into a locked
// graphics buffer, and Sand.shader draws six vertices a grain from it. Unity's world is left-handed: x is mirrored once, in the
// shader, and everything on this side stays right-handed.
//
// Light and soft shadows have their place in Update, beside the sand: an object's baked shadow goes into input.shadows, and its
// texture onto the floor; the light would come from the camera image, from which the library does not estimate it yet.
using System;
using System.Runtime.InteropServices;
using Sandglass;
using Unity.Collections.LowLevel.Unsafe;
using UnityEngine;

public unsafe class Sand : MonoBehaviour {
  public Material material;  // of Sand.shader
  [Range(1, 8)] public float budgetMilliseconds = 4;
  [Range(0, 1)] public float thermalHeadroom = 1;  // lower it when the device warns (Adaptive Performance's warning level, say)

  const float ParticleRadius = 0.01f, HalfWidth = 0.1f, Height = 0.2f;
  IntPtr memory, scene;
  GraphicsBuffer grains;
  int grainCount;
  sandglass_collider floor;
  sandglass_frame_input input;
  sandglass_frame_report report;

  public sandglass_frame_report Report { get { return report; } }

  static void Check(int status, IntPtr reason) {
    if (status != Native.SANDGLASS_OK)
      throw new InvalidOperationException(Native.Text(Native.sandglass_status_name(status)) + ": " + Native.Text(reason));
  }

  [AOT.MonoPInvokeCallback(typeof(InsideFunction))]
  static int Everywhere(IntPtr user, float* point) { return 1; }
  static readonly InsideFunction everywhere = Everywhere;

  // Points in the block that is poured: a lattice of particles, or a Poisson-disk set of grains.
  static float[] Sample(bool lattice, float distance) {
    float[] low = {-HalfWidth, 2 * ParticleRadius, -HalfWidth}, high = {HalfWidth, 2 * ParticleRadius + Height, HalfWidth};
    sandglass_sample_options options;
    Native.sandglass_sample_options_default(out options);
    uint capacity, count;
    ulong bytes;
    IntPtr reason;
    if (lattice) {
      Check(Native.sandglass_sample_lattice_capacity(low, high, distance, out capacity, out reason), reason);
      Check(Native.sandglass_sample_lattice_bytes(low, high, distance, out bytes, out reason), reason);
    } else {
      Check(Native.sandglass_sample_volume_capacity(low, high, distance, out capacity, out reason), reason);
      Check(Native.sandglass_sample_volume_bytes(low, high, distance, capacity, out bytes, out reason), reason);
    }
    var points = new float[3 * capacity];
    IntPtr scratch = Marshal.AllocHGlobal((IntPtr)((long)bytes + Native.SANDGLASS_BLOCK_ALIGNMENT));
    try {
      if (lattice)
        Check(Native.sandglass_sample_lattice(low, high, distance, everywhere, IntPtr.Zero, ref options, Aligned(scratch), bytes,
                                              points, capacity, out count, out reason), reason);
      else
        Check(Native.sandglass_sample_volume(low, high, distance, everywhere, IntPtr.Zero, ref options, Aligned(scratch), bytes,
                                             points, capacity, out count, out reason), reason);
    } finally {
      Marshal.FreeHGlobal(scratch);
    }
    Array.Resize(ref points, (int)(3 * count));
    return points;
  }

  static IntPtr Aligned(IntPtr block) {
    const long a = Native.SANDGLASS_BLOCK_ALIGNMENT;
    return (IntPtr)((block.ToInt64() + a - 1) / a * a);
  }

  void OnEnable() {
    float[] particles = Sample(true, 2.02f * ParticleRadius), fine = Sample(false, 0.58f * ParticleRadius);
    grainCount = fine.Length / 3;
    sandglass_scene_desc desc;
    Native.sandglass_scene_desc_default(out desc);
    desc.clock = Native.sandglass_clock_system();
    desc.granular.particle_radius = ParticleRadius;
    desc.granular.particle_capacity = (uint)(particles.Length / 3);
    desc.granular.grain_capacity = (uint)grainCount;
    desc.granular.collider_capacity = 1;
    ulong bytes;
    IntPtr reason;
    Check(Native.sandglass_scene_bytes(ref desc, out bytes, out reason), reason);
    memory = Marshal.AllocHGlobal((IntPtr)((long)bytes + Native.SANDGLASS_BLOCK_ALIGNMENT));
    Check(Native.sandglass_scene_create(ref desc, Aligned(memory), bytes, out scene, out reason), reason);
    Check(Native.sandglass_granular_add(scene, particles, null, (uint)(particles.Length / 3), fine, null, (uint)grainCount, out reason), reason);

    grains = new GraphicsBuffer(GraphicsBuffer.Target.Structured, GraphicsBuffer.UsageFlags.LockBufferForWrite, grainCount,
                                sizeof(sandglass_grain));
    var ground = new sandglass_collider();
    ground.shape = Native.SANDGLASS_SHAPE_HALF_SPACE;
    ground.rotation[3] = 1;
    floor = ground;
    Native.sandglass_frame_input_default(out input);
  }

  void OnDisable() {
    if (grains != null) grains.Dispose();
    grains = null;
    Marshal.FreeHGlobal(memory);
    memory = scene = IntPtr.Zero;
  }

  void Update() {
    IntPtr reason;
    var mapped = grains.LockBufferForWrite<sandglass_grain>(0, grainCount);
    fixed (sandglass_collider* colliders = &floor) {
      input.time_step = Time.deltaTime;
      input.budget_ns = (ulong)(1e6f * budgetMilliseconds);
      input.thermal_headroom = thermalHeadroom;
      input.colliders = colliders;
      input.collider_count = 1;
      input.grains = NativeArrayUnsafeUtility.GetUnsafePtr(mapped);
      input.grain_capacity = (uint)grainCount;
      int status = Native.sandglass_scene_frame(scene, ref input, ref report, out reason);
      grains.UnlockBufferAfterWrite<sandglass_grain>(grainCount);
      Check(status, reason);
    }
    var draw = new RenderParams(material);
    draw.worldBounds = new Bounds(transform.position, 4 * Vector3.one);
    draw.matProps = new MaterialPropertyBlock();
    draw.matProps.SetBuffer("_Grains", grains);
    draw.matProps.SetMatrix("_FromScene", transform.localToWorldMatrix);
    draw.matProps.SetFloat("_Radius", 0.35f * ParticleRadius);
    Graphics.RenderPrimitives(draw, MeshTopology.Triangles, 6 * grainCount);
  }
}
