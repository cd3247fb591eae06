#pragma once
// The functions of ARCore's C API that the sample calls.
#include <stdint.h>
typedef struct ArSession_ ArSession;
typedef struct ArConfig_ ArConfig;
typedef struct ArFrame_ ArFrame;
typedef struct ArCamera_ ArCamera;
typedef struct ArCameraIntrinsics_ ArCameraIntrinsics;
typedef struct ArImage_ ArImage;
typedef struct ArImageMetadata_ ArImageMetadata;
typedef struct ACameraMetadata ACameraMetadata;
typedef struct ArPose_ ArPose;
typedef struct ArHitResult_ ArHitResult;
typedef struct ArHitResultList_ ArHitResultList;
typedef struct ArTrackable_ ArTrackable;
enum ArStatus : int32_t { AR_SUCCESS = 0 };
enum ArUpdateMode : int32_t { AR_UPDATE_MODE_LATEST_CAMERA_IMAGE = 1 };
enum ArTrackingState : int32_t { AR_TRACKING_STATE_TRACKING = 0, AR_TRACKING_STATE_STOPPED = 2 };
enum ArTrackableType : int32_t { AR_TRACKABLE_NOT_VALID = 0, AR_TRACKABLE_PLANE = 0x41520101 };
enum ArCoordinates2dType : int32_t {
  AR_COORDINATES_2D_TEXTURE_NORMALIZED = 1,
  AR_COORDINATES_2D_OPENGL_NORMALIZED_DEVICE_COORDINATES = 6
};
extern "C" {
ArStatus ArSession_create(void* env, void* context, ArSession** session);
void ArSession_destroy(ArSession* session);
ArStatus ArSession_configure(ArSession* session, const ArConfig* config);
ArStatus ArSession_resume(ArSession* session);
ArStatus ArSession_pause(ArSession* session);
ArStatus ArSession_update(ArSession* session, ArFrame* frame);
void ArSession_setCameraTextureName(ArSession* session, uint32_t texture);
void ArSession_setDisplayGeometry(ArSession* session, int32_t rotation, int32_t width, int32_t height);
void ArConfig_create(const ArSession* session, ArConfig** config);
void ArConfig_destroy(ArConfig* config);
void ArConfig_setUpdateMode(const ArSession* session, ArConfig* config, ArUpdateMode mode);
void ArFrame_create(const ArSession* session, ArFrame** frame);
void ArFrame_destroy(ArFrame* frame);
void ArFrame_acquireCamera(const ArSession* session, const ArFrame* frame, ArCamera** camera);
ArStatus ArFrame_acquireCameraImage(ArSession* session, ArFrame* frame, ArImage** image);
void ArFrame_hitTest(const ArSession* session, const ArFrame* frame, float x, float y, ArHitResultList* hits);
void ArFrame_transformCoordinates2d(const ArSession* session, const ArFrame* frame, ArCoordinates2dType from,
                                    int32_t count, const float* input, ArCoordinates2dType to, float* output);
void ArCamera_getTrackingState(const ArSession* session, const ArCamera* camera, ArTrackingState* state);
void ArCamera_getDisplayOrientedPose(const ArSession* session, const ArCamera* camera, ArPose* pose);
void ArCamera_getProjectionMatrix(const ArSession* session, const ArCamera* camera, float near, float far,
                                  float* matrix);
void ArCamera_getPose(const ArSession* session, const ArCamera* camera, ArPose* pose);
void ArCamera_getImageIntrinsics(const ArSession* session, const ArCamera* camera, ArCameraIntrinsics* intrinsics);
void ArCamera_release(ArCamera* camera);
void ArCameraIntrinsics_create(const ArSession* session, ArCameraIntrinsics** intrinsics);
void ArCameraIntrinsics_destroy(ArCameraIntrinsics* intrinsics);
void ArCameraIntrinsics_getFocalLength(const ArSession* session, const ArCameraIntrinsics* intrinsics, float* x,
                                       float* y);
void ArCameraIntrinsics_getPrincipalPoint(const ArSession* session, const ArCameraIntrinsics* intrinsics, float* x,
                                          float* y);
void ArImage_getWidth(const ArSession* session, const ArImage* image, int32_t* width);
void ArImage_getHeight(const ArSession* session, const ArImage* image, int32_t* height);
void ArImage_getTimestamp(const ArSession* session, const ArImage* image, int64_t* ns);
void ArImage_getPlaneData(const ArSession* session, const ArImage* image, int32_t plane, const uint8_t** data,
                          int32_t* length);
void ArImage_getPlaneRowStride(const ArSession* session, const ArImage* image, int32_t plane, int32_t* stride);
void ArImage_getPlanePixelStride(const ArSession* session, const ArImage* image, int32_t plane, int32_t* stride);
void ArImage_release(ArImage* image);
ArStatus ArFrame_acquireImageMetadata(const ArSession* session, const ArFrame* frame, ArImageMetadata** metadata);
void ArImageMetadata_getNdkCameraMetadata(const ArSession* session, const ArImageMetadata* metadata,
                                          const ACameraMetadata** ndk_metadata);
void ArImageMetadata_release(ArImageMetadata* metadata);
void ArPose_create(const ArSession* session, const float* raw, ArPose** pose);
void ArPose_destroy(ArPose* pose);
void ArPose_getPoseRaw(const ArSession* session, const ArPose* pose, float* raw);
void ArPose_getMatrix(const ArSession* session, const ArPose* pose, float* matrix);
void ArHitResultList_create(const ArSession* session, ArHitResultList** hits);
void ArHitResultList_destroy(ArHitResultList* hits);
void ArHitResultList_getSize(const ArSession* session, const ArHitResultList* hits, int32_t* size);
void ArHitResultList_getItem(const ArSession* session, const ArHitResultList* hits, int32_t index, ArHitResult* hit);
void ArHitResult_create(const ArSession* session, ArHitResult** hit);
void ArHitResult_destroy(ArHitResult* hit);
void ArHitResult_getHitPose(const ArSession* session, const ArHitResult* hit, ArPose* pose);
void ArHitResult_acquireTrackable(const ArSession* session, const ArHitResult* hit, ArTrackable** trackable);
void ArTrackable_getType(const ArSession* session, const ArTrackable* trackable, ArTrackableType* type);
void ArTrackable_release(ArTrackable* trackable);
}
