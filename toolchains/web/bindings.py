#!/usr/bin/env python3
"""What JavaScript needs to know of the public headers: python3 bindings.py INCLUDE_FOLDER OUTPUT_FOLDER

Reads every header in INCLUDE_FOLDER/sandglass and writes to OUTPUT_FOLDER:
  abi.mjs         the layout of every struct and the signature of every function, as data
  sandglass.d.ts  the same as types, with the headers' comments; what sandglass.mjs adds is appended from types.d.ts
  exports.txt     the names for the linker, in Emscripten's form
  layout.c        a claim for each size and offset; the target's compiler checks them
It knows the subset of C that the headers are written in and refuses a line that it does not understand.
"""
import json
import pathlib
import re
import sys

SCALARS = {"uint8_t": ("u8", 1), "int8_t": ("i8", 1), "uint16_t": ("u16", 2), "int16_t": ("i16", 2), "uint32_t": ("u32", 4),
           "int32_t": ("i32", 4), "int": ("i32", 4), "uint64_t": ("u64", 8), "int64_t": ("i64", 8), "float": ("f32", 4),
           "double": ("f64", 8)}
POINTER = ("ptr", 4)
COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)


class Refused(Exception):
    pass


def prose(comment):
    """The sentences of a C comment as lines."""
    lines = comment[2:-2].strip().split("\n")
    return [re.sub(r"^\s*\* ?", "", line).rstrip() for line in lines]


