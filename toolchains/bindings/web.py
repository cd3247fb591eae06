#!/usr/bin/env python3
"""What JavaScript needs to know of the public headers: python3 web.py INCLUDE_FOLDER OUTPUT_FOLDER

Writes to OUTPUT_FOLDER:
  abi.mjs         the layout of every struct and the signature of every function, as data
  sandglass.d.ts  the same as types, with the headers' comments; what sandglass.mjs adds is appended from ../web/types.d.ts
  exports.txt     the names for the linker, in Emscripten's form
  layout.c        a claim for each size and offset; the target's compiler checks them
"""

import json
import pathlib
import sys

from headers import Headers, Refused, doc, fails

POINTER = 4
SCALARS = {
    "uint8_t": "u8",
    "int8_t": "i8",
    "uint16_t": "u16",
    "int16_t": "i16",
    "uint32_t": "u32",
    "int32_t": "i32",
    "int": "i32",
    "uint64_t": "u64",
    "int64_t": "i64",
    "float": "f32",
    "double": "f64",
}
ARRAYS = {
    "f32": "Float32Array",
    "f64": "Float64Array",
    "u32": "Uint32Array",
    "i32": "Int32Array",
    "u64": "BigUint64Array",
    "u8": "Uint8Array",
    "i8": "Int8Array",
    "u16": "Uint16Array",
    "i16": "Int16Array",
    "ptr": "Uint32Array",
}


def kind(headers, item):
    """The type of a field or of an element of it."""
    return "ptr" if item.pointer else item.base if item.base in headers.structs else SCALARS.get(item.base, "i32")


def parameter(headers, item):
    """Its type; a struct by value goes by its address."""
    name = kind(headers, item)
    return "ptr" if name in headers.structs else name


def result(headers, item):
    """Its type, and what that is of."""
    if item.base == "void" and not item.pointer:
        return "void", ""
    if item.base == "char":
        return "text", ""
    return ("struct" if not item.pointer and item.base in headers.structs else kind(headers, item)), item.base


def arguments(function):
    return function.parameters[:-1] if fails(function) else function.parameters


def pointer_type(headers, item, otherwise):
    """Of one pointer: to what only the library knows, to a struct, to anything else."""
    if item.pointers != 1 or item.callback:
        return "Pointer"
    return (
        f'Handle<"{item.base}">'
        if item.base in headers.handles
        else f"{item.base} | Pointer | null"
        if item.base in headers.structs
        else otherwise
    )


def field_type(headers, field):
    """As it is read; as it is written, where that is another type."""
    name = kind(headers, field)
    if name in headers.structs:
        return (name if not field.count else f"{name}[]"), None
    if field.count:
        return f"Numbers<{ARRAYS[name]}>", None
    if name != "ptr":
        return "number", None
    written = pointer_type(headers, field, "Pointer")
    if written.startswith("Handle"):
        return f"{written} | null", None
    return (f"PointerTo<{field.base}>", written) if "|" in written else ("Pointer", None)


def parameter_type(headers, item):
    name = parameter(headers, item)
    if name == "ptr":
        return item.base if not item.pointer else pointer_type(headers, item, "Pointer | Numbers | null")
    return "number | bigint" if name in ("u64", "i64") else "number"


def result_type(headers, function):
    if fails(function):
        return "void"
    name, of = result(headers, function.returns)
    if name == "ptr" and of in headers.handles:
        return pointer_type(headers, function.returns, "")
    return {"void": "void", "text": "string | null", "ptr": "Pointer", "u64": "bigint", "i64": "bigint", "struct": of}.get(name, "number")


def listed(headers, items):
    return ", ".join(f"{item.name}: {parameter_type(headers, item)}" for item in items)


def typescript(headers):
    out = ["// Generated from the public headers by web.py.\n"]
    for name, struct in headers.structs.items():
        out.append(doc(struct.comment, "") + f'export interface {name} extends Struct<"{name}"> {{\n')
        for field in struct.fields:
            read, written = field_type(headers, field)
            one = (
                f"get {field.name}(): {read};\n  set {field.name}(value: {written})"
                if written
                else f"{'readonly ' * (field.count > 0)}{field.name}: {read}"
            )
            out.append(doc(field.comment, "  ") + f"  {one};\n")
        out.append("}\n\n")
    out.append("export interface Structs {\n" + "".join(f"  {name}: {name};\n" for name in headers.structs) + "}\n\n")
    out.append("/** What create() takes for each: the arguments of its _bytes function. */\nexport interface Descriptions {\n")
    for name in headers.functions:
        if name.endswith("_create") and (size := headers.functions.get(name[:-7] + "_bytes")):
            out.append(f"  {name[:-7]}: [{listed(headers, arguments(size)[:-1])}];\n")
    out.append(
        "}\n\n/** Every function of the C API. One that fails throws an Error whose message is the library's sentence. */\n"
        "export interface Functions {\n"
    )
    for name, function in headers.functions.items():
        out.append(doc(function.comment, "  ") + f"  {name}({listed(headers, arguments(function))}): {result_type(headers, function)};\n")
    out.append(
        "}\n\nexport declare const constants: {\n"
        + "".join(f"  readonly {name}: {value};\n" for name, value in headers.constants.items())
        + "};\n\n"
    )
    return "".join(out)


def abi(headers):
    structs, functions = {}, {}
    for name, struct in headers.structs.items():
        size, _, offsets = headers.layout(name, POINTER)
        structs[name] = {"size": size, "fields": [[f.name, kind(headers, f), o, f.count] for f, o in zip(struct.fields, offsets)]}
    for name, function in headers.functions.items():
        functions[name] = [[parameter(headers, item) for item in arguments(function)], *result(headers, function.returns), fails(function)]
    return (
        "// Generated from the public headers by web.py.\n"
        f"export const structs = {json.dumps(structs)};\nexport const functions = {json.dumps(functions)};\n"
        f"export const constants = {json.dumps(headers.constants)};\n"
    )


def main():
    headers, output = Headers(sys.argv[1]), pathlib.Path(sys.argv[2])
    types = pathlib.Path(__file__).parent.parent / "web/types.d.ts"
    (output / "abi.mjs").write_text(abi(headers))
    (output / "sandglass.d.ts").write_text(typescript(headers) + types.read_text())
    (output / "exports.txt").write_text("".join(f"_{name}\n" for name in [*headers.functions, "malloc", "free"]))
    (output / "layout.c").write_text(headers.claims(POINTER))


if __name__ == "__main__":
    try:
        main()
    except Refused as refused:
        sys.exit(f"web.py does not understand a header: {refused}")
