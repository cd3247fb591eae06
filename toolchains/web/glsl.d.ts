import type { Drawn } from "sandglass/stage";
export declare const kit: { readonly [file: string]: string },
  receive: string,
  receivers: readonly ("pile" | "shadow" | "occlusion" | "sky")[];
export declare function receiverValues(drawn: Drawn): { [uniform: string]: number[] };
export declare function kitValues(drawn: Drawn): { [uniform: string]: number | number[] };
