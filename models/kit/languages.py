#!/usr/bin/env python3
"""The kit's GLSL in the other languages of the web: python3 languages.py KIT_FOLDER OUT_FOLDER

kit_wgsl.mjs   the functions of the kit as WGSL, by what they are needed for
kit_nodes.mjs  the same as nodes of three.js' shading language

It reads what the kit is written in: functions and constants of numbers, vectors and matrices; `if`, loops of known length, `? :`,
`inout` numbers. A function returns at its end, and only there. What it cannot read is an error with its line.

WGSL: uniforms are `uniforms.NAME`, a texture NAME has the sampler NAMESampler, and global variables are private: the camera and the
room's table, too, which an app sets before it calls. Textures of one level are read at it, so that any control flow may.
Nodes: kitNodes(T, given) has uniforms and textures as given.NAME, arrays with element(), and gives the functions; global variables
lie in `globals`."""

import json
import pathlib
import re
import sys

SURFACE = ("uniforms.glsl", "light.glsl", "sand.glsl", "packed.glsl", "surface.glsl")
LOOSE = ("uniforms.glsl", "light.glsl", "sand.glsl", "loose.glsl")
CAMERA = {"view": "mat4", "projection": "mat4", "eye": "vec3", "table_of_room": "mat3"}
PARTS = {"surface": SURFACE, "loose": LOOSE, "receive": ("receive.glsl",), "depth": ("receive.glsl", "depth.glsl")}

WGSL_TYPES = {"float": "f32", "int": "i32", "uint": "u32", "bool": "bool", "vec2": "vec2f", "vec3": "vec3f", "vec4": "vec4f"}
WGSL_TYPES |= {"mat3": "mat3x3f", "mat4": "mat4x4f", "sampler2D": "texture_2d<f32>", "sampler3D": "texture_3d<f32>"}
TYPES = set(WGSL_TYPES) | {"void"}
TOKEN = re.compile(
    r"\s*(?:(\d+\.\d+|\d+u?|0x[0-9a-f]+u)(?![\w.])|([A-Za-z_]\w*)|(<<|>>|<=|>=|==|!=|&&|\|\||\+\+|--|[-+*/^&|]=|[-+*/%^&|<>=!?:;,.(){}\[\]]))"
)
LEVELS = [["||"], ["&&"], ["|"], ["^"], ["&"], ["==", "!="], ["<", ">", "<=", ">="], ["<<", ">>"], ["+", "-"], ["*", "/", "%"]]
NODE_OPERATORS = {"||": "or", "&&": "and", "^": "bitXor", "&": "bitAnd", "|": "bitOr", ">>": "shiftRight", "<<": "shiftLeft"}
NODE_OPERATORS |= {"<": "lessThan", ">": "greaterThan", "<=": "lessThanEqual", ">=": "greaterThanEqual", "==": "equal"}
NODE_OPERATORS |= {"+": "add", "-": "sub", "*": "mul", "/": "div"}
NODE_ASSIGNS = {"=": "assign", "+=": "addAssign", "-=": "subAssign", "*=": "mulAssign", "/=": "divAssign"}
WGSL_NAMES = {"dFdx": "dpdx", "dFdy": "dpdy", "inversesqrt": "inverseSqrt"}
NODE_NAMES = {"inversesqrt": "inverseSqrt"}
ALIKE = ("max", "min", "clamp", "step", "pow")  # WGSL wants arguments of one type
SCALAR = ("dot", "length")
COMPARED = {"greaterThan": ">", "lessThan": "<"}


