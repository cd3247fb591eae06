// The part of Android's and ARCore's interfaces that the sample's Java uses. Each line `//// FILE` begins a file of its
// own; samples.sh writes the files for javac. Like the real one, GLSurfaceView has a thread that serves its queue also
// while it is paused, and that ends when the view is detached. Views and surfaces do nothing.
//// android/Manifest.java
package android;
public final class Manifest {
  public static final class permission { public static final String CAMERA = "camera"; }
}
//// android/app/Activity.java
package android.app;
public class Activity extends android.content.Context {
  protected void onCreate(android.os.Bundle saved) {}
  protected void onResume() {}
  protected void onPause() {}
  protected void onDestroy() {}
  public void setContentView(android.view.View view) {}
  public void runOnUiThread(Runnable work) { work.run(); }
  public int checkSelfPermission(String permission) { return android.content.pm.PackageManager.PERMISSION_GRANTED; }
  public void requestPermissions(String[] permissions, int code) {}
  public android.view.WindowManager getWindowManager() { return () -> new android.view.Display(); }
  public android.content.res.AssetManager getAssets() { return new android.content.res.AssetManager(); }
}
//// android/content/Context.java
package android.content;
public class Context {}
//// android/content/pm/PackageManager.java
package android.content.pm;
public class PackageManager { public static final int PERMISSION_GRANTED = 0; }
//// android/content/res/AssetManager.java
package android.content.res;
public final class AssetManager {}
//// android/graphics/PixelFormat.java
package android.graphics;
public class PixelFormat { public static final int TRANSLUCENT = -3; }
//// android/os/Bundle.java
package android.os;
public final class Bundle {}
//// android/view/Display.java
package android.view;
public final class Display { public int getRotation() { return 0; } }
//// android/view/WindowManager.java
package android.view;
public interface WindowManager { Display getDefaultDisplay(); }
//// android/view/MotionEvent.java
package android.view;
public final class MotionEvent {
  public static final int ACTION_UP = 1;
  public int getAction() { return ACTION_UP; }
  public float getX() { return 10; }
  public float getY() { return 20; }
}
//// android/view/View.java
package android.view;
public class View {
  public interface OnTouchListener { boolean onTouch(View view, MotionEvent event); }
  public OnTouchListener touched;
  public void setOnTouchListener(OnTouchListener listener) { touched = listener; }
}
//// android/view/Surface.java
package android.view;
public class Surface {}
//// android/view/SurfaceHolder.java
package android.view;
public interface SurfaceHolder {
  interface Callback {
    void surfaceCreated(SurfaceHolder holder);
    void surfaceChanged(SurfaceHolder holder, int format, int width, int height);
    void surfaceDestroyed(SurfaceHolder holder);
  }
  void addCallback(Callback callback);
  void setFormat(int format);
  Surface getSurface();
}
//// android/view/SurfaceView.java
package android.view;
public class SurfaceView extends View {
  public SurfaceView(android.content.Context context) {}
  public void setZOrderMediaOverlay(boolean on) {}
  public SurfaceHolder getHolder() {
    return new SurfaceHolder() {
      @Override public void addCallback(Callback callback) {}
      @Override public void setFormat(int format) {}
      @Override public Surface getSurface() { return new Surface(); }
    };
  }
}
//// android/widget/FrameLayout.java
package android.widget;
public class FrameLayout extends android.view.View {
  public FrameLayout(android.content.Context context) {}
  public void addView(android.view.View view) {}
}
//// android/widget/TextView.java
package android.widget;
public class TextView extends android.view.View {
  public TextView(android.content.Context context) {}
  public void setText(CharSequence text) {}
}
//// android/opengl/GLSurfaceView.java
package android.opengl;
import java.util.ArrayDeque;
import javax.microedition.khronos.egl.EGLConfig;
import javax.microedition.khronos.opengles.GL10;
public class GLSurfaceView extends android.view.SurfaceView {
  public interface Renderer {
    void onSurfaceCreated(GL10 gl, EGLConfig config);
    void onSurfaceChanged(GL10 gl, int width, int height);
    void onDrawFrame(GL10 gl);
  }
  public static GLSurfaceView made;
  public Thread thread;
  private final ArrayDeque<Runnable> queue = new ArrayDeque<>();
  private boolean paused, drawing, detached, sized;
  private Renderer renderer;
  public GLSurfaceView(android.content.Context context) { super(context); made = this; }
  public void setEGLContextClientVersion(int version) {}
  public void setPreserveEGLContextOnPause(boolean preserve) {}
  public void setRenderer(Renderer r) {
    renderer = r;
    thread = new Thread(this::run, "gl");
    thread.start();
  }
  public synchronized void queueEvent(Runnable event) { queue.add(event); notifyAll(); }
  public synchronized void onPause() {
    paused = true;
    while (drawing) waitQuietly();
    sized = false;
  }
  public synchronized void onResume() { paused = false; notifyAll(); }
  public void detach() throws InterruptedException {
    synchronized (this) { detached = true; notifyAll(); }
    thread.join();
  }
  private synchronized void waitQuietly() {
    try { wait(20); } catch (InterruptedException e) { Thread.currentThread().interrupt(); }
  }
  private void run() {
    renderer.onSurfaceCreated(null, null);
    for (;;) {
      Runnable event;
      boolean size = false;
      synchronized (this) {
        if (detached) return;
        event = queue.poll();
        if (event == null && paused) { waitQuietly(); continue; }
        if (event == null) { drawing = true; size = !sized; sized = true; }
      }
      if (event != null) { event.run(); continue; }
      if (size) renderer.onSurfaceChanged(null, 640, 480);
      renderer.onDrawFrame(null);
      synchronized (this) { drawing = false; notifyAll(); }
    }
  }
}
//// javax/microedition/khronos/egl/EGLConfig.java
package javax.microedition.khronos.egl;
public class EGLConfig {}
//// javax/microedition/khronos/opengles/GL10.java
package javax.microedition.khronos.opengles;
public interface GL10 {}
//// com/google/ar/core/exceptions/UnavailableException.java
package com.google.ar.core.exceptions;
public class UnavailableException extends Exception {}
//// com/google/ar/core/ArCoreApk.java
package com.google.ar.core;
public class ArCoreApk {
  public enum InstallStatus { INSTALLED, INSTALL_REQUESTED }
  public static ArCoreApk getInstance() { return new ArCoreApk(); }
  public InstallStatus requestInstall(android.app.Activity activity, boolean ask)
      throws com.google.ar.core.exceptions.UnavailableException {
    return InstallStatus.INSTALLED;
  }
}
