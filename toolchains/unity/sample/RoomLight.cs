// The light of the room, from AR Foundation's camera. Hands the camera's images to the library, asks it for the light at
// the sand's place, and sets Unity's own light and ambient probe to it. The images are read in the scene's frame
// (Sand.cs), within that frame's budget.
using System;
using System.Runtime.InteropServices;
using Sandglass;
using Unity.Collections.LowLevel.Unsafe;
using UnityEngine;
using UnityEngine.Rendering;
using UnityEngine.XR.ARFoundation;
using UnityEngine.XR.ARSubsystems;

public unsafe sealed class RoomLight : IDisposable {
  // Below the first share of the room, ask the user to look around; above the second, a short exposure would help.
  const float EnoughSeen = 0.5f, MuchClipped = 0.02f;
  IntPtr memory, room;
  readonly ARCameraManager manager;
  XRCpuImage held;
  bool holding;
  float exposure;                      // of the newest frame; 0: unknown
  sandglass_room_light known, shown;  // now, and on its way there

  public IntPtr Handle { get { return room; } }
  // The light as it is drawn, in Sandglass's right-handed world.
  public sandglass_room_light Shown { get { return shown; } }
  // From the scale of the last image that was read to that of the one on the screen, where exposures are told.
  public float Scale { get { return exposure > 0 && shown.white > 0 ? exposure * shown.white : 1; } }
  public bool WantsLook { get { return known.seen < EnoughSeen; } }
  public bool WantsShortExposure { get { return known.clipped > MuchClipped; } }
  // Towards where looking would tell most, in Unity's world.
  public Vector3 Look {
    get {
      sandglass_room_light light = known;
      return new Vector3(light.look[0], light.look[1], -light.look[2]);
    }
  }

  public RoomLight(ARCameraManager cameraManager) {
    manager = cameraManager;
    manager.frameReceived += Received;
    sandglass_room_desc desc;
    Native.sandglass_room_desc_default(out desc);
    ulong bytes;
    IntPtr reason;
    Sand.Check(Native.sandglass_room_bytes(ref desc, out bytes, out reason), reason);
    memory = Marshal.AllocHGlobal((IntPtr)((long)bytes + Native.SANDGLASS_BLOCK_ALIGNMENT));
    Sand.Check(Native.sandglass_room_create(ref desc, Sand.Aligned(memory), bytes, out room, out reason), reason);
  }

  // Seconds times ISO / 100, as sandglass_camera_image.exposure wants it. AR Foundation 5.1 tells both on iOS 16 and on
  // Android, where the phone does.
  void Received(ARCameraFrameEventArgs frame) {
    XRCameraFrameExifData exif;
    double seconds = 0;
    short iso = 0;
    bool told = frame.TryGetExifData(out exif) && exif.TryGetExposureTime(out seconds);
    exposure = told && exif.TryGetPhotographicSensitivity(out iso) ? (float)(seconds * iso / 100) : 0;
  }

  public void Dispose() {
    Release();
    manager.frameReceived -= Received;
    Marshal.FreeHGlobal(memory);
    memory = room = IntPtr.Zero;
  }

  // Takes the newest image; release it after the frame. False if there is none or the library does not read its layout.
  public bool Acquire(out sandglass_camera_image acquired) {
    sandglass_camera_image image;
    Native.sandglass_camera_image_default(out image);
    acquired = image;
    XRCameraIntrinsics intrinsics;
    if (!manager.TryGetIntrinsics(out intrinsics) || !manager.TryAcquireLatestCpuImage(out held)) return false;
    holding = true;
    image.width = (uint)held.width;
    image.height = (uint)held.height;
    image.timestamp_ns = (ulong)(1e9 * held.timestamp);
    image.focal_x = intrinsics.focalLength.x;
    image.focal_y = intrinsics.focalLength.y;
    image.centre_x = intrinsics.principalPoint.x;
    image.centre_y = intrinsics.principalPoint.y;
    // Unity's pose is that of the upright image and left-handed, so z changes its sign.
    Quaternion pose = manager.transform.rotation;
    Vector3 place = manager.transform.position;
    image.position[0] = place.x;
    image.position[1] = place.y;
    image.position[2] = -place.z;
    image.exposure = exposure;
    image.orientation[0] = -pose.x;
    image.orientation[1] = -pose.y;
    image.orientation[2] = pose.z;
    image.orientation[3] = pose.w;
    image.pose_is_upright = 1;
    switch (Screen.orientation) {  // the sensor lies in landscape
      case ScreenOrientation.Portrait: image.turn_deg = 90; break;
      case ScreenOrientation.LandscapeRight: image.turn_deg = 180; break;
      case ScreenOrientation.PortraitUpsideDown: image.turn_deg = 270; break;
      default: image.turn_deg = 0; break;
    }
    bool known = SetPlanes(&image);
    acquired = image;
    if (!known) Release();
    return known;
  }

