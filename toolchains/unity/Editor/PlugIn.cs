// Says in the editor's console where its plug-in is missing, or is of another version than the binding.
using System;

namespace Sandglass {
public static class PlugIn {
  /// <summary>What is wrong, in one sentence; null where nothing is.</summary>
  public static string Fault() {
    try {
      return Native.VersionFits() ? null : "Sandglass: the plug-in and Sandglass.cs are of different versions: take both from one package.";
    } catch (DllNotFoundException) {
      return "Sandglass: the package has no plug-in for this editor: build sandglass_unity for it, then the target unity_package again.";
    }
  }
  [UnityEditor.InitializeOnLoadMethod]
  static void Tell() { if (Fault() != null) UnityEngine.Debug.LogError(Fault()); }
}
}  // namespace Sandglass
