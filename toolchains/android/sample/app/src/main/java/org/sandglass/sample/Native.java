package org.sandglass.sample;

import android.content.Context;
import android.content.res.AssetManager;
import android.view.Surface;

/**
 * The native part, sample.cpp. create, resume and pause are called on the UI thread while the GL thread draws no frame.
 * All others are called on the GL thread of the lower surface.
 */
final class Native {
  static {
    System.loadLibrary("sample");
  }

  /** Makes a session of ARCore. Returns its handle, or 0. */
  static native long create(Context context);

  static native boolean resume(long handle);

  static native void pause(long handle);

  /** Tells that the lower surface has a context and this size. */
  static native void surface(long handle, int rotation, int width, int height);

  /** Makes Filament's engine on the upper surface. Returns false and makes nothing if that is not possible. */
  static native boolean show(long handle, Surface surface, AssetManager assets, int width, int height);

  /** Destroys what show made. */
  static native void hide(long handle);

  static native void tap(long handle, float x, float y);

  static native void frame(long handle, double seconds);

  /** Which way to turn the phone, so that it sees more of the room's light: 0 none, 1 left, 2 right, 3 up. */
  static native int hint(long handle);

  /** Call hide first. */
  static native void destroy(long handle);

  private Native() {}
}
