// The example, mounted as React's StrictMode does it, twice on a page; and a scene that is drawn on demand.
import { StrictMode, useState } from "react";
import { Canvas, _roots, advance, useThree } from "@react-three/fiber";
import { createRoot } from "react-dom/client";
import { Hands, Place, Pour, Push, Sand, Sandglass, See, useSandglass } from "sandglass/react";
import type { Camera, Scene, WebGLRenderer } from "three";
import { Example } from "./example.js";
import { photograph, things } from "./things.js";

const found: { [name: string]: { scene: Scene; gl: WebGLRenderer; camera: Camera; stage: object } } = {};
// How many workers run.
let workers = 0;
const Own = globalThis.Worker;
globalThis.Worker = class extends Own {
  constructor(...how: ConstructorParameters<typeof Own>) {
    super(...how);
    ++workers;
  }
  terminate() {
    --workers;
    super.terminate();
  }
};

// A picture stays to be read.
const own = HTMLCanvasElement.prototype.getContext as (kind: string, how?: object) => RenderingContext | null;
HTMLCanvasElement.prototype.getContext = function (this: HTMLCanvasElement, kind: string, how?: object) {
  return own.call(this, kind, { ...how, preserveDrawingBuffer: true });
} as typeof HTMLCanvasElement.prototype.getContext;

let show: (more: { pour?: boolean; shown?: boolean; table?: number }) => void;

function Look({ name }: { name: string }) {
  const { scene, gl, camera } = useThree();
  found[name] = { scene, gl, camera, stage: useSandglass() };
  return null;
}
function OnDemand({ photo }: { photo: ImageBitmap }) {
  const [state, set] = useState({ pour: false, shown: true, table: 0 });
  show = (more) => set((before) => ({ ...before, ...more }));
  return (
    <Canvas frameloop="demand" camera={{ position: [0, 0.5, 1] }}>
      {state.shown && (
        <Sandglass worker={false} budget={50}>
          <See image={photo} />
          <Sand particles={300}>
            {state.pour && <Pour position={[0, 0.3, 0]} />}
            <Push position={[0.3, 0.1, 0]} radius={0.03} />
          </Sand>
          <Hands />
          {state.table > 0 && (
            <Place version={state.table}>
              <mesh>
                <boxGeometry args={[0.4, 0.1 * state.table, 0.4]} />
              </mesh>
            </Place>
          )}
          <Look name="demand" />
        </Sandglass>
      )}
    </Canvas>
  );
}
async function begin() {
  const photo = await photograph();
  const into = (height: number) => createRoot(document.body.appendChild(Object.assign(document.createElement("div"), { style: `height: ${height}px` })));
  const examples = [into(240), into(240)];
  for (const root of examples) {
    root.render(
      <StrictMode>
        <Example photo={photo} {...things()} />
      </StrictMode>,
    );
  }
  into(240).render(
    <StrictMode>
      <OnDemand photo={photo} />
    </StrictMode>,
  );
  const looked = (k: number, look: (canvas: HTMLCanvasElement) => number) => look(document.querySelectorAll("canvas")[k]);
  // A frame of a session, in which a hand is told of. Gives how many of its joints are asked for.
  const hand = () => {
    let asked = 0;
    const joints = new Map(Array.from({ length: 25 }, (_, i) => [i, i]));
    const getJointPose = () => (++asked, { radius: 0.01, transform: { position: { x: 1, y: 1, z: 1 } } });
    const frame = { session: { inputSources: [{ handedness: "left", hand: joints }] }, getJointPose } as unknown as XRFrame;
    advance(performance.now(), true, _roots.get(document.querySelectorAll("canvas")[2])!.store.getState(), frame);
    return asked;
  };
  // What stands in the scene of each canvas.
  const scenes = () => [...document.querySelectorAll("canvas")].map((canvas) => _roots.get(canvas)?.store.getState().scene.children.map((one) => one.name || one.type).sort().join());
  Object.defineProperty(globalThis, "workers", { get: () => workers });
  Object.assign(globalThis, { looked, found, scenes, hand, show: (more: object) => show(more), leave: () => examples.forEach((root) => root.unmount()), ready: "yes" });
}
begin().catch((error) => Object.assign(globalThis, { ready: error.message }));