class Reader:
    """A text of GLSL as functions and declarations, each a tuple that begins with its kind."""

    def __init__(self, text, name):
        text = re.sub(r"//[^\n]*", "", text)
        text = re.sub(r"#ifndef \w+ *\n(.*?)#endif\n", r"\1", text, flags=re.DOTALL)
        self.name, self.text, self.at, self.tokens = name, text, 0, []
        place = 0
        while text[place:].strip():
            found = TOKEN.match(text, place)
            if not found:
                self.refuse(f"{text[place:].split()[0]} is not read here", place)
            self.tokens.append((found[found.lastindex], ("number", "name", "sign")[found.lastindex - 1], found.start(found.lastindex)))
            place = found.end()
        self.tokens.append(("", "end", place))

    def refuse(self, sentence, place):
        sys.exit(f"languages.py: {self.name}, line {self.text.count(chr(10), 0, place) + 1} without directives: {sentence}.")

    def peek(self, ahead=0):
        return self.tokens[min(self.at + ahead, len(self.tokens) - 1)][0]

    def take(self, *wanted):
        token, kind, place = self.tokens[self.at]
        if wanted and token not in wanted:
            self.refuse(f"{token or 'the end'} stands where {' or '.join(wanted)} has to", place)
        self.at += 1
        return token

    def taken(self, token):
        if self.peek() != token:
            return False
        self.at += 1
        return True

    def file(self):
        found = []
        while self.peek():
            storage = self.take() if self.peek() in ("uniform", "const") else "private"
            kind, name = self.take(*TYPES), self.take()
            if self.taken("("):
                found.append(("function", kind, name, self.parameters(), self.block()))
            else:
                found += [(storage, *one) for one in self.declared(kind, name)]
        return found

    def parameters(self):
        found = []
        while not self.taken(")"):
            shared = self.taken("inout")
            found.append((self.take(*TYPES), self.take(), shared))
            self.taken(",")
        return found

    def declared(self, kind, name):
        """Each: type, name, length of an array or None, value or None."""
        found = []
        while True:
            length = None
            if self.taken("["):
                length = int(self.take())
                self.take("]")
            found.append((kind, name, length, self.expression() if self.taken("=") else None))
            if self.take(",", ";") == ";":
                return found
            name = self.take()

    def block(self):
        if not self.taken("{"):
            return self.statement()
        found = []
        while not self.taken("}"):
            found += self.statement()
        return found

    def statement(self):
        if self.taken("if"):
            self.take("(")
            condition = self.expression()
            self.take(")")
            return [("if", condition, self.block(), self.block() if self.taken("else") else [])]
        if self.taken("for"):
            return [self.loop()]
        if self.taken("return"):
            value = self.expression()
            self.take(";")
            return [("return", value)]
        if self.taken("discard"):
            self.take(";")
            return [("discard",)]
        self.taken("const")
        if self.peek() in TYPES and self.peek(1) != "(":
            return [("declare", *one) for one in self.declared(self.take(), self.take())]
        found = []
        while True:
            found += self.assignment()
            if self.take(",", ";") == ";":
                return found

    def assignment(self):
        """`a = b = c` as two."""
        place = self.postfix()
        sign = self.take("=", "+=", "-=", "*=", "/=") if self.peek() != ";" else self.refuse("a call stands alone", 0)
        start = self.at
        value = self.expression()
        if self.peek() == "=":
            self.at = start
            more = self.assignment()
            return more + [("assign", sign, place, more[-1][2])]
        return [("assign", sign, place, value)]

    def loop(self):
        self.take("(")
        self.take("int")
        name = self.take()
        self.take("=")
        first = int(self.take())
        self.take(";")
        self.take(name)
        sign, last = self.take("<", ">="), 0
        last = int(self.take())
        self.take(";")
        step = self.take("++", "--")
        self.take(name)
        self.take(")")
        return ("for", name, first, sign, last, step, self.block())

    def expression(self):
        condition = self.binary(0)
        if not self.taken("?"):
            return condition
        yes = self.expression()
        self.take(":")
        return ("select", condition, yes, self.expression())

    def binary(self, level):
        if level == len(LEVELS):
            return self.unary()
        left = self.binary(level + 1)
        while self.peek() in LEVELS[level]:
            sign = self.take()
            left = ("binary", sign, left, self.binary(level + 1))
        return left

    def unary(self):
        if self.taken("-"):
            return ("minus", self.unary())
        return self.postfix()

    def postfix(self):
        token, kind, place = self.tokens[self.at]
        self.at += 1
        if token == "(":
            found = ("group", self.expression())
            self.take(")")
        elif kind == "number":
            found = ("number", token)
        elif kind == "name":
            found = ("call", token, self.arguments()) if self.taken("(") else ("name", token)
        else:
            self.refuse(f"{token} begins no value", place)
        while self.peek() in (".", "["):
            if self.take() == ".":
                found = ("part", found, self.take())
            else:
                found = ("element", found, self.expression())
                self.take("]")
        return found

    def arguments(self):
        found = []
        while not self.taken(")"):
            found.append(self.expression())
            self.taken(",")
        return found


