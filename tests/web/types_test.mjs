// The types of sandglass/stage are what a stage has and gives, and the page keeps to them.
// node types_test.mjs TYPESCRIPT PAGE_FOLDER    in a project that has the package. PAGE_FOLDER: the page's modules with the
// package's beside them, and .d.ts as .d.mts
import assert from "node:assert/strict";
import { readdirSync, readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";
import { Stage } from "sandglass/stage";

const ts = createRequire(import.meta.url)(process.argv[2]);
const page = process.argv[3];
const k_options = {
  strict: true,
  noEmit: true,
  target: ts.ScriptTarget.ES2022,
  module: ts.ModuleKind.Node16,
  moduleResolution: ts.ModuleResolutionKind.Node16,
  lib: ["lib.es2022.d.ts", "lib.dom.d.ts"],
};
const k_numbers = [Float32Array, Uint8Array, Uint16Array, Uint32Array];

writeFileSync("declared.mts", 'export type { Drawn, Stage } from "sandglass/stage";\n');
const program = ts.createProgram(["declared.mts"], k_options);
const checker = program.getTypeChecker();
const exported = checker.getExportsOfModule(checker.getSymbolAtLocation(program.getSourceFile("declared.mts")));
const typeOf = (name) =>
  checker.getDeclaredTypeOfSymbol(checker.getAliasedSymbol(exported.find((symbol) => symbol.name === name)));

const isOptional = (property) => (property.flags & ts.SymbolFlags.Optional) !== 0;
const ofProperty = (property) => checker.getTypeOfSymbolAtLocation(property, property.valueDeclaration);

// Where a value is not what its type says. `seen`: gets the path of each property that the type has and the value, too.
function differences(value, whole, path, seen) {
  const type = checker.getNonNullableType(whole);
  if (value === null) return checker.typeToString(whole).includes("null") ? [] : [`${path} is null`];
  const name = checker.typeToString(type);
  if (typeof value !== "object") return typeof value === name ? [] : [`${path} is a ${typeof value}, not ${name}`];
  const numbers = k_numbers.find((kind) => value instanceof kind);
  if (numbers) return numbers.name === name ? [] : [`${path} is a ${numbers.name}, not ${name}`];
  if (Array.isArray(value)) {
    const item = checker.getIndexTypeOfType(type, ts.IndexKind.Number);
    if (!item) return [`${path} is an array, not ${name}`];
    return value.flatMap((one) => differences(one, item, `${path}[]`, seen));
  }
  const properties = new Map(type.getProperties().map((property) => [property.name, property]));
  const missing = [...properties.values()].filter((property) => !isOptional(property) && !(property.name in value));
  return [
    ...missing.map((property) => `${path} has no ${property.name}`),
    ...Object.entries(value).flatMap(([key, one]) => {
      const property = properties.get(key);
      if (!property) return [`${path}.${key} is in no type`];
      seen.add(`${path}.${key}`);
      return differences(one, ofProperty(property), `${path}.${key}`, seen);
    }),
  ];
}

// The paths of all properties of a type.
function paths(whole, path) {
  const type = checker.getNonNullableType(whole);
  const item = checker.isArrayType(type) && checker.getTypeArguments(type)[0];
  if (item) return paths(item, `${path}[]`);
  if (type.flags & ts.TypeFlags.NumberLike || /Array$/.test(checker.typeToString(type))) return [];
  return type.getProperties().flatMap((property) => {
    const inner = `${path}.${property.name}`;
    return [inner, ...paths(ofProperty(property), inner)];
  });
}

function stageWithAll(sand) {
  const side = 0.1;
  const positions = Float32Array.from({ length: 24 }, (_, i) => (((i / 3) >> (i % 3)) & 1) * side);
  const corners = "013032467475045051237276026064157173";
  const indices = Uint32Array.from(corners, Number);
  const stage = new Stage(sand, { half: 0.3 });
  stage.createSand({ particles: 200 });
  stage.addModel({ positions, indices, position: [0.1, 0.05, 0], rotation: [0, 0, 0, 1] });
  stage.setWall({ x: [1, 0, 0], y: [0, 0, 1], z: [0, -1, 0], at: [0, 0, -0.2], low: [-1, -1], high: [1, 0] });
  stage.pour({ position: [0, 0.3, 0] });
  return stage;
}

// Frames until all that can be drawn was.
async function checkDrawn() {
  const { sand } = await Stage.create({});
  const stage = stageWithAll(sand);
  const type = typeOf("Drawn");
  const all = paths(type, "drawn");
  const seen = new Set();
  let last;
  await stage.fields;
  for (let i = 0; i < 400 && seen.size < all.length; ++i) {
    last = stage.frame(1 / 60);
    assert.deepEqual(differences(last, type, "drawn", seen), []);
  }
  assert.deepEqual(
    all.filter((path) => !seen.has(path)),
    [],
    "a type has what nobody sees",
  );
  // The controls: a field more, a field less, a field of another kind.
  assert.deepEqual(differences({ ...last, more: 1 }, type, "drawn", seen), ["drawn.more is in no type"]);
  assert.deepEqual(differences({ ...last, floor: "0" }, type, "drawn", seen), ["drawn.floor is a string, not number"]);
  const { boxes, ...less } = last;
  assert.deepEqual(differences(less, type, "drawn", seen), ["drawn has no boxes"]);
  assert.equal(boxes.wallShadow.length, 4);
  return stage;
}

function checkStage(stage) {
  const own = Object.getOwnPropertyNames(Stage.prototype).filter((name) => name !== "constructor");
  const typed = typeOf("Stage").getProperties();
  assert.deepEqual([...own, ...Object.keys(stage)].sort(), typed.map(({ name }) => name).sort());
}

const k_no_member = [2339, 2341, 2551];

// What a module does with a stage that its types do not say: members, arguments, and a stage of which no type is known.
function breaches(files) {
  const pages = ts.createProgram(files, { ...k_options, strict: false, allowJs: true, checkJs: true });
  const types = pages.getTypeChecker();
  const found = [];
  const isOfStage = (node) => {
    for (let call = node; call; call = call.parent) {
      if (!ts.isCallExpression(call) && !ts.isNewExpression(call)) continue;
      const made = types.getResolvedSignature(call)?.declaration;
      return made?.getSourceFile().fileName.endsWith("stage.d.mts");
    }
    return false;
  };
  for (const file of files) {
    const source = pages.getSourceFile(file);
    const said = (node, sentence) => {
      const { line } = source.getLineAndCharacterOfPosition(node.getStart());
      found.push(`${file}:${line + 1}: ${sentence}`);
    };
    for (const { code, start, messageText } of pages.getSemanticDiagnostics(source)) {
      const sentence = ts.flattenDiagnosticMessageText(messageText, " ");
      const node = ts.getTokenAtPosition?.(source, start) ?? source;
      const member = k_no_member.includes(code) && /on type '(Stage|Drawn|Omit<Drawn)/.test(sentence);
      if (member || (!k_no_member.includes(code) && isOfStage(node))) said(node, sentence);
    }
    const visit = (node) => {
      const of = ts.isPropertyAccessExpression(node) && node.expression;
      const name = of && (ts.isPropertyAccessExpression(of) ? of.name : of).getText();
      if (name === "stage" && types.getTypeAtLocation(of).flags & ts.TypeFlags.Any)
        said(node, `${node.getText()}: the type of the stage is not known`);
      ts.forEachChild(node, visit);
    };
    visit(source);
  }
  return found;
}

function checkPage() {
  const own = readFileSync(join(page, "own.txt"), "utf8").trim().split("\n");
  const files = own.map((name) => join(page, name));
  assert.ok(own.includes("page.mjs") && readdirSync(page).includes("stage.d.mts"));
  assert.deepEqual(breaches(files), []);
  // The control.
  const wrong = join(page, "wrong.mjs");
  writeFileSync(
    wrong,
    `import { Stage } from "./stage.mjs";
const stage = new Stage(null, { halv: 1 });
stage.castList = 1;
stage.castOnly("all");
stage.drawn({}).pileOpacty *= 0.9;
export const f = (page) => page.stage.models;
`,
  );
  const lines = breaches([wrong]).map((fault) => fault.split(":")[1]);
  assert.deepEqual(lines.sort(), ["2", "3", "4", "5", "6"]);
}

checkStage(await checkDrawn());
checkPage();
console.log("the types of a stage are what it has");
