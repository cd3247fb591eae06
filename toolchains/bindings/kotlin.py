#!/usr/bin/env python3
"""The C API in Kotlin, over JNI: python3 kotlin.py INCLUDE_FOLDER Api.kt jni.cpp

Names are those of C without sandglass_, in camel case. A struct is a class over memory that C sees, a handle one that is closed. A function
of a handle is its member, any other one of Sandglass. A fixed array of floats is a FloatArray where it is an argument. What fails throws.
../android/kotlin/Memory.kt and ../android/entries.h hold what is not made of the headers. Pointers have 8 bytes.
"""
import pathlib
import sys

from headers import Headers, Refused

POINTER = 8
GET = {"uint8_t": "u8", "int8_t": "i8", "uint16_t": "u16", "int16_t": "i16", "uint64_t": "i64", "int64_t": "i64", "float": "f32", "double": "f64"}
KOTLIN = {"i64": "Long", "f32": "Float", "f64": "Double"}
JAVA = {"Long": "jlong", "Float": "jfloat", "Double": "jdouble", "Int": "jint", "String?": "jstring", "Unit": "void"}


def capital(name):
    return "".join(word.capitalize() for word in name.removeprefix("sandglass_").split("_"))


def camel(name):
    name = capital(name)
    return name[:1].lower() + name[1:]


def doc(comment, indent):
    text = "\n".join(f"{indent} * {line}".rstrip() for line in comment).replace("/*", "/ *").replace("*/", "* /")
    return f"{indent}/**\n{text}\n{indent} */\n" if comment else ""


def number(item):
    """How Memory.kt reads it, and its type."""
    how = GET.get(item.base, "i32")
    return how, KOTLIN.get(how, "Int")


def returned(headers, function):
    value = function.returns
    if value.base == "char" and value.pointer:
        return "String?"
    if value.base == "void" or fails(function) or by_value(headers, function):
        return "Unit"
    return "Long" if value.pointer else number(value)[1]


def by_value(headers, function):
    return function.returns.base in headers.structs and not function.returns.pointer


def fails(function):
    return bool(function.parameters) and function.parameters[-1].name == "reason"


