// sandglass/react: a stage in a scene of react-three-fiber, as components. React, react-three-fiber and three are the app's own.
import { Suspense, createContext, createElement, use, useContext, useEffect, useRef, useState } from "react";
import { useFrame, useThree } from "@react-three/fiber";
import { createStage } from "./three.mjs";

const k_still_frames = 30; // without a change, after which nothing is drawn on demand

const Here = createContext(null); // of the stage's promise, and what its components share
const h = createElement;

function useHere() {
  const here = useContext(Here);
  if (!here) throw new Error("sandglass: this component needs a stage. Put it into <Sandglass>.");
  return { stage: use(here.stage), here };
}
// The stage. It waits for it, as Suspense has it.
export const useSandglass = () => useHere().stage;

// What fails is thrown where React's error boundaries take it.
function useFailure() {
  const [, set] = useState(null);
  return (error) =>
    set(() => {
      throw error;
    });
}

// A stage, as long as it is mounted. `worker` is true if it is not said; other options are those of createStage.
export function Sandglass({ children, fallback = null, onCreated, worker = true, ...options }) {
  const renderer = useThree((state) => state.gl);
  const scene = useThree((state) => state.scene);
  const invalidate = useThree((state) => state.invalidate);
  const [here, setHere] = useState(null);
  const told = useRef({});
  Object.assign(told.current, { options, onCreated });
  useEffect(() => {
    const stage = made(renderer, scene, { worker, ...told.current.options });
    const shared = { stage, nozzles: new Map(), balls: new Map(), still: 0, wake };
    function wake() {
      shared.still = 0;
      invalidate();
    }
    stage.then(
      (one) => {
        watch(one, shared, invalidate);
        told.current.onCreated?.(one);
      },
      () => {}, // who uses it is told
    );
    setHere(shared);
    wake();
    return () => {
      setHere(null);
      stage.then((one) => one.dispose()).catch(() => {});
    };
  }, [renderer, scene, invalidate, worker]);
  if (!here) return fallback;
  return h(Here.Provider, { value: here }, h(Suspense, { fallback }, h(Frames), children));
}
async function made(renderer, scene, options) {
  const THREE = await (renderer.isWebGPURenderer ? import("three/webgpu") : import("three"));
  return createStage(THREE, { renderer, scene, ...options });
}
// A picture on demand is asked for as long as something changes.
function watch(stage, shared, invalidate) {
  const take = stage.take.bind(stage);
  let light = "";
  stage.take = (drawn) => {
    take(drawn);
    const now = String([...drawn.light.toLight, ...drawn.light.facing, ...drawn.light.ambient]);
    const changed = drawn.skin || Object.keys(drawn.textures).length > 0 || drawn.fieldsLeft > 0 || now !== light;
    light = now;
    shared.still = changed ? 0 : shared.still + 1;
    if (shared.still < k_still_frames || shared.nozzles.size > 0) invalidate();
  };
}
function Frames() {
  const stage = useSandglass();
  useFrame((_, seconds) => stage.update(seconds), -1);
  return null;
}

// An image of the room, and the camera that took it: the scene's, if none is said.
export function See({ image, camera, ...options }) {
  const { stage, here } = useHere();
  const own = useThree((state) => state.camera);
  const fail = useFailure();
  useEffect(() => {
    own.updateMatrixWorld();
    stage.see(image?.isTexture ? image.image : image, camera ?? own, options).then(here.wake, fail);
  }, [stage, image, camera ?? own, JSON.stringify(options)]);
  return null;
}

// What throws a shadow, and what sand lies on: its children.
export function Model({ children, shadow, collide, ...group }) {
  const { stage, here } = useHere();
  const ref = useRef();
  const fail = useFailure();
  useEffect(() => {
    const object = ref.current;
    const options = Object.fromEntries(Object.entries({ shadow, collide }).filter(([, value]) => value !== undefined));
    stage.addModel(object, options).then(here.wake, fail);
    return () => {
      stage.removeModel(object).catch(() => {});
      here.wake();
    };
  }, [stage, shadow, collide]);
  return h("group", { ref, ...group }, children);
}

