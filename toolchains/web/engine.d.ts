// The types of sandglass/three and sandglass/babylon; objects are the engine's own.
import type {
  Ball,
  Drawn,
  ModelOptions,
  Nozzle,
  SandOptions,
  Stage,
  StageOptions,
  View,
  WorkerStage,
} from "sandglass/stage";

/** A part of the real place. */
export interface Place {
  /** Takes its mesh as it is now. What was there stays until sand lies on it. */
  update(): Promise<void>;
  /** Withdraws it. The object is shown as before. */
  dispose(): Promise<void>;
}

/** Focal lengths and the middle in pixels of the picture, and where the camera is from the viewer (0), looking along -z. */
export interface Lens {
  focal: ArrayLike<number>;
  centre: ArrayLike<number>;
  position?: ArrayLike<number>;
  orientation?: ArrayLike<number>;
}
/** What a depth texture shows, as receiveByDepth takes it. */
export interface ByDepth {
  /** An image of depth along the camera's axis, the upper row first, 0 where it is not known; Babylon's depth renderer with
   * storeCameraSpaceZ makes one, with `metres` 1. In three.js also a depth texture that a camera has drawn, of a render target, and not
   * logarithmic. */
  depth?: object | null;
  /** Of an image: what its numbers are times to give metres; times depth_scale of sandglass_heights, where there is a relief. */
  metres?: number;
  /** Of an image: normDepthBufferFromNormView of WebXR, from the view to the image (column-major). */
  fromView?: ArrayLike<number>;
  /** The camera of the depth, where it is not the one that draws. */
  camera?: object;
  /** Fields of sandglass_heights (relief.h): where depth is not known. null: there it is the floor. */
  heights?: Heights | null;
}
export interface Heights {
  cells: ArrayLike<number>;
  heights: ArrayLike<number>;
  corner: ArrayLike<number>;
  along: ArrayLike<number>;
  across: ArrayLike<number>;
  up: ArrayLike<number>;
}
export interface DepthReceiver {
  /** A triangle over the whole picture, in the scene. */
  readonly mesh: any;
  /** What is not given stays as it was. */
  set(what: ByDepth): void;
  dispose(): void;
}

/** What is refused changes nothing. After dispose() all but update() and removeModel(), which do nothing then, are refused. */
export interface EngineStage {
  readonly stage: Stage | WorkerStage;
  /** Of the last frame. `fieldsLeft`: how many models sand cannot lie on yet. */
  readonly drawn: Drawn;
  /** Takes what is seen of an object: no hidden children, of a LOD the present level, all instances. The object itself may be
   * hidden, as one that stands for a real thing. In each frame its pose is followed; one that is not finite is left out. Once it
   * was seen, it throws no shadow while it is hidden or out of the scene; sand goes on lying on it. Where its parts move (bones,
   * animation), shadow and sand do not follow: that is said once in the console. An object that is added already is refused. */
  addModel(object: object, options?: ModelOptions): Promise<void>;
  /** Also before addModel has answered, and of places. */
  removeModel(object: object): Promise<void>;
  /** A part of the real place, such as a scanned room, a table or a mesh of WebXR: sand lies on it, shadows fall on it, it hides what
   * is behind it and is not drawn: the object is hidden meanwhile. Taken as by addModel, and its pose is followed. What is closed is
   * solid; of what is open the highest surface counts, up to 0.5 m above the floor. It is seen on the background, and on what is drawn
   * before: three draws it with the renderOrder -1000. */
  addPlace(object: object): Promise<Place>;
  /** By the camera's projection matrix: any camera with perspective, also a tracker's or WebXR's. */
  see(image: object, camera: object, view?: View): Promise<void>;
  /** The same of a camera with a known lens, such as getUserMedia's of a headset; `viewer`: where the headset was when the picture was
   * taken, as an XRRigidTransform. */
  seeThrough(
    image: object,
    viewer: { readonly position: object; readonly orientation: object },
    lens: Lens,
    view?: View,
  ): Promise<void>;
  receive<Material extends object>(material: Material, options?: { shadowOnly?: boolean }): Material;
  stopReceiving(material: object): void;
  /** Shadows fall on what is drawn already, the camera's picture or splats, where its depth says that it stands: they slide over books
   * and slopes. `height` of createStage is as high as those are; what is twice as high, a hand, gets none. The mesh lies behind all
   * that has written depth, so nothing virtual gets any. three.js draws it after scene.background and before what has a
   * renderOrder from 0 on; for splats set its material's `transparent`, and a renderOrder above theirs. With
   * WebGPURenderer a picture behind the canvas needs a clear alpha below 1, and no scene.background. Babylon.js draws it after
   * layers and what is opaque; for splats set an alphaIndex above theirs. Surfaces are taken to face up. */
  receiveByDepth(what?: ByDepth): DepthReceiver;
  createSand(options?: SandOptions): Promise<any>;
  /** There is no sand any more, and nothing pours. */
  removeSand(): Promise<void>;
  pour(...nozzles: Nozzle[]): unknown;
  push(...balls: Ball[]): unknown;
  /** The hands of an XRFrame push sand, in an XRReferenceSpace that is the scene; without a frame there are none. What is lost
   * vanishes, and comes back without a blow. Call it in each frame. */
  seeHands(frame?: object | null, space?: object | null): Promise<void>;
  /** The meshes that an XRFrame tells of (mesh-detection), or else its convex planes (plane-detection), are places, until a call without
   * them. What cannot be one is said in the console. Call it in each frame. */
  seeRoom(frame: object, space: object): Promise<void>;
  /** What XRFrame.getDepthInformation gives of an XRView (usage cpu-optimized; null is left out): sand lies on what it shows. */
  seeDepth(depth: object | null | undefined, view: object): Promise<void>;
  update(seconds?: number): void;
  dispose(): void;
}
/** three.js needs `renderer`: a WebGLRenderer of r160 or newer, or a WebGPURenderer of r184 or newer. With `worker`, the stage runs in a Worker. WebXR by WebGPU, and multiview, are untried. */
export declare function createStage(
  engine: object,
  options: StageOptions & { scene: object; renderer?: object; worker?: boolean },
): Promise<EngineStage>;
