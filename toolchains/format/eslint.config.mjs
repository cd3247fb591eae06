// What JavaScript must not have. The packages lie in build/format.
import { createRequire } from "node:module";

const from = createRequire(new URL("../../build/format/", import.meta.url));
const js = from("@eslint/js");
const globals = from("globals");

const k_lines = { skipBlankLines: false, skipComments: false };
const k_in_page = { ...globals.browser, ...globals.worker, XRWebGLBinding: "readonly", XRWebGLLayer: "readonly" };

export default [
  js.configs.recommended,
  {
    files: ["**/*.mjs", "**/*.mts"],
    languageOptions: { globals: { ...k_in_page, ...globals.node } },
    linterOptions: { reportUnusedDisableDirectives: "error" },
    rules: {
      eqeqeq: "error",
      "no-sequences": ["error", { allowInParentheses: false }],
      "one-var": ["error", { initialized: "never" }],
      "no-unused-vars": ["error", { argsIgnorePattern: "^_", varsIgnorePattern: "^_" }],
      "max-lines": ["error", { max: 600, ...k_lines }],
      "max-lines-per-function": ["error", { max: 80, ...k_lines }],
    },
  },
  { files: ["**/*.mts"], languageOptions: { parser: from("@typescript-eslint/parser") } },
];
