// What fingers, keys, buttons and files do.
import { toLink, fromLink } from "./link.mjs";
import { followDevice } from "./tilt.mjs";
import { CameraImages } from "./room_light.mjs";
import { RealTable } from "./real_table.mjs";
import { fixedRun, asText } from "./measure.mjs";
import { addMesh, addObject } from "./objects.mjs";
import { by, say, counted } from "./elements.mjs";
import { k_scene } from "./data.mjs";

const k_move = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const k_tip_step = 2; // degrees a key
const k_tap = 8; // pixels that a finger which taps may move
const k_hints = {
  glass: "Tap to turn it over",
  pour: "Touch the ground to pour sand",
  push: "Drag through the sand",
  turn: "Drag to look around",
};
const k_tip = { j: ["right", -1], l: ["right", 1], i: ["near", -1], k: ["near", 1] };

// Runs what may fail, and says why.
const tried =
  (run) =>
  async (...values) => {
    try {
      await run(...values);
    } catch (error) {
      say(error.message);
    }
  };

function listenToFingers(page, view) {
  const fingers = new Map();
  let apart = 0;
  let still = false;
  const spread = () => {
    const [a, b] = [...fingers.values()];
    return Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
  };
  view.addEventListener("pointerdown", (event) => {
    view.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, event);
    page.wake();
    const hand = page.tool === "pour" || page.tool === "push";
    page.at = fingers.size === 1 && hand && event.button === 0 ? page.place(event) : null;
    still = fingers.size === 1 && event.button === 0;
    by("hint").textContent = "";
    if (fingers.size === 2) apart = spread();
  });
  view.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    if (
      still &&
      Math.hypot(event.clientX - before.clientX, event.clientY - before.clientY) < k_tap &&
      page.tool === "glass"
    )
      return;
    fingers.set(event.pointerId, event);
    still = false;
    page.wake();
    if (fingers.size === 2) {
      page.camera.zoom(apart / spread());
      apart = spread();
    }
    if (fingers.size === 2 || page.tool === "turn" || page.tool === "glass" || event.buttons === 2)
      page.camera.turn(
        (event.clientX - before.clientX) / 200 / fingers.size,
        (event.clientY - before.clientY) / 200 / fingers.size,
      );
    else page.at = page.place(event);
  });
  for (const kind of ["pointerup", "pointercancel"])
    view.addEventListener(kind, (event) => {
      if (kind === "pointerup" && still && page.tool === "glass") page.turnOver();
      fingers.delete(event.pointerId);
      page.at = null;
      still = false;
    });
  view.addEventListener("contextmenu", (event) => event.preventDefault());
  view.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      page.camera.zoom(Math.exp(event.deltaY / 800));
      page.wake();
    },
    { passive: false },
  );
}

function tipBySliders(page) {
  page.wake();
  const [right, near] = ["right", "near"].map((id) => Number(by(id).value));
  page.tipByAngles(right, near);
  say(right === 0 && near === 0 ? "The table is level." : `The right side is ${right}° lower, the near side ${near}°.`);
}

// The tool of a finger. The hourglass is one, and stands in place of the table.
function choose(page, tool) {
  page.tool = tool;
  document.querySelector(`[name=tool][value=${tool}]`).checked = true;
  if (tool !== "turn") page.show(tool === "glass" ? "glass" : "table");
  by("hint").textContent = k_hints[tool];
}

function listenToKeys(page, view) {
  view.addEventListener("keydown", (event) => {
    const step = k_move[event.key];
    const tip = k_tip[event.key];
    page.wake();
    if (event.key === " " && page.tool === "glass") {
      event.preventDefault();
      return page.turnOver();
    }
    if (step) {
      page.mark = [page.mark[0] + 0.02 * step[0], 0, page.mark[2] + 0.02 * step[1]];
      say(
        `The mark is ${Math.round(100 * page.mark[0])} cm right and ${Math.round(100 * page.mark[2])} cm in front of the middle.`,
      );
    }
    if (event.key === " " || event.key === "p") choose(page, event.key === " " ? "pour" : "push");
    if (event.key === " " || event.key === "p" || (step && page.at)) page.at = page.mark;
    if (event.key === "a" || event.key === "d") page.camera.turn(event.key === "a" ? 0.1 : -0.1, 0);
    if (event.key === "+" || event.key === "-") page.camera.zoom(event.key === "+" ? 0.9 : 1.1);
    if (tip) {
      by(tip[0]).value = Number(by(tip[0]).value) + tip[1] * k_tip_step;
      tipBySliders(page);
    }
    if (event.key === "r") page.again();
    if (step || event.key === " ") event.preventDefault();
  });
  view.addEventListener("keyup", (event) => {
    if (event.key === " " || event.key === "p") page.at = null;
  });
}

const pressed = (id, on) => by(id).setAttribute("aria-pressed", on);

// The device's orientation, which gravity and the camera's pose may both follow.
async function follow(page) {
  page.following ??= await followDevice((event) => page.hold(event));
}

async function switchTilt(page) {
  if (!page.tipping) await follow(page);
  page.tipping = !page.tipping;
  page.level = undefined;
  pressed("tilt", page.tipping);
  if (!page.tipping) tipBySliders(page);
  else say("Tip the phone: the table is level as you hold it now.");
}

