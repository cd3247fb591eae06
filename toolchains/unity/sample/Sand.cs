// Sand in a Unity scene with AR Foundation 5.1 or newer. Put this on an object that stands where the sand shall fall,
// such as an anchor on a real plane. Once a frame the library reads the camera's image for the light of the room, writes
// the grains that have moved to an array (a locked buffer would not keep the others), and makes the shadows of the sand and
// of one object, which Table.shader draws on the real table. Sand.shader mixes the last two buffers of grains, as sandglass.h
// says at grains_time. Only what has changed is uploaded.
//
// Unity's world is left-handed and Sandglass's is right-handed: z changes its sign in the shader, and where poses and
// light are handed over. The sand keeps to the world's axes, whatever this object's rotation is.
using System;
using System.Runtime.InteropServices;
using Sandglass;
using Unity.Collections.LowLevel.Unsafe;
using UnityEngine;
using UnityEngine.XR.ARFoundation;
using UnityEngine.XR.ARSubsystems;

public unsafe class Sand : MonoBehaviour {
  public Material material;  // of Sand.shader
  public Material table;     // of Table.shader
  public MeshFilter casts;   // optional: an object on the table, whose mesh is readable and stays as it is
  public MeshFilter[] real;  // optional: what is real upon the table, as ARMeshManager.meshes has it; the object's shadow falls on it
  public ARCameraManager cameraManager;
  // Lower it when the device warns, for example by the warning level of Adaptive Performance.
  [Range(0, 1)] public float thermalHeadroom = 1;

  const float ParticleRadius = 0.01f;
  const int Particles = 1500, Grains = 8 * Particles;
  const float HalfSide = 0.5f;     // metres: where shadows are seen
  const float DepthBias = 0.02f;   // metres: how wrong the depth of what is real may be
  const float Receives = 0.15f;    // metres above the table: so high are the object's shadows made, by default
  Material onReal;                 // of Table.shader, for meshes
  IntPtr memory, vertices, corners;
  int vertexCount, triangleCount;
  sandglass_pile_shadow* pile;
  sandglass_cast* cast;
  readonly Texture2D[] textures = new Texture2D[4];  // those of Table.shader
  readonly ulong[] versions = new ulong[5];  // of what was uploaded; the last is the grains'
  static readonly string[] names = { "_Object", "_ObjectRoom", "_Sand", "_SandRoom" };
  sandglass_scene* scene;
  sandglass_room* room;
  sandglass_room_light shown;  // as it is drawn
  readonly sandglass_grain[] grains = new sandglass_grain[Grains];
  readonly GraphicsBuffer[] buffers = new GraphicsBuffer[2];
  int older, newer;  // of the two
  double olderTime, newerTime;
  sandglass_camera_image screen;  // the last image; its planes are gone
  float exposure;                 // of the newest frame; 0: unknown

  static void Check(int status, byte* reason) {
    if (status != Native.SANDGLASS_OK) throw new InvalidOperationException(Native.Text(reason));
  }

  static ulong Aligned(ulong bytes) {
    const ulong a = Native.SANDGLASS_BLOCK_ALIGNMENT;
    return (bytes + a - 1) / a * a;
  }

