// The C API, one to one: names, layouts and order are those of the public headers (types.h, sandglass.h, sampling.h, …), which
// document every field. Sizes and offsets are compared with the C compiler's by tests/package, so a header that moved on fails there, not
// on a phone. Nothing here allocates; what calls it every frame should keep its structs and arrays.
//
// Enumerations are int constants, as in C. Handles are IntPtr. Callbacks are delegates: keep a reference to each for as
// long as a scene has its function pointer (Marshal.GetFunctionPointerForDelegate), and under IL2CPP make it a static
// method with [MonoPInvokeCallback].
using System;
using System.Runtime.InteropServices;

namespace Sandglass {

// What a field is called in C where C# cannot spell it.
[AttributeUsage(AttributeTargets.Field)]
public sealed class CNameAttribute : Attribute {
  public readonly string Name;
  public CNameAttribute(string name) { Name = name; }
}

[UnmanagedFunctionPointer(CallingConvention.Cdecl)] public delegate ulong NowFunction(IntPtr user);
[UnmanagedFunctionPointer(CallingConvention.Cdecl)] public delegate void TraceFunction(IntPtr user, IntPtr name);
[UnmanagedFunctionPointer(CallingConvention.Cdecl)] public delegate void LogFunction(IntPtr user, IntPtr sentence);
[UnmanagedFunctionPointer(CallingConvention.Cdecl)] public delegate void ProgressFunction(IntPtr user, ulong done, ulong total);
[UnmanagedFunctionPointer(CallingConvention.Cdecl)] public unsafe delegate int InsideFunction(IntPtr user, float* point);
[UnmanagedFunctionPointer(CallingConvention.Cdecl)] public unsafe delegate float DistanceFunction(IntPtr user, float* point);

[StructLayout(LayoutKind.Sequential)]
public struct sandglass_clock {
  public IntPtr now_ns;
  public IntPtr user;
}

[StructLayout(LayoutKind.Sequential)]
public struct sandglass_parallel {
  public IntPtr run;
  public IntPtr user;
}

[StructLayout(LayoutKind.Sequential)]
public struct sandglass_trace {
  public IntPtr begin, end;
  public IntPtr user;
}

[StructLayout(LayoutKind.Sequential)]
public struct sandglass_log {
  public IntPtr write;
  public IntPtr user;
}

[StructLayout(LayoutKind.Sequential)]
public struct sandglass_reference_scheme {
  public int scheme, blend;
  public uint solver_iterations, stabilisation_iterations;
  public float relaxation;
}

[StructLayout(LayoutKind.Sequential)]
public struct sandglass_granular_desc {
  public uint particle_capacity, grain_capacity, boundary_capacity, body_capacity, body_particle_capacity;
  public uint emitter_capacity, sink_capacity, collider_capacity;
  public float particle_radius, grain_radius, static_friction, kinetic_friction, height_weighting;
  public float courant, substep_max, substep_min, list_skin, sleep_after, refine_step;
  public sandglass_reference_scheme reference;
  public float collider_band, lowest;
}

[StructLayout(LayoutKind.Sequential)]
public struct sandglass_level {
  public uint struct_size;
  public IntPtr name;
  public float cost_solver, cost_refine, overlap_p99, overlap_mean, angle_degrees;
}

[StructLayout(LayoutKind.Sequential)]
public unsafe struct sandglass_scene_desc {
  public uint struct_size;
  public int isa;
  public uint unit_items;
  public uint finest_level;
  public fixed float gravity[3];
  public sandglass_clock clock;
  public sandglass_parallel parallel;
  public sandglass_trace trace;
  public sandglass_log log;
  public sandglass_granular_desc granular;
}

[StructLayout(LayoutKind.Sequential)]
public struct sandglass_region {
  public IntPtr name;
  public ulong offset, bytes;
}

[StructLayout(LayoutKind.Sequential)]
public unsafe struct sandglass_body {
  public uint struct_size;
  public uint particle_count;
  public float* particle_positions;
  public float density_ratio;
  public fixed float linear_velocity[3];
  public fixed float angular_velocity[3];
}

[StructLayout(LayoutKind.Sequential)]
public unsafe struct sandglass_body_pose {
  public fixed float position[3];
  public fixed float rotation[4];
  public fixed float linear_velocity[3];
  public fixed float angular_velocity[3];
}

[StructLayout(LayoutKind.Sequential)]
public unsafe struct sandglass_ray_hit {
  public int what;
  public uint index;
  public float distance;
  public fixed float point[3];
  public fixed float normal[3];
}

[StructLayout(LayoutKind.Sequential)]
public unsafe struct sandglass_collider {
  public int shape;
  public fixed float position[3];
  public fixed float rotation[4];
  public fixed float size[3];
  public fixed float linear_velocity[3];
  public fixed float angular_velocity[3];
  public int grains_only;
  public IntPtr field;
  public uint id;
}

[StructLayout(LayoutKind.Sequential)]
public unsafe struct sandglass_grain {
  public fixed float position[3];
  public float speed;
}

[StructLayout(LayoutKind.Sequential)]
public struct sandglass_plan_run {
  public uint stage, units;
}

[StructLayout(LayoutKind.Sequential)]
public unsafe struct sandglass_plan {
  public uint struct_size, level, run_count;
  public fixed uint runs[2 * Native.SANDGLASS_PLAN_RUNS];  // sandglass_plan_run: stage, units
}

[StructLayout(LayoutKind.Sequential)]
public unsafe struct sandglass_emitter {
  public fixed float position[3];
  public fixed float rotation[4];
  public float radius, speed;
  public uint grains_per_particle;
}

[StructLayout(LayoutKind.Sequential)]
public unsafe struct sandglass_frame_input {
  public uint struct_size;
  public float time_step;
  public ulong budget_ns;
  public float thermal_headroom;
  public sandglass_collider* colliders;
  public uint collider_count, emitter_count;
  public sandglass_emitter* emitters;
  public sandglass_collider* sinks;
  public uint sink_count;
  public float output_lag;
  public void* grains;
  public uint grain_stride, grain_capacity;
  public IntPtr* shadows;
  public uint shadow_count;
  public IntPtr pile_shadow;
  public IntPtr light;
  public sandglass_camera_image* camera;
  public sandglass_plan* plan;
  public IntPtr room;
}

[StructLayout(LayoutKind.Sequential)]
public struct sandglass_stage_report {
  public uint units, denied;
  public ulong elapsed_ns;
}

[StructLayout(LayoutKind.Sequential)]
public struct sandglass_frame_report {
  public uint struct_size, level;
  public ulong frame, budget_ns, target_ns, elapsed_ns, mandatory_ns, last_unit_ns, longest_unit_ns;
  public uint clock_fault;
  [CName("stages[0]")] public sandglass_stage_report granular;
  [CName("stages[1]")] public sandglass_stage_report lighting;
  [CName("stages[2]")] public sandglass_stage_report shadow;
  [CName("stages[3]")] public sandglass_stage_report refine;
  [CName("stages[4]")] public sandglass_stage_report output;
  public double simulated_time, time_debt;
  public float grain_lag, substep;
  public uint substeps, list_builds, particles, awake, grains, awake_grains, dropped_contacts, quarantined;
  public uint ignored_colliders, particle_numbers, grain_numbers;
  public ulong emitted_particles, emitted_grains, removed_particles, removed_grains, denied_particles;
  public float speed_max;
  public uint pending_shadows, shadow_age, light_valid, light_changed, light_age, light_units_left, ignored_images;
  public sandglass_plan plan;
  public ulong removed_bodies;
}

[StructLayout(LayoutKind.Sequential)]
public unsafe struct sandglass_mesh {
  public float* vertices;
  public uint vertex_count;
  public uint* indices;
  public uint triangle_count;
}

[StructLayout(LayoutKind.Sequential)]
public struct sandglass_sample_options {
  public uint struct_size, tries;
  public ulong seed;
  public int metric;
  public IntPtr progress;
  public IntPtr user;
}

[StructLayout(LayoutKind.Sequential)]
public struct sandglass_shadow_desc {
  public uint struct_size;
  public int isa;
  public IntPtr asset;
  public ulong asset_bytes;
  public int mode;
  public uint threshold;
  public float light_tolerance;
  public uint light_count;
}

[StructLayout(LayoutKind.Sequential)]
public unsafe struct sandglass_shadow_info {
  public uint struct_size, version;
  public fixed float origin[3];
  public float half_x, half_z, height, angular_diameter, polar_max;
  public uint plane_fitted, width, layers;
  public ulong macs_per_texel;
  public float rmse_float, rmse_int8;
  public uint validated_lights, float_parameters, ambient_texels;
  public float ambient_half;
  public uint ambient_components;
  public float ambient_rmse;
  public uint surface_vertices;
}

[StructLayout(LayoutKind.Sequential)]
public unsafe struct sandglass_shadow_texture {
  public uint struct_size, valid;
  public byte* coverage;
  public fixed float low[2];
  public fixed float high[2];
  public fixed float light[3];
  public float opacity;
  public uint beyond, age, evaluated;
}

[StructLayout(LayoutKind.Sequential)]
public unsafe struct sandglass_shadow_ambient {
  public uint struct_size, valid;
  public byte* visibility;
  public uint side;
  public fixed float low[2];
  public fixed float high[2];
  public uint age, completed;
}

[StructLayout(LayoutKind.Sequential)]
public unsafe struct sandglass_pile_shadow_desc {
  public uint struct_size;
  public int isa;
  public fixed float low[2];
  public fixed float high[2];
  public float floor;
  public uint texels;
  public float angular_diameter, light_tolerance;
  public uint on_sand, sky_texels;
}

[StructLayout(LayoutKind.Sequential)]
public unsafe struct sandglass_pile_shadow_texture {
  public uint struct_size, valid, texels;
  public byte* coverage;
  public byte* on_sand;
  public fixed float low[2];
  public fixed float high[2];
  public float opacity;
  public uint age;
}

[StructLayout(LayoutKind.Sequential)]
public unsafe struct sandglass_pile_shadow_sky {
  public uint struct_size, valid, texels;
  public byte* floor;
  public byte* on_sand;
  public byte* heights;
  public uint height_texels;
  public float height;
  public fixed float low[2];
  public fixed float high[2];
  public uint age;
}

[StructLayout(LayoutKind.Sequential)]
public unsafe struct sandglass_camera_image {
  public uint struct_size;
  public int format, range;
  public uint width, height, turn_deg;
  [CName("planes[0]")] public byte* plane0;
  [CName("planes[1]")] public byte* plane1;
  [CName("planes[2]")] public byte* plane2;
  public fixed uint strides[3];
  public float focal_x, focal_y, centre_x, centre_y;
  public fixed float orientation[4];
  public uint pose_is_upright;
  public ulong timestamp_ns;
  public fixed float position[3];
  public float exposure;
}

[StructLayout(LayoutKind.Sequential)]
public struct sandglass_room_desc {
  public uint struct_size;
  public float radius, half_life, interval;
}

[StructLayout(LayoutKind.Sequential)]
public unsafe struct sandglass_room_light {
  public uint struct_size, valid;
  public fixed float cells[64];
  public fixed float ambient_cells[64];
  public fixed float main_direction[3];
  public float main_share;
  public fixed float main_colour[3];
  public fixed float irradiance[3];
  public fixed float sh[27];
  public float seen, clipped;
  public fixed float look[3];
  public float white;
}

[StructLayout(LayoutKind.Sequential)]
public struct sandglass_light_desc {
  public uint struct_size;
  public int isa;
  public IntPtr asset;
  public ulong asset_bytes;
  public float interval, smoothing, turn_limit, outlier_angle, outlier_level;
  public int backend;
}

[StructLayout(LayoutKind.Sequential)]
public struct sandglass_light_info {
  public uint struct_size, training_images, calibration_images;
  public float angle_deg, difference;
  public ulong data_hash, seed;
}

[StructLayout(LayoutKind.Sequential)]
public unsafe struct sandglass_light_estimate {
  public uint struct_size, valid;
  public ulong timestamp_ns, image_ns;
  public fixed float direction[3];
  public fixed float light[3];
  public float strength;
  public fixed float ambient[3];
  public float contrast, confidence;
  public uint estimates;
  public float deviation;
  public uint rejected;
  public fixed float sh[27];
}

[StructLayout(LayoutKind.Sequential)]
public unsafe struct sandglass_light_filament {
  public uint struct_size;
  public fixed float direction[3];
  public fixed float colour[3];
  public float intensity;
  public fixed float sh[27];
  public float sh_intensity;
}

[StructLayout(LayoutKind.Sequential)]
public unsafe struct sandglass_light_arkit {
  public uint struct_size;
  public fixed float primary_light_direction[3];
  public float primary_light_intensity;
  public fixed float orientation[4];
  public float ambient_intensity, ambient_colour_temperature;
  public fixed float sh[27];
}

[StructLayout(LayoutKind.Sequential)]
public unsafe struct sandglass_light_arcore {
  public uint struct_size;
  public fixed float main_light_direction[3];
  public fixed float main_light_intensity[3];
  public fixed float sh[27];
}

[StructLayout(LayoutKind.Sequential)]
public unsafe struct sandglass_light_unity {
  public uint struct_size;
  public fixed float forward[3];
  public fixed float rotation[4];
  public fixed float colour[3];
  public float intensity;
  public fixed float sh[27];
}

public static unsafe class Native {
#if UNITY_IOS && !UNITY_EDITOR
  const string k_library = "__Internal";  // linked into the app
#else
  const string k_library = "sandglass";  // libsandglass.so, libsandglass.dylib
#endif