  public void Release() {
    if (holding) held.Dispose();
    holding = false;
  }

  static byte* Bytes(XRCpuImage.Plane plane) { return (byte*)NativeArrayUnsafeUtility.GetUnsafeReadOnlyPtr(plane.data); }

  // ARKit's two planes are NV12. Android's three are NV12, NV21 or I420; their pixel stride and order show which.
  bool SetPlanes(sandglass_camera_image* image) {
    XRCpuImage.Plane luma = held.GetPlane(0), u = held.GetPlane(1);
    image->plane0 = Bytes(luma);
    image->plane1 = Bytes(u);
    image->strides[0] = (uint)luma.rowStride;
    image->strides[1] = image->strides[2] = (uint)u.rowStride;
    image->format = Native.SANDGLASS_CAMERA_NV12;
    if (held.format == XRCpuImage.Format.IosYpCbCr420_8BiPlanarFullRange) return true;
    if (held.format != XRCpuImage.Format.AndroidYuv420_888) return false;
    XRCpuImage.Plane v = held.GetPlane(2);
    byte* second = Bytes(v);
    if (luma.pixelStride != 1 || u.pixelStride != v.pixelStride) return false;
    if (u.pixelStride == 1) {
      image->format = Native.SANDGLASS_CAMERA_I420;
      image->plane2 = second;
      image->strides[2] = (uint)v.rowStride;
      return true;
    }
    if (u.pixelStride != 2) return false;
    if (second == image->plane1 + 1) return true;
    if (image->plane1 != second + 1) return false;
    image->format = Native.SANDGLASS_CAMERA_NV21;
    image->plane1 = second;
    return true;
  }

  // After each frame: the light at `place` (Unity's world), which comes in softly.
  public void Update(Vector3 place, bool seen, float seconds) {
    IntPtr reason;
    if (seen || known.struct_size == 0) {
      known.struct_size = (uint)sizeof(sandglass_room_light);
      Sand.Check(Native.sandglass_room_get(room, new float[] {place.x, place.y, -place.z}, null, ref known, out reason), reason);
    }
    Native.sandglass_room_light_fade(ref shown, ref known, seconds);
  }

  // What was seen, for a later session in the same world frame, such as one that has relocalised to a saved world map.
  public byte[] Save() {
    var data = new byte[Native.sandglass_room_save_bytes(room)];
    IntPtr reason;
    fixed (byte* bytes = data) Sand.Check(Native.sandglass_room_save(room, bytes, (ulong)data.Length, out reason), reason);
    return data;
  }

  public bool Restore(byte[] data) {
    IntPtr reason;
    fixed (byte* bytes = data) return Native.sandglass_room_restore(room, bytes, (ulong)data.Length, out reason) == Native.SANDGLASS_OK;
  }

  // Another room: forgets all that was seen.
  public void Forget() { Native.sandglass_room_reset(room); }

  // Sets Unity's directional light and ambient probe, for whatever else the app draws. The probe leaves the main light
  // out, which is the directional one.
  public sandglass_light_unity Show(Light sun) {
    var unity = new sandglass_light_unity();
    unity.struct_size = (uint)sizeof(sandglass_light_unity);
    IntPtr reason;
    Sand.Check(Native.sandglass_room_to_unity(ref shown, Native.SANDGLASS_LIGHT_MODEL_AMBIENT, ref unity, out reason), reason);
    unity.intensity *= Scale;
    for (int i = 0; i < 27; ++i) unity.sh[i] *= Scale;
    sun.transform.rotation = new Quaternion(unity.rotation[0], unity.rotation[1], unity.rotation[2], unity.rotation[3]);
    sun.color = new Color(unity.colour[0], unity.colour[1], unity.colour[2], 1).gamma;
    sun.intensity = unity.intensity;
    var probe = new SphericalHarmonicsL2();
    for (int channel = 0; channel < 3; ++channel)
      for (int i = 0; i < 9; ++i) probe[channel, i] = unity.sh[9 * channel + i];
    RenderSettings.ambientMode = AmbientMode.Custom;
    RenderSettings.ambientProbe = probe;
    return unity;
  }
}