  void OnEnable() {
    sandglass_scene_desc desc;
    Native.sandglass_scene_desc_default(&desc);
    desc.clock = Native.sandglass_clock_system();
    desc.granular.particle_radius = ParticleRadius;
    desc.granular.particle_capacity = Particles;
    desc.granular.grain_capacity = Grains;
    desc.granular.collider_capacity = desc.granular.emitter_capacity = 1;
    sandglass_room_desc roomDesc;
    Native.sandglass_room_desc_default(&roomDesc);
    sandglass_pile_shadow_desc pileDesc;
    Native.sandglass_pile_shadow_desc_default(&pileDesc);
    pileDesc.low[0] = pileDesc.low[1] = -HalfSide;
    pileDesc.high[0] = pileDesc.high[1] = HalfSide;
    pileDesc.sky_texels = 64;
    sandglass_cast_desc castDesc;
    Native.sandglass_cast_desc_default(&castDesc);
    Mesh mesh = casts != null ? casts.sharedMesh : null;
    int[] triangles = mesh != null ? mesh.triangles : new int[0];
    castDesc.layers = 4;
    castDesc.triangle_capacity = (uint)Math.Max(1, 2 * triangles.Length / 3);
    ulong sceneBytes, roomBytes, pileBytes, castBytes;
    byte* reason;
    Check(Native.sandglass_scene_bytes(&desc, &sceneBytes, &reason), reason);
    Check(Native.sandglass_room_bytes(&roomDesc, &roomBytes, &reason), reason);
    Check(Native.sandglass_pile_shadow_bytes(&pileDesc, &pileBytes, &reason), reason);
    Check(Native.sandglass_cast_bytes(&castDesc, &castBytes, &reason), reason);
    ulong all = Aligned(sceneBytes) + Aligned(roomBytes) + Aligned(pileBytes) + castBytes;
    memory = Marshal.AllocHGlobal((IntPtr)(all + Native.SANDGLASS_BLOCK_ALIGNMENT));
    var block = (byte*)Aligned((ulong)memory);
    fixed (sandglass_scene** made = &scene) Check(Native.sandglass_scene_create(&desc, block, sceneBytes, made, &reason), reason);
    fixed (sandglass_room** made = &room)
      Check(Native.sandglass_room_create(&roomDesc, block + Aligned(sceneBytes), roomBytes, made, &reason), reason);
    block += Aligned(sceneBytes) + Aligned(roomBytes);
    fixed (sandglass_pile_shadow** made = &pile)
      Check(Native.sandglass_pile_shadow_create(&pileDesc, block, pileBytes, made, &reason), reason);
    fixed (sandglass_cast** made = &cast)
      Check(Native.sandglass_cast_create(&castDesc, block + Aligned(pileBytes), castBytes, made, &reason), reason);
    if (mesh != null) Stand(mesh.vertices, triangles);
    fixed (sandglass_grain* none = grains)
      for (int i = 0; i < Grains; ++i) none[i].position[1] = -1e6f;  // SANDGLASS_REMOVED_Y
    for (int i = 0; i < 2; ++i) {
      buffers[i] = new GraphicsBuffer(GraphicsBuffer.Target.Structured, Grains, sizeof(sandglass_grain));
      buffers[i].SetData(grains);
    }
    onReal = new Material(table);
    onReal.EnableKeyword("ON_MESH");
    Array.Clear(versions, 0, 5);
    newerTime = -1;
    cameraManager.frameReceived += Received;
  }

  // The object casts. Its pose comes with every frame.
  void Stand(Vector3[] places, int[] triangles) {
    vertices = Marshal.AllocHGlobal(12 * places.Length);
    corners = Marshal.AllocHGlobal(4 * triangles.Length);
    fixed (Vector3* from = places) Buffer.MemoryCopy(from, (void*)vertices, 12 * places.Length, 12 * places.Length);
    Marshal.Copy(triangles, 0, corners, triangles.Length);
    vertexCount = places.Length;
    triangleCount = triangles.Length / 3;
  }

  void OnDisable() {
    cameraManager.frameReceived -= Received;
    foreach (GraphicsBuffer buffer in buffers) if (buffer != null) buffer.Dispose();
    Marshal.FreeHGlobal(memory);
    Marshal.FreeHGlobal(vertices);
    Marshal.FreeHGlobal(corners);
    memory = vertices = corners = IntPtr.Zero;
  }

  // Seconds times ISO / 100, as sandglass_camera_image.exposure wants it: told on iOS 16 and on Android, where the phone
  // does.
  void Received(ARCameraFrameEventArgs frame) {
    exposure = frame.TryGetExifData(out var exif) && exif.TryGetExposureTime(out double seconds) &&
        exif.TryGetPhotographicSensitivity(out short iso) ? (float)(seconds * iso / 100) : 0;
  }

