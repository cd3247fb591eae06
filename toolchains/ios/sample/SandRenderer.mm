// Once for every displayed frame, in 4 ms, the library writes the grains straight into a shared Metal buffer, and
// gathers the room's light from ARKit's image. The shadows of the sand, and of what else stands there, darken the table.
// Build it optimised in debug builds too: kernels without optimisation miss every budget.
#import "SandRenderer.h"

#include <string.h>

#include <atomic>

#include "sand.h"
#include "shader_types.h"

// The share of the budget that the device can sustain, from the four states that iOS tells.
static float thermal_headroom(void) {
  const NSProcessInfoThermalState heat = NSProcessInfo.processInfo.thermalState;
  return heat <= NSProcessInfoThermalStateFair ? 1.0f : heat == NSProcessInfoThermalStateSerious ? 0.5f : 0.25f;
}

// How long and how sensitively an image was exposed, as sandglass_camera_image.exposure wants it: seconds times ISO /
// 100. 0 before iOS 16, which does not tell the ISO; exposureOffset is no gain but how far the camera is from the
// brightness that it aims at. From iOS 16 on an app can expose shortly by configurableCaptureDeviceForPrimaryCamera.
static float exposure_of(ARFrame *frame) {
  if (@available(iOS 16.0, *)) {
    NSNumber *time = frame.exifData[@"ExposureTime"];
    NSArray<NSNumber *> *iso = frame.exifData[@"ISOSpeedRatings"];
    return iso.firstObject == nil ? 0.0f : time.floatValue * iso.firstObject.floatValue / 100.0f;
  }
  return 0.0f;
}

// The camera's image as the library reads it, valid while the pixel buffer is locked. It has two planes and is stored
// in landscape; the library finds from the pose which way is up.
static sandglass_camera_image camera_image(ARFrame *frame) {
  CVPixelBufferRef pixels = frame.capturedImage;
  sandglass_camera_image image = sandglass::camera_image();
  image.format = SANDGLASS_CAMERA_NV12;
  CFTypeRef matrix = CVBufferCopyAttachment(pixels, kCVImageBufferYCbCrMatrixKey, NULL);
  if (matrix != NULL) {
    if (CFEqual(matrix, kCVImageBufferYCbCrMatrix_ITU_R_709_2)) image.range = SANDGLASS_YUV_FULL_709;
    CFRelease(matrix);
  }
  image.width = static_cast<uint32_t>(CVPixelBufferGetWidthOfPlane(pixels, 0));
  image.height = static_cast<uint32_t>(CVPixelBufferGetHeightOfPlane(pixels, 0));
  for (size_t plane = 0; plane < 2; ++plane) {
    image.planes[plane] = static_cast<const uint8_t *>(CVPixelBufferGetBaseAddressOfPlane(pixels, plane));
    image.strides[plane] = static_cast<int32_t>(CVPixelBufferGetBytesPerRowOfPlane(pixels, plane));
  }
  const simd_float3x3 intrinsics = frame.camera.intrinsics;
  image.focal_x = intrinsics.columns[0].x;
  image.focal_y = intrinsics.columns[1].y;
  image.centre_x = intrinsics.columns[2].x;
  image.centre_y = intrinsics.columns[2].y;
  float matrix_to_world[16];
  const simd_float4x4 transform = frame.camera.transform;
  memcpy(matrix_to_world, &transform, sizeof matrix_to_world);
  sandglass_camera_orientation(matrix_to_world, image.orientation);
  for (int k = 0; k < 3; ++k) image.position[k] = matrix_to_world[12 + k];
  image.exposure = exposure_of(frame);
  if (@available(iOS 16.0, *)) {
    AVCaptureDevice *camera = [ARWorldTrackingConfiguration configurableCaptureDeviceForPrimaryCamera];
    const AVCaptureWhiteBalanceGains gains = camera.deviceWhiteBalanceGains;  // 0 where there is no such camera
    image.gains[0] = gains.redGain;
    image.gains[1] = gains.greenGain;
    image.gains[2] = gains.blueGain;
  }
  image.timestamp_ns = static_cast<uint64_t>(1e9 * frame.timestamp);
  return image;
}

// The GPU may still read the one before, which its commands hold.
static id<MTLTexture> new_texture(id<MTLDevice> device, MTLPixelFormat format, size_t width, size_t height, const void *bytes, size_t row) {
  MTLTextureDescriptor *descriptor = [MTLTextureDescriptor texture2DDescriptorWithPixelFormat:format width:width height:height mipmapped:NO];
  id<MTLTexture> texture = [device newTextureWithDescriptor:descriptor];
  [texture replaceRegion:MTLRegionMake2D(0, 0, width, height) mipmapLevel:0 withBytes:bytes bytesPerRow:row];
  return texture;
}

static simd_float4 vector(const float v[3]) { return simd_make_float4(v[0], v[1], v[2], 0); }

