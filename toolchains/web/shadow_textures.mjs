// The textures of a stage's shadows in an engine. Each is the engine's own, and is kept while its size stays.
const k_unknown = { pile: 0, shadow: 0, occlusion: 255, sky: 255 }; // their one byte where nothing is known yet

export class ShadowTextures {
  // `engine`: make(side, bytes), which may be several squares one above the other, and fill(texture, bytes).
  // `placed(name, texture)` is called with each new one.
  constructor(engine, placed) {
    Object.assign(this, { engine, placed, all: {}, sizes: {} });
    for (const [name, level] of Object.entries(k_unknown)) this.show(name, { side: 1, bytes: Uint8Array.of(level) });
  }
  show(name, { side, bytes }) {
    const { all, sizes, engine } = this;
    const before = all[name];
    if (before && sizes[name] === bytes.length) {
      engine.fill(before, bytes);
      return;
    }
    sizes[name] = bytes.length;
    before?.dispose();
    this.put(name, engine.make(side, bytes));
  }
  put(name, texture) {
    this.all[name] = texture;
    this.placed(name, texture);
  }
  end() {
    for (const texture of Object.values(this.all)) texture.dispose();
  }
}

// Of frame(), what sand shows by which name of the kit.
const k_on_sand = { pile: "onSand", shadow: "shadow", sky: "skyOnSand" };
export function showOnSand(textures, drawn) {
  for (const [name, of] of Object.entries(k_on_sand)) if (drawn.textures[of]) textures.show(name, drawn.textures[of]);
}

// What frame() gives before there is anything to draw.
export const nothingDrawn = {
  light: { toLight: [0, 1, 0], facing: [0, 0, 0], ambient: new Array(27).fill(0), floor: [0, 0, 0] },
  pileBox: [0, 0, 0, 0],
  shadowBox: [0, 0, 0, 0],
  occlusionBox: [2, 2, 0, 0],
  slide: [0, 0, 0, 0],
  layers: [1, 0],
  floor: 0,
  pileOpacity: 0,
  shadowOpacity: 0,
  skyKnown: 0,
  textures: {},
};