  // False where the library does not read the layout, and while poses are wrong: after an interruption, say.
  bool Describe(XRCpuImage held, sandglass_camera_image* image) {
    if (ARSession.state != ARSessionState.SessionTracking || ARSession.notTrackingReason != NotTrackingReason.None) return false;
    if (!cameraManager.TryGetIntrinsics(out var lens)) return false;
    Native.sandglass_camera_image_default(image);
    image->width = (uint)held.width;
    image->height = (uint)held.height;
    image->timestamp_ns = (ulong)(1e9 * held.timestamp);
    image->focal_x = lens.focalLength.x;
    image->focal_y = lens.focalLength.y;
    image->centre_x = lens.principalPoint.x;
    image->centre_y = lens.principalPoint.y;
    image->exposure = exposure;
    Quaternion pose = cameraManager.transform.rotation;  // that of the upright image
    Vector3 place = cameraManager.transform.position;
    image->position[0] = place.x;
    image->position[1] = place.y;
    image->position[2] = -place.z;
    image->orientation[0] = -pose.x;
    image->orientation[1] = -pose.y;
    image->orientation[2] = pose.z;
    image->orientation[3] = pose.w;
    image->pose_is_upright = 1;
    ScreenOrientation upright = Screen.orientation;  // the sensor lies in landscape
    image->turn_deg = upright == ScreenOrientation.Portrait ? 90u : upright == ScreenOrientation.LandscapeRight ? 180u :
        upright == ScreenOrientation.PortraitUpsideDown ? 270u : 0;
    // ARKit's two planes are NV12. Android's three are I420, whose chroma may lie in pairs.
    bool android = held.format == XRCpuImage.Format.AndroidYuv420_888;
    if (!android && held.format != XRCpuImage.Format.IosYpCbCr420_8BiPlanarFullRange) return false;
    XRCpuImage.Plane y = held.GetPlane(0), u = held.GetPlane(1), v = android ? held.GetPlane(2) : u;
    image->format = android ? Native.SANDGLASS_CAMERA_I420 : Native.SANDGLASS_CAMERA_NV12;
    image->chroma_step = android ? (uint)u.pixelStride : 0;
    image->planes_0 = Bytes(y);
    image->planes_1 = Bytes(u);
    image->planes_2 = Bytes(v);
    image->strides[0] = y.rowStride;
    image->strides[1] = u.rowStride;
    image->strides[2] = v.rowStride;
    screen = *image;
    return true;
  }

  static byte* Bytes(XRCpuImage.Plane plane) { return (byte*)NativeArrayUnsafeUtility.GetUnsafeReadOnlyPtr(plane.data); }

  void Update() {
    var floor = new sandglass_collider { shape = Native.SANDGLASS_SHAPE_HALF_SPACE };
    floor.rotation[3] = 1;
    var nozzle = new sandglass_emitter { radius = 0.03f, speed = 0.5f, grains_per_particle = Grains / Particles };
    nozzle.position[1] = 0.3f;
    nozzle.rotation[3] = 1;
    sandglass_camera_image image;
    bool taken = cameraManager.TryAcquireLatestCpuImage(out var held), seen = taken && Describe(held, &image);
    sandglass_frame_input input;
    Native.sandglass_frame_input_default(&input);
    input.time_step = Time.deltaTime;
    input.budget_ns = 4000000;
    input.thermal_headroom = thermalHeadroom;
    input.colliders = &floor;
    input.emitters = &nozzle;
    input.collider_count = input.emitter_count = 1;
    input.grain_capacity = Grains;
    input.grains_age = newerTime < 0 ? 0u : 1u;
    input.room = room;
    input.pile_shadow = pile;
    sandglass_cast* one = cast;
    input.casts = &one;
    input.cast_count = 1;
    SetShadows();
    input.camera = seen ? &image : null;  // it is read within the call
    var report = new sandglass_frame_report { struct_size = (uint)sizeof(sandglass_frame_report) };
    byte* reason;
    int status;
    fixed (sandglass_grain* into = grains) {
      input.grains = into;
      status = Native.sandglass_scene_frame(scene, &input, &report, &reason);
    }
    if (taken) held.Dispose();
    Check(status, reason);
    sandglass_unity_light light = Light();
    // By the eye's height over the table; from below, where nothing lies on it, by its distance.
    Vector3 eye = cameraManager.transform.position - transform.position;
    float nearer = 1 - DepthBias / Math.Max(eye.y > 0 ? eye.y : eye.magnitude, 2 * DepthBias);
    DrawTable(nearer);
    if (report.sand.grains_time > newerTime) {
      older = newer;
      olderTime = newerTime;
      newerTime = report.sand.grains_time;
      if (versions[4] != report.versions.grains) buffers[newer = 1 - newer].SetData(grains);
      versions[4] = report.versions.grains;
    }
    Draw((int)report.sand.grain_numbers, report.sand.shown_time, light, nearer);
  }

