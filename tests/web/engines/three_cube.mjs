// The light cube of three.js, behind the README's example.
import { worst } from "./cube.mjs";

globalThis.cube = (fault) => {
  const { THREE, stage, renderer } = globalThis;
  const small = new THREE.Scene();
  const target = new THREE.WebGLRenderTarget(8, 8, { type: THREE.FloatType });
  const pixels = new Float32Array(256);
  const camera = new THREE.OrthographicCamera(-0.4, 0.4, 0.4, -0.4, 0.1, 10);
  renderer.setAnimationLoop(null);
  small.add(
    new THREE.Mesh(new THREE.BoxGeometry(1, 1, 1), new THREE.MeshLambertMaterial({ color: 0xffffff })),
    stage.probe,
    stage.sun,
    stage.sun.target,
  );
  return worst(stage, (n) => {
    if (fault === "signs") for (const k of [1, 3, 5, 7]) stage.probe.sh.coefficients[k].negate();
    if (fault === "pi") stage.sun.color.multiplyScalar(1 / Math.PI);
    camera.up.set(n[1] ? 1 : 0, n[1] ? 0 : 1, 0);
    camera.position.set(...n).multiplyScalar(2);
    camera.lookAt(0, 0, 0);
    renderer.setRenderTarget(target);
    renderer.render(small, camera);
    renderer.readRenderTargetPixels(target, 0, 0, 8, 8, pixels);
    renderer.setRenderTarget(null);
    return pixels[0];
  });
};
