// The types of sandglass/stage and sandglass/worker. Numbers are metres and seconds; rotations are (x, y, z, w).
import type { Sandglass, Values, sandglass_granular_desc } from "sandglass";

type Triple = readonly number[];
export interface StageOptions {
  sand?: Sandglass; source?: URL | string | BufferSource | WebAssembly.Module; threads?: number;
  origin?: Triple; half?: number; budget?: number;
}
export interface SandOptions extends Values<sandglass_granular_desc> { particles?: number; radius?: number; }
export interface ModelOptions { shadow?: boolean; collide?: boolean; }
export interface Nozzle { position: Triple; rotation?: readonly number[]; radius?: number; speed?: number; }
export interface Ball { position: Triple; radius: number; velocity?: Triple; }
export interface View { orientation?: readonly number[]; position?: Triple; diagonal?: number; exposure?: number; ms?: number; }
export interface Texture { side: number; bytes: Uint8Array; }
export interface Drawn {
  light: { toLight: number[]; facing: number[]; radiance: number[]; ambient: number[]; floor: number[] };
  textures: { [Name in "pile" | "onSand" | "sky" | "skyOnSand" | "shadow" | "occlusion"]?: Texture };
  pileBox: number[]; shadowBox: number[]; occlusionBox: number[]; floor: number;
  pileOpacity: number; shadowOpacity: number; skyKnown: number; milliseconds: number; particles: number;
  skin?: { chunks: { number: number; vertices: Uint8Array; indices: Uint16Array }[]; flying: number; lying: number; loose: Float32Array } | null;
}
interface Methods {
  createSand(options?: SandOptions): { radius: number };
  addModel(mesh: { positions: Float32Array; indices: Uint32Array; position: Triple; rotation: readonly number[] }, options?: ModelOptions): number;
  move(model: number, position: Triple, rotation: readonly number[]): void;
  remove(model: number): void;
  pour(...nozzles: Nozzle[]): void;
  push(...balls: Ball[]): void;
  see(image: { data: ArrayLike<number>; width: number; height: number }, view?: View): void;
  frame(seconds: number): Drawn;
}
export interface Stage extends Methods { readonly sand: Sandglass; readonly fields: Promise<unknown>; }
export declare const Stage: { create(options?: StageOptions): Promise<Stage> };
export type WorkerStage = { [Name in keyof Methods]: (...values: Parameters<Methods[Name]>) => Promise<ReturnType<Methods[Name]>> } & { readonly fields: Promise<unknown> };
export declare const WorkerStage: { create(options?: StageOptions): Promise<WorkerStage> };