  // What casts, and in which light. Unity's z is turned around: the object's matrix mirrors it.
  void SetShadows() {
    byte* reason;
    if (triangleCount > 0) {
      sandglass_cast_mesh mesh;
      Native.sandglass_cast_mesh_default(&mesh);
      mesh.positions = (float*)vertices;
      mesh.vertex_count = (uint)vertexCount;
      mesh.indices = (void*)corners;
      mesh.triangle_count = (uint)triangleCount;
      Matrix4x4 pose = casts.transform.localToWorldMatrix;
      Vector3 at = transform.position;
      for (int column = 0; column < 4; ++column) {
        bool place = column == 3;
        mesh.world_from_mesh[4 * column] = pose[0, column] - (place ? at.x : 0);
        mesh.world_from_mesh[4 * column + 1] = pose[1, column] - (place ? at.y : 0);
        mesh.world_from_mesh[4 * column + 2] = -(pose[2, column] - (place ? at.z : 0));
      }
      Check(Native.sandglass_cast_set_meshes(cast, &mesh, 1, &reason), reason);
    }
    fixed (float* direction = shown.main_direction)
    fixed (float* cells = shown.ambient_cells) {
      if (shown.struct_size == 0) return;  // no frame was lit yet
      Check(Native.sandglass_pile_shadow_set_light(pile, direction, shown.main_angular_diameter, &reason), reason);
      Check(Native.sandglass_cast_set_light(cast, direction, shown.main_angular_diameter, &reason), reason);
      Check(Native.sandglass_pile_shadow_set_cells(pile, cells, &reason), reason);
      Check(Native.sandglass_cast_set_cells(cast, cells, &reason), reason);
    }
  }

  // A texture of shadows, and where it lies from this object.
  void Load(MaterialPropertyBlock block, int i, bool valid, sandglass_texture texture) {
    block.SetVector(names[i] + "Box", valid ? new Vector4(texture.corner[0], texture.corner[2], 1 / texture.along[0], 1 / texture.across[2]) : new Vector4(0, 0, 0, 0));
    if (!valid) return;
    int side = (int)texture.side, rows = (int)texture.layers * side;
    if (textures[i] == null || textures[i].width != side) textures[i] = new Texture2D(side, rows, TextureFormat.R8, false, true);
    if (versions[i] != texture.version) {
      textures[i].LoadRawTextureData((IntPtr)texture.bytes, side * rows);
      textures[i].Apply();
      versions[i] = texture.version;
    }
    block.SetTexture(names[i], textures[i]);
  }

