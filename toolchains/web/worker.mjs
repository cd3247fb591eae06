// sandglass/worker: a stage in a Worker. Its methods are those of sandglass/stage and give promises; what is drawn arrives
// as transferred arrays. Fields of models are made in a worker, too. Workers are made of text, so no bundler has to find a
// file; a page with a Content-Security-Policy allows worker-src blob:.
import { compile } from "./sandglass.mjs";
import { structs, functions, constants } from "./abi.mjs";
import { text } from "./worker_text.mjs";
import { sandBlock } from "./sand_block.mjs";
import {
  ballsOf,
  checked,
  handsOf,
  k_depth_options,
  k_ended,
  k_options,
  k_view_options,
  nozzlesOf,
  poseOf,
} from "./options.mjs";

const k_own_worker = false; // in that text: true
const k_policy = "Allow worker-src blob: in the page's policy.";
let worker_url, field_worker;

const urlOfText = () =>
  URL.createObjectURL(
    new Blob(
      [
        `const structs = ${JSON.stringify(structs)}, functions = ${JSON.stringify(functions)}, constants = ${JSON.stringify(constants)};\n`,
        text,
      ],
      { type: "text/javascript" },
    ),
  );

// A worker of that text. It opens workers of its own text itself.
function newTextWorker() {
  if (typeof Worker === "undefined")
    throw new Error("sandglass: there are no workers here, as under node. Take Stage of sandglass/stage instead.");
  try {
    worker_url ??= k_own_worker ? location.href : urlOfText();
    return new Worker(worker_url, { type: "module" });
  } catch (cause) {
    throw new Error(`sandglass: a worker does not start: ${cause.message}. ${k_policy}`, { cause });
  }
}

// Gives a function that calls a command of worker_commands.mjs and promises its result, until `end` or a failure of the
// worker itself: then `ended` is the reason, with which all promises are answered.
export function openWorker() {
  const worker = newTextWorker();
  const waiting = new Map();
  let last = 0;
  const call = (command, ...values) =>
    new Promise((done, failed) => {
      if (call.ended) throw call.ended;
      worker.postMessage({ id: ++last, command, values });
      waiting.set(last, { done, failed });
    });
  call.end = (reason) => {
    call.ended ??= new Error(reason);
    worker.terminate();
    for (const { failed } of waiting.values()) failed(call.ended);
    waiting.clear();
  };
  worker.onmessage = ({ data: { id, result, error } }) => {
    const promise = waiting.get(id);
    waiting.delete(id);
    if (error === undefined) promise?.done(result);
    else promise?.failed(new Error(error));
  };
  worker.onerror = ({ message }) =>
    call.end(`sandglass: a worker does not run${message ? `: ${message}` : ""}. ${k_policy}`);
  return call;
}

function fieldWorker() {
  if (!field_worker || field_worker.ended) field_worker = openWorker();
  return field_worker;
}
export async function fieldMade(module, mesh, spacing) {
  return fieldWorker()("field", module, mesh, spacing);
}
export async function blockMade(bytes) {
  return typeof Worker === "undefined" ? sandBlock(bytes) : fieldWorker()("block", bytes);
}

export class WorkerStage {
  // Options as for Stage.create.
  static async create(options = {}) {
    const { sand, source, ...own } = checked("createStage", options, k_options);
    const stage = new WorkerStage();
    const module = sand?.module ?? (await compile(source, own.threads));
    stage.call = openWorker();
    try {
      await stage.call("create", module, own);
    } catch (error) {
      stage.end();
      throw error;
    }
    return stage;
  }
  end() {
    this.call.end(k_ended);
  }
}
// What is sent is checked here, and vectors are made arrays: a copy in the worker is no vector.
const k_sent = {
  pour: (...nozzles) => nozzlesOf(nozzles),
  push: (...balls) => ballsOf(balls),
  setHands: (...hands) => handsOf(hands),
  addPlace: ({ position, rotation, ...mesh }) => [{ ...mesh, ...poseOf("addPlace", position, rotation) }],
  seeDepth: (image) => [checked("seeDepth", image, k_depth_options, { reach: 1e6 })],
  addModel: ({ position, rotation, ...mesh }, options) => [
    { ...mesh, ...poseOf("addModel", position, rotation) },
    options,
  ],
  move: (model, position, rotation) => [model, ...Object.values(poseOf("move", position, rotation))],
  see: (image, view = {}) => [image, checked("see", view, k_view_options)],
};
const k_calls = [
  "createSand",
  "addModel",
  "addPlace",
  "move",
  "remove",
  "setShadow",
  "pour",
  "push",
  "setHands",
  "see",
];
for (const name of [...k_calls, "seeDepth", "frame"])
  WorkerStage.prototype[name] = async function (...values) {
    return this.call("stage", name, k_sent[name]?.(...values) ?? values);
  };
Object.defineProperty(WorkerStage.prototype, "fields", {
  get() {
    return this.call("fields");
  },
});
