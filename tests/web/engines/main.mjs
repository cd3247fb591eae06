// Opens the app that the address names, and says when it runs.
const apps = { light: () => import("./light.mjs"), sand: () => import("./sand.mjs") };
apps[new URLSearchParams(location.search).get("app")]().then(
  () => {
    globalThis.ready = "yes";
  },
  (error) => {
    globalThis.ready = error.message;
  },
);