  void DrawTable(float nearer) {
    var draw = new RenderParams(table) { worldBounds = new Bounds(transform.position, 2 * HalfSide * Vector3.one), matProps = new MaterialPropertyBlock() };
    var texture = new sandglass_texture { struct_size = (uint)sizeof(sandglass_texture) };
    for (int i = 0; i < 2; ++i) {
      if (i == 0) Native.sandglass_cast_get_texture(cast, &texture); else Native.sandglass_cast_get_ambient(cast, &texture);
      Load(draw.matProps, i, texture.valid != 0 && triangleCount > 0, texture);
      if (i == 0) draw.matProps.SetVector("_Slide", new Vector4(texture.slide[0], texture.slide[2], 0, 0));
    }
    Native.sandglass_pile_shadow_get_texture(pile, Native.SANDGLASS_PILE_SHADOW_SKY_FLOOR, &texture);
    Load(draw.matProps, 3, texture.valid != 0, texture);
    Native.sandglass_pile_shadow_get_texture(pile, Native.SANDGLASS_PILE_SHADOW_FLOOR, &texture);
    Load(draw.matProps, 2, texture.valid != 0, texture);
    draw.matProps.SetVector("_Origin", transform.position);
    draw.matProps.SetFloat("_HalfSide", HalfSide);
    draw.matProps.SetFloat("_MainShare", shown.main_share);
    draw.matProps.SetFloat("_SandOpacity", texture.scale);
    draw.matProps.SetFloat("_Nearer", nearer);
    draw.matProps.SetFloat("_Height", Receives);
    Graphics.RenderPrimitives(draw, MeshTopology.Triangles, 6);
    var upon = new RenderParams(onReal) { worldBounds = draw.worldBounds, matProps = draw.matProps };
    if (real != null)
      foreach (MeshFilter one in real) Graphics.RenderMesh(upon, one.sharedMesh, 0, one.transform.localToWorldMatrix);
  }

  // The room's light at the sand, which comes in softly. For what else the app draws, set it on Unity's directional light
  // and its ambient probe, too.
  sandglass_unity_light Light() {
    var known = new sandglass_room_light { struct_size = (uint)sizeof(sandglass_room_light) };
    byte* reason;
    sandglass_room_place place;
    Native.sandglass_room_place_default(&place);
    place.position[0] = transform.position.x;
    place.position[1] = transform.position.y;
    place.position[2] = -transform.position.z;
    var lighting = new sandglass_light { struct_size = (uint)sizeof(sandglass_light) };
    var unity = new sandglass_unity_light { struct_size = (uint)sizeof(sandglass_unity_light) };
    float scale;
    fixed (sandglass_room_light* light = &shown)
    fixed (sandglass_camera_image* image = &screen) {
      place.shown = light;
      Check(Native.sandglass_room_get(room, &place, &known, &reason), reason);
      Native.sandglass_room_fade(light, &known, Time.deltaTime);
      Check(Native.sandglass_light_of_room(light, &lighting, &reason), reason);
      scale = Native.sandglass_room_exposure(light, image);  // of the image on the screen
    }
    Check(Native.sandglass_light_to_unity(&lighting, Native.SANDGLASS_LIGHT_AMBIENT, &unity, &reason), reason);
    unity.intensity *= scale;
    for (int i = 0; i < 27; ++i) unity.sh[i] *= scale;
    return unity;
  }

  // A channel of all other light, on a grain that faces up.
  static float Up(float* of) { return Math.Max(of[0] + of[1] - of[6] - of[8], 0); }

  void Draw(int count, double time, sandglass_unity_light light, float nearer) {
    var draw = new RenderParams(material) { worldBounds = new Bounds(transform.position, 4 * Vector3.one), matProps = new MaterialPropertyBlock() };
    draw.matProps.SetBuffer("_Older", buffers[older]);
    draw.matProps.SetBuffer("_Newer", buffers[newer]);
    draw.matProps.SetFloat("_Share", (float)Math.Min(Math.Max((time - olderTime) / (newerTime - olderTime), 0), 1));
    draw.matProps.SetFloat("_Span", (float)(newerTime - olderTime));
    draw.matProps.SetVector("_Origin", transform.position);
    draw.matProps.SetFloat("_Radius", 0.35f * ParticleRadius);
    draw.matProps.SetFloat("_Nearer", nearer);
    draw.matProps.SetVector("_ToLight", new Vector4(-light.forward[0], -light.forward[1], -light.forward[2], 0));
    draw.matProps.SetVector("_Sun", light.intensity * new Vector4(light.colour[0], light.colour[1], light.colour[2], 0));
    draw.matProps.SetVector("_Ambient", new Vector4(Up(light.sh), Up(light.sh + 9), Up(light.sh + 18), 0));
    if (count > 0) Graphics.RenderPrimitives(draw, MeshTopology.Triangles, 6 * count);
  }
}
