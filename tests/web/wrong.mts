// What the types refuse: each line below such a comment is an error, or the comment is one.
import { load } from "sandglass";
import { Stage } from "sandglass/stage";

const sand = await load();
const desc = sand.make("sandglass_scene_desc");
const input = sand.make("sandglass_frame_input");
const scene = sand.create("sandglass_scene", desc);
const room = sand.create("sandglass_room", sand.make("sandglass_room_desc"));
// @ts-expect-error: a room is no scene
sand.sandglass_scene_hash(room);
// @ts-expect-error: a scene is no room
input.room = scene;
// @ts-expect-error: a number is no handle
sand.sandglass_scene_hash(4096);
// @ts-expect-error: an address is no handle
input.skin = sand.allocate(64);
// @ts-expect-error: a handle is missing
sand.sandglass_room_reset(null);
// @ts-expect-error: a misspelt handle
sand.create("sandglass_rooom", desc);
// @ts-expect-error: the description of another thing
sand.create("sandglass_room", desc);
// @ts-expect-error: an argument is missing
sand.create("sandglass_mesh_inside", sand.make("sandglass_mesh"));
// @ts-expect-error: a misspelt struct
sand.make("sandglass_scene_descr");
// @ts-expect-error: a misspelt field
sand.make("sandglass_scene_desc", { gravty: [0, 0, 0] });
// @ts-expect-error: a misspelt field of a struct in a struct
desc.set({ granular: { particle_capcity: 1 } });
// @ts-expect-error: a misspelt field
input.set({ time_stap: 1 });
// @ts-expect-error: a struct of another type
input.colliders = desc;
// @ts-expect-error: the same, by set
input.set({ emitters: desc });
// @ts-expect-error: a struct by value of another type
desc.clock = sand.make("sandglass_parallel");
// @ts-expect-error: text for an array
desc.gravity = "down";
// @ts-expect-error: a function that there is not
sand.sandglass_scene_fame(scene, input, null);
// @ts-expect-error: half floats are no bytes
(await Stage.create()).see({ data: new Uint16Array(4), width: 1, height: 1 });
// @ts-expect-error: a ball without a radius
(await Stage.create()).push({ position: [0, 0, 0] });
// @ts-expect-error: bytes are no depth
(await Stage.create()).seeDepth({ data: new Uint8Array(4), width: 2, height: 2 });
// @ts-expect-error: a joint without a radius
(await Stage.create()).setHands([{ position: [0, 0, 0] }]);
// @ts-expect-error: a place throws no shadow, which is no option
(await Stage.create()).addPlace({ positions: [], indices: [], position: [], rotation: [] }, { shadow: true });
// @ts-expect-error: a misspelt option
await Stage.create({ budgt: 4 });