def size_of(kind):
    return int(kind[3]) if kind.startswith("vec") else 1


class Wgsl:
    """WGSL of what a Reader found. Types are known of every value, as arguments of one call have to be alike."""

    def __init__(self, found):
        self.functions = {one[2]: one for one in found if one[0] == "function"}
        self.globals = {one[2]: one for one in found if one[0] != "function"}
        self.locals, self.shared = {}, set()

    def text(self):
        lines = [f"var<private> {name}: {WGSL_TYPES[kind]};" for name, kind in CAMERA.items() if name in self.globals]
        for storage, kind, name, _length, value in self.globals.values():
            if storage == "const":
                lines.append(f"const {name}: {WGSL_TYPES[kind]} = {self.value(value)[0]};")
            if storage == "private":
                lines.append(f"var<private> {name}: {WGSL_TYPES[kind]};")
        return "\n".join(lines + [self.function(one) for one in self.functions.values()]) + "\n"

    def uniforms(self):
        """Of those in `uniforms`: name, type in GLSL, length of an array or 0."""
        return [[name, kind, length or 0] for storage, kind, name, length, _ in self.globals.values() if self.in_block(storage, kind, name)]

    def textures(self):
        return [[name, kind] for storage, kind, name, _, _ in self.globals.values() if storage == "uniform" and "sampler" in kind]

    def in_block(self, storage, kind, name):
        return storage == "uniform" and "sampler" not in kind and name not in CAMERA

    def function(self, one):
        _, kind, name, parameters, body = one
        self.locals = {n: (k, None) for k, n, _ in parameters}
        self.shared = {n for _, n, shared in parameters if shared}
        given = []
        for k, n, shared in parameters:
            given.append(f"{n}: ptr<function, {WGSL_TYPES[k]}>" if shared else f"{n}: {WGSL_TYPES[k]}")
            if "sampler" in k:
                given.append(f"{n}Sampler: sampler")
        returns = "" if kind == "void" else f" -> {WGSL_TYPES[kind]}"
        return f"fn {name}({', '.join(given)}){returns} {{\n{self.body(body, 1)}}}"

    def body(self, statements, depth):
        return "".join("  " * depth + line + "\n" for one in statements for line in self.statement(one, depth))

    def statement(self, one, depth):
        kind = one[0]
        if kind == "declare":
            _, type_of, name, length, value = one
            text = f" = {self.as_type(value, type_of)}" if value else ""
            self.locals[name] = (type_of, length)
            return [f"var {name}: {WGSL_TYPES[type_of]}{text};"]
        if kind == "assign":
            place, type_of = self.value(one[2])
            alike = self.as_type(one[3], type_of) if one[1] in ("=", "+=", "-=") else self.value(one[3])[0]
            return [f"{place} {one[1]} {alike};"]
        if kind == "if":
            rest = f" else {{\n{self.body(one[3], depth + 1)}{'  ' * depth}}}" if one[3] else ""
            return [f"if ({self.value(one[1])[0]}) {{\n{self.body(one[2], depth + 1)}{'  ' * depth}}}{rest}"]
        if kind == "for":
            _, name, first, sign, last, step, body = one
            self.locals[name] = ("int", None)
            return [f"for (var {name}: i32 = {first}; {name} {sign} {last}; {name}{step}) {{\n{self.body(body, depth + 1)}{'  ' * depth}}}"]
        if kind == "return":
            return [f"return {self.value(one[1])[0]};"]
        return ["discard;"]

    def as_type(self, value, kind):
        text, found = self.value(value)
        return text if found == kind or kind in ("float", "int", "uint", "bool") else f"{WGSL_TYPES[kind]}({text})"

    def value(self, one):
        """Text and type."""
        kind = one[0]
        if kind == "number":
            return one[1], "uint" if one[1].endswith("u") else "float" if "." in one[1] else "int"
        if kind == "name":
            return self.named(one[1])
        if kind == "group":
            text, found = self.value(one[1])
            return f"({text})", found
        if kind == "minus":
            text, found = self.value(one[1])
            return f"-{text}", found
        if kind == "part":
            text, _ = self.value(one[1])
            return f"{text}.{one[2]}", "float" if len(one[2]) == 1 else f"vec{len(one[2])}"
        if kind == "element":
            return self.element(one)
        if kind == "select":
            (no, found), (yes, _), (condition, _) = (self.value(one[k]) for k in (3, 2, 1))
            return f"select({no}, {yes}, {condition})", found
        if kind == "binary":
            return self.binary(one)
        return self.call(one[1], one[2])

    def named(self, name):
        if name in self.locals:
            return (f"(*{name})" if name in self.shared else name), self.locals[name][0]
        storage, kind, _, _, _ = self.globals[name]
        return (f"uniforms.{name}" if self.in_block(storage, kind, name) else name), kind

    def element(self, one):
        text, kind = self.value(one[1])
        index = self.value(one[2])[0]
        if kind.startswith("mat"):
            return f"{text}[{index}]", f"vec{kind[3]}"
        if one[1][0] == "name":  # an array
            part = {2: ".xy", 3: ".xyz", 4: ""}[size_of(kind)]
            return f"{text}[{index}]{part}", kind
        return f"{text}[{index}]", "float"

    def binary(self, one):
        sign = one[1]
        (left, a), (right, b) = self.value(one[2]), self.value(one[3])
        if sign in ("<", ">", "<=", ">=", "==", "!=", "&&", "||"):
            return f"{left} {sign} {right}", "bool"
        if a.startswith("mat") or b.startswith("mat"):
            return f"{left} {sign} {right}", b if a.startswith("mat") else a
        return f"{left} {sign} {right}", b if size_of(b) > size_of(a) or a == "int" else a

    def call(self, name, given):
        values = [self.value(v) for v in given]
        texts, kinds = [t for t, _ in values], [k for _, k in values]
        if name in self.functions:
            return self.own(name, given, texts), self.functions[name][1]
        if name in COMPARED:
            return f"({texts[0]} {COMPARED[name]} {texts[1]})", "bool"
        if name == "all":
            return f"all({texts[0]})", "bool"
        if name in ("texture", "textureLod"):
            level = texts[2] if name == "textureLod" else "0.0"
            return f"textureSampleLevel({texts[0]}, {texts[0]}Sampler, {texts[1]}, {level})", "vec4"
        if name == "mat3" and kinds == ["mat4"]:
            return "mat3x3f(" + ", ".join(f"{texts[0]}[{k}].xyz" for k in range(3)) + ")", "mat3"
        if name in WGSL_TYPES:
            return f"{WGSL_TYPES[name]}({', '.join(texts)})", name
        largest = max(kinds, key=size_of)
        if name in ALIKE and largest.startswith("vec"):
            texts = [t if k == largest else f"{WGSL_TYPES[largest]}({t})" for t, k in values]
        return f"{WGSL_NAMES.get(name, name)}({', '.join(texts)})", "float" if name in SCALAR else "vec3" if name == "cross" else largest

    def own(self, name, given, texts):
        out = []
        for value, text, (kind, _, shared) in zip(given, texts, self.functions[name][3]):
            out.append((value[1] if value[1] in self.shared else f"&{text}") if shared else text)
            if "sampler" in kind:
                out.append(f"{text}Sampler")
        return f"{name}({', '.join(out)})"


