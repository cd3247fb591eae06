// Writes a C file with one claim for every struct's size, every field's offset and size, and every constant of
// Sandglass.cs. The target's C compiler compiles it against the headers. Also lists what is mirrored, which the script
// compares with the headers.
using System;
using System.Reflection;
using System.Runtime.InteropServices;
using Sandglass;

static class Layout {
  static int claims;

  static void Claim(string condition, string what) {
    Console.WriteLine("typedef char claim_{0}[({1}) ? 1 : -1]; /* {2} */", claims++, condition, what);
  }

  static void Main() {
    Console.WriteLine("#include <stddef.h>\n#include \"sandglass/sandglass.h\"\n#include \"sandglass/field.h\"\n#include \"sandglass/pile_shadow.h\"\n#include \"sandglass/shadow.h\"\n#include \"sandglass/light.h\"\n#include \"sandglass/room.h\"");
    foreach (Type type in typeof(Native).Assembly.GetTypes()) {
      if (!type.IsValueType || !type.Name.StartsWith("sandglass_")) continue;
      Console.WriteLine("/* mirrored {0} */", type.Name);
      Claim("sizeof(" + type.Name + ") == " + Marshal.SizeOf(type), "size of " + type.Name);
      foreach (FieldInfo field in type.GetFields(BindingFlags.Instance | BindingFlags.Public)) {
        object[] renamed = field.GetCustomAttributes(typeof(CNameAttribute), false);
        string name = renamed.Length == 0 ? field.Name : ((CNameAttribute)renamed[0]).Name;
        Claim("offsetof(" + type.Name + ", " + name + ") == " + Marshal.OffsetOf(type, field.Name), type.Name + "." + name);
        Claim("sizeof(((" + type.Name + "*)0)->" + name + ") == " + Size(field.FieldType), "size of " + type.Name + "." + name);
      }
    }
    foreach (FieldInfo field in typeof(Native).GetFields(BindingFlags.Static | BindingFlags.Public)) {
      if (field.IsLiteral) Claim(field.Name + " == " + field.GetRawConstantValue(), field.Name);
    }
    foreach (MethodInfo method in typeof(Native).GetMethods(BindingFlags.Static | BindingFlags.Public)) {
      if (method.Name.StartsWith("sandglass_")) Console.WriteLine("/* mirrored {0} */", method.Name);
    }
  }

  // Marshal cannot size a pointer type. A fixed buffer is a struct that the compiler made.
  static int Size(Type type) { return type.IsPointer ? IntPtr.Size : Marshal.SizeOf(type); }
}
