// The types of sandglass/stage and sandglass/worker. Numbers are metres and seconds; rotations are (x, y, z, w).
import type { Handle, Pointer, Sandglass, Values, sandglass_granular_desc, sandglass_room_light } from "sandglass";

/** An array, or a vector of a renderer or of WebXR. */
export type Triple = ArrayLike<number> | { readonly x: number; readonly y: number; readonly z: number };
/** A rotation, not all 0. Angles (Euler) are none. */
export type Quadruple =
  ArrayLike<number> | { readonly x: number; readonly y: number; readonly z: number; readonly w: number };
export interface StageOptions {
  sand?: Sandglass;
  source?: URL | string | BufferSource | WebAssembly.Module;
  threads?: number;
  origin?: Triple;
  half?: number;
  /** Metres above the floor, up to which materials that receive shadows stand. Their shadows then take 1.4 to 1.9 times as long. */
  height?: number;
  budget?: number;
  /** The room keeps what metal reflects: sandglass_room_get_cube(). */
  reflections?: boolean;
}
export interface SandOptions extends Values<sandglass_granular_desc> {
  particles?: number;
  radius?: number;
}
/** Finite, up to 1000 km from the world's origin. */
export interface Pose {
  position: Triple;
  rotation: Quadruple;
}
/** Three numbers a vertex, three indices a triangle. */
export interface Mesh {
  positions: ArrayLike<number>;
  indices: ArrayLike<number>;
}
/** Models that throw shadows have 1,000,000 triangles at most, all together. */
export interface ModelOptions {
  shadow?: boolean;
  collide?: boolean;
}
/** At most 8. `radius`: from that of a particle to 100 times as much; `speed`: at most 100. */
export interface Nozzle {
  position: Triple;
  rotation?: Quadruple;
  radius?: number;
  speed?: number;
}
/** At most 31. */
export interface Ball {
  position: Triple;
  radius: number;
  velocity?: Triple;
}
/** Its radius, metres, as WebXR gives it. */
export interface Joint {
  position: Triple;
  radius: number;
}
/** A depth image, the upper row first, and its own camera: focal lengths and the middle in its pixels, the middle of the first being
 * 0, and how it looks along -z of the image as stored. `toMetres`: what a number is multiplied by; 1 if not given. 0 is unknown. */
export interface Depth {
  data: Uint16Array | Float32Array;
  width: number;
  height: number;
  toMetres?: number;
  focal: ArrayLike<number>;
  centre: ArrayLike<number>;
  position: Triple;
  orientation: Quadruple;
}
/** RGBA bytes, 4 * width * height of them, the upper row first. */
export interface Image {
  data: Uint8Array | Uint8ClampedArray | number[];
  width: number;
  height: number;
}
/** How a camera sees, by its projection matrix P (column-major). `diagonal`: degrees, 2 atan(hypot(1 / P[0], 1 / P[5])); 75 if
 * not given. `centre`: P[8] and P[9], 0 where its axis meets the middle of the image. */
export interface View {
  orientation?: Quadruple;
  position?: Triple;
  diagonal?: number;
  centre?: ArrayLike<number>;
  exposure?: number;
  ms?: number;
}
/** A plane by its axes, of which y is the normal, and how far it reaches from `at` along x and z. */
export interface Wall {
  x: number[];
  y: number[];
  z: number[];
  at: number[];
  low: number[];
  high: number[];
}

/** The room's light: the direction and irradiance of the main light, the rest as radiance (nine harmonics) and as
 * irradiance over pi (nine terms of a polynomial, see sandglass_filament_light), and the floor's radiance. */
export interface Light {
  toLight: number[];
  facing: number[];
  radiance: number[];
  ambient: number[];
  floor: number[];
}
/** One byte a texel. */
export interface Texture {
  side: number;
  bytes: Uint8Array;
}
/** A chunk of the skin's mesh: vertices as in sandglass_skin_vertex. */
export interface Chunk {
  number: number;
  vertices: Uint8Array;
  indices: Uint16Array;
}
/** What changed of the sand's skin. `loose`: eight numbers a particle (sandglass_skin_loose), in the box from low to high. */
export interface SkinChange {
  chunks: Chunk[];
  flying: number;
  lying: number;
  loose: Float32Array;
  low: number[];
  high: number[];
}
/** Sand that falls from a nozzle: its place and radius; its direction and speed. */
export interface Stream {
  nozzle: number[];
  way: number[];
}
/** What has to be drawn anew. Boxes: x and z of a texture's lower corner, and one over its extent. */
export interface Drawn {
  light: Light;
  /** Those that changed. */
  textures: {
    pile?: Texture;
    onSand?: Texture;
    sky?: Texture;
    skyOnSand?: Texture;
    shadow?: Texture;
    occlusion?: Texture;
    wallShadow?: Texture;
    wallOcclusion?: Texture;
  };
  floor: number;
  pileBox: number[];
  shadowBox: number[];
  occlusionBox: number[];
  /** x and z of the shadow's slide; half a texel, of shadow and occlusion. */
  slide: number[];
  /** How many layers shadow and occlusion have; that less 1, over the height of the highest. */
  layers: number[];
  boxes: { shadow: number[]; occlusion: number[]; wallShadow?: number[]; wallOcclusion?: number[] };
  pileOpacity: number;
  shadowOpacity: number;
  skyKnown: number;
  /** How many textures show what was. */
  behind: number;
  /** Fields of models that are not made yet: nothing is poured before they are. */
  fieldsLeft: number;
  milliseconds: number;
  particles: number;
  /** null: as before. Without sand neither this nor the two below are there. */
  skin?: SkinChange | null;
  streams?: Stream[];
  /** Of a particle. */
  radius?: number;
}

