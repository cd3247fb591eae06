// What the page is made of that takes long: the library, and what a worker makes once a picture is drawn.
import { load } from "./sandglass.mjs";
import { fieldBytes, unpacked } from "./scene.mjs";
import { sandBlock } from "./sand_block.mjs";
import { meshReader } from "./mesh_file.mjs";
import { by } from "./elements.mjs";
import { k_scene } from "./data.mjs";

const k_threads_at_most = 4; // a phone's fast cores

// Of an element of the page that assemble.py made.
export function inflated(name) {
  const packed = new Blob([unpacked(by(name).textContent, Uint8Array)]).stream();
  return new Response(packed.pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
}
const urlOfScript = (...parts) => URL.createObjectURL(new Blob(parts, { type: "text/javascript" }));

// The library, with a pool where browsers let memory be shared, on a page that is cross-origin isolated, and its module lies
// beside the page. No results depend on it. What fails with threads may do without.
export async function loaded() {
  const threads = globalThis.crossOriginIsolated ? Math.min(k_threads_at_most, navigator.hardwareConcurrency) : 1;
  const pooled = threads > 1 ? await load("sandglass-threads.wasm", { threads }).catch(() => null) : null;
  return pooled ?? load(await inflated("sandglass"));
}

// The reader of mesh files; it is compiled when the first one comes.
export async function loadedMeshReader() {
  const [module, script] = await Promise.all(["mesh_reader", "meshopt_decoder"].map(inflated));
  const { MeshoptDecoder } = await import(urlOfScript(script));
  return meshReader(module, MeshoptDecoder);
}

// What takes seconds, made in a worker of this script once a picture is drawn; where there is none, it is made here.
export async function letHelp(page) {
  const script = document.querySelector("script[type=module]").textContent;
  const block_module = await inflated("sand_block");
  const worker = new Worker(urlOfScript(script.replaceAll("import.meta.url", "location.href")));
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
  worker.onerror = async () => takeBlock(await sandBlock(block_module));
  worker.postMessage({ block_module, library: page.sand.module });
}
export function help() {
  onmessage = async ({ data: { block_module, library } }) => {
    postMessage({ block: await sandBlock(block_module) });
    const sand = await load(library);
    postMessage({ fields: k_scene.colliders.map(({ field }) => field && fieldBytes(sand, field)) });
  };
}
