// The light of the room, from AR Foundation's camera. Hands the camera's image to the library, reads the library's
// estimate, and sets Unity's own light and ambient probe to it. The estimate itself is made in the scene's frame
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
  IntPtr file, memory, light;
  XRCpuImage held;
  bool holding;

  public IntPtr Handle { get { return light; } }

  // `network` is models/lights/room.light, a text asset named room.light.bytes in Unity.
  public RoomLight(byte[] network) {
    file = Marshal.AllocHGlobal(network.Length);  // aligned to at least 8 bytes; must outlive the light
    Marshal.Copy(network, 0, file, network.Length);
    sandglass_light_desc desc;
    Native.sandglass_light_desc_default(out desc);
    desc.asset = file;
    desc.asset_bytes = (ulong)network.Length;
    ulong bytes;
    IntPtr reason;
    Sand.Check(Native.sandglass_light_bytes(ref desc, out bytes, out reason), reason);
    memory = Marshal.AllocHGlobal((IntPtr)((long)bytes + Native.SANDGLASS_BLOCK_ALIGNMENT));
    Sand.Check(Native.sandglass_light_create(ref desc, Sand.Aligned(memory), bytes, out light, out reason), reason);
  }

  public void Dispose() {
    Release();
    Marshal.FreeHGlobal(memory);
    Marshal.FreeHGlobal(file);
    memory = file = light = IntPtr.Zero;
  }

  // Takes the newest image; release it after the frame. False if there is none or the library does not read its layout.
  public bool Acquire(ARCameraManager camera, out sandglass_camera_image acquired) {
    sandglass_camera_image image;
    Native.sandglass_camera_image_default(out image);
    acquired = image;
    XRCameraIntrinsics intrinsics;
    if (!camera.TryGetIntrinsics(out intrinsics) || !camera.TryAcquireLatestCpuImage(out held)) return false;
    holding = true;
    image.width = (uint)held.width;
    image.height = (uint)held.height;
    image.timestamp_ns = (ulong)(1e9 * held.timestamp);
    image.focal_x = intrinsics.focalLength.x;
    image.focal_y = intrinsics.focalLength.y;
    image.centre_x = intrinsics.principalPoint.x;
    image.centre_y = intrinsics.principalPoint.y;
    // Unity's pose is that of the upright image and left-handed, so z changes its sign.
    Quaternion pose = camera.transform.rotation;
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

  public sandglass_light_estimate Estimate() {
    var estimate = new sandglass_light_estimate();
    estimate.struct_size = (uint)sizeof(sandglass_light_estimate);
    Native.sandglass_light_get(light, ref estimate);
    return estimate;
  }

  // Sets Unity's directional light and ambient probe, for whatever else the app draws.
  public static void Show(sandglass_light_estimate estimate, Light sun) {
    var unity = new sandglass_light_unity();
    unity.struct_size = (uint)sizeof(sandglass_light_unity);
    IntPtr reason;
    Sand.Check(Native.sandglass_light_to_unity(ref estimate, Native.SANDGLASS_LIGHT_MODEL_AMBIENT, ref unity, out reason), reason);
    sun.transform.rotation = new Quaternion(unity.rotation[0], unity.rotation[1], unity.rotation[2], unity.rotation[3]);
    sun.color = new Color(unity.colour[0], unity.colour[1], unity.colour[2], 1).gamma;
    sun.intensity = unity.intensity;
    var probe = new SphericalHarmonicsL2();
    for (int channel = 0; channel < 3; ++channel)
      for (int i = 0; i < 9; ++i) probe[channel, i] = unity.sh[9 * channel + i];
    RenderSettings.ambientMode = AmbientMode.Custom;
    RenderSettings.ambientProbe = probe;
  }
}
