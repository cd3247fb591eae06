// A recording as the fragment of a URL, and back. A browser sends no fragment to any server. What a frame has in common
// with the one before is left out, and the rest is compressed (deflate) and written in the letters of base64url.
const k_link = "#r=";
const k_link_at_most = 30000; // characters of the fragment; messengers and browsers cut longer ones
const k_frame_fields = ["emitters", "colliders", "level", "runs", "gravity", "tipped", "added"];

// Numbers that come from 32-bit floats, in as few digits as give them again.
function short(value) {
  if (typeof value !== "number" || Number.isInteger(value)) return value;
  for (let digits = 6; digits < 9; ++digits) {
    const text = Number(value.toPrecision(digits));
    if (Math.fround(text) === Math.fround(value)) return text;
  }
  return Math.fround(value) === value ? Number(value.toPrecision(9)) : value;
}

async function through(stream, bytes) {
  return new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(stream)).arrayBuffer());
}

export async function toLink(recording) {
  let before = [];
  const frames = recording.frames.map((frame) => {
    const now = k_frame_fields.map((name) => JSON.stringify(frame[name], (_, value) => short(value)) ?? "null");
    const said = now.map((text, i) => (text === before[i] ? "0" : `[${text}]`));
    before = now;
    while (said.at(-1) === "0") said.pop();
    return `[${said}]`;
  });
  const { scene, step, hash } = recording;
  const bytes = await through(
    new CompressionStream("deflate-raw"),
    new TextEncoder().encode(JSON.stringify({ scene, step, hash }).slice(0, -1) + `,"frames":[${frames}]}`),
  );
  let text = "";
  for (const byte of bytes) text += String.fromCharCode(byte);
  const link = k_link + btoa(text).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
  if (link.length > k_link_at_most)
    throw new Error(
      `The recording has ${link.length} characters, and a link holds ${k_link_at_most}. Save it as a file, or start again and record less.`,
    );
  return link;
}

// The recording in a fragment, or null if there is none. Throws what a reader can act on.
export async function fromLink(fragment) {
  if (!fragment.startsWith(k_link)) return null;
  try {
    if (fragment.length > k_link_at_most) throw new Error();
    const bytes = Uint8Array.from(atob(fragment.slice(k_link.length).replaceAll("-", "+").replaceAll("_", "/")), (c) =>
      c.charCodeAt(0),
    );
    const { scene, step, hash, frames } = JSON.parse(
      new TextDecoder().decode(await through(new DecompressionStream("deflate-raw"), bytes)),
    );
    let before = [];
    return {
      sandglass: "recording",
      scene,
      step,
      hash,
      frames: frames.map((said) => {
        before = k_frame_fields.map((_, i) => (said[i] === undefined || said[i] === 0 ? before[i] : said[i][0]));
        return Object.fromEntries(k_frame_fields.map((name, i) => [name, before[i] ?? undefined]));
      }),
    };
  } catch {
    throw new Error(
      "The link is cut off or damaged, so its recording cannot be played. Ask for it again, or for the file.",
    );
  }
}
