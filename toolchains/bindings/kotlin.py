#!/usr/bin/env python3
"""The C API in Kotlin, over JNI: python3 kotlin.py INCLUDE_FOLDER Api.kt jni.cpp

Names are those of C without sandglass_, in camel case. A struct is a class over memory that C sees, a handle one that is closed. A function
of a handle is its member, any other one of Sandglass. What fails throws. What is not made of the headers stands in ../android/kotlin/Memory.kt
and ../android/entries.h. A pointer goes to C as a number, beside the object that keeps what it leads to. Pointers have 8 bytes.
"""
import pathlib
import sys

from headers import Headers, Refused

# A type of C: the end of ByteBuffer's get and put, the type in Kotlin and in Java's C++, and the ways from and to the buffer's.
NUMBERS = {"uint8_t": ("", "Int", "jint", ".toInt() and 0xff", ".toByte()"), "int8_t": ("", "Int", "jint", ".toInt()", ".toByte()"),
           "uint16_t": ("Short", "Int", "jint", ".toInt() and 0xffff", ".toShort()"), "int16_t": ("Short", "Int", "jint", ".toInt()", ".toShort()"),
           "float": ("Float", "Float", "jfloat", "", ""), "double": ("Double", "Double", "jdouble", "", ""), "uint64_t": ("Long", "Long", "jlong", "", "")}
POINTER = 8
LONG, INT = NUMBERS["uint64_t"], ("Int", "Int", "jint", "", "")


def camel(name):
    first, *rest = name.removeprefix("sandglass_").split("_")
    return first + "".join(map(str.capitalize, rest))


def capital(name):
    return camel(name)[0].upper() + camel(name)[1:]


def doc(comment, indent):
    lines = "".join(f"{indent} * {line}".rstrip() + "\n" for line in comment).replace("/*", "/ *").replace("*/", "* /")
    return f"{indent}/**\n{lines}{indent} */\n" if comment else ""


def number(item):
    return LONG if item.pointer else NUMBERS.get(item.base, INT)


def fails(function):
    return [item.name for item in function.parameters][-1:] == ["reason"]


