// Sand on the real floor.
//
// Threads: the GL thread of the lower surface runs the frames and every call of the renderer, so Filament's engine
// belongs to it. The UI thread makes, resumes and pauses the session while no frame runs.
//
// A frame: ARCore updates the camera image and the poses. In 4 ms the library writes the grains straight into the
// renderer's buffer, gathers the room's light from the image, and casts the sand's shadows in that light. Filament
// draws grains and shadows with the same pose.
#include <android/asset_manager_jni.h>
#include <android/log.h>
#include <android/native_window_jni.h>
#include <camera/NdkCameraMetadata.h>
#include <jni.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include "arcore_c_api.h"
#include "camera_background.h"
#include "camera_planes.h"
#include "performance.h"
#include "sand_stage.h"
#include "sand_view.h"

namespace {

struct Sample {
  ArSession* session = nullptr;
  ArFrame* frame = nullptr;
  sample::SandStage stage;
  sample::SandView view;
  sample::CameraBackground background;
  std::unique_ptr<sample::Performance> performance;
  ANativeWindow* window = nullptr;
  double last_seconds = 0.0;
  bool poured = false;
  int hint = 0;  // of Native.hint
};

Sample* of(jlong handle) { return reinterpret_cast<Sample*>(handle); }

void say(const sandglass::Status& status) {
  if (!status) __android_log_print(ANDROID_LOG_ERROR, "sandglass", "%s: %s", status.name(), status.reason);
}

// Reads a whole file of the app's assets into 8-byte words. Empty if there is no such file.
std::vector<uint64_t> read_asset(AAssetManager* manager, const char* name, uint64_t* bytes) {
  std::vector<uint64_t> words;
  AAsset* asset = AAssetManager_open(manager, name, AASSET_MODE_BUFFER);
  if (asset == nullptr) return words;
  *bytes = static_cast<uint64_t>(AAsset_getLength64(asset));
  const void* data = AAsset_getBuffer(asset);
  if (data != nullptr) {
    words.resize((*bytes + 7) / 8);
    std::memcpy(words.data(), data, *bytes);
  }
  AAsset_close(asset);
  return words;
}

// How long and how sensitively the image was exposed, as sandglass_camera_image.exposure wants it: seconds times ISO /
// 100, times the gain behind the sensor. 0 where the phone does not say.
float exposure_of(Sample* s) {
  ArImageMetadata* held = nullptr;
  if (ArFrame_acquireImageMetadata(s->session, s->frame, &held) != AR_SUCCESS) return 0.0f;
  const ACameraMetadata* metadata = nullptr;
  ArImageMetadata_getNdkCameraMetadata(s->session, held, &metadata);
  ACameraMetadata_const_entry time = {}, iso = {}, boost = {};
  float exposure = 0.0f;
  if (ACameraMetadata_getConstEntry(metadata, ACAMERA_SENSOR_EXPOSURE_TIME, &time) == ACAMERA_OK && time.count == 1 &&
      ACameraMetadata_getConstEntry(metadata, ACAMERA_SENSOR_SENSITIVITY, &iso) == ACAMERA_OK && iso.count == 1)
    exposure = 1e-9f * static_cast<float>(time.data.i64[0]) * static_cast<float>(iso.data.i32[0]) / 100.0f;
  if (ACameraMetadata_getConstEntry(metadata, ACAMERA_CONTROL_POST_RAW_SENSITIVITY_BOOST, &boost) == ACAMERA_OK &&
      boost.count == 1)
    exposure *= static_cast<float>(boost.data.i32[0]) / 100.0f;
  ArImageMetadata_release(held);
  return exposure;
}

// The camera's image of this frame as the library reads it. False if ARCore has none yet or has it in another layout.
// If true, *held must be released after the frame.
bool camera_image(Sample* s, ArCamera* camera, ArImage** held, sandglass_camera_image* image) {
  if (ArFrame_acquireCameraImage(s->session, s->frame, held) != AR_SUCCESS) return false;
  const uint8_t* planes[3] = {};
  int32_t rows[3] = {}, pixels[3] = {}, length = 0, width = 0, height = 0;
  for (int32_t i = 0; i < 3; ++i) {
    ArImage_getPlaneData(s->session, *held, i, &planes[i], &length);
    ArImage_getPlaneRowStride(s->session, *held, i, &rows[i]);
    ArImage_getPlanePixelStride(s->session, *held, i, &pixels[i]);
  }
  ArImage_getWidth(s->session, *held, &width);
  ArImage_getHeight(s->session, *held, &height);
  int64_t taken_ns = 0;
  ArImage_getTimestamp(s->session, *held, &taken_ns);
  *image = sandglass::camera_image();
  image->width = static_cast<uint32_t>(width), image->height = static_cast<uint32_t>(height);
  image->timestamp_ns = static_cast<uint64_t>(taken_ns);

  ArCameraIntrinsics* intrinsics = nullptr;
  ArCameraIntrinsics_create(s->session, &intrinsics);
  ArCamera_getImageIntrinsics(s->session, camera, intrinsics);
  ArCameraIntrinsics_getFocalLength(s->session, intrinsics, &image->focal_x, &image->focal_y);
  ArCameraIntrinsics_getPrincipalPoint(s->session, intrinsics, &image->centre_x, &image->centre_y);
  ArCameraIntrinsics_destroy(intrinsics);

  ArPose* pose = nullptr;  // the pose of the image as stored, in landscape: the library finds which way is up
  float raw[7];
  ArPose_create(s->session, nullptr, &pose);
  ArCamera_getPose(s->session, camera, pose);
  ArPose_getPoseRaw(s->session, pose, raw);
  ArPose_destroy(pose);
  for (int k = 0; k < 4; ++k) image->orientation[k] = raw[k];
  for (int k = 0; k < 3; ++k) image->position[k] = raw[4 + k];
  image->exposure = exposure_of(s);
  image->turn_deg = SANDGLASS_TURN_FROM_POSE;

  if (sample::set_yuv_planes(planes, rows, pixels, image)) return true;
  ArImage_release(*held);
  return false;
}

// Which way the user should turn the phone to show the library most: 0 none, 1 left, 2 right, 3 up. `to_world` is the
// pose of the upright image.
int hint_of(const float* look, const float to_world[16]) {
  if (look == nullptr) return 0;
  float right = 0.0f, up = 0.0f;
  for (int k = 0; k < 3; ++k) right += look[k] * to_world[k], up += look[k] * to_world[4 + k];
  return up > std::fabs(right) ? 3 : right > 0.0f ? 2 : 1;
}

// The first real horizontal plane under a point of the screen.
bool hit_plane(Sample* s, float x, float y, float point[3]) {
  ArHitResultList* hits = nullptr;
  ArHitResultList_create(s->session, &hits);
  ArFrame_hitTest(s->session, s->frame, x, y, hits);
  int32_t count = 0;
  ArHitResultList_getSize(s->session, hits, &count);
  bool found = false;
  for (int32_t i = 0; i < count && !found; ++i) {
    ArHitResult* hit = nullptr;
    ArHitResult_create(s->session, &hit);
    ArHitResultList_getItem(s->session, hits, i, hit);
    ArTrackable* trackable = nullptr;
    ArHitResult_acquireTrackable(s->session, hit, &trackable);
    ArTrackableType type = AR_TRACKABLE_NOT_VALID;
    ArTrackable_getType(s->session, trackable, &type);
    if (type == AR_TRACKABLE_PLANE) {
      ArPose* pose = nullptr;
      float raw[7];
      ArPose_create(s->session, nullptr, &pose);
      ArHitResult_getHitPose(s->session, hit, pose);
      ArPose_getPoseRaw(s->session, pose, raw);  // quaternion x y z w, then position
      ArPose_destroy(pose);
      for (int k = 0; k < 3; ++k) point[k] = raw[4 + k];
      found = true;
    }
    ArTrackable_release(trackable);
    ArHitResult_destroy(hit);
  }
  ArHitResultList_destroy(hits);
  return found;
}

}  // namespace

