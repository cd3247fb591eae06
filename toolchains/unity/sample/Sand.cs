// Sand in a Unity scene. Put this on an object that stands where the sand shall fall (with AR Foundation, an anchor on
// a real plane). The floor is the plane through that object; the sand keeps to the world's axes, whatever its rotation
// is. Once a frame the library writes the grains straight into a locked graphics buffer, gathers the room's light from
// the camera's image, and casts the sand's shadows in that light. Sand.shader draws six vertices a grain; Shadow.shader
// darkens the floor.
//
// Unity's world is left-handed and Sandglass's is right-handed. z changes its sign in the shaders and where the light
// is handed over. Everything else here is right-handed.
using System;
using System.Runtime.InteropServices;
using Sandglass;
using Unity.Collections.LowLevel.Unsafe;
using UnityEngine;
using UnityEngine.XR.ARFoundation;

public unsafe class Sand : MonoBehaviour {
  public Material material;        // of Sand.shader
  public Material shadowMaterial;  // of Shadow.shader
  public ARCameraManager cameraManager;
  public Light sun;
  public Transform arrow;  // optional: points where the user should look, while much of the room is unknown
  [Range(1, 8)] public float budgetMilliseconds = 4;
  // Lower it when the device warns, for example by the warning level of Adaptive Performance.
  [Range(0, 1)] public float thermalHeadroom = 1;

  const float ParticleRadius = 0.01f, HalfWidth = 0.1f, Height = 0.2f;
  const float ShadowHalf = 0.64f;
  const int ShadowTexels = 128, SkyTexels = 64;
  IntPtr memory, scene, shadowMemory, shadow;
  RoomLight room;
  Texture2D coverage, sky, skyOnSand;
  GraphicsBuffer grains;
  int grainCount;
  sandglass_collider floor;
  sandglass_frame_input input;
  sandglass_frame_report report;

  public sandglass_frame_report Report { get { return report; } }

  public static void Check(int status, IntPtr reason) {
    if (status != Native.SANDGLASS_OK)
      throw new InvalidOperationException(Native.Text(Native.sandglass_status_name(status)) + ": " + Native.Text(reason));
  }

  [AOT.MonoPInvokeCallback(typeof(InsideFunction))]
  static int Everywhere(IntPtr user, float* point) { return 1; }
  static readonly InsideFunction everywhere = Everywhere;

  // Points in the block that is poured: a lattice for particles, or a Poisson-disk set for grains.
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

  public static IntPtr Aligned(IntPtr block) {
    const long a = Native.SANDGLASS_BLOCK_ALIGNMENT;
    return (IntPtr)((block.ToInt64() + a - 1) / a * a);
  }

  static Texture2D Bytes(int side) {
    var texture = new Texture2D(side, side, TextureFormat.R8, false, true);
    texture.wrapMode = TextureWrapMode.Clamp;
    return texture;
  }

  static void Upload(Texture2D texture, byte* bytes, uint side) {
    texture.LoadRawTextureData((IntPtr)bytes, (int)(side * side));
    texture.Apply(false);
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

    sandglass_pile_shadow_desc shadowDesc;
    Native.sandglass_pile_shadow_desc_default(out shadowDesc);
    for (int k = 0; k < 2; ++k) {
      shadowDesc.low[k] = -ShadowHalf;
      shadowDesc.high[k] = ShadowHalf;
    }
    shadowDesc.texels = ShadowTexels;
    shadowDesc.sky_texels = SkyTexels;
    shadowDesc.on_sand = 0;
    Check(Native.sandglass_pile_shadow_bytes(ref shadowDesc, out bytes, out reason), reason);
    shadowMemory = Marshal.AllocHGlobal((IntPtr)((long)bytes + Native.SANDGLASS_BLOCK_ALIGNMENT));
    Check(Native.sandglass_pile_shadow_create(ref shadowDesc, Aligned(shadowMemory), bytes, out shadow, out reason), reason);
    coverage = Bytes(ShadowTexels);
    sky = Bytes(SkyTexels);
    skyOnSand = Bytes(SkyTexels);
    room = new RoomLight(cameraManager);
    room.Update(transform.position, true, 0);  // what is usual in a room, until images come

    grains = new GraphicsBuffer(GraphicsBuffer.Target.Structured, GraphicsBuffer.UsageFlags.LockBufferForWrite, grainCount,
                                sizeof(sandglass_grain));
    var ground = new sandglass_collider();
    ground.shape = Native.SANDGLASS_SHAPE_HALF_SPACE;
    ground.rotation[3] = 1;
    floor = ground;
    Native.sandglass_frame_input_default(out input);
    report.struct_size = (uint)sizeof(sandglass_frame_report);
  }

  void OnDisable() {
    if (grains != null) grains.Dispose();
    grains = null;
    if (room != null) room.Dispose();
    room = null;
    Marshal.FreeHGlobal(shadowMemory);
    Marshal.FreeHGlobal(memory);
    memory = scene = shadowMemory = shadow = IntPtr.Zero;
  }

