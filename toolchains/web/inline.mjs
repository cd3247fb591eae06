// sandglass/inline: as sandglass, with the module in this file, for bundlers that leave other files alone. `wasm`, its
// bytes, is a `source` for a stage.
import { load as loadFrom } from "./sandglass.mjs";
import { k_inlined } from "./inlined.mjs";

export { constants } from "./sandglass.mjs";
export const wasm = () => Uint8Array.from(atob(k_inlined), (letter) => letter.charCodeAt(0));
export const load = (source, options) => loadFrom(source ?? wasm(), options);
