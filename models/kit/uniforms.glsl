// What an app tells the sand kit, in GLSL of OpenGL ES 3, WebGL 2 and Vulkan. Lengths are metres, colours linear.
#ifndef CAMERA_DECLARED  // by the engine
uniform mat4 view, projection;
uniform vec3 eye;
#endif

// The room's light as the library gives it: irradiance over pi of what faces the main light, and by the normal; the
// floor's radiance, which `ambient` holds; `table_of_room` turns `ambient`, which is of the room, to the world.
uniform vec3 to_light, sun, ambient[9], below;
uniform mat3 table_of_room;

// Shadows of the library: what the sand hides of the main light (`pile`) and leaves of the room's (`sky`), on the floor
// or on itself; what objects hide (`shadow`) and leave (`occlusion`). Boxes: x and z of the lower corner, and one over the extent.
uniform sampler2D pile, shadow, occlusion, sky;
uniform vec4 pile_box, shadow_box, occlusion_box;
uniform vec3 shadow_layers;  // of `shadow` (cast.h): their number; that less 1, over their height; half a texel of one
uniform mat4 on_plane;  // of a place on the plane that the objects' shadows lie on: x, height and z
uniform float pile_opacity, shadow_opacity, sky_known;

// The sand. Minerals: the albedo of a grain by itself, and the share of all grains that have this one or one before it.
uniform sampler3D grains, facets;  // the block of packed grains
uniform float block_side, wet;     // of the block; 0 dry, 1 wet
uniform vec4 minerals[4];

// Loose sand. Each stream: a nozzle's place and radius; its direction and speed. `stream_narrow`: how wide a stream is
// drawn, of the nozzle's width; 0: none.
uniform float particle_radius, pixels, flies, frame_seconds, stream_narrow;  // pixels: of a metre at a distance of one
uniform vec4 streams[3], stream_ways[3];
