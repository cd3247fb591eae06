// The life of the sample's activity, on the stand-ins: renderer and frames belong to the GL thread from beginning to
// end, no frame draws on a surface that is gone, and everything that was made is destroyed before the activity ends. A
// stand-in for Native records which thread called what. As in the stand-ins, `//// FILE` begins a file.
//// org/sandglass/sample/Native.java
package org.sandglass.sample;
import java.util.concurrent.atomic.AtomicInteger;
final class Native {
  static volatile boolean session, shown, surfaceGone = true, wanted = true;
  static final AtomicInteger shows = new AtomicInteger(), hides = new AtomicInteger(), frames = new AtomicInteger(), taps = new AtomicInteger();
  static volatile String wrong;
  private static void on(String thread, String call) {
    if (!Thread.currentThread().getName().equals(thread)) wrong = call + " on thread " + Thread.currentThread().getName();
    if (!session && !call.equals("create")) wrong = call + " without a session";
  }
  static long create(android.content.Context context) { on("main", "create"); session = true; return 1; }
  static boolean resume(long handle) { on("main", "resume"); return true; }
  static void pause(long handle) { on("main", "pause"); }
  static void surface(long handle, int rotation, int width, int height) { on("gl", "surface"); }
  static int hint(long handle) { on("gl", "hint"); return frames.get() % 4; }
  static boolean show(long handle, android.view.Surface surface, android.content.res.AssetManager assets, int width, int height) {
    on("gl", "show");
    if (shown) wrong = "show while shown";
    if (!wanted) return false;
    shows.incrementAndGet();
    return shown = true;
  }
  static void hide(long handle) {
    on("gl", "hide");
    if (!shown) wrong = "hide of nothing";
    hides.incrementAndGet();
    shown = false;
  }
  static void tap(long handle, float x, float y) { on("gl", "tap"); taps.incrementAndGet(); }
  static void frame(long handle, double seconds) {
    on("gl", "frame");
    if (shown && surfaceGone) wrong = "frame on a surface that has gone";
    frames.incrementAndGet();
  }
  static void destroy(long handle) {
    on("gl", "destroy");
    if (shown) wrong = "destroy while shown";
    session = false;
  }
}
//// org/sandglass/sample/Lives.java
package org.sandglass.sample;
import android.opengl.GLSurfaceView;
import android.view.MotionEvent;
public final class Lives {
  private static void check(boolean holds, String claim) {
    if (Native.wrong != null || !holds) {
      System.err.println(Native.wrong != null ? Native.wrong : "not so: " + claim);
      System.exit(1);
    }
  }
  private static void await(java.util.function.BooleanSupplier holds, String claim) throws InterruptedException {
    for (int i = 0; i < 500 && !holds.getAsBoolean(); ++i) Thread.sleep(10);
    check(holds.getAsBoolean(), claim);
  }
  private static void appear(MainActivity activity) {
    Native.surfaceGone = false;
    activity.surfaceCreated(null);
    activity.surfaceChanged(null, 0, 640, 480);
  }
  private static void disappear(MainActivity activity) {
    activity.surfaceDestroyed(null);
    Native.surfaceGone = true;
    check(!Native.shown, "nothing is shown once surfaceDestroyed has returned");
  }
  // One life, in which the upper surface is made before or after ARCore's session.
  private static void live(boolean surfaceFirst) throws InterruptedException {
    final MainActivity activity = new MainActivity();
    activity.onCreate(null);
    final GLSurfaceView camera = GLSurfaceView.made;
    if (surfaceFirst) appear(activity);
    activity.onResume();
    if (!surfaceFirst) appear(activity);
    await(() -> Native.shown, "sand is shown");
    final int before = Native.frames.get();
    await(() -> Native.frames.get() > before, "frames are drawn");
    final int taps = Native.taps.get();
    camera.touched.onTouch(camera, new MotionEvent());
    await(() -> Native.taps.get() == taps + 1, "a tap arrives");
    activity.onPause();
    disappear(activity);
    activity.onResume();
    Native.wanted = false;  // the system gives no window
    appear(activity);
    final int blind = Native.frames.get();
    await(() -> Native.frames.get() > blind, "frames go on without the upper surface");
    Native.wanted = true;
    await(() -> Native.shown, "sand is shown again");
    final int shows = Native.shows.get();
    activity.surfaceChanged(null, 0, 480, 640);  // turned
    await(() -> Native.shows.get() == shows + 1 && Native.shown, "sand is shown in the other format");
    activity.onPause();
    if (surfaceFirst) disappear(activity);
    activity.onDestroy();
    check(!Native.session && !Native.shown, "all is given back when onDestroy has returned");
    camera.detach();
    if (!surfaceFirst) disappear(activity);  // it must not wait for a thread that has ended
    check(Native.shows.get() == Native.hides.get(), "what is shown is hidden once");
  }
  public static void main(String[] arguments) throws InterruptedException {
    live(true);
    live(false);
    System.out.println(Native.shows.get() + " times shown, " + Native.frames.get() + " frames");
    System.exit(0);
  }
}