async function switchCamera(page) {
  if (page.watching) {
    page.watching.stop();
    page.watching = null;
    page.setLight();
  } else {
    page.watching = await CameraImages.open();
    await follow(page).catch(() => {}); // without it the camera looks where the picture does
    say("Turn the camera around the room: the light becomes that of what it sees. Nothing leaves this page.");
  }
  pressed("camera", page.watching !== null);
}

// Plays a recording, to the bit, and goes on from its end.
export async function play(page, told) {
  if (page.tool === "glass") choose(page, "pour");
  page.measuring = true;
  try {
    const hash = await page.play(told, (share) => say(`Playing: ${Math.round(100 * share)} %`));
    say(`The recording ends here as it did where it was made, to the bit: ${hash}.`);
  } finally {
    page.measuring = false;
  }
}

async function take(page, file) {
  if (/\.json$/i.test(file.name))
    return play(
      page,
      await file
        .text()
        .then(JSON.parse)
        .catch(() => null),
    );
  if (page.tool === "glass") choose(page, "pour");
  const mesh = (await page.readMesh())(new Uint8Array(await file.arrayBuffer()), file.name);
  const becomes = document.querySelector("[name=dropped]:checked").value;
  const note = mesh.remarks && ` Note: ${mesh.remarks}.`;
  say(
    becomes === "sand"
      ? `${counted(addMesh(page, mesh))} particles of "${file.name}".${note}`
      : `"${file.name}" stands at the mark: ${counted(addObject(page, mesh, becomes === "metal"))} triangles.${note}`,
  );
}

async function share(page) {
  const url = location.href.replace(/#.*/, "") + (await toLink(page.recording()));
  history.replaceState(null, "", url);
  await navigator.clipboard.writeText(url).then(
    () => say(`The link to these ${page.recorded.length} frames is copied.`),
    () => say(`The link to these ${page.recorded.length} frames is in the address bar. Copy it there.`),
  );
}

function save(page) {
  const link = document.createElement("a");
  const url = URL.createObjectURL(new Blob([JSON.stringify(page.recording())], { type: "application/json" }));
  Object.assign(link, { href: url, download: "sandglass_recording.json" }).click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
  say(`Saved ${page.recorded.length} frames. Drop the file on this page, on any device, to play it.`);
}

async function measure(page) {
  if (page.measuring) return;
  page.measuring = true;
  try {
    by("text").textContent = asText(
      await fixedRun(page.sand, k_scene.frames, (done) => say(`Measuring: ${Math.round(100 * done)} %`)),
    );
    by("result").showModal();
    say("");
  } finally {
    page.measuring = false;
  }
}

export function listen(page) {
  const view = by("view");
  const click = (id, run) => by(id).addEventListener("click", tried(run));
  listenToFingers(page, view);
  listenToKeys(page, view);
  for (const input of document.querySelectorAll("[name=tool]"))
    input.addEventListener("change", () => choose(page, input.value));
  by("hint").textContent = k_hints.glass;
  click("open", () => {
    const open = !by("more").open;
    open ? by("more").show() : by("more").close();
  });
  by("more").addEventListener("close", () => by("open").setAttribute("aria-expanded", false));
  by("more").addEventListener("toggle", () => by("open").setAttribute("aria-expanded", by("more").open));
  addEventListener("keydown", (event) => {
    if (event.key === "Escape" && by("more").open) {
      by("more").close();
      by("open").focus();
    }
  });
  by("wet").addEventListener("input", () => {
    page.painter.sand.wet = Number(by("wet").value);
    page.wake();
  });
  for (const id of ["azimuth", "polar"]) by(id).addEventListener("input", () => page.setLight());
  for (const id of ["right", "near"]) by(id).addEventListener("input", () => tipBySliders(page));
  by("budget").addEventListener("input", () => {
    by("budget_label").textContent = `Budget ${by("budget").value} ms`;
  });
  addEventListener("resize", () => page.wake());
  click("again", () => page.again());
  click("tilt", () => switchTilt(page));
  click("camera", () => switchCamera(page));
  click("real", () => {
    choose(page, page.tool === "glass" ? "pour" : page.tool);
    return RealTable.start(page);
  });
  click("measure", () => measure(page));
  click("save", () => save(page));
  click("share", () => share(page));
  click("close", () => by("result").close());
  click("copy", () =>
    navigator.clipboard.writeText(by("text").textContent).then(
      () => say("Copied."),
      () => say("This browser does not copy. Select the text and copy it."),
    ),
  );
  by("file").addEventListener("change", () => {
    if (by("file").files[0]) tried(take)(page, by("file").files[0]);
  });
  addEventListener("dragover", (event) => event.preventDefault());
  addEventListener("drop", (event) => {
    event.preventDefault();
    if (event.dataTransfer.files[0]) tried(take)(page, event.dataTransfer.files[0]);
  });
  addEventListener(
    "hashchange",
    tried(async () => {
      const told = await fromLink(location.hash);
      if (told) await play(page, told);
    }),
  );
}
