package org.sandglass.sample;

import android.content.Context;
import android.content.res.AssetManager;
import android.view.Surface;

/**
 * The native part, sample.cpp. create, resume and pause are called on the UI thread, while the GL thread draws no frame; all others on
 * the GL thread of the lower surface.
 */
final class Native {
  static {
    System.loadLibrary("sample");
  }

  /** A session of ARCore, or 0. */
  static native long create(Context context);

  static native boolean resume(long handle);

  static native void pause(long handle);

  /** The lower surface has a context, and this size. */
  static native void surface(long handle, AssetManager assets, int rotation, int width, int height);

  /** Filament's engine, on the upper surface; false, and nothing made, where that cannot be. */
  static native boolean show(long handle, Surface surface, AssetManager assets, int width, int height);

  /** The end of what show made. */
  static native void hide(long handle);

  static native void tap(long handle, float x, float y);

  static native void frame(long handle, double seconds);

  /** After hide. */
  static native void destroy(long handle);

  private Native() {}
}