class Nodes:
    """JavaScript that makes nodes of what a Reader found."""

    def __init__(self, found):
        self.functions = {one[2]: one for one in found if one[0] == "function"}
        self.globals = {one[2]: one for one in found if one[0] != "function"}
        self.locals, self.loops, self.shares = {}, set(), False

    def text(self, name):
        lines = [f"export function {name}(T, given) {{", "  const globals = {};"]
        for storage, kind, own, _length, value in self.globals.values():
            if storage == "const":
                lines.append(f"  const {own} = {self.value(value)};")
            if storage == "private":
                lines.append(f"  globals.{own} = T.{kind}().toVar();")
        lines += [self.function(one) for one in self.functions.values()]
        return "\n".join(lines + [f"  return {{ {', '.join(self.functions)}, globals }};", "}", ""])

    def function(self, one):
        _, _, name, parameters, body = one
        self.locals, self.loops = dict.fromkeys(n for _, n, _ in parameters), set()
        self.shares = any(shared for _, _, shared in parameters)
        return f"  const {name} = ({', '.join(n for _, n, _ in parameters)}) => {{\n{self.body(body, 2)}  }};"

    def body(self, statements, depth):
        return "".join("  " * depth + self.statement(one, depth) + "\n" for one in statements)

    def statement(self, one, depth):
        kind, end = one[0], "  " * depth
        if kind == "declare":
            _, type_of, name, _, value = one
            text = self.value(value) if value else ""
            self.locals[name] = None
            return f"const {name} = T.{type_of}({text}).toVar();"
        if kind == "assign":
            return f"{self.value(one[2])}.{NODE_ASSIGNS[one[1]]}({self.value(one[3])});"
        if kind == "if":
            rest = f".Else(() => {{\n{self.body(one[3], depth + 1)}{end}}})" if one[3] else ""
            return f"T.If({self.value(one[1])}, () => {{\n{self.body(one[2], depth + 1)}{end}}}){rest};"
        if kind == "for":
            _, name, first, sign, last, step, body = one
            self.loops.add(name)
            return f"for (let {name} = {first}; {name} {sign} {last}; {step}{name}) {{\n{self.body(body, depth + 1)}{end}}}"
        if kind == "return":  # what a later draw would change is kept
            return f"return {self.value(one[1])}{'.toVar()' if self.shares else ''};"
        return "T.Discard();"

    def value(self, one):
        kind = one[0]
        if kind == "number":
            return f"T.uint({one[1][:-1]})" if one[1].endswith("u") else one[1]
        if kind == "name":
            return self.named(one[1])
        if kind == "group":
            return self.value(one[1])
        if kind == "minus":
            return f"T.negate({self.value(one[1])})"
        if kind == "part":
            return f"{self.value(one[1])}.{one[2]}"
        if kind == "element":
            return f"{self.value(one[1])}.element({self.index(one[2])})"
        if kind == "select":
            return f"T.select({', '.join(self.value(v) for v in one[1:])})"
        if kind == "binary":
            return f"T.{NODE_OPERATORS[one[1]]}({self.value(one[2])}, {self.value(one[3])})"
        return self.call(one[1], [self.value(v) for v in one[2]])

    def index(self, one):
        if one[0] == "binary":
            return f"{self.index(one[2])} {one[1]} {self.index(one[3])}"
        return one[1]

    def named(self, name):
        if name in self.locals or name in self.loops:
            return name
        storage = self.globals[name][0]
        return {"uniform": f"given.{name}", "private": f"globals.{name}", "const": name}[storage]

    def call(self, name, texts):
        if name in self.functions:
            return f"{name}({', '.join(texts)})"
        if name == "texture":
            return f"{texts[0]}.sample({texts[1]}).level(0)"
        if name == "textureLod":
            return f"{texts[0]}.sample({texts[1]}).level({texts[2]})"
        return f"T.{NODE_NAMES.get(name, name)}({', '.join(texts)})"


def read(kit, part):
    return [one for file in PARTS[part] for one in Reader((kit / file).read_text(), file).file()]


def main():
    kit, out = map(pathlib.Path, sys.argv[1:])
    made = {}
    for part in PARTS:
        wgsl = Wgsl(read(kit, part))
        made[part] = {"text": wgsl.text(), "uniforms": wgsl.uniforms(), "textures": wgsl.textures()}
    (out / "kit_wgsl.mjs").write_text(f"// Made by languages.py.\nexport const k_wgsl = {json.dumps(made, indent=1)};\n")
    nodes = "".join(Nodes(read(kit, part)).text(f"{part}Nodes") for part in PARTS)
    (out / "kit_nodes.mjs").write_text(f"// Made by languages.py.\n{nodes}")


main()