class Writer:
    def __init__(self, headers):
        self.headers = headers
        self.given = set()  # structs that an app fills; what points out of the others is the library's
        for function in headers.functions.values():
            self.given.update(item.base for item in function.parameters if item.const and item.base in headers.structs)
        while more := {item.base for name in self.given for item in headers.structs[name].fields if item.base in headers.structs} - self.given:
            self.given |= more

    def memory(self, item):
        """The class of what a pointer leads to."""
        known = item.base in self.headers.structs or f"{item.base}_desc" in self.headers.structs
        return capital(item.base) if known and item.pointers == 1 else "Memory"

    def field(self, owner, item, offset):
        name, at, h = camel(item.name), f"at + {offset}", self.headers
        size = h.size(item, POINTER)[0]
        where = f"element({at}, i, {item.count}, {size})" if item.count else at
        index, i = ("i: Int, ", "i: Int") if item.count else ("", "")
        if item.base in h.structs and not item.pointer:
            made = f"{capital(item.base)}(span, {where})"
            return f"  fun {name}({i}) = {made}\n" if item.count else f"  val {name} = {made}\n"
        if item.pointer and not item.callback and owner in self.given:
            kind = self.memory(item)
            cast = "" if kind == "Memory" else f" as {kind}?"
            if item.count:
                return f"  fun {name}({i}, of: {kind}?) = span.keep({where}, of)\n"
            return f"  var {name}: {kind}?\n    get() = span.kept({where}){cast}\n    set(of) = span.keep({where}, of)\n"
        how, kind = ("i64", "Long") if item.pointer else number(item)
        if item.count and how == "f32":
            return f"  val {name} = Floats(span, {at}, {item.count})\n"
        if item.count:
            return f"  fun {name}({i}): {kind} = span.{how}({where})\n  fun {name}({index}to: {kind}) = span.{how}({where}, to)\n"
        return f"  var {name}: {kind}\n    get() = span.{how}({at})\n    set(to) = span.{how}({at}, to)\n"

    def struct(self, name, struct):
        size, _, offsets = self.headers.layout(name, POINTER)
        default = self.headers.functions.get(f"{name}_default")
        fresh = f"Native.{name.removeprefix('sandglass_')}_default(address, this)" if default and len(default.parameters) == 1 else \
            f"span.i32(at, {size})" if struct.fields[0].name == "struct_size" else "Unit"
        fields = "".join(doc(item.comment, "  ") + self.field(name, item, offset) for item, offset in zip(struct.fields, offsets))
        kind = capital(name)
        return (f"{doc(struct.comment, '')}class {kind}(span: Span, at: Int) : Struct(span, at, {size}) {{\n"
                f"  constructor() : this(Span({size}), 0) {{ fresh() }}\n  private fun fresh() = {fresh}\n{fields}"
                f"  companion object {{\n    const val SIZE = {size}\n    /** So many, one behind the other: the first stands for all where C takes an array. */\n"
                f"    fun array(count: Int): List<{kind}> {{\n      val span = Span(count * SIZE)\n"
                f"      return List(count) {{ i -> {kind}(span, i * SIZE).also {{ it.fresh() }} }}\n    }}\n  }}\n}}\n\n")

    def function(self, name, function, handle):
        h, declared, given = self.headers, [], []
        items = function.parameters[:-1] if fails(function) else function.parameters
        for item in items:
            me, it = handle and item is items[0], camel(item.name)
            if me:
                given.append("address, this")
            elif item.count:
                declared.append(f"{it}: FloatArray?")
                given.append(f"sized(\"{it}\", {it}, {item.count})")
            elif item.pointer and not item.callback:
                declared.append(f"{it}: {self.memory(item)}?")
                given.append(f"of({it}), {it}")
            else:
                declared.append(f"{it}: {'Long' if item.callback else number(item)[1]}")
                given.append(it)
        short = name.removeprefix("sandglass_")
        own = short.removeprefix("granular_").removeprefix(handle.removeprefix("sandglass_") + "_") if handle else short
        head = f"{doc(function.comment, '  ')}  fun {camel(own)}({', '.join(declared)})"
        if by_value(h, function):
            made = capital(function.returns.base)
            return f"{head}: {made} {{\n    val made = {made}(Span({made}.SIZE), 0)\n    Native.{short}({', '.join([*given, 'made.address, made'])})\n    return made\n  }}\n\n"
        call = f"Native.{short}({', '.join(given)})"
        if handle and own.startswith("set_"):  # what it reads later stays, too
            call = "".join([f"{{\n    {call}\n", *(f'    keep("{own}", {camel(item.name)})\n' for item in items[1:] if item.pointer and not item.count), "  }"])
            return f"{head} {call}\n\n"
        return f"{head}: {returned(h, function)} = {call}\n\n"

    def native(self, name, function):
        """The declaration in Kotlin and the definition in C++."""
        kotlin, java, given, back = [], [], [], []
        items = function.parameters[:-1] if fails(function) else function.parameters
        for i, item in enumerate(items):
            if item.count:
                kotlin, java = kotlin + [f"a{i}: FloatArray?"], java + [f"jfloatArray a{i}"]
                given.append(f"Floats<{item.count}, {'true' if item.const else 'false'}>(env, a{i})")
            elif item.pointer:
                kept = not item.callback
                kotlin, java = kotlin + [f"a{i}: Long"] + [f"k{i}: Any?"] * kept, java + [f"jlong a{i}"] + ["jobject"] * kept
                given.append(f"Pointer{{a{i}}}")
            else:
                kind = number(item)[1]
                kotlin, java = kotlin + [f"a{i}: {kind}"], java + [f"{JAVA[kind]} a{i}"]
                given.append(f"static_cast<{item.base}>(a{i})")
        kind = returned(self.headers, function)
        if by_value(self.headers, function):
            kotlin, java = kotlin + ["r: Long", "k: Any?"], java + ["jlong r", "jobject"]
        call = f"{name}({', '.join(given + ['&failure.reason'] * fails(function))})"
        if fails(function):
            body = f"Failure failure;\n  failure.raise(env, {call});"
        elif by_value(self.headers, function):
            body = f"*static_cast<{function.returns.base}*>(Pointer{{r}}) = {call};"
        elif kind == "String?":
            body = f"return text(env, {call});"
        elif kind == "Long" and function.returns.pointer:
            body = f"return reinterpret_cast<jlong>({call});"
        else:
            body = f"{call};" if kind == "Unit" else f"return static_cast<{JAVA[kind]}>({call});"
        short = name.removeprefix("sandglass_")
        entry = short.replace("_", "_1")
        return (f"  @JvmStatic external fun {short}({', '.join(kotlin)}): {kind}\n",
                f"JNIEXPORT {JAVA[kind]} JNICALL Java_org_sandglass_Native_{entry}({', '.join(['JNIEnv*' + ' env' * ('env' in body), 'jclass', *java])}) {{\n  {body}\n}}\n")

    def api(self):
        h, members, plain, natives, entries = self.headers, {}, [], [], []
        for name, function in h.functions.items():
            first = function.parameters[0] if function.parameters else None
            handle = first.base if first and first.pointers == 1 and first.base in h.handles else ""
            kotlin, cpp = self.native(name, function)
            natives.append(kotlin)
            entries.append(cpp)
            if not name.endswith("_release"):  # is close
                (members.setdefault(handle, []) if handle else plain).append(self.function(name, function, handle))
        out = ["// Generated from the public headers by kotlin.py.\npackage org.sandglass\n\n"]
        for name, value in h.constants.items():
            out.append(f"const val {name} = {value}{'f' if isinstance(value, float) else 'L' if value > 0x7fffffff else ''}\n")
        out += ["\n", *(self.struct(name, struct) for name, struct in h.structs.items())]
        for name in h.handles:
            if f"{name}_desc" in h.structs:
                kind, short = capital(name), name.removeprefix("sandglass_")
                end = f"{{ if (isOpen) Native.{short}_release(address, this) }}" if f"{name}_release" in h.functions else "{}"
                out.append(f"/** Made in a block of its own. Fails like {name}_create. */\nclass {kind}(desc: {kind}Desc) : Owned(\"{kind}\", block {{ Native.{short}_bytes(desc.address, desc, it.address, it) }},\n"
                           f"  {{ block, bytes, made -> Native.{short}_create(desc.address, desc, block.address, block, bytes, made.address, made) }}) {{\n"
                           f"  init {{ keep(\"desc\", desc) }}\n"
                           f"{''.join(members.pop(name, []))}  override fun release() {end}\n}}\n\n")
        out.append(f"/** What belongs to no handle. */\nobject Sandglass {{\n{''.join(plain)}}}\n\ninternal object Native {{\n"
                   f"  init {{ System.loadLibrary(\"sandglass_jni\") }}\n  @JvmStatic external fun address(bytes: java.nio.ByteBuffer): Long\n  @JvmStatic external fun insideTest(): Long\n{''.join(natives)}}}\n")
        if members:
            raise Refused(f"members of a handle that nothing creates: {sorted(members)}")
        includes = "".join(f"#include \"sandglass/{name}\"\n" for name in h.names)
        return "".join(out), f"// Generated from the public headers by kotlin.py.\n#include \"entries.h\"\n{includes}\n\nextern \"C\" {{\n{''.join(entries)}}}\n"


if __name__ == "__main__":
    try:
        for file, text in zip(sys.argv[2:4], Writer(Headers(sys.argv[1])).api()):
            pathlib.Path(file).write_text(text)
    except Refused as refused:
        sys.exit(f"kotlin.py does not understand a header: {refused}")