// A part of the real place: its children, which are not drawn. `version`: another one where their meshes have changed.
export function Place({ children, version, ...group }) {
  const { stage, here } = useHere();
  const ref = useRef();
  const place = useRef();
  const fail = useFailure();
  useEffect(() => {
    const object = ref.current;
    place.current = stage.addPlace(object);
    place.current.then(here.wake, fail);
    return () => {
      stage.removeModel(object).catch(() => {});
      here.wake();
    };
  }, [stage]);
  const told = useRef(version);
  useEffect(() => {
    if (told.current === version) return;
    told.current = version;
    place.current.then((one) => one.update()).then(here.wake, fail);
  }, [version]);
  return h("group", { ref, ...group }, children);
}
// The hands of a WebXR session push sand.
export function Hands() {
  const { stage } = useHere();
  const { xr } = useThree((state) => state.gl);
  const fail = useFailure();
  const seen = useRef(false);
  const see = (frame, failed) => {
    if (!frame && !seen.current) return;
    seen.current = Boolean(frame);
    stage.seeHands(frame, xr.getReferenceSpace()).catch(failed);
  };
  useFrame((_, _seconds, frame) => see(frame, fail), -2);
  useEffect(() => () => see(null, () => {}), [stage]);
  return null;
}

// What shadows fall on: the materials of its children.
export function Receive({ children, shadowOnly = false, ...group }) {
  const { stage, here } = useHere();
  const ref = useRef();
  useEffect(() => {
    const materials = new Set();
    ref.current.traverse(({ material }) => [material ?? []].flat().forEach((one) => materials.add(one)));
    for (const material of materials) stage.receive(material, { shadowOnly });
    here.wake();
    return () => {
      for (const material of materials) stage.stopReceiving(material);
    };
  }, [stage, shadowOnly]);
  return h("group", { ref, ...group }, children);
}

// Sand. Its children, as Pour, are there once it is. Options as for createSand.
export function Sand({ children, ...options }) {
  const { stage, here } = useHere();
  const [ready, setReady] = useState(false);
  const mounted = useRef(false);
  const fail = useFailure();
  const remove = () => stage.removeSand().catch(() => {}); // the stage may end meanwhile
  useEffect(() => {
    mounted.current = true;
    stage.createSand(options).then(
      () => {
        setReady(mounted.current);
        if (!mounted.current) remove();
        here.wake();
      },
      (error) => mounted.current && fail(error),
    );
    return () => {
      mounted.current = false;
      remove();
      here.wake();
    };
  }, [stage, JSON.stringify(options)]);
  return ready ? children : null;
}

// A nozzle. All that are mounted pour.
export function Pour(nozzle) {
  const { stage, here } = useHere();
  useListed(here.nozzles, nozzle, () => stage.pour(...here.nozzles.values()), here);
  return null;
}
// A ball that pushes sand. All that are mounted push.
export function Push(ball) {
  const { stage, here } = useHere();
  useListed(here.balls, ball, () => stage.push(...here.balls.values()), here);
  return null;
}
function useListed(list, value, tell, here) {
  const [key] = useState(() => ({}));
  const fail = useFailure();
  const told = useRef(tell);
  told.current = tell;
  const send = () => {
    Promise.resolve()
      .then(() => told.current())
      .catch(fail);
    here.wake();
  };
  useEffect(() => {
    list.set(key, value);
    send();
  }, [list, JSON.stringify(value, numbers)]);
  useEffect(
    () => () => {
      list.delete(key);
      send();
    },
    [list],
  );
}
// Vectors as what they hold.
const numbers = (_, value) => (typeof value?.toArray === "function" ? value.toArray() : value);
