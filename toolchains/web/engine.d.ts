// The types of sandglass/three and sandglass/babylon; objects are the engine's own.
import type { Ball, Drawn, ModelOptions, Nozzle, SandOptions, Stage, StageOptions, View, WorkerStage } from "sandglass/stage";

export interface EngineStage {
  readonly stage: Stage | WorkerStage;
  readonly drawn: Drawn;
  addModel(object: object, options?: ModelOptions): Promise<void>;
  removeModel(object: object): Promise<void>;
  see(image: object, camera: object, view?: View): Promise<void>;
  receive<Material extends object>(material: Material, options?: { shadowOnly?: boolean }): Material;
  stopReceiving(material: object): void;
  createSand(options?: SandOptions): Promise<any>;
  pour(...nozzles: Nozzle[]): unknown;
  push(...balls: Ball[]): unknown;
  update(seconds?: number): void;
  dispose(): void;
}
/** three.js needs `renderer`: a WebGLRenderer, or a WebGPURenderer of r184 or newer. With `worker`, the stage runs in a Worker. */
export declare function createStage(engine: object, options: StageOptions & { scene: object; renderer?: object; worker?: boolean }): Promise<EngineStage>;