  public const int SANDGLASS_VERSION_MAJOR = 0, SANDGLASS_VERSION_MINOR = 1, SANDGLASS_VERSION_PATCH = 0;
  public const int SANDGLASS_VERSION =
      1000000 * SANDGLASS_VERSION_MAJOR + 1000 * SANDGLASS_VERSION_MINOR + SANDGLASS_VERSION_PATCH;
  // Whether the native library is of the version that these structs mirror: ask before any other call.
  public static bool VersionFits() { return sandglass_version() / 1000 == SANDGLASS_VERSION / 1000; }
  public const int SANDGLASS_OK = 0, SANDGLASS_ERROR_INVALID_ARGUMENT = 1, SANDGLASS_ERROR_MEMORY_TOO_SMALL = 2,
                   SANDGLASS_ERROR_MEMORY_ALIGNMENT = 3, SANDGLASS_ERROR_CAPACITY = 4, SANDGLASS_ERROR_UNSUPPORTED = 5,
                   SANDGLASS_ERROR_REPLAY = 6;
  public const int SANDGLASS_BLOCK_ALIGNMENT = 64;
  public const int SANDGLASS_ISA_AUTOMATIC = 0, SANDGLASS_ISA_SCALAR = 1, SANDGLASS_ISA_NEON = 2, SANDGLASS_ISA_AVX2 = 3,
                   SANDGLASS_ISA_AVX512 = 4, SANDGLASS_ISA_NEON_DOTPROD = 5, SANDGLASS_ISA_NEON_I8MM = 6, SANDGLASS_ISA_WASM = 7;
  public const int SANDGLASS_SCHEME_SMALL_STEP = 0, SANDGLASS_SCHEME_AVERAGED = 1;
  public const int SANDGLASS_BLEND_CONTINUOUS = 0, SANDGLASS_BLEND_SOURCE = 1;
  public const int SANDGLASS_LEVEL_FULL = 0, SANDGLASS_LEVEL_KEEP_LISTS = 1, SANDGLASS_LEVEL_COARSE = 2,
                   SANDGLASS_LEVEL_COARSER = 3, SANDGLASS_LEVEL_SLOW_MOTION = 4, SANDGLASS_LEVEL_COUNT = 5;
  public const int SANDGLASS_SHAPE_HALF_SPACE = 0, SANDGLASS_SHAPE_SPHERE = 1, SANDGLASS_SHAPE_CAPSULE = 2,
                   SANDGLASS_SHAPE_BOX = 3, SANDGLASS_SHAPE_FIELD = 4;
  public const int SANDGLASS_HIT_NOTHING = 0, SANDGLASS_HIT_SAND = 1, SANDGLASS_HIT_BODY = 2;
  public const int SANDGLASS_STAGE_GRANULAR = 0, SANDGLASS_STAGE_LIGHTING = 1, SANDGLASS_STAGE_SHADOW = 2,
                   SANDGLASS_STAGE_REFINE = 3, SANDGLASS_STAGE_OUTPUT = 4, SANDGLASS_STAGE_COUNT = 5;
  public const int SANDGLASS_PLAN_RUNS = 48;
  public const int SANDGLASS_INSIDE_PARITY = 0, SANDGLASS_INSIDE_WINDING = 1;
  public const int SANDGLASS_METRIC_EUCLIDEAN = 0, SANDGLASS_METRIC_GEODESIC = 1;
  public const int SANDGLASS_SHADOW_TEXELS = 256, SANDGLASS_SHADOW_LIGHTS = 8, SANDGLASS_LIGHT_CELLS = 64;
  public const int SANDGLASS_SHADOW_ADAPTIVE = 0, SANDGLASS_SHADOW_FULL = 1;
  public const int SANDGLASS_LIGHT_WIDTH = 256, SANDGLASS_LIGHT_HEIGHT = 192, SANDGLASS_CAMERA_SIDE_LIMIT = 16384;
  public const int SANDGLASS_CAMERA_RGB = 0, SANDGLASS_CAMERA_RGBA = 1, SANDGLASS_CAMERA_NV12 = 2, SANDGLASS_CAMERA_NV21 = 3,
                   SANDGLASS_CAMERA_I420 = 4;
  public const int SANDGLASS_YUV_FULL_601 = 0, SANDGLASS_YUV_VIDEO_601 = 1, SANDGLASS_YUV_FULL_709 = 2,
                   SANDGLASS_YUV_VIDEO_709 = 3;
  public const uint SANDGLASS_TURN_FROM_POSE = 0xffffffffu;
  public const int SANDGLASS_LIGHT_MODEL_AMBIENT = 0, SANDGLASS_LIGHT_MODEL_WHOLE = 1, SANDGLASS_LIGHT_MODEL_PICTURE = 2;
  public const int SANDGLASS_SOLID_INSIDE = 0, SANDGLASS_SOLID_OUTSIDE = 1;