class Writer:
    def __init__(self, headers):
        self.headers = headers
        # Structs that an app fills. What points out of the others is the library's, and a number.
        self.given = {item.base for function in headers.functions.values() for item in function.parameters if item.const}
        while more := {item.base for name in self.given & set(headers.structs) for item in headers.structs[name].fields} - self.given:
            self.given |= more

    def kind(self, item):
        """The class of what a pointer leads to."""
        known = item.base in self.headers.structs or f"{item.base}_desc" in self.headers.structs
        return "Floats" if item.count else capital(item.base) if known and item.pointers == 1 else "Memory"

    def returned(self, function):
        """The type in Kotlin and in C++. A struct comes back in one that is made before."""
        value = function.returns
        if value.base == "char":
            return "String?", "jstring"
        return ("Unit", "void") if value.base == "void" or fails(function) or self.by_value(function) else number(value)[1:3]

    def by_value(self, function):
        return function.returns.base in self.headers.structs and not function.returns.pointer

    def field(self, owner, item, offset):
        name, size = camel(item.name), self.headers.size(item, POINTER)[0]
        at = f"element(at + {offset}, i, {item.count}, {size})" if item.count else f"at + {offset}"
        if item.base == "float" and item.count and not item.pointer:
            return f"  val {name} = Floats(span, at + {offset}, {item.count})\n"
        if item.pointer and not item.callback and owner in self.given:
            kind = self.kind(item._replace(count=0))
            kind, get, put = f"{kind}?", f"span.kept({at})" + f" as {kind}?" * (kind != "Memory"), f"span.keep({at}, to)"
        elif item.base in self.headers.structs and not item.pointer:
            kind, get, put = capital(item.base), f"{capital(item.base)}(span, {at})", ""
        else:
            end, kind, _, get, put = number(item)
            get, put = f"span.bytes.get{end}({at}){get}", f"span.bytes.put{end}({at}, to{put})"
        if item.count:
            return f"  fun {name}(i: Int): {kind} = {get}\n" + f"  fun {name}(i: Int, to: {kind}) {{ {put} }}\n" * (put != "")
        return f"  var {name}: {kind}\n    get() = {get}\n    set(to) {{ {put} }}\n" if put else f"  val {name} = {get}\n"

    def struct(self, name, struct):
        size, _, offsets = self.headers.layout(name, POINTER)
        default, kind = self.headers.functions.get(f"{name}_default"), capital(name)
        fresh = f"Native.{camel(name)}Default(address, this)" if default and len(default.parameters) == 1 else \
            f"span.bytes.putInt(at, {size})" if struct.fields[0].name == "struct_size" else ""
        fields = "".join(doc(item.comment, "  ") + self.field(name, item, offset) for item, offset in zip(struct.fields, offsets))
        return (f"{doc(struct.comment, '')}class {kind}(span: Buffer, at: Int) : Struct(span, at) {{\n{fields}"
                f"  constructor() : this(Buffer(SIZE), 0) {{ fresh() }}\n  private fun fresh() {{ {fresh} }}\n  companion object {{\n    const val SIZE = {size}\n"
                "    /** So many, one behind the other: the first stands for all where C takes an array. */\n    fun array(count: Int) = "
                f"Buffer(count * SIZE).let {{ all -> List(count) {{ {kind}(all, it * SIZE).also {{ one -> one.fresh() }} }} }}\n  }}\n}}\n\n")

    def function(self, name, function, handle):
        declared, given, kept, own = [], [], "", name.removeprefix("sandglass_")
        own = own.removeprefix("granular_").removeprefix(handle.removeprefix("sandglass_") + "_") if handle else own
        for item in function.parameters[:-1 if fails(function) else None]:
            it = camel(item.name)
            if handle and not given:
                given.append("address, this")
            elif item.pointer and not item.callback:
                declared.append(f"{it}: {self.kind(item)}?")
                given.append(f"address({it}{f', {item.count}' * (item.count > 0)}), {it}")
                kept += f"; keep(\"{own}\", {it})" * (handle != "" and own.startswith("set_"))  # it may be read later
            else:
                declared.append(f"{it}: {number(item)[1]}")
                given.append(it)
        call, returned = f"Native.{camel(name)}({', '.join(given)})", self.returned(function)[0]
        if self.by_value(function):
            returned = capital(function.returns.base)
            call = f"{returned}().also {{ {call[:-1]}{', ' * (given != [])}it.address, it) }}"
        body = f" {{ {call}{kept} }}" if returned == "Unit" else f": {returned} = {call}"
        return f"{doc(function.comment, '  ')}  fun {camel(own)}({', '.join(declared)}){body}\n\n"

    def native(self, name, function):
        """The declaration in Kotlin and the definition in C++."""
        kotlin, java, given, (kind, in_java) = [], [], [], self.returned(function)
        for i, item in enumerate(function.parameters[:-1 if fails(function) else None]):
            keeps = item.pointer and not item.callback
            kotlin += [f"a{i}: {number(item)[1]}"] + [f"k{i}: Any?"] * keeps
            java += [f"{number(item)[2]} a{i}"] + ["jobject"] * keeps
            given.append(f"Pointer{{a{i}}}" if item.pointer else f"static_cast<{item.base}>(a{i})")
        if self.by_value(function):
            kotlin, java = kotlin + ["r: Long", "k: Any?"], java + ["jlong r", "jobject"]
        call = f"{name}({', '.join(given + ['&reason'] * fails(function))})"
        body = (f"const char* reason = nullptr;\n  const sandglass_status status = {call};\n  finish(env, native, status, reason)" if fails(function) else f"*static_cast<{function.returns.base}*>(Pointer{{r}}) = {call}"
                if self.by_value(function) else f"return text(env, {call})" if kind == "String?" else call if kind == "Unit" else f"return ({in_java}){call}")
        entry = [f"JNIEnv*{' env' * ('env' in body)}", f"jclass{' native' * fails(function)}", *java]
        return (f"  @JvmStatic external fun {camel(name)}({', '.join(kotlin)}): {kind}\n",
                f"JNIEXPORT {in_java} JNICALL Java_org_sandglass_Native_{camel(name)}({', '.join(entry)}) {{\n  {body};\n}}\n")

    def write(self):
        h, members = self.headers, {name: "" for name in ["", *self.headers.handles]}
        for name, function in h.functions.items():
            first = function.parameters[0] if function.parameters else None
            handle = first.base if first and first.pointers == 1 and first.base in h.handles else ""
            members[handle] += self.function(name, function, handle) * (not name.endswith("_release"))  # which close calls
        out = ["// Generated from the public headers by kotlin.py.\npackage org.sandglass\n\n"]
        out += [f"const val {name} = {value}{'f' if isinstance(value, float) else 'L' if value > 0x7fffffff else ''}\n" for name, value in h.constants.items()]
        out += ["\n", *(self.struct(name, struct) for name, struct in h.structs.items())]
        for name in h.handles:
            kind, native = capital(name), f"Native.{camel(name)}"
            release = f"  override fun release() {{ {native}Release(address, this) }}\n" if f"{name}_release" in h.functions else ""
            if f"{name}_desc" in h.structs:
                out.append(f"/** Made in a block of its own. Fails like {name}_create. */\nclass {kind}(desc: {kind}Desc) : Owned(\"{kind}\", desc,\n"
                           f"  {{ {native}Bytes(desc.address, desc, it.address, it) }},\n  {{ block, bytes, made -> {native}Create(desc.address, desc, "
                           f"block.address, block, bytes, made.address, made) }}) {{\n{members[name]}{release}}}\n\n")
            elif members[name]:
                raise Refused(f"{name} has functions and no {name}_desc")
        natives = [self.native(*both) for both in h.functions.items()]
        out += [f"/** What belongs to no handle. */\nobject Sandglass {{\n{members['']}}}\n\ninternal object Native {{\n  init {{ System.loadLibrary(\"sandglass_jni\") }}\n"
                "  @JvmStatic fun fail(status: Int, sentence: String?) { throw SandglassException(status, sentence) }\n"
                "  @JvmStatic external fun address(bytes: java.nio.ByteBuffer): Long\n",
                *(kotlin for kotlin, _ in natives), "}\n"]
        includes = "".join(f"#include \"sandglass/{name}\"\n" for name in h.names)
        return "".join(out), f"// Generated from the public headers by kotlin.py.\n{includes}#include \"entries.h\"\n\nextern \"C\" {{\n{''.join(cpp for _, cpp in natives)}}}\n"


if __name__ == "__main__":
    try:
        for file, text in zip(sys.argv[2:4], Writer(Headers(sys.argv[1])).write()):
            pathlib.Path(file).write_text(text)
    except Refused as refused:
        sys.exit(f"kotlin.py does not understand a header: {refused}")
