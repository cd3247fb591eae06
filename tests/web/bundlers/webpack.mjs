// Bundles what esbuild has made JavaScript of, and fails where webpack warns.
import { fileURLToPath } from "node:url";
import webpack from "webpack";

const path = (name) => fileURLToPath(new URL(name, import.meta.url));
const output = { path: path("webpack"), filename: "react_main.js", clean: true };
webpack(
  { mode: "production", entry: path("js/react_main.js"), output, performance: { hints: false } },
  (error, stats) => {
    if (error) throw error;
    if (stats.hasErrors() || stats.hasWarnings())
      throw new Error(stats.toString({ all: false, errors: true, warnings: true }));
  },
);