interface Methods {
  createSand(options?: SandOptions): { radius: number };
  /** Gives the number that move() and remove() take. */
  addModel(model: Mesh & Pose, options?: ModelOptions): number;
  /** A mesh of the real place, up to 1,000,000 triangles. One that is closed, its triangles counter-clockwise from outside, is solid, as
   * models are: 32 in all. Of others, up to 256, the highest surface counts, up to 0.5 m above the floor and `half` around the origin.
   * Gives a number as addModel does. Without `height` in the stage's options, receivers then stand as high as places. */
  addPlace(place: Mesh & Pose): number;
  move(model: number, position: Triple, rotation: Quadruple): void;
  remove(model: number): void;
  /** Whether it throws a shadow from now on. */
  setShadow(model: number, shadow: boolean): void;
  pour(...nozzles: Nozzle[]): void;
  push(...balls: Ball[]): void;
  /** At most 2, that push sand from now on: of each the 25 joints of WebXR, in their order; null where it is lost. */
  setHands(...hands: (readonly Joint[] | null)[]): void;
  /** Sand lies on what it shows, within `half` around the origin. One with the numbers of the one before is passed over. */
  seeDepth(depth: Depth): void;
  see(image: Image, view?: View): void;
  frame(seconds: number): Drawn;
}

export interface Stage extends Methods {}
/** Besides: what an app needs that runs the frames of a scene of its own, as the project's page does. */
export declare class Stage {
  static create(options?: StageOptions): Promise<Stage>;
  constructor(sand: Sandglass, options?: Omit<StageOptions, "sand" | "source" | "threads">);
  readonly sand: Sandglass;
  /** Settles when sand lies on all models that it has to. */
  readonly fields: Promise<unknown>;

  /** Draws the sand of another scene, by its skin and the radius of its particles. */
  showSand(skin: Handle<"sandglass_skin">, radius: number): void;
  /** What the frames of that scene take, so that they make this stage's shadows: fields of sandglass_frame_input. */
  readonly frameFields: {
    pile_shadow: Handle<"sandglass_pile_shadow">;
    casts: Pointer;
    cast_count: number;
    skin: Handle<"sandglass_skin">;
  };
  /** What each frame of that scene takes of the real place: fields of sandglass_frame_input, and a collider or none. */
  takePlace(): {
    fields: { relief: Handle<"sandglass_relief">; depth: Pointer };
    bodies: { shape: number; position: number[]; relief: Handle<"sandglass_relief">; id: number }[];
  };
  /** Its sand is other sand at once: nothing of what was drawn is kept. */
  refresh(): void;
  /** What changed since the call before, drawn in this light. Arrays are views of the module's memory, valid until the
   * next call. */
  drawn<Given>(light: Given): Omit<Drawn, "light"> & { light: Given };

  /** Room for the shadows of models of so many triangles, before they come. */
  reserve(triangles: number): void;
  /** These models throw shadows from now on, and no others. */
  castOnly(...models: number[]): void;
  /** Models throw shadows on this plane, too; null: there is none. */
  setWall(wall: Wall | null): void;

  /** Of images that see() was given. */
  readonly images: number;
  readonly room: Handle<"sandglass_room">;
  /** What places and depth images have told, for sandglass_relief_get_heights; 0: there were none. */
  readonly relief: Handle<"sandglass_relief"> | 0;
  /** The light of the place that the room tells now, and the light that fade() has come to. */
  readonly roomLight: sandglass_room_light;
  readonly fadedLight: sandglass_room_light;
  /** Something is placed there: its light does not fade from that of another place. */
  stand(position: Triple): void;
  /** What was seen is of another frame of the world. */
  forget(): void;
  fade(seconds: number): Light;
  /** Ends the threads of a module that create() loaded. No call may follow. */
  end(): void;
  /** Shadows of a light: towards the main one, the cells (sandglass_room_light.ambient_cells) where the rest comes from,
   * and its diameter, radians; 0: not known. */
  shade(toLight: Triple, cells: number[] | Float32Array, diameter?: number): void;
  /** The cells above the wall. */
  shadeWall(cells: number[] | Float32Array): void;
}
/** Where it is made, there have to be workers: not under node, and not in a service worker. A call that is refused rejects. */
export type WorkerStage = {
  [Name in keyof Methods]: (...values: Parameters<Methods[Name]>) => Promise<ReturnType<Methods[Name]>>;
} & {
  readonly fields: Promise<unknown>;
  /** Ends the worker. What is under way, and what is called afterwards, is refused. */
  end(): void;
};
export declare const WorkerStage: { create(options?: StageOptions): Promise<WorkerStage> };
