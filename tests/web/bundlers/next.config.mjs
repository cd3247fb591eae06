// three, React and the package are installed in the folder above.
const root = new URL("..", import.meta.url).pathname.slice(0, -1);
export default { output: "export", turbopack: { root }, outputFileTracingRoot: root };
