package org.sandglass.sample;

import android.content.Context;
import android.content.res.AssetManager;
import android.view.Surface;

/** The native part, sample.cpp. All but create and destroy are called on the GLSurfaceView's thread. */
final class Native {
  static {
    System.loadLibrary("sample");
  }

  static native long create(Context context);
  static native void destroy(long handle);
  static native boolean resume(long handle);
  static native void pause(long handle);
  static native void surface(long handle, Surface surface, AssetManager assets, int rotation, int width, int height);
  static native void tap(long handle, float x, float y);
  static native void frame(long handle, double seconds);

  private Native() {}
}
