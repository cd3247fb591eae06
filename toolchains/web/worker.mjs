// sandglass/worker: a stage in a Worker. Its methods are those of sandglass/stage and give promises; what is drawn arrives
// as transferred arrays. Fields of models are made in a worker, too. Workers are made of text, so no bundler has to find a
// file; a page with a Content-Security-Policy allows worker-src blob:.
import { compile } from "./sandglass.mjs";
import { structs, functions, constants } from "./abi.mjs";
import { text } from "./worker_text.mjs";

let worker_url, field_worker;

// Gives a function that calls a command of worker_commands.mjs and promises its result. A worker opens workers of its own text.
export function openWorker() {
  worker_url ??=
    typeof document === "undefined"
      ? location.href
      : URL.createObjectURL(
          new Blob(
            [
              `const structs = ${JSON.stringify(structs)}, functions = ${JSON.stringify(functions)}, constants = ${JSON.stringify(constants)};\n`,
              text,
            ],
            { type: "text/javascript" },
          ),
        );
  const worker = new Worker(worker_url, { type: "module" });
  const waiting = new Map();
  let last = 0;
  worker.onmessage = ({ data: { id, result, error } }) => {
    const { done, failed } = waiting.get(id);
    waiting.delete(id);
    if (error === undefined) done(result);
    else failed(new Error(error));
  };
  worker.onerror = ({ message }) => {
    for (const { failed } of waiting.values())
      failed(new Error(`sandglass: a worker does not start: ${message}. Allow worker-src blob: in the page's policy.`));
  };
  return Object.assign(
    (command, ...values) =>
      new Promise((done, failed) => {
        waiting.set(++last, { done, failed });
        worker.postMessage({ id: last, command, values });
      }),
    { end: () => worker.terminate() },
  );
}

const fieldWorker = () => (field_worker ??= openWorker());
export async function fieldMade(module, mesh, spacing) {
  return fieldWorker()("field", module, mesh, spacing);
}
export async function blockMade(bytes) {
  return fieldWorker()("block", bytes);
}

export class WorkerStage {
  // Options as for Stage.create.
  static async create({ sand, source, ...options } = {}) {
    const stage = new WorkerStage();
    stage.call = openWorker();
    await stage.call("create", sand?.module ?? (await compile(source, options.threads)), options);
    return stage;
  }
}
for (const name of ["createSand", "addModel", "move", "remove", "pour", "push", "see", "frame"])
  WorkerStage.prototype[name] = function (...values) {
    return this.call("stage", name, values);
  };
Object.defineProperty(WorkerStage.prototype, "fields", {
  get() {
    return this.call("fields");
  },
});