@implementation SandRenderer {
  sample::Sand _sand;
  id<MTLRenderPipelineState> _pipeline, _table;
  id<MTLBuffer> _grains[sample::k_buffers];
  id<MTLTexture> _textures[5];  // those of Shaders.metal; the last is the depth
  uint64_t _versions[4];
  dispatch_semaphore_t _free;
  std::atomic<bool> _heatChanged;
  float _headroom;
  NSTimeInterval _last;
}

// The view's attachment encodes: MTLPixelFormatBGRA8Unorm_sRGB. It has a depth buffer, and less than before passes.
- (instancetype)initWithView:(MTKView *)view {
  if (!(self = [super init])) return nil;
  _headroom = thermal_headroom();  // before it is observed, as the notification wants it
  [NSNotificationCenter.defaultCenter addObserver:self selector:@selector(heatChanged:) name:NSProcessInfoThermalStateDidChangeNotification object:nil];
  _heatChanged = true;  // it may have, in between
  if (!_sand.create(_headroom)) return nil;  // the status has the reason: log it
  id<MTLLibrary> library = [view.device newDefaultLibrary];
  MTLRenderPipelineDescriptor *descriptor = [[MTLRenderPipelineDescriptor alloc] init];
  descriptor.vertexFunction = [library newFunctionWithName:@"grain_vertex"];
  descriptor.fragmentFunction = [library newFunctionWithName:@"grain_fragment"];
  descriptor.colorAttachments[0].pixelFormat = view.colorPixelFormat;
  descriptor.depthAttachmentPixelFormat = view.depthStencilPixelFormat;
  _pipeline = [view.device newRenderPipelineStateWithDescriptor:descriptor error:NULL];
  descriptor.vertexFunction = [library newFunctionWithName:@"table_vertex"];
  descriptor.fragmentFunction = [library newFunctionWithName:@"table_fragment"];
  descriptor.colorAttachments[0].blendingEnabled = YES;
  descriptor.colorAttachments[0].sourceRGBBlendFactor = MTLBlendFactorSourceAlpha;
  descriptor.colorAttachments[0].destinationRGBBlendFactor = MTLBlendFactorOneMinusSourceAlpha;
  _table = [view.device newRenderPipelineStateWithDescriptor:descriptor error:NULL];
  for (uint32_t i = 0; i < sample::k_buffers; ++i)
    _grains[i] = [view.device newBufferWithLength:sample::k_grains * sizeof(sandglass_grain) options:MTLResourceStorageModeShared];
  _free = dispatch_semaphore_create(2);  // frames: the GPU may be so far behind
  return self;
}

// On any thread. Asking for the state here may send the notification again, so the next frame asks.
- (void)heatChanged:(NSNotification *)notification {
  (void)notification;
  _heatChanged = true;
}

- (BOOL)rests { return _sand.rests(); }

- (BOOL)stand:(const sandglass_cast_mesh *)meshes count:(uint32_t)count {
  return bool(_sand.stand(meshes, count));
}

// ARKit's depth, where the device has a LiDAR scanner and the session's frameSemantics ask for sceneDepth; else it is not known.
- (void)loadDepth:(ARFrame *)frame device:(id<MTLDevice>)device {
  CVPixelBufferRef map = frame.sceneDepth.depthMap;
  const float unknown = 0;
  if (map == NULL && _textures[4].width != 1) _textures[4] = new_texture(device, MTLPixelFormatR32Float, 1, 1, &unknown, sizeof unknown);
  if (map == NULL) return;
  CVPixelBufferLockBaseAddress(map, kCVPixelBufferLock_ReadOnly);
  _textures[4] = new_texture(device, MTLPixelFormatR32Float, CVPixelBufferGetWidth(map), CVPixelBufferGetHeight(map),
                             CVPixelBufferGetBaseAddress(map), CVPixelBufferGetBytesPerRow(map));
  CVPixelBufferUnlockBaseAddress(map, kCVPixelBufferLock_ReadOnly);
}