  void Update() {
    IntPtr reason;
    sandglass_room_light light = room.Shown;
    Check(Native.sandglass_pile_shadow_set_light(shadow, Copy(light.main_direction, 3), out reason), reason);
    Check(Native.sandglass_pile_shadow_set_cells(shadow, Copy(light.ambient_cells, 64), out reason), reason);
    sandglass_camera_image image;
    bool seen = room.Acquire(out image);
    var mapped = grains.LockBufferForWrite<sandglass_grain>(0, grainCount);
    fixed (sandglass_collider* colliders = &floor) {
      input.time_step = Time.deltaTime;
      input.budget_ns = (ulong)(1e6f * budgetMilliseconds);
      input.thermal_headroom = thermalHeadroom;
      input.colliders = colliders;
      input.collider_count = 1;
      input.grains = NativeArrayUnsafeUtility.GetUnsafePtr(mapped);
      input.grain_capacity = (uint)grainCount;
      input.pile_shadow = shadow;
      input.room = room.Handle;
      input.camera = seen ? &image : null;
      int status = Native.sandglass_scene_frame(scene, ref input, ref report, out reason);
      input.camera = null;  // the image was read within the call
      grains.UnlockBufferAfterWrite<sandglass_grain>(grainCount);
      room.Release();
      Check(status, reason);
    }
    room.Update(transform.position, seen, Time.deltaTime);
    if (arrow != null) {
      arrow.gameObject.SetActive(room.WantsLook);
      arrow.rotation = Quaternion.LookRotation(room.Look);
    }
    sandglass_light_unity unity = room.Show(sun);
    Matrix4x4 fromScene = Matrix4x4.Translate(transform.position);
    DrawShadow(fromScene);
    DrawGrains(fromScene, unity);
  }

  static float[] Copy(float* from, int count) {
    var copy = new float[count];
    for (int i = 0; i < count; ++i) copy[i] = from[i];
    return copy;
  }

  void DrawShadow(Matrix4x4 fromScene) {
    var texture = new sandglass_pile_shadow_texture();
    texture.struct_size = (uint)sizeof(sandglass_pile_shadow_texture);
    Native.sandglass_pile_shadow_get_texture(shadow, ref texture);
    var left = new sandglass_pile_shadow_sky();
    left.struct_size = (uint)sizeof(sandglass_pile_shadow_sky);
    Native.sandglass_pile_shadow_get_sky(shadow, ref left);
    Upload(coverage, texture.coverage, texture.texels);
    Upload(sky, left.floor, left.texels);
    Upload(skyOnSand, left.on_sand, left.texels);
    var draw = new RenderParams(shadowMaterial);
    draw.worldBounds = new Bounds(transform.position, 4 * Vector3.one);
    draw.matProps = new MaterialPropertyBlock();
    draw.matProps.SetTexture("_Coverage", coverage);
    draw.matProps.SetTexture("_Sky", sky);
    draw.matProps.SetMatrix("_FromScene", fromScene);
    draw.matProps.SetVector("_Rectangle", new Vector4(texture.low[0], texture.low[1], texture.high[0], texture.high[1]));
    draw.matProps.SetFloat("_Strength", texture.opacity * room.Shown.main_share);
    Graphics.RenderPrimitives(draw, MeshTopology.Triangles, 6);
  }

  // The main light as a directional one, and all other light as it falls on a grain that faces up.
  void DrawGrains(Matrix4x4 fromScene, sandglass_light_unity light) {
    var rest = new float[3];
    for (int channel = 0; channel < 3; ++channel) {
      float* of = light.sh + 9 * channel;
      rest[channel] = Math.Max(of[0] + of[1] - of[6] - of[8], 0);
    }
    var draw = new RenderParams(material);
    draw.worldBounds = new Bounds(transform.position, 4 * Vector3.one);
    draw.matProps = new MaterialPropertyBlock();
    draw.matProps.SetBuffer("_Grains", grains);
    draw.matProps.SetTexture("_Sky", skyOnSand);
    draw.matProps.SetVector("_Rectangle", new Vector4(-ShadowHalf, -ShadowHalf, ShadowHalf, ShadowHalf));
    draw.matProps.SetMatrix("_FromScene", fromScene);
    draw.matProps.SetFloat("_Radius", 0.35f * ParticleRadius);
    draw.matProps.SetVector("_ToLight", new Vector4(-light.forward[0], -light.forward[1], -light.forward[2], 0));
    draw.matProps.SetVector("_Sun", light.intensity * new Vector4(light.colour[0], light.colour[1], light.colour[2], 0));
    draw.matProps.SetVector("_Ambient", new Vector4(rest[0], rest[1], rest[2], 0));
    Graphics.RenderPrimitives(draw, MeshTopology.Triangles, 6 * grainCount);
  }
}
