// What the page is made of that takes long: the library, and what a worker makes once a picture is drawn.
import { load } from "./sandglass.mjs";
import { fieldBytes, unpacked } from "./scene.mjs";
import { sandBlock } from "./sand_block.mjs";
import { meshReader } from "./mesh_file.mjs";
import { k_module, k_mesh_module, k_block_module, k_scene } from "./data.mjs";

const k_threads_at_most = 4; // a phone's fast cores

function inflated(text) {
  const packed = new Blob([unpacked(text, Uint8Array)]).stream();
  return new Response(packed.pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
}

// The library, with a pool where browsers let memory be shared, on a page that is cross-origin isolated, and its module lies
// beside the page. No results depend on it. What fails with threads may do without.
export async function loaded() {
  const threads = globalThis.crossOriginIsolated ? Math.min(k_threads_at_most, navigator.hardwareConcurrency) : 1;
  const pooled = threads > 1 ? await load("sandglass-threads.wasm", { threads }).catch(() => null) : null;
  return pooled ?? load(await inflated(k_module));
}

// The reader of mesh files; it is compiled when the first one comes.
export const loadedMeshReader = async () => meshReader(await inflated(k_mesh_module));
const loadedBlock = async () => sandBlock(await inflated(k_block_module));

// What takes seconds, made in a worker of this script once a picture is drawn; where there is none, it is made here.
export function letHelp(page) {
  const script = document.querySelector("script[type=module]").textContent;
  const text = script.replaceAll("import.meta.url", "location.href");
  const url = URL.createObjectURL(new Blob([text], { type: "text/javascript" }));
  const worker = new Worker(url);
  const takeBlock = (block) => {
    page.painter.setBlock(block);
    page.wake();
  };
  worker.onmessage = ({ data: { block, fields } }) => {
    if (block) {
      takeBlock(block);
      return;
    }
    for (const [i, made] of fields.entries()) if (made) k_scene.colliders[i].field.made ??= made;
    worker.terminate();
  };
  worker.onerror = async () => takeBlock(await loadedBlock());
}
export async function help() {
  postMessage({ block: await loadedBlock() });
  const sand = await load(await inflated(k_module));
  postMessage({ fields: k_scene.colliders.map(({ field }) => field && fieldBytes(sand, field)) });
}
