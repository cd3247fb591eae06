package org.sandglass.sample;

import java.nio.ByteBuffer;

/**
 * The native part, sand.cpp. Call everything on the thread of a GLSurfaceView, whose context must have OpenGL ES 3. A
 * surface that goes away takes the context with it: destroy before, and create again.
 */
public final class Sand {
  static {
    System.loadLibrary("sand");
  }

  /** Makes the scene, and what draws it. Returns its handle, or 0. */
  public static native long create();

  /** Pours onto a point of a real horizontal plane: hitResult.getHitPose().getTranslation(). */
  public static native void pour(long sand, float x, float y, float z);

  /**
   * Hands over the image of Frame.acquireCameraImage(), until the next call of frame, after which it may be closed. Only
   * while camera.getTrackingState() is TRACKING: poses are wrong else.
   *
   * @param planes the three buffers of image.getPlanes(), which are direct
   * @param strides row and pixel stride of each plane
   * @param lens focal length x, y and principal point x, y of camera.getImageIntrinsics()
   * @param pose rotation x, y, z, w and translation of camera.getPose(): that of the image as stored, not the display's
   * @param exposure of the function below
   * @param gains frame.getImageMetadata().getFloatArray(ImageMetadata.COLOR_CORRECTION_GAINS); null where it is missing
   * @return false for an image that the library does not read
   */
  public static native boolean image(long sand, ByteBuffer[] planes, int[] strides, int width, int height, long timestampNs,
                                     float[] lens, float[] pose, float exposure, float[] gains);

  /**
   * Hands over the newest depth of the camera's image, so that what is real hides the shadows behind it. Without it, or
   * where the phone has none, they lie over everything.
   *
   * @param plane the buffer of frame.acquireDepthImage16Bits(), which may be closed afterwards
   * @param corners where the lower left, lower right and upper left corner of the screen lie in it: three pairs of
   *     frame.transformCoordinates2d(OPENGL_NORMALIZED_DEVICE_COORDINATES, ..., TEXTURE_NORMALIZED, ...)
   */
  public static native void depth(long sand, ByteBuffer plane, int rowStride, int width, int height, float[] corners);

  /**
   * Simulates and draws, over the camera's image.
   *
   * @param projection camera.getProjectionMatrix
   * @param view camera.getViewMatrix, which is that of the display
   * @param width and height of the surface, pixels
   * @return true while the phone is hot or busy: then call neither image nor depth, and set Config.DepthMode.DISABLED
   */
  public static native boolean frame(long sand, double seconds, float[] projection, float[] view, int width, int height);

  public static native void destroy(long sand);

  /**
   * How long and how sensitively an image was exposed, from frame.getImageMetadata(): SENSOR_EXPOSURE_TIME,
   * SENSOR_SENSITIVITY and CONTROL_POST_RAW_SENSITIVITY_BOOST (the gain behind the sensor; 100 where the phone does not
   * say). Give 0 to image() where the first two are missing. ARCore sets the exposure itself; an app that opens the
   * camera shared (SHARED_CAMERA) can expose shortly where a clipped lamp hides how bright it is (room.h).
   */
  public static float exposure(long timeNs, int iso, int boost) {
    return 1e-9f * timeNs * iso / 100 * boost / 100;
  }

  private Sand() {}
}
