package org.sandglass.sample;

import android.Manifest;
import android.app.Activity;
import android.content.pm.PackageManager;
import android.graphics.PixelFormat;
import android.opengl.GLSurfaceView;
import android.os.Bundle;
import android.view.MotionEvent;
import android.view.SurfaceHolder;
import android.view.SurfaceView;
import android.widget.FrameLayout;
import android.widget.TextView;
import com.google.ar.core.ArCoreApk;
import com.google.ar.core.exceptions.UnavailableException;
import java.util.concurrent.CountDownLatch;
import javax.microedition.khronos.egl.EGLConfig;
import javax.microedition.khronos.opengles.GL10;

/**
 * Two surfaces: the camera image below, Filament's transparent one above. A tap on a real table pours sand there.
 *
 * <p>Filament's engine belongs to one thread from its creation to its end. This is the GL thread of the lower surface,
 * which serves its queue also while it is paused. The upper surface is made and taken away on the UI thread, which
 * therefore waits until the GL thread has stopped using it.
 */
public final class MainActivity extends Activity implements GLSurfaceView.Renderer, SurfaceHolder.Callback {
  private GLSurfaceView camera;
  private SurfaceView sand;
  private volatile long sample;  // 0 before ARCore has a session, and at the end
  // The fields below are used by the GL thread alone: the size of the lower surface and whether the sample knows it,
  // the size of the upper one (0 while there is none) and whether Filament draws on it.
  private int cameraWidth, cameraHeight;
  private boolean begun;
  private int width, height;
  private boolean shown;
  // What the user is asked for, so that the camera sees where the light comes from.
  private static final String[] HINTS = {"", "Look around: to the left", "Look around: to the right", "Look up"};
  private int hint;
  private TextView text;

  @Override
  protected void onCreate(Bundle saved) {
    super.onCreate(saved);
    camera = new GLSurfaceView(this);
    camera.setEGLContextClientVersion(3);
    camera.setPreserveEGLContextOnPause(true);
    camera.setRenderer(this);
    camera.setOnTouchListener((view, event) -> {
      if (event.getAction() == MotionEvent.ACTION_UP) {
        final float x = event.getX(), y = event.getY();
        camera.queueEvent(() -> {
          if (sample != 0) Native.tap(sample, x, y);
        });
      }
      return true;
    });
    sand = new SurfaceView(this);
    sand.setZOrderMediaOverlay(true);
    sand.getHolder().setFormat(PixelFormat.TRANSLUCENT);
    sand.getHolder().addCallback(this);
    FrameLayout both = new FrameLayout(this);
    both.addView(camera);
    both.addView(sand);
    text = new TextView(this);
    both.addView(text);
    setContentView(both);
  }

  @Override
  protected void onResume() {
    super.onResume();
    if (checkSelfPermission(Manifest.permission.CAMERA) != PackageManager.PERMISSION_GRANTED) {
      requestPermissions(new String[] {Manifest.permission.CAMERA}, 0);
      return;  // the system calls onResume again
    }
    try {
      if (ArCoreApk.getInstance().requestInstall(this, sample == 0) == ArCoreApk.InstallStatus.INSTALL_REQUESTED) return;
    } catch (UnavailableException e) {
      throw new IllegalStateException("This device has no ARCore.", e);
    }
    if (sample == 0) sample = Native.create(this);
    if (sample == 0 || !Native.resume(sample)) throw new IllegalStateException("ARCore could not start a session.");
    camera.onResume();
  }

  @Override
  protected void onPause() {
    super.onPause();
    camera.onPause();  // returns when no frame runs
    if (sample != 0) Native.pause(sample);
  }

  @Override
  protected void onDestroy() {
    if (sample != 0) {
      onGlThread(() -> {
        hide();
        Native.destroy(sample);
        sample = 0;
      });
    }
    super.onDestroy();  // after this the view ends, and the GL thread with it
  }

  /** Runs on the GL thread and waits until it has run. */
  private void onGlThread(Runnable work) {
    final CountDownLatch done = new CountDownLatch(1);
    camera.queueEvent(() -> {
      work.run();
      done.countDown();
    });
    try {
      done.await();
    } catch (InterruptedException e) {
      Thread.currentThread().interrupt();
    }
  }

  // The upper surface, on the UI thread.

  @Override
  public void surfaceCreated(SurfaceHolder holder) {}

  @Override
  public void surfaceChanged(SurfaceHolder holder, int format, int newWidth, int newHeight) {
    camera.queueEvent(() -> {
      hide();
      width = newWidth;
      height = newHeight;
    });
  }

  @Override
  public void surfaceDestroyed(SurfaceHolder holder) {
    if (sample == 0) return;  // nothing draws on the surface, and after onDestroy there is no GL thread to wait for
    onGlThread(() -> {
      hide();
      width = height = 0;
    });
  }

  // On the GL thread.

  private void hide() {
    if (shown) Native.hide(sample);
    shown = false;
  }

  @Override
  public void onSurfaceCreated(GL10 gl, EGLConfig config) {}

  @Override
  public void onSurfaceChanged(GL10 gl, int newWidth, int newHeight) {
    cameraWidth = newWidth;
    cameraHeight = newHeight;
    begun = false;
  }

  /** Session and surfaces are made in any order. Whatever is there by now is set up before the frame. */
  @Override
  public void onDrawFrame(GL10 gl) {
    if (sample == 0) return;
    if (!begun) Native.surface(sample, getWindowManager().getDefaultDisplay().getRotation(), cameraWidth, cameraHeight);
    begun = true;
    if (!shown && width > 0) shown = Native.show(sample, sand.getHolder().getSurface(), getAssets(), width, height);
    Native.frame(sample, 1e-9 * System.nanoTime());
    final int next = Native.hint(sample);
    if (next != hint) runOnUiThread(() -> text.setText(HINTS[next]));
    hint = next;
  }
}
