#!/usr/bin/env python3
"""The C API in Kotlin, over JNI: python3 kotlin.py INCLUDE_FOLDER Api.kt jni.cpp

Names are those of C without sandglass_, in camel case. A struct is a class over memory that C sees, a handle one that is closed. A function
of a handle is its member, any other one of Sandglass. What fails throws. What is not made of the headers stands in ../android/kotlin/Memory.kt
and ../android/entries.h. A pointer goes to C as a number, beside the object that keeps what it leads to. Pointers have 8 bytes.
"""

import pathlib
import sys

from headers import Headers, Refused, doc, fails

# A type of C: the end of ByteBuffer's get and put, the type in Kotlin and in Java's C++, and the ways from and to the buffer's.
NUMBERS = {
    "uint8_t": ("", "Int", "jint", ".toInt() and 0xff", ".toByte()"),
    "int8_t": ("", "Int", "jint", ".toInt()", ".toByte()"),
    "uint16_t": ("Short", "Int", "jint", ".toInt() and 0xffff", ".toShort()"),
    "int16_t": ("Short", "Int", "jint", ".toInt()", ".toShort()"),
    "float": ("Float", "Float", "jfloat", "", ""),
    "double": ("Double", "Double", "jdouble", "", ""),
    "uint64_t": ("Long", "Long", "jlong", "", ""),
}
POINTER = 8
HEAD = "// Generated from the public headers by kotlin.py.\n"


def camel(name):
    first, *rest = name.removeprefix("sandglass_").split("_")
    return first + "".join(map(str.capitalize, rest))


def capital(name):
    return camel(name)[0].upper() + camel(name)[1:]


def number(item):
    return NUMBERS.get("uint64_t" if item.pointer else item.base, ("Int", "Int", "jint", "", ""))


def kind_of(headers, item):
    """The class of what a pointer leads to."""
    known = item.base in headers.structs or f"{item.base}_desc" in headers.structs
    return "Floats" if item.count else capital(item.base) if known and item.pointers == 1 else "Memory"


def returned(headers, function):
    """The type in Kotlin and in C++, and the struct that comes back in one that is made before."""
    value = function.returns
    if value.base in headers.structs and not value.pointer:
        return "Unit", "void", capital(value.base)
    return (
        ("String?", "jstring", "")
        if value.base == "char"
        else (*(("Unit", "void") if value.base == "void" or fails(function) else number(value)[1:3]), "")
    )


def field(headers, item, offset, given):
    name, at = camel(item.name), f"at + {offset}"
    if item.base == "float" and item.count and not item.pointer:
        return f"  val {name} = Floats(span, {at}, {item.count})\n"
    if item.count:
        at = f"element({at}, i, {item.count}, {headers.size(item, POINTER)[0]})"
    if item.pointer and not item.callback and given:
        kind = kind_of(headers, item._replace(count=0)) + "?"
        get, put = f"span.kept({at}) as {kind}", f"span.keep({at}, to)"
    elif item.base in headers.structs and not item.pointer:
        kind, get, put = capital(item.base), f"{capital(item.base)}(span, {at})", ""
    else:
        end, kind, _, get, put = number(item)
        get, put = f"span.bytes.get{end}({at}){get}", f"span.bytes.put{end}({at}, to{put})"
    if item.count:
        return f"  fun {name}(i: Int): {kind} = {get}\n" + f"  fun {name}(i: Int, to: {kind}) {{ {put} }}\n" * (put != "")
    return f"  var {name}: {kind}\n    get() = {get}\n    set(to) {{ {put} }}\n" if put else f"  val {name} = {get}\n"


def struct(headers, name, given):
    struct, (size, _, offsets), kind, default = (
        headers.structs[name],
        headers.layout(name, POINTER),
        capital(name),
        headers.functions.get(f"{name}_default"),
    )
    fresh = (
        f"Native.{camel(name)}Default(address, this)"
        if default and len(default.parameters) == 1
        else f"span.bytes.putInt(at, {size})"
        if struct.fields[0].name == "struct_size"
        else ""
    )
    fields = "".join(doc(item.comment, "  ") + field(headers, item, offset, given) for item, offset in zip(struct.fields, offsets))
    return (
        f"{doc(struct.comment, '')}class {kind}(span: Buffer, at: Int) : Struct(span, at) {{\n{fields}"
        f"  constructor() : this(Buffer(SIZE), 0) {{ fresh() }}\n  private fun fresh() {{ {fresh} }}\n  companion object {{\n    const val SIZE = {size}\n"
        "    /** So many, one behind the other: the first stands for all where C takes an array. */\n    fun array(count: Int) = "
        f"Buffer(count * SIZE).let {{ all -> List(count) {{ {kind}(all, it * SIZE).also {{ one -> one.fresh() }} }} }}\n  }}\n}}\n\n"
    )


