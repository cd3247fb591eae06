// What runs in a worker that openWorker (worker.mjs) makes: this file behind those that it imports, as one text.
import { load } from "./sandglass.mjs";
import { Stage } from "./stage.mjs";
import { fieldOf } from "./mesh_field.mjs";
import { sandBlock } from "./sand_block.mjs";

let stage, own;
const commands = {
  async field(module, mesh, spacing) {
    return fieldOf((own ??= await load(module)), mesh, spacing);
  },
  block: (bytes) => sandBlock(bytes),
  async create(module, options) {
    stage = await Stage.create({ ...options, sand: await load(module, options) });
  },
  stage: (name, values) => stage[name](...values),
  async fields() {
    await stage.fields;
  },
};
// Arrays as copies that leave for good.
function leaving(value, buffers) {
  if (ArrayBuffer.isView(value)) {
    const copy = value.slice();
    buffers.push(copy.buffer);
    return copy;
  }
  if (Array.isArray(value)) return value.map((item) => leaving(item, buffers));
  return value && typeof value === "object"
    ? Object.fromEntries(Object.entries(value).map(([key, item]) => [key, leaving(item, buffers)]))
    : value;
}
onmessage = async ({ data: { id, command, values } }) => {
  try {
    const buffers = [];
    const result = leaving(await commands[command](...values), buffers);
    postMessage({ id, result }, buffers);
  } catch (error) {
    postMessage({ id, error: error.message });
  }
};