// The table, before what stands on it.
- (void)encodeTable:(ARFrame *)frame constants:(ShaderFrame &)constants with:(id<MTLRenderCommandEncoder>)encoder view:(MTKView *)view
            upright:(UIInterfaceOrientation)upright {
  const sample::Shadows shadows = _sand.shadows();
  const sample::ShadowTexture *const all[4] = {&shadows.object, &shadows.object_room, &shadows.sand, &shadows.sand_room};
  for (int i = 0; i < 4; ++i) {
    if (_textures[i] == nil || _versions[i] != all[i]->version)
      _textures[i] = new_texture(view.device, MTLPixelFormatR8Unorm, all[i]->texels, all[i]->layers * all[i]->texels, all[i]->bytes, all[i]->texels);
    _versions[i] = all[i]->version;
    constants.boxes[i] = simd_make_float4(all[i]->box[0], all[i]->box[1], all[i]->box[2], all[i]->box[3]);
  }
  [self loadDepth:frame device:view.device];
  const CGAffineTransform t = CGAffineTransformInvert([frame displayTransformForOrientation:upright viewportSize:view.bounds.size]);
  constants.depth_from_screen.columns[0] = simd_make_float3(static_cast<float>(t.a), static_cast<float>(t.b), 0);
  constants.depth_from_screen.columns[1] = simd_make_float3(static_cast<float>(t.c), static_cast<float>(t.d), 0);
  constants.depth_from_screen.columns[2] = simd_make_float3(static_cast<float>(t.tx), static_cast<float>(t.ty), 1);
  constants.viewport = simd_make_float2(static_cast<float>(view.drawableSize.width), static_cast<float>(view.drawableSize.height));
  constants.half_side = sample::k_table;
  constants.main_share = shadows.main_share;
  constants.sand_opacity = shadows.sand_opacity;
  const simd_float4 eye = frame.camera.transform.columns[3];
  const float *const origin = _sand.origin();
  constants.eye = simd_make_float2(eye.x - origin[0], eye.z - origin[2]);
  constants.eye_height = eye.y - origin[1];
  constants.slide = simd_make_float2(shadows.slide[0], shadows.slide[1]);
  constants.layers = simd_make_float2(static_cast<float>(shadows.object.layers) - 1, static_cast<float>(shadows.object_room.layers) - 1);
  constants.height = sample::k_receives;
  constants.depth_bias = 0.02f;  // metres: how wrong a LiDAR scanner's depth is at arm's length
  [encoder setRenderPipelineState:_table];
  [encoder setVertexBytes:&constants length:sizeof constants atIndex:0];
  [encoder setFragmentBytes:&constants length:sizeof constants atIndex:0];
  for (NSUInteger i = 0; i < 5; ++i) [encoder setFragmentTexture:_textures[i] atIndex:i];
  [encoder drawPrimitives:MTLPrimitiveTypeTriangleStrip vertexStart:0 vertexCount:4];
}

- (void)pour:(ARRaycastResult *)hit {
  const simd_float4 place = hit.worldTransform.columns[3];
  const float point[3] = {place.x, place.y, place.z};
  _sand.pour(point);
}

- (void)encode:(ARFrame *)frame into:(id<MTLCommandBuffer>)commands with:(id<MTLRenderCommandEncoder>)encoder view:(MTKView *)view
       upright:(UIInterfaceOrientation)upright {
  dispatch_semaphore_wait(_free, DISPATCH_TIME_FOREVER);
  const sample::Buffers &buffers = _sand.buffers();
  const float step = _last > 0.0 ? static_cast<float>(frame.timestamp - _last) : 0.0f;
  _last = frame.timestamp;
  if (_heatChanged.exchange(false)) _headroom = thermal_headroom();
  CVPixelBufferLockBaseAddress(frame.capturedImage, kCVPixelBufferLock_ReadOnly);
  const sandglass_camera_image seen = camera_image(frame);
  // While ARKit relocalises, poses are those of another frame: an image would light the room from the wrong side.
  const bool tracked = frame.camera.trackingState == ARTrackingStateNormal;
  const sandglass_frame_report report =
      _sand.frame(step, _headroom, static_cast<sandglass_grain *>(_grains[buffers.next].contents), tracked ? &seen : NULL);
  CVPixelBufferUnlockBaseAddress(frame.capturedImage, kCVPixelBufferLock_ReadOnly);

  const simd_float4x4 projection = [frame.camera projectionMatrixForOrientation:upright viewportSize:view.bounds.size zNear:0.05 zFar:50];
  const sample::Shading shading = _sand.shading();
  ShaderFrame constants;
  constants.view_from_world = [frame.camera viewMatrixForOrientation:upright];
  constants.clip_from_world = simd_mul(projection, constants.view_from_world);
  constants.to_light = vector(shading.to_light);
  constants.sun = vector(shading.sun);
  constants.ambient = vector(shading.ambient);
  constants.origin = vector(_sand.origin());
  constants.share = buffers.share;
  constants.span = buffers.span;
  constants.pixels_at_one_metre =  // the radius of a grain is 0.35 of a particle's
      0.35f * sample::k_particle_radius * projection.columns[1].y * static_cast<float>(view.drawableSize.height);
  [self encodeTable:frame constants:constants with:encoder view:view upright:upright];
  [encoder setRenderPipelineState:_pipeline];  // with the same constants
  [encoder setVertexBuffer:_grains[buffers.older] offset:0 atIndex:1];
  [encoder setVertexBuffer:_grains[buffers.newer] offset:0 atIndex:2];
  if (report.sand.grain_numbers > 0) [encoder drawPrimitives:MTLPrimitiveTypePoint vertexStart:0 vertexCount:report.sand.grain_numbers];
  dispatch_semaphore_t released = _free;
  [commands addCompletedHandler:^(id<MTLCommandBuffer> finished) {
    (void)finished;
    dispatch_semaphore_signal(released);
  }];
}

@end
