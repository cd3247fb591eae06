export * from "sandglass";
export declare function wasm(): Uint8Array;
