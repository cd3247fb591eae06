// The types of sandglass/react.
import type { ReactNode } from "react";
import type { ThreeElements } from "@react-three/fiber";
import type { EngineStage } from "sandglass/three";
import type { Ball, ModelOptions, Nozzle, SandOptions, StageOptions, View } from "sandglass/stage";

type Group = ThreeElements["group"];

/** A stage in the scene, as long as it is mounted, in a worker if `worker` is not false. Its children may wait for it, as Suspense
 * has it; `fallback` is shown meanwhile. Options are read when it is mounted. */
export declare function Sandglass(
  props: StageOptions & {
    worker?: boolean;
    fallback?: ReactNode;
    onCreated?: (stage: EngineStage) => void;
    children?: ReactNode;
  },
): ReactNode;
/** The stage around. */
export declare function useSandglass(): EngineStage;
/** An image of the room (an element, a bitmap or a texture), and the camera that took it: the scene's, if none is said. */
export declare function See(props: View & { image: object; camera?: object }): ReactNode;
/** Its children throw a shadow, and sand lies on them. */
export declare function Model(props: Group & ModelOptions): ReactNode;
/** A part of the real place, such as a scanned room: sand lies on its children, shadows fall on them, they hide what is behind them and
 * are not drawn. `version`: another one where their meshes have changed. */
export declare function Place(props: Group & { version?: unknown }): ReactNode;
/** The hands of a WebXR session push sand. */
export declare function Hands(): ReactNode;
/** Shadows fall on the materials of its children. */
export declare function Receive(props: Group & { shadowOnly?: boolean }): ReactNode;
/** Sand; its children are there once it is. */
export declare function Sand(props: SandOptions & { children?: ReactNode }): ReactNode;
/** A nozzle, in Sand. */
export declare function Pour(props: Nozzle): ReactNode;
/** A ball that pushes sand, in Sand. */
export declare function Push(props: Ball): ReactNode;
