package org.sandglass.sample;

import android.Manifest;
import android.app.Activity;
import android.content.pm.PackageManager;
import android.graphics.PixelFormat;
import android.opengl.GLSurfaceView;
import android.os.Bundle;
import android.view.MotionEvent;
import android.view.SurfaceView;
import android.widget.FrameLayout;
import com.google.ar.core.ArCoreApk;
import com.google.ar.core.exceptions.UnavailableException;
import javax.microedition.khronos.egl.EGLConfig;
import javax.microedition.khronos.opengles.GL10;

/** Two surfaces: the camera image below, Filament's transparent one above. A tap on a real table pours sand there. */
public final class MainActivity extends Activity implements GLSurfaceView.Renderer {
  private GLSurfaceView camera;
  private SurfaceView sand;
  private long sample;

  @Override
  protected void onCreate(Bundle saved) {
    super.onCreate(saved);
    camera = new GLSurfaceView(this);
    camera.setEGLContextClientVersion(3);
    camera.setPreserveEGLContextOnPause(true);
    camera.setRenderer(this);
    camera.setOnTouchListener((view, event) -> {
      if (event.getAction() == MotionEvent.ACTION_UP && sample != 0) {
        final float x = event.getX(), y = event.getY();
        camera.queueEvent(() -> Native.tap(sample, x, y));
      }
      return true;
    });
    sand = new SurfaceView(this);
    sand.setZOrderMediaOverlay(true);
    sand.getHolder().setFormat(PixelFormat.TRANSLUCENT);
    FrameLayout both = new FrameLayout(this);
    both.addView(camera);
    both.addView(sand);
    setContentView(both);
  }

  @Override
  protected void onResume() {
    super.onResume();
    if (checkSelfPermission(Manifest.permission.CAMERA) != PackageManager.PERMISSION_GRANTED) {
      requestPermissions(new String[] {Manifest.permission.CAMERA}, 0);
      return;  // comes back here
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
    camera.onPause();
    if (sample != 0) Native.pause(sample);
  }

  @Override
  protected void onDestroy() {
    if (sample != 0) Native.destroy(sample);
    sample = 0;
    super.onDestroy();
  }

  @Override
  public void onSurfaceCreated(GL10 gl, EGLConfig config) {}

  @Override
  public void onSurfaceChanged(GL10 gl, int width, int height) {
    final int rotation = getWindowManager().getDefaultDisplay().getRotation();
    if (sample != 0) Native.surface(sample, sand.getHolder().getSurface(), getAssets(), rotation, width, height);
  }

  @Override
  public void onDrawFrame(GL10 gl) {
    if (sample != 0) Native.frame(sample, 1e-9 * System.nanoTime());
  }
}