def function(headers, name, function, handle):
    """What an app calls, the declaration behind it, and its definition in C++."""
    kotlin, java, declared, given, passed, kept, own = [], [], [], [], [], "", name.removeprefix("sandglass_")
    own = own.removeprefix("granular_").removeprefix(handle.removeprefix("sandglass_") + "_") if handle else own
    for i, item in enumerate(function.parameters[: -1 if fails(function) else None]):
        it, leads = camel(item.name), item.pointer and not item.callback
        if handle and i == 0:
            given.append("address, this")
        else:
            declared.append(f"{it}: {kind_of(headers, item)}?" if leads else f"{it}: {number(item)[1]}")
            given.append(f"address({it}{f', {item.count}' * (item.count > 0)}), {it}" if leads else it)
            kept += f'; keep("{own}", {it})' * (leads and handle != "" and own.startswith("set_"))  # it may be read later
        kotlin += [f"a{i}: {number(item)[1]}"] + [f"k{i}: Any?"] * leads
        java += [f"{number(item)[2]} a{i}"] + ["jobject"] * leads
        passed.append(f"Pointer{{a{i}}}" if item.pointer else f"static_cast<{item.base}>(a{i})")
    kind, in_java, made = returned(headers, function)
    if made:
        kotlin, java = kotlin + ["r: Long", "k: Any?"], java + ["jlong r", "jobject"]
    native, c = (f"Native.{camel(name)}({', '.join(given)})", f"{name}({', '.join(passed + ['&reason'] * fails(function))})")
    if made:
        body, c = (
            f": {made} = {made}().also {{ {native[:-1]}{', ' * (given != [])}it.address, it) }}",
            f"*static_cast<{function.returns.base}*>(Pointer{{r}}) = {c}",
        )
    else:
        body = f" {{ {native}{kept} }}" if kind == "Unit" else f": {kind} = {native}"
        c = (
            f"const char* reason = nullptr;\n  const sandglass_status status = {c};\n  finish(env, native, status, reason)"
            if fails(function)
            else f"return text(env, {c})"
            if kind == "String?"
            else c
            if kind == "Unit"
            else f"return ({in_java}){c}"
        )
    entry = [f"JNIEnv*{' env' * ('env' in c)}", f"jclass{' native' * fails(function)}", *java]
    return (
        f"{doc(function.comment, '  ')}  fun {camel(own)}({', '.join(declared)}){body}\n\n"
        * (not name.endswith("_release")),  # which close calls
        f"  @JvmStatic external fun {camel(name)}({', '.join(kotlin)}): {kind}\n",
        f"JNIEXPORT {in_java} JNICALL Java_org_sandglass_Native_{camel(name)}({', '.join(entry)}) {{\n  {c};\n}}\n",
    )


def write(headers):
    # Structs that an app fills. What points out of the others is the library's, and a number.
    given = {item.base for one in headers.functions.values() for item in one.parameters if item.const}
    while more := {item.base for name in given & set(headers.structs) for item in headers.structs[name].fields} - given:
        given |= more
    members, natives, entries = {name: "" for name in ["", *headers.handles]}, "", ""
    for name, one in headers.functions.items():
        first = one.parameters[0] if one.parameters else None
        handle = first.base if first and first.pointers == 1 and first.base in headers.handles else ""
        member, native, entry = function(headers, name, one, handle)
        members[handle], natives, entries = members[handle] + member, natives + native, entries + entry
    out = [f"{HEAD}package org.sandglass\n\n"]
    out += [
        f"const val {name} = {value}{'f' if isinstance(value, float) else 'L' if value > 0x7FFFFFFF else ''}\n"
        for name, value in headers.constants.items()
    ]
    out += ["\n", *(struct(headers, name, name in given) for name in headers.structs)]
    for name in headers.handles:
        kind, native = capital(name), f"Native.{camel(name)}"
        release = f"  override fun release() {{ {native}Release(address, this) }}\n" if f"{name}_release" in headers.functions else ""
        if f"{name}_desc" in headers.structs:
            out.append(
                f'/** Made in a block of its own. Fails like {name}_create. */\nclass {kind}(desc: {kind}Desc) : Owned("{kind}", desc,\n'
                f"  {{ {native}Bytes(desc.address, desc, it.address, it) }},\n  {{ block, bytes, made -> {native}Create(desc.address, desc, "
                f"block.address, block, bytes, made.address, made) }}) {{\n{members[name]}{release}}}\n\n"
            )
        elif members[name]:
            raise Refused(f"{name} has functions and no {name}_desc")
    out.append(
        f'/** What belongs to no handle. */\nobject Sandglass {{\n{members[""]}}}\n\ninternal object Native {{\n  init {{ System.loadLibrary("sandglass_jni") }}\n'
        "  @JvmStatic fun fail(status: Int, sentence: String?) { throw SandglassException(status, sentence) }\n"
        f"  @JvmStatic external fun address(bytes: java.nio.ByteBuffer): Long\n{natives}}}\n"
    )
    includes = "".join(f'#include "sandglass/{name}"\n' for name in headers.names)
    return "".join(out), f'{HEAD}{includes}#include "entries.h"\n\nextern "C" {{\n{entries}}}\n'


if __name__ == "__main__":
    try:
        for file, text in zip(sys.argv[2:4], write(Headers(sys.argv[1]))):
            pathlib.Path(file).write_text(text)
    except Refused as refused:
        sys.exit(f"kotlin.py does not understand a header: {refused}")
