// What the types accept, under tsc --strict.
import { load, constants, type Handle, type Numbers, type sandglass_collider } from "sandglass";
import { load as loadInline, wasm } from "sandglass/inline";
import { Stage, WorkerStage } from "sandglass/stage";
import { createStage } from "sandglass/three";
import { byDepth, depthNumbers, receive, receivers, receiverValues } from "sandglass/glsl";

const sand = await load(await WebAssembly.compile(wasm()), { threads: 1 });
const other = await loadInline();
const desc = sand.make("sandglass_scene_desc", { gravity: [0, -9.81, 0], granular: { particle_capacity: 10 } });
desc.granular.set({ emitter_capacity: 1, collider_capacity: 2 });
desc.gravity[1] = -1.62;
desc.gravity.set([0, -1, 0]);
desc.clock = sand.sandglass_clock_system();
const scene: Handle<"sandglass_scene"> = sand.create("sandglass_scene", desc);
const room = sand.create("sandglass_room", sand.make("sandglass_room_desc", { radius: 2 }));
const inside = sand.create("sandglass_mesh_inside", sand.make("sandglass_mesh"), constants.SANDGLASS_INSIDE_WINDING);
const input = sand.make("sandglass_frame_input", { time_step: 1 / 60, budget_ns: 4_000_000n, room, skin: null });
const colliders = sand.array("sandglass_collider", 2);
const one: sandglass_collider = colliders[0]!;
input.colliders = one;
input.colliders = colliders.address;
input.collider_count = 2;
input.set({ colliders: one, emitters: null });
one.set({ shape: constants.SANDGLASS_SHAPE_SPHERE, size: new Float32Array(3) });
const image = sand.make("sandglass_camera_image");
image.planes[0] = sand.put(new Uint8Array(4));
const planes: Numbers<Uint32Array> = image.planes;
const copy: Uint32Array = planes.slice();
sand.sandglass_room_reset(room);
sand.sandglass_scene_frame(scene, input, null);
sand.sandglass_camera_orientation(sand.put(new Float32Array(16)), image.orientation);
const hash: bigint = sand.sandglass_scene_hash(scene);
const name: string | null = sand.sandglass_isa_name(0);
const distance: number = sand.view().getFloat32(sand.put(copy), true);
const seen: number[] = [...image.position];
sand.free(inside);
sand.destroy(room);
other.destroy(other.create("sandglass_room", other.make("sandglass_room_desc")));
const stage = await Stage.create({ sand, budget: 4 });
const far = await WorkerStage.create({ source: wasm() });
const number: number = stage.addModel({
  positions: new Float32Array(9),
  indices: new Uint32Array(3),
  position: [0, 0, 0],
  rotation: [0, 0, 0, 1],
});
stage.createSand({ particles: 100, particle_radius: 0.01 });
stage.pour({ position: [0, 1, 0] });
stage.pour({ position: { x: 0, y: 1, z: 0 }, rotation: { x: 0, y: 0, z: 0, w: 1 } });
stage.see({ data: [1, 2, 3, 4], width: 1, height: 1 }, { centre: [0, 0.1] });
far.setShadow(await far.addModel({ positions: [], indices: [], position: [], rotation: [] }), false);
const place: number = stage.addPlace({ positions: [], indices: [], position: [0, 0, 0], rotation: [0, 0, 0, 1] });
stage.setHands(null, [{ position: { x: 0, y: 1, z: 0 }, radius: 0.01 }]);
stage.seeDepth({
  data: new Uint16Array(4),
  width: 2,
  height: 2,
  focal: [1, 1],
  centre: [0, 0],
  position: [0, 0, 0],
  orientation: [0, 0, 0, 1],
});
const heights = sand.make("sandglass_heights");
if (stage.relief) sand.sandglass_relief_get_heights(stage.relief, heights);
const side: number | undefined = stage.frame(1 / 60).textures.pile?.side;
const drawn = await far.frame(0.1);
const engine = await createStage({}, { scene: {}, renderer: {}, worker: true });
engine.update();
const held = await engine.addPlace({});
await held.update();
await held.dispose();
engine.seeHands(null);
await engine.seeThrough({}, { position: {}, orientation: {} }, { focal: [500, 500], centre: [319.5, 239.5] });
await engine.seeDepth(undefined, {});
await engine.seeRoom({}, {});
engine.update(1 / 60);
engine.receive({ roughness: 1 }, { shadowOnly: true }).roughness.toFixed(1);
engine.receiveByDepth({ depth: {}, metres: 0.001 }).set({ heights: null });
console.log(
  hash,
  name,
  distance,
  seen,
  number,
  place,
  side,
  receive,
  receivers[0],
  receiverValues(drawn),
  byDepth,
  depthNumbers(drawn),
);