class Headers:
    def __init__(self, texts):
        self.scalars, self.structs, self.functions, self.constants, self.comments = dict(SCALARS), {}, {}, {}, {}
        for text in texts:
            self.constants_of(text)
        for text in texts:
            self.declarations_of(text)

    def constants_of(self, text):
        plain = COMMENT.sub("", text)
        for name, value in re.findall(r"#define (SANDGLASS_(?!BRACKETS)\w+) (-?[\d.e+-]+f?)\n", plain):
            self.constants[name] = float(value.rstrip("f")) if re.search(r"[.e]", value) else int(value)
        for body in re.findall(r"\benum \{(.*?)\};", plain, re.DOTALL):
            for name, value in re.findall(r"(SANDGLASS_\w+) = (-?\d+)", body):
                self.constants[name] = int(value)
        for name in re.findall(r"typedef int32_t (sandglass_\w+);", plain):
            self.scalars[name] = ("i32", 4)
        for name in re.findall(r"typedef \w+ \(\*(sandglass_\w+)\)\(", plain):
            self.scalars[name] = POINTER

    def declarations_of(self, text):
        pattern = re.compile(r"(?P<comment>/\*(?:(?!\*/).)*\*/\s*\n)?typedef struct (?P<struct>sandglass_\w+) \{\n(?P<body>.*?)\n\} \w+;|"
                             r"(?P<above>/\*(?:(?!\*/).)*\*/\s*\n)?SANDGLASS_API (?:SANDGLASS_NODISCARD )?(?P<returns>[\w ]+\**)\s+"
                             r"(?P<function>sandglass_\w+)\((?P<parameters>[^;]*?)\);", re.DOTALL)
        for found in pattern.finditer(text):
            if found["struct"]:
                self.structs[found["struct"]] = self.struct(found["struct"], found["body"])
                self.comments[found["struct"]] = prose(found["comment"].strip()) if found["comment"] else []
            else:
                self.functions[found["function"]] = self.function(found["returns"], found["parameters"])
                self.comments[found["function"]] = prose(found["above"].strip()) if found["above"] else []

    def struct(self, name, body):
        fields, offset, alignment, comment = [], 0, 1, []
        # The comment that stands behind the last field's semicolon is that of the next field.
        for part in re.finditer(r"(/\*.*?\*/)|([^;/]+);", body, re.DOTALL):
            if part[1]:
                comment = prose(part[1])
                continue
            for field, kind, size, align, count in self.fields(name, " ".join(part[2].split())):
                offset = (offset + align - 1) // align * align
                fields.append({"name": field, "type": kind, "offset": offset, "count": count, "comment": comment})
                offset += size * (count or 1)
                alignment = max(alignment, align)
        return {"size": (offset + alignment - 1) // alignment * alignment, "align": alignment, "fields": fields}

    def fields(self, struct, declaration):
        callback = re.fullmatch(r"[\w ]+ \(\*(\w+)\)\(.*\)", declaration)
        if callback:
            yield callback[1], "ptr", 4, 4, 0
            return
        match = re.fullmatch(r"(?:const )?(?:struct )?(\w+)\s*(\*?)\s*(?:const\* )?(.*)", declaration)
        if not match:
            raise Refused(f"{struct}: {declaration}")
        base, star, rest = match.groups()
        for one in rest.split(","):
            part = re.fullmatch(r"\s*(?:\*\s*(?:const\s*\*\s*)?)?(\w+)(?:\[(\w+)\])?\s*", one)
            if not part:
                raise Refused(f"{struct}: {declaration}")
            count = 0 if part[2] is None else int(part[2]) if part[2].isdigit() else self.constants[part[2]]
            if star or "*" in one or "*" in declaration:
                yield part[1], "ptr", 4, 4, count
            elif base in self.structs:
                inner = self.structs[base]
                yield part[1], base, inner["size"], inner["align"], count
            elif base in self.scalars:
                kind, size = self.scalars[base]
                yield part[1], kind, size, size, count
            else:
                raise Refused(f"{struct}: unknown type {base}")

    def function(self, returns, parameters):
        returns, declared = " ".join(returns.split()), []
        for parameter in [] if parameters.strip() == "void" else re.split(r",\s*(?![^()]*\))", " ".join(parameters.split())):
            callback = re.fullmatch(r"[\w ]+ \(\*(\w+)\)\(.*\)", parameter)
            match = re.fullmatch(r"((?:const )?(?:struct )?\w+[\s*const]*?)\s*\b(\w+)(\[\w+\])?", parameter)
            if callback or not match:
                raise Refused(f"parameter {parameter}")
            kind, name, array = match.groups()
            base = re.sub(r"\b(const|struct)\b|\*", "", kind).strip()
            if "*" in kind or array:
                declared.append({"name": name, "type": "ptr", "of": base})
            elif base in self.structs:
                declared.append({"name": name, "type": "ptr", "of": base})  # a struct by value goes by its address
            elif base in self.scalars:
                declared.append({"name": name, "type": self.scalars[base][0], "of": base})
            else:
                raise Refused(f"parameter {parameter}")
        result = {"type": "void"}
        if returns == "const char*":
            result = {"type": "text"}
        elif "*" in returns:
            result = {"type": "ptr", "of": returns.replace("const", "").replace("*", "").strip()}
        elif returns in self.structs:
            result = {"type": "struct", "of": returns}
        elif returns != "void":
            result = {"type": self.scalars[returns][0], "of": returns}
        # Its text becomes the message of what is thrown.
        fails = bool(declared) and declared[-1]["name"] == "reason" and result.get("of") == "sandglass_status"
        return {"returns": result, "parameters": declared[:-1] if fails else declared, "fails": fails}


def doc(comment, indent):
    if not comment:
        return ""
    lines = "".join(f"{indent} * {line}".rstrip() + "\n" for line in comment)
    return f"{indent}/**\n{lines}{indent} */\n"


def field_type(headers, field):
    kind = field["type"]
    if kind in headers.structs:
        return kind if not field["count"] else f"{kind}[]"
    if not field["count"]:
        return "number"
    return {"f32": "Float32Array", "f64": "Float64Array", "u32": "Uint32Array", "i32": "Int32Array", "u64": "BigUint64Array",
            "u8": "Uint8Array", "u16": "Uint16Array", "ptr": "Uint32Array"}[kind]


def parameter_type(headers, parameter):
    if parameter["type"] == "ptr":
        if parameter["of"] in headers.structs:
            return f"{parameter['of']} | Pointer"
        return "Pointer"
    return "number | bigint" if parameter["type"] in ("u64", "i64") else "number"


def result_type(function):
    kind = function["returns"]["type"]
    if function["fails"]:
        return "void"
    return {"void": "void", "text": "string | null", "ptr": "Pointer", "u64": "bigint", "i64": "bigint",
            "struct": function["returns"].get("of")}.get(kind, "number")


def typescript(headers):
    out = ["// Generated from the public headers by bindings.py.\n", "/** An address in the module's memory; 0 is NULL. */\n"
           "export type Pointer = number;\n\n"]
    for name, struct in headers.structs.items():
        out.append(doc(headers.comments[name], "") + f"export interface {name} extends Struct {{\n")
        for field in struct["fields"]:
            readonly = "readonly " if field["count"] else ""
            out.append(doc(field["comment"], "  ") + f"  {readonly}{field['name']}: {field_type(headers, field)};\n")
        out.append("}\n\n")
    out.append("export interface Structs {\n" + "".join(f"  {name}: {name};\n" for name in headers.structs) + "}\n\n")
    out.append("/** Every function of the C API. One that fails throws an Error whose message is the library's sentence. */\n"
               "export interface Functions {\n")
    for name, function in headers.functions.items():
        parameters = ", ".join(f"{p['name']}: {parameter_type(headers, p)}" for p in function["parameters"])
        out.append(doc(headers.comments[name], "  ") + f"  {name}({parameters}): {result_type(function)};\n")
    out.append("}\n\nexport declare const constants: {\n" +
               "".join(f"  readonly {name}: {value};\n" for name, value in headers.constants.items()) + "};\n\n")
    return "".join(out)


def claims(headers):
    out = ["#include <stddef.h>\n"] + [f"#include \"sandglass/{name}.h\"\n" for name in
                                       ("sandglass", "field", "light", "pile_shadow", "room", "shadow")]
    for name, struct in headers.structs.items():
        out.append(f"_Static_assert(sizeof({name}) == {struct['size']}, \"size of {name}\");\n")
        for field in struct["fields"]:
            out.append(f"_Static_assert(offsetof({name}, {field['name']}) == {field['offset']}, \"{name}.{field['name']}\");\n")
    return "".join(out)


def abi(headers):
    structs = {name: {"size": struct["size"],
                      "fields": [[f["name"], f["type"], f["offset"], f["count"]] for f in struct["fields"]]}
               for name, struct in headers.structs.items()}
    functions = {name: [[p["type"] for p in f["parameters"]], f["returns"]["type"], f["returns"].get("of", ""), f["fails"]]
                 for name, f in headers.functions.items()}
    return ("// Generated from the public headers by bindings.py.\n"
            f"export const structs = {json.dumps(structs)};\nexport const functions = {json.dumps(functions)};\n"
            f"export const constants = {json.dumps(headers.constants)};\n")


def main():
    include, output = pathlib.Path(sys.argv[1]) / "sandglass", pathlib.Path(sys.argv[2])
    first = ["types.h", "sampling.h", "field.h", "sandglass.h"]  # structs come before those that hold them
    paths = [include / name for name in first] + sorted(p for p in include.glob("*.h") if p.name not in first)
    headers = Headers([path.read_text() for path in paths])
    here = pathlib.Path(__file__).parent
    for name, text in (("abi.mjs", abi(headers)), ("sandglass.d.ts", typescript(headers) + (here / "types.d.ts").read_text()),
                       ("exports.txt", "".join(f"_{name}\n" for name in [*headers.functions, "malloc", "free"])),
                       ("layout.c", claims(headers))):
        path = output / name
        if not path.exists() or path.read_text() != text:
            path.write_text(text)
    declared = len(re.findall(r"^SANDGLASS_API\b", "".join(path.read_text() for path in paths), re.MULTILINE))
    if declared != len(headers.functions):
        raise Refused(f"{declared} functions are declared and {len(headers.functions)} were understood")


if __name__ == "__main__":
    try:
        main()
    except Refused as refused:
        sys.exit(f"bindings.py does not understand a header: {refused}")