extern "C" {

JNIEXPORT jlong JNICALL Java_org_sandglass_sample_Native_create(JNIEnv* env, jclass, jobject context) {
  auto* s = new Sample;
  if (ArSession_create(env, context, &s->session) != AR_SUCCESS) {
    delete s;
    return 0;
  }
  ArConfig* config = nullptr;
  ArConfig_create(s->session, &config);
  ArConfig_setUpdateMode(s->session, config, AR_UPDATE_MODE_LATEST_CAMERA_IMAGE);
  const ArStatus configured = ArSession_configure(s->session, config);
  ArConfig_destroy(config);
  if (configured != AR_SUCCESS) {
    ArSession_destroy(s->session);
    delete s;
    return 0;
  }
  ArFrame_create(s->session, &s->frame);
  return reinterpret_cast<jlong>(s);
}

JNIEXPORT jboolean JNICALL Java_org_sandglass_sample_Native_resume(JNIEnv*, jclass, jlong handle) {
  return ArSession_resume(of(handle)->session) == AR_SUCCESS;
}

JNIEXPORT void JNICALL Java_org_sandglass_sample_Native_pause(JNIEnv*, jclass, jlong handle) {
  ArSession_pause(of(handle)->session);
}

// Needs the GL thread's context to be current.
JNIEXPORT void JNICALL Java_org_sandglass_sample_Native_surface(JNIEnv*, jclass, jlong handle, jint rotation,
                                                                jint width, jint height) {
  Sample* s = of(handle);
  ArSession_setCameraTextureName(s->session, s->background.create());
  ArSession_setDisplayGeometry(s->session, rotation, width, height);
  if (!s->stage) say(s->stage.create());
  if (s->performance == nullptr) s->performance = std::make_unique<sample::Performance>(16'666'667);
}

JNIEXPORT jboolean JNICALL Java_org_sandglass_sample_Native_show(JNIEnv* env, jclass, jlong handle, jobject surface,
                                                                 jobject assets, jint width, jint height) {
  Sample* s = of(handle);
  AAssetManager* files = AAssetManager_fromJava(env, assets);
  uint64_t grain_bytes = 0, shadow_bytes = 0;
  const std::vector<uint64_t> grain = read_asset(files, "grain.filamat", &grain_bytes),
                              shadow = read_asset(files, "shadow.filamat", &shadow_bytes);
  if (grain.empty() || shadow.empty()) return JNI_FALSE;
  s->window = ANativeWindow_fromSurface(env, surface);
  if (s->window == nullptr) return JNI_FALSE;  // the surface is gone already
  if (!s->view.create(s->window, static_cast<uint32_t>(width), static_cast<uint32_t>(height), grain.data(), grain_bytes,
                      shadow.data(), shadow_bytes)) {
    ANativeWindow_release(s->window);
    s->window = nullptr;
    return JNI_FALSE;
  }
  return JNI_TRUE;
}

JNIEXPORT void JNICALL Java_org_sandglass_sample_Native_hide(JNIEnv*, jclass, jlong handle) {
  Sample* s = of(handle);
  s->view.destroy();
  ANativeWindow_release(s->window);
  s->window = nullptr;
}

JNIEXPORT void JNICALL Java_org_sandglass_sample_Native_destroy(JNIEnv*, jclass, jlong handle) {
  Sample* s = of(handle);
  ArFrame_destroy(s->frame);
  ArSession_destroy(s->session);
  delete s;
}

JNIEXPORT void JNICALL Java_org_sandglass_sample_Native_tap(JNIEnv*, jclass, jlong handle, jfloat x, jfloat y) {
  Sample* s = of(handle);
  float point[3];
  if (!s->stage || !hit_plane(s, x, y, point)) return;
  const sandglass::Status status = s->stage.pour(point);
  say(status);
  s->poured = static_cast<bool>(status);
}

JNIEXPORT jint JNICALL Java_org_sandglass_sample_Native_hint(JNIEnv*, jclass, jlong handle) { return of(handle)->hint; }

JNIEXPORT void JNICALL Java_org_sandglass_sample_Native_frame(JNIEnv*, jclass, jlong handle, jdouble seconds) {
  Sample* s = of(handle);
  if (s->performance == nullptr || ArSession_update(s->session, s->frame) != AR_SUCCESS) return;
  s->background.draw(s->session, s->frame);
  if (!s->stage || !s->view.shown()) return;
  ArCamera* camera = nullptr;
  ArFrame_acquireCamera(s->session, s->frame, &camera);
  ArTrackingState tracking = AR_TRACKING_STATE_STOPPED;
  ArCamera_getTrackingState(s->session, camera, &tracking);
  if (tracking == AR_TRACKING_STATE_TRACKING) {
    const float step = s->last_seconds > 0.0 ? static_cast<float>(seconds - s->last_seconds) : 0.0f;
    sandglass_grain* grains = s->poured ? s->view.buffer() : nullptr;  // null: simulated too, and drawn next time
    ArImage* held = nullptr;
    sandglass_camera_image image;
    const bool seen = camera_image(s, camera, &held, &image);
    const sandglass_frame_report report =
        s->stage.frame(step, s->performance->headroom(seconds), grains, seen ? &image : nullptr);
    if (seen) ArImage_release(held);
    s->performance->report(report.target_ns, report.elapsed_ns);
    s->view.set_light(s->stage.light(), s->stage.light_scale());
    s->view.set_shadow(s->stage.shadow(), s->stage.sky(), s->stage.shadow_strength());
    float projection[16], camera_to_world[16];
    ArCamera_getProjectionMatrix(s->session, camera, sample::SandView::k_near, sample::SandView::k_far, projection);
    ArPose* pose = nullptr;
    ArPose_create(s->session, nullptr, &pose);
    ArCamera_getDisplayOrientedPose(s->session, camera, pose);
    ArPose_getMatrix(s->session, pose, camera_to_world);
    ArPose_destroy(pose);
    s->hint = hint_of(s->stage.look(), camera_to_world);
    s->view.draw(grains != nullptr, s->stage.drawn(), s->stage.origin(), projection, camera_to_world);
    s->last_seconds = seconds;
  }
  ArCamera_release(camera);
}

}  // extern "C"
