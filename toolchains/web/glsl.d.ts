import type { Drawn } from "sandglass/stage";
export declare const kit: { readonly [file: string]: string },
  receive: string,
  byDepth: string,
  receivers: readonly ("pile" | "shadow" | "occlusion" | "sky")[];
export declare function receiverValues(drawn: Drawn): { [uniform: string]: number[] };
/** The value of sandglass_depth_numbers, in `byDepth`. */
export declare function depthNumbers(drawn: Drawn): number[];
export declare function kitValues(drawn: Drawn): { [uniform: string]: number | number[] };
