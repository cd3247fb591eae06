// The scene of toolchains/linux-arm64/sample in C#: the same block of sand, poured for the same second. The script
// compares the two hashes.
using System;
using System.Runtime.InteropServices;
using Sandglass;

static unsafe class Pour {
  static void Check(int status, byte* reason) {
    if (status != Native.SANDGLASS_OK) throw new Exception(Native.Text(Native.sandglass_status_name(status)) + ": " + Native.Text(reason));
  }

  static int Main() {
    const float r = 0.01f;
    var particles = new float[3 * 6 * 8 * 6];
    int at = 0;
    for (int y = 0; y < 8; ++y)
      for (int z = 0; z < 6; ++z)
        for (int x = 0; x < 6; ++x)
          foreach (int cell in new[] {x, y + 1, z}) particles[at++] = 2.0f * r * cell;

    sandglass_scene_desc desc;
    Native.sandglass_scene_desc_default(&desc);
    desc.granular.particle_radius = r;
    desc.granular.particle_capacity = (uint)(particles.Length / 3);
    desc.granular.collider_capacity = 1;
    ulong bytes;
    byte* reason;
    sandglass_scene* scene;
    Check(Native.sandglass_scene_bytes(&desc, &bytes, &reason), reason);
    const long alignment = Native.SANDGLASS_BLOCK_ALIGNMENT;
    IntPtr memory = Marshal.AllocHGlobal((IntPtr)((long)bytes + alignment));
    long block = (memory.ToInt64() + alignment - 1) / alignment * alignment;
    Check(Native.sandglass_scene_create(&desc, (void*)block, bytes, &scene, &reason), reason);
    fixed (float* positions = particles) {
      var sand = new sandglass_points { positions = positions, count = desc.granular.particle_capacity };
      Check(Native.sandglass_scene_add(scene, &sand, null, &reason), reason);
    }

    var floor = new sandglass_collider();
    floor.shape = Native.SANDGLASS_SHAPE_HALF_SPACE;
    floor.rotation[3] = 1.0f;
    sandglass_frame_input input;
    Native.sandglass_frame_input_default(&input);
    input.time_step = 1.0f / 60.0f;
    input.budget_ns = 4000000;
    input.colliders = &floor;
    input.collider_count = 1;
    var report = new sandglass_frame_report();
    report.struct_size = (uint)sizeof(sandglass_frame_report);
    for (int frame = 0; frame < 60; ++frame) Check(Native.sandglass_scene_frame(scene, &input, &report, &reason), reason);
    Console.WriteLine("{0} particles, {1} kernels, fastest {2:F3} m/s", report.sand.particles,
                      Native.Text(Native.sandglass_isa_name(Native.sandglass_scene_isa(scene))), report.sand.speed_max);
    Console.WriteLine("hash 0x{0:x16}", Native.sandglass_scene_hash(scene));
    Marshal.FreeHGlobal(memory);
    return report.struct_size == sizeof(sandglass_frame_report) && report.frame == 60 ? 0 : 1;
  }
}