  // The sentence behind a `reason` or a name; null for NULL.
  public static string Text(IntPtr sentence) { return sentence == IntPtr.Zero ? null : Marshal.PtrToStringAnsi(sentence); }

  // ------------------------------------------------------------------------------------------------ sandglass.h
  [DllImport(k_library)] public static extern uint sandglass_version();
  [DllImport(k_library)] public static extern IntPtr sandglass_status_name(int status);
  [DllImport(k_library)] public static extern sandglass_clock sandglass_clock_system();
  [DllImport(k_library)] public static extern sandglass_trace sandglass_trace_system();
  [DllImport(k_library)] public static extern IntPtr sandglass_isa_name(int isa);
  [DllImport(k_library)] public static extern int sandglass_isa_available(int isa);
  [DllImport(k_library)] public static extern void sandglass_scene_desc_default(out sandglass_scene_desc desc);
  [DllImport(k_library)] public static extern int sandglass_scene_bytes(ref sandglass_scene_desc desc, out ulong bytes, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_scene_create(ref sandglass_scene_desc desc, IntPtr block, ulong bytes, out IntPtr scene, out IntPtr reason);
  [DllImport(k_library)] public static extern void sandglass_scene_reset(IntPtr scene);
  [DllImport(k_library)] public static extern int sandglass_scene_set_gravity(IntPtr scene, float[] gravity, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_scene_move(IntPtr scene, float[] rotation, float[] translation, out IntPtr reason);
  [DllImport(k_library)] public static extern ulong sandglass_scene_save_bytes(IntPtr scene);
  [DllImport(k_library)] public static extern int sandglass_scene_save(IntPtr scene, byte[] data, ulong bytes, out ulong written, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_scene_restore(IntPtr scene, byte[] data, ulong bytes, out IntPtr reason);
  [DllImport(k_library)] public static extern uint sandglass_scene_regions(IntPtr scene, [Out] sandglass_region[] regions, uint capacity);
  [DllImport(k_library)] public static extern int sandglass_scene_isa(IntPtr scene);
  [DllImport(k_library)] public static extern int sandglass_granular_add(IntPtr scene, float[] particle_positions, float[] particle_velocities, uint particle_count, float[] grain_positions, float[] grain_velocities, uint grain_count, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_granular_remove(IntPtr scene, ref sandglass_collider region, out uint particles, out uint grains, out IntPtr reason);
  [DllImport(k_library)] public static extern void sandglass_body_default(out sandglass_body body);
  [DllImport(k_library)] public static extern int sandglass_granular_add_body(IntPtr scene, ref sandglass_body body, out uint index, out IntPtr reason);
  [DllImport(k_library)] public static extern sandglass_body_pose sandglass_granular_body_pose(IntPtr scene, uint index);
  [DllImport(k_library)] public static extern int sandglass_granular_held_collider(IntPtr scene, uint index, out sandglass_collider held);
  [DllImport(k_library)] public static extern int sandglass_granular_has_body(IntPtr scene, uint index);
  [DllImport(k_library)] public static extern int sandglass_granular_remove_body(IntPtr scene, uint index, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_granular_set_body(IntPtr scene, uint index, ref sandglass_body_pose pose, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_granular_push_body(IntPtr scene, uint index, float[] impulse, float[] point, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_granular_ray(IntPtr scene, float[] origin, float[] direction, float reach, out sandglass_ray_hit hit);
  [DllImport(k_library)] public static extern int sandglass_body_box_count(float[] half_extents, float particle_radius, out uint count, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_body_box(float[] half_extents, float particle_radius, float[] position, float[] rotation, float density, float* points, uint capacity, out sandglass_body body, out IntPtr reason);
  [DllImport(k_library)] public static extern void sandglass_body_box_collider(ref sandglass_body_pose pose, float[] half_extents, float[] rotation, out sandglass_collider collider);
  [DllImport(k_library)] public static extern int sandglass_rotation_about(float[] axis, float angle, [Out] float[] rotation);
  [DllImport(k_library)] public static extern int sandglass_granular_set_boundary(IntPtr scene, float[] positions, uint count, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_granular_set_friction(IntPtr scene, float static_friction, float kinetic_friction, out IntPtr reason);
  [DllImport(k_library)] public static extern void sandglass_frame_input_default(out sandglass_frame_input input);
  [DllImport(k_library)] public static extern int sandglass_scene_frame(IntPtr scene, ref sandglass_frame_input input, ref sandglass_frame_report report, out IntPtr reason);
  [DllImport(k_library)] public static extern IntPtr sandglass_level_describe(uint level);  // sandglass_level*
  [DllImport(k_library)] public static extern IntPtr sandglass_level_name(uint level);
  [DllImport(k_library)] public static extern void sandglass_granular_particles(IntPtr scene, [Out] float[] positions, [Out] float[] velocities);
  [DllImport(k_library)] public static extern void sandglass_granular_grains(IntPtr scene, [Out] float[] positions, [Out] float[] velocities);
  [DllImport(k_library)] public static extern ulong sandglass_scene_hash(IntPtr scene);

  // ------------------------------------------------------------------------------------------------ sampling.h
  [DllImport(k_library)] public static extern int sandglass_sample_disk(float radius, uint count, [Out] float[] points, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_sample_sphere(float radius, uint count, [Out] float[] points, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_sample_ring(float radius, float theta_a, float theta_b, uint count, [Out] float[] points, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_mesh_bounds(ref sandglass_mesh mesh, [Out] float[] bounds_min, [Out] float[] bounds_max, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_mesh_area(ref sandglass_mesh mesh, out double area, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_mesh_winding_number(ref sandglass_mesh mesh, float[] point, out double winding, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_mesh_inside_bytes(ref sandglass_mesh mesh, int rule, out ulong bytes, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_mesh_inside_create(ref sandglass_mesh mesh, int rule, IntPtr block, ulong bytes, out IntPtr inside, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_mesh_inside_test(IntPtr inside, float[] point);
  [DllImport(k_library)] public static extern void sandglass_sample_options_default(out sandglass_sample_options options);
  [DllImport(k_library)] public static extern int sandglass_sample_surface_capacity(ref sandglass_mesh mesh, float distance, ref sandglass_sample_options options, out uint capacity, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_sample_surface_bytes(ref sandglass_mesh mesh, float distance, ref sandglass_sample_options options, uint capacity, out ulong bytes, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_sample_surface(ref sandglass_mesh mesh, float distance, ref sandglass_sample_options options, IntPtr scratch, ulong scratch_bytes, [Out] float[] points, uint capacity, out uint count, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_sample_volume_capacity(float[] bounds_min, float[] bounds_max, float distance, out uint capacity, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_sample_volume_bytes(float[] bounds_min, float[] bounds_max, float distance, uint capacity, out ulong bytes, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_sample_volume(float[] bounds_min, float[] bounds_max, float distance, InsideFunction inside, IntPtr inside_user, ref sandglass_sample_options options, IntPtr scratch, ulong scratch_bytes, [Out] float[] points, uint capacity, out uint count, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_sample_lattice_capacity(float[] bounds_min, float[] bounds_max, float distance, out uint capacity, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_sample_lattice_bytes(float[] bounds_min, float[] bounds_max, float distance, out ulong bytes, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_sample_lattice(float[] bounds_min, float[] bounds_max, float distance, InsideFunction inside, IntPtr inside_user, ref sandglass_sample_options options, IntPtr scratch, ulong scratch_bytes, [Out] float[] points, uint capacity, out uint count, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_sample_power(float[] points, uint count, float[] frequency, out double power, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_sample_spectrum(float[] points, uint count, float frequency_max, uint bins, uint directions, int planar, [Out] double[] power, out IntPtr reason);

  // ------------------------------------------------------------------------------------------------ field.h
  [DllImport(k_library)] public static extern int sandglass_field_bytes(float[] bounds_min, float[] bounds_max, float spacing, out ulong bytes, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_field_from_function(float[] bounds_min, float[] bounds_max, float spacing, int solid, DistanceFunction distance, IntPtr user, IntPtr block, ulong bytes, out IntPtr field, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_field_from_mesh(ref sandglass_mesh mesh, InsideFunction inside, IntPtr inside_user, float[] bounds_min, float[] bounds_max, float spacing, float band, int solid, IntPtr block, ulong bytes, out IntPtr field, out IntPtr reason);
  [DllImport(k_library)] public static extern float sandglass_field_distance(IntPtr field, float[] point, [Out] float[] normal);
  [DllImport(k_library)] public static extern int sandglass_field_bounds(IntPtr field, [Out] float[] bounds_min, [Out] float[] bounds_max);

  // ------------------------------------------------------------------------------------------------ pile_shadow.h
  [DllImport(k_library)] public static extern void sandglass_pile_shadow_desc_default(out sandglass_pile_shadow_desc desc);
  [DllImport(k_library)] public static extern int sandglass_pile_shadow_bytes(ref sandglass_pile_shadow_desc desc, out ulong bytes, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_pile_shadow_create(ref sandglass_pile_shadow_desc desc, IntPtr block, ulong bytes, out IntPtr shadow, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_pile_shadow_set_light(IntPtr shadow, float[] direction, out IntPtr reason);
  [DllImport(k_library)] public static extern void sandglass_pile_shadow_refresh(IntPtr shadow);
  [DllImport(k_library)] public static extern uint sandglass_pile_shadow_run(IntPtr shadow, float[] positions, uint count, float radius, uint units);
  [DllImport(k_library)] public static extern void sandglass_pile_shadow_get_texture(IntPtr shadow, ref sandglass_pile_shadow_texture texture);
  [DllImport(k_library)] public static extern int sandglass_pile_shadow_set_cells(IntPtr shadow, float[] cells, out IntPtr reason);
  [DllImport(k_library)] public static extern void sandglass_pile_shadow_get_sky(IntPtr shadow, ref sandglass_pile_shadow_sky sky);
  [DllImport(k_library)] public static extern void sandglass_pile_shadow_light_grains(IntPtr shadow, float[] positions, uint count, float radius, byte[] visibility);
  [DllImport(k_library)] public static extern ulong sandglass_pile_shadow_hash(IntPtr shadow);

  // ------------------------------------------------------------------------------------------------ shadow.h
  [DllImport(k_library)] public static extern void sandglass_shadow_desc_default(out sandglass_shadow_desc desc);
  [DllImport(k_library)] public static extern int sandglass_shadow_inspect(IntPtr asset, ulong asset_bytes, ref sandglass_shadow_info info, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_shadow_bytes(ref sandglass_shadow_desc desc, out ulong bytes, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_shadow_create(ref sandglass_shadow_desc desc, IntPtr block, ulong bytes, out IntPtr shadow, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_shadow_set_light(IntPtr shadow, uint light, float[] direction, float irradiance, out IntPtr reason);
  [DllImport(k_library)] public static extern uint sandglass_shadow_run(IntPtr[] shadows, uint count, uint units);
  [DllImport(k_library)] public static extern uint sandglass_shadow_units_left(IntPtr shadow);
  [DllImport(k_library)] public static extern void sandglass_shadow_get_texture(IntPtr shadow, uint light, ref sandglass_shadow_texture texture);
  [DllImport(k_library)] public static extern int sandglass_shadow_resample(IntPtr shadow, uint light, uint size, [Out] byte[] coverage, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_shadow_combine(IntPtr shadow, uint size, [Out] byte[] coverage, [Out] float[] low, [Out] float[] high, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_shadow_set_cells(IntPtr shadow, float[] cells, float yaw, out IntPtr reason);
  [DllImport(k_library)] public static extern void sandglass_shadow_get_ambient(IntPtr shadow, ref sandglass_shadow_ambient ambient);
  [DllImport(k_library)] public static extern int sandglass_shadow_surface(IntPtr asset, ulong asset_bytes, float[] positions, float[] normals, uint count, [Out] float[] transfer, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_shadow_turn_harmonics(float[] sh, float[] rotation, [Out] float[] turned, out IntPtr reason);
  [DllImport(k_library)] public static extern ulong sandglass_shadow_hash(IntPtr shadow);
  [DllImport(k_library)] public static extern int sandglass_shadow_isa(IntPtr shadow);

  // ------------------------------------------------------------------------------------------------ light.h
  [DllImport(k_library)] public static extern void sandglass_camera_image_default(out sandglass_camera_image image);
  [DllImport(k_library)] public static extern float sandglass_camera_focal(uint width, uint height, float diagonal_deg);
  [DllImport(k_library)] public static extern int sandglass_camera_orientation(float[] matrix, [Out] float[] orientation);
  [DllImport(k_library)] public static extern int sandglass_camera_check(ref sandglass_camera_image image, out IntPtr reason);
  [DllImport(k_library)] public static extern void sandglass_light_desc_default(out sandglass_light_desc desc);
  [DllImport(k_library)] public static extern int sandglass_light_inspect(IntPtr asset, ulong asset_bytes, ref sandglass_light_info info, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_light_bytes(ref sandglass_light_desc desc, out ulong bytes, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_light_create(ref sandglass_light_desc desc, IntPtr block, ulong bytes, out IntPtr light, out IntPtr reason);
  [DllImport(k_library)] public static extern void sandglass_light_release(IntPtr light);
  [DllImport(k_library)] public static extern void sandglass_light_reset(IntPtr light);
  [DllImport(k_library)] public static extern int sandglass_light_turn(IntPtr light, float[] rotation, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_light_set_image(IntPtr light, ref sandglass_camera_image image, out uint taken, out IntPtr reason);
  [DllImport(k_library)] public static extern uint sandglass_light_run(IntPtr light, uint units);
  [DllImport(k_library)] public static extern uint sandglass_light_units_left(IntPtr light);
  [DllImport(k_library)] public static extern void sandglass_light_get(IntPtr light, ref sandglass_light_estimate estimate);
  [DllImport(k_library)] public static extern void sandglass_light_get_latest(IntPtr light, ref sandglass_light_estimate estimate);
  [DllImport(k_library)] public static extern ulong sandglass_light_hash(IntPtr light);
  [DllImport(k_library)] public static extern int sandglass_light_isa(IntPtr light);
  [DllImport(k_library)] public static extern void sandglass_room_desc_default(out sandglass_room_desc desc);
  [DllImport(k_library)] public static extern int sandglass_room_bytes(ref sandglass_room_desc desc, out ulong bytes, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_room_create(ref sandglass_room_desc desc, IntPtr block, ulong bytes, out IntPtr room, out IntPtr reason);
  [DllImport(k_library)] public static extern void sandglass_room_reset(IntPtr room);
  [DllImport(k_library)] public static extern int sandglass_room_set_image(IntPtr room, ref sandglass_camera_image image, out uint taken, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_room_move(IntPtr room, float[] rotation, float[] translation, out IntPtr reason);
  [DllImport(k_library)] public static extern unsafe int sandglass_room_get(IntPtr room, float[] position, sandglass_light_estimate* estimate, ref sandglass_room_light light, out IntPtr reason);
  [DllImport(k_library)] public static extern void sandglass_room_light_fade(ref sandglass_room_light shown, ref sandglass_room_light now, float seconds);
  [DllImport(k_library)] public static extern ulong sandglass_room_save_bytes(IntPtr room);
  [DllImport(k_library)] public static extern unsafe int sandglass_room_save(IntPtr room, void* data, ulong bytes, out IntPtr reason);
  [DllImport(k_library)] public static extern unsafe int sandglass_room_restore(IntPtr room, void* data, ulong bytes, out IntPtr reason);
  [DllImport(k_library)] public static extern ulong sandglass_room_hash(IntPtr room);
  [DllImport(k_library)] public static extern int sandglass_light_harmonics(ref sandglass_light_estimate estimate, int model, [Out] float[] sh, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_light_to_filament(ref sandglass_light_estimate estimate, int model, float nits, ref sandglass_light_filament filament, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_light_to_arkit(ref sandglass_light_estimate estimate, int model, ref sandglass_light_arkit arkit, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_light_to_unity(ref sandglass_light_estimate estimate, int model, ref sandglass_light_unity unity, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_room_harmonics(ref sandglass_room_light light, int model, [Out] float[] sh, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_room_to_filament(ref sandglass_room_light light, int model, float nits, ref sandglass_light_filament filament, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_room_to_arkit(ref sandglass_room_light light, int model, ref sandglass_light_arkit arkit, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_room_to_arcore(ref sandglass_room_light light, int model, ref sandglass_light_arcore arcore, out IntPtr reason);
  [DllImport(k_library)] public static extern int sandglass_room_to_unity(ref sandglass_room_light light, int model, ref sandglass_light_unity unity, out IntPtr reason);
}

}  // namespace Sandglass
