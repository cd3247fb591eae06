// Sand on the real floor. ARKit gives the camera image and the pose. Once for every displayed frame, in 4 ms, the
// library writes the grains straight into a shared Metal buffer, gathers the room's light from the image, and casts the
// sand's shadows in that light. Metal draws the image and, with the same pose, shadows and grains. Three buffers take
// turns, so that the GPU never reads what the library writes.
#import "SandViewController.h"

#import <ARKit/ARKit.h>
#import <CoreVideo/CoreVideo.h>
#import <Metal/Metal.h>
#import <MetalKit/MetalKit.h>

#include <string.h>

#include <cmath>
#include <numbers>

#include "sand_stage.h"
#include "shader_types.h"

static const int k_buffers = 3;
static const float k_near = 0.05f, k_far = 50.0f;

// The share of the budget that the device can keep up, from the four states that iOS tells.
static float thermal_headroom(void) {
  switch (NSProcessInfo.processInfo.thermalState) {
    case NSProcessInfoThermalStateNominal:
    case NSProcessInfoThermalStateFair:
      return 1.0f;
    case NSProcessInfoThermalStateSerious:
      return 0.5f;
    default:
      return 0.25f;
  }
}

// How long and how sensitively an image was exposed, as sandglass_camera_image.exposure wants it: seconds times ISO /
// 100. 0 before iOS 16, which does not tell the ISO; exposureOffset is no gain but how far the camera is from the
// brightness that it aims at.
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
    image.strides[plane] = static_cast<uint32_t>(CVPixelBufferGetBytesPerRowOfPlane(pixels, plane));
  }
  const simd_float3x3 intrinsics = frame.camera.intrinsics;
  image.focal_x = intrinsics.columns[0].x, image.focal_y = intrinsics.columns[1].y;
  image.centre_x = intrinsics.columns[2].x, image.centre_y = intrinsics.columns[2].y;
  float matrix_to_world[16];
  const simd_float4x4 transform = frame.camera.transform;
  memcpy(matrix_to_world, &transform, sizeof matrix_to_world);
  sandglass_camera_orientation(matrix_to_world, image.orientation);
  for (int k = 0; k < 3; ++k) image.position[k] = matrix_to_world[12 + k];
  image.exposure = exposure_of(frame);
  image.turn_deg = SANDGLASS_TURN_FROM_POSE;
  image.timestamp_ns = static_cast<uint64_t>(1e9 * frame.timestamp);
  return image;
}

@interface SandViewController () <MTKViewDelegate, ARSessionDelegate>
@end

@implementation SandViewController {
  ARSession *_session;
  MTKView *_view;
  id<MTLCommandQueue> _queue;
  id<MTLRenderPipelineState> _imagePipeline, _shadowPipeline, _sandPipeline;
  id<MTLDepthStencilState> _imageDepth, _sandDepth;
  id<MTLBuffer> _grains[k_buffers];
  id<MTLTexture> _coverage[k_buffers], _sky[k_buffers], _skyOnSand[k_buffers];
  UILabel *_hint;
  CVMetalTextureCacheRef _textures;
  dispatch_semaphore_t _free;
  int _turn;
  NSTimeInterval _last;
  sample::SandStage _stage;
  BOOL _poured;
}

- (void)viewDidLoad {
  [super viewDidLoad];
  id<MTLDevice> device = MTLCreateSystemDefaultDevice();
  _view = [[MTKView alloc] initWithFrame:self.view.bounds device:device];
  _view.colorPixelFormat = MTLPixelFormatBGRA8Unorm_sRGB;  // blends in linear light, as a shadow must
  _view.depthStencilPixelFormat = MTLPixelFormatDepth32Float;
  _view.delegate = self;
  self.view = _view;
  _queue = [device newCommandQueue];
  _free = dispatch_semaphore_create(k_buffers);
  for (int i = 0; i < k_buffers; ++i) {
    _coverage[i] = [self texture:sample::k_shadow_texels device:device];
    _sky[i] = [self texture:sample::k_sky_texels device:device];
    _skyOnSand[i] = [self texture:sample::k_sky_texels device:device];
    _grains[i] = [device newBufferWithLength:sample::k_grains * sizeof(sandglass_grain) options:MTLResourceStorageModeShared];
  }
  CVMetalTextureCacheCreate(NULL, NULL, device, NULL, &_textures);
  id<MTLLibrary> library = [device newDefaultLibrary];
  _imagePipeline = [self pipeline:@"image_vertex" fragment:@"image_fragment" blended:NO library:library device:device];
  _shadowPipeline = [self pipeline:@"shadow_corner" fragment:@"room_shadow_catcher" blended:YES library:library device:device];
  _sandPipeline = [self pipeline:@"sand_vertex" fragment:@"sand_fragment" blended:NO library:library device:device];
  _imageDepth = [self depth:MTLCompareFunctionAlways write:NO device:device];
  _sandDepth = [self depth:MTLCompareFunctionLess write:YES device:device];

  const sandglass::Status status = _stage.create();
  if (!status) NSLog(@"%s: %s", status.name(), status.reason);
  _hint = [[UILabel alloc] initWithFrame:CGRectMake(0, 40, self.view.bounds.size.width, 40)];
  [_view addSubview:_hint];
  _session = [[ARSession alloc] init];
  _session.delegate = self;
  [_view addGestureRecognizer:[[UITapGestureRecognizer alloc] initWithTarget:self action:@selector(tap:)]];
}

- (void)viewWillAppear:(BOOL)animated {
  [super viewWillAppear:animated];
  ARWorldTrackingConfiguration *configuration = [[ARWorldTrackingConfiguration alloc] init];
  configuration.planeDetection = ARPlaneDetectionHorizontal;
  [_session runWithConfiguration:configuration];
}

- (void)viewWillDisappear:(BOOL)animated {
  [super viewWillDisappear:animated];
  [_session pause];
}

- (id<MTLTexture>)texture:(uint32_t)side device:(id<MTLDevice>)device {
  return [device newTextureWithDescriptor:[MTLTextureDescriptor texture2DDescriptorWithPixelFormat:MTLPixelFormatR8Unorm
                                                                                              width:side
                                                                                             height:side
                                                                                          mipmapped:NO]];
}

static void upload(id<MTLTexture> texture, const uint8_t *bytes, uint32_t side) {
  [texture replaceRegion:MTLRegionMake2D(0, 0, side, side) mipmapLevel:0 withBytes:bytes bytesPerRow:side];
}

// Asks the user to show the library where the light comes from. The rows of `view` are the axes of the upright image.
- (void)showHint:(simd_float4x4)view {
  const float *look = _stage.look();
  float right = 0.0f, up = 0.0f;
  for (int k = 0; look != nullptr && k < 3; ++k) right += look[k] * view.columns[k].x, up += look[k] * view.columns[k].y;
  _hint.text = look == nullptr          ? @""
               : up > std::fabs(right) ? @"Look up"
               : right > 0.0f          ? @"Look around: to the right"
                                       : @"Look around: to the left";
}

- (id<MTLRenderPipelineState>)pipeline:(NSString *)vertex
                              fragment:(NSString *)fragment
                               blended:(BOOL)blended
                               library:(id<MTLLibrary>)library
                                device:(id<MTLDevice>)device {
  MTLRenderPipelineDescriptor *descriptor = [[MTLRenderPipelineDescriptor alloc] init];
  descriptor.vertexFunction = [library newFunctionWithName:vertex];
  descriptor.fragmentFunction = [library newFunctionWithName:fragment];
  descriptor.colorAttachments[0].pixelFormat = _view.colorPixelFormat;
  descriptor.colorAttachments[0].blendingEnabled = blended;
  descriptor.colorAttachments[0].sourceRGBBlendFactor = MTLBlendFactorSourceAlpha;
  descriptor.colorAttachments[0].destinationRGBBlendFactor = MTLBlendFactorOneMinusSourceAlpha;
  descriptor.depthAttachmentPixelFormat = _view.depthStencilPixelFormat;
  NSError *error = nil;
  id<MTLRenderPipelineState> state = [device newRenderPipelineStateWithDescriptor:descriptor error:&error];
  if (state == nil) NSLog(@"%@", error);
  return state;
}

- (id<MTLDepthStencilState>)depth:(MTLCompareFunction)compare write:(BOOL)write device:(id<MTLDevice>)device {
  MTLDepthStencilDescriptor *descriptor = [[MTLDepthStencilDescriptor alloc] init];
  descriptor.depthCompareFunction = compare;
  descriptor.depthWriteEnabled = write;
  return [device newDepthStencilStateWithDescriptor:descriptor];
}

- (void)tap:(UITapGestureRecognizer *)recognizer {
  ARFrame *frame = _session.currentFrame;
  if (frame == nil) return;
  // The ray query takes points of the camera image, from 0 to 1, so the map from image to view is inverted.
  const CGSize size = _view.bounds.size;
  const CGPoint at = [recognizer locationInView:_view];
  const CGAffineTransform shown = [frame displayTransformForOrientation:UIInterfaceOrientationPortrait viewportSize:size];
  const CGPoint image = CGPointApplyAffineTransform(CGPointMake(at.x / size.width, at.y / size.height), CGAffineTransformInvert(shown));
  ARRaycastQuery *query = [frame raycastQueryFromPoint:image
                                        allowingTarget:ARRaycastTargetExistingPlaneGeometry
                                             alignment:ARRaycastTargetAlignmentHorizontal];
  ARRaycastResult *hit = [_session raycast:query].firstObject;
  if (hit == nil) return;
  const simd_float4 place = hit.worldTransform.columns[3];
  const float point[3] = {place.x, place.y, place.z};
  const sandglass::Status status = _stage.pour(point);
  if (!status) NSLog(@"%s: %s", status.name(), status.reason);
  _poured = static_cast<bool>(status);
}

// One plane of the camera's YUV image as a texture, without a copy.
- (id<MTLTexture>)plane:(size_t)plane format:(MTLPixelFormat)format image:(CVPixelBufferRef)image {
  CVMetalTextureRef wrapped = NULL;
  CVMetalTextureCacheCreateTextureFromImage(NULL, _textures, image, NULL, format, CVPixelBufferGetWidthOfPlane(image, plane),
                                            CVPixelBufferGetHeightOfPlane(image, plane), plane, &wrapped);
  if (wrapped == NULL) return nil;
  id<MTLTexture> texture = CVMetalTextureGetTexture(wrapped);
  CFRelease(wrapped);
  return texture;
}

- (void)drawInMTKView:(MTKView *)view {
  ARFrame *frame = _session.currentFrame;
  MTLRenderPassDescriptor *pass = view.currentRenderPassDescriptor;
  if (frame == nil || pass == nil) return;
  dispatch_semaphore_wait(_free, DISPATCH_TIME_FOREVER);
  id<MTLBuffer> grains = _grains[_turn];
  id<MTLTexture> coverage = _coverage[_turn], sky = _sky[_turn], skyOnSand = _skyOnSand[_turn];
  _turn = (_turn + 1) % k_buffers;

  const float step = _last > 0.0 ? static_cast<float>(frame.timestamp - _last) : 0.0f;
  CVPixelBufferLockBaseAddress(frame.capturedImage, kCVPixelBufferLock_ReadOnly);
  const sandglass_camera_image seen = camera_image(frame);
  _stage.frame(step, thermal_headroom(), _poured ? static_cast<sandglass_grain *>(grains.contents) : nullptr, &seen);
  CVPixelBufferUnlockBaseAddress(frame.capturedImage, kCVPixelBufferLock_ReadOnly);
  _last = frame.timestamp;

  const CGSize size = view.bounds.size;
  const UIInterfaceOrientation portrait = UIInterfaceOrientationPortrait;
  ShaderFrame constants;
  const simd_float4x4 projection = [frame.camera projectionMatrixForOrientation:portrait viewportSize:size zNear:k_near zFar:k_far];
  constants.view_from_world = [frame.camera viewMatrixForOrientation:portrait];
  constants.clip_from_world = simd_mul(projection, constants.view_from_world);
  [self showHint:constants.view_from_world];
  // The main light as a directional one; all other light as it falls on a grain that faces up.
  sandglass_light_filament light = {};
  light.struct_size = sizeof light;
  (void)!sandglass_room_to_filament(&_stage.light(), SANDGLASS_LIGHT_MODEL_AMBIENT, _stage.light_scale(), &light, nullptr);
  const float *c = light.colour, k = light.intensity / std::numbers::pi_v<float>, *d = light.direction;
  float rest[3];
  for (int i = 0; i < 3; ++i)
    rest[i] = light.sh_intensity * std::fmax(light.sh[i] + light.sh[3 + i] - light.sh[18 + i] - light.sh[24 + i], 0.0f);
  constants.to_light = simd_make_float4(-d[0], -d[1], -d[2], 0);
  constants.sun = simd_make_float4(k * c[0], k * c[1], k * c[2], 0);
  constants.ambient = simd_make_float4(rest[0], rest[1], rest[2], 0);
  constants.origin = simd_make_float4(_stage.origin()[0], _stage.origin()[1], _stage.origin()[2], 0);
  // The diameter of a grain in pixels at distance 1. Its radius is 0.35 of a particle's.
  constants.point_size = 0.35f * sample::k_particle_radius * projection.columns[1][1] * static_cast<float>(view.drawableSize.height);
  const CGAffineTransform image =
      CGAffineTransformInvert([frame displayTransformForOrientation:portrait viewportSize:size]);
  constants.image_from_view[0] = simd_make_float4(static_cast<float>(image.a), static_cast<float>(image.c), static_cast<float>(image.tx), 0);
  constants.image_from_view[1] = simd_make_float4(static_cast<float>(image.b), static_cast<float>(image.d), static_cast<float>(image.ty), 0);

  const sandglass_pile_shadow_texture texture = _stage.shadow();
  const sandglass_pile_shadow_sky left = _stage.sky();
  upload(coverage, texture.coverage, sample::k_shadow_texels);
  upload(sky, left.floor, sample::k_sky_texels);
  upload(skyOnSand, left.on_sand, sample::k_sky_texels);
  ShaderShadow shadow;
  simd_float4x4 place = matrix_identity_float4x4;
  place.columns[3] = simd_make_float4(_stage.origin()[0], _stage.origin()[1], _stage.origin()[2], 1);
  shadow.clip_from_object = simd_mul(constants.clip_from_world, place);
  shadow.rectangle = simd_make_float4(texture.low[0], texture.low[1], texture.high[0], texture.high[1]);
  shadow.plane = 0.001f;
  constants.rectangle = shadow.rectangle;
  ShaderRoomShadow room;
  room.light_rectangle = room.ambient_rectangle = shadow.rectangle;
  room.strength = _stage.shadow_strength();

  id<MTLCommandBuffer> commands = [_queue commandBuffer];
  id<MTLRenderCommandEncoder> encoder = [commands renderCommandEncoderWithDescriptor:pass];
  [encoder setVertexBytes:&constants length:sizeof(constants) atIndex:ShaderBufferFrame];
  id<MTLTexture> luma = [self plane:0 format:MTLPixelFormatR8Unorm image:frame.capturedImage];
  id<MTLTexture> chroma = [self plane:1 format:MTLPixelFormatRG8Unorm image:frame.capturedImage];
  if (luma != nil && chroma != nil) {
    [encoder setRenderPipelineState:_imagePipeline];
    [encoder setDepthStencilState:_imageDepth];
    [encoder setFragmentTexture:luma atIndex:0];
    [encoder setFragmentTexture:chroma atIndex:1];
    [encoder drawPrimitives:MTLPrimitiveTypeTriangleStrip vertexStart:0 vertexCount:4];
  }
  if (_poured && _stage.drawn() > 0) {
    [encoder setRenderPipelineState:_shadowPipeline];
    [encoder setVertexBytes:&shadow length:sizeof(shadow) atIndex:0];
    [encoder setFragmentBytes:&shadow length:sizeof(shadow) atIndex:0];
    [encoder setFragmentBytes:&room length:sizeof(room) atIndex:1];
    [encoder setFragmentTexture:coverage atIndex:0];
    [encoder setFragmentTexture:sky atIndex:1];
    [encoder drawPrimitives:MTLPrimitiveTypeTriangleStrip vertexStart:0 vertexCount:4];
    [encoder setRenderPipelineState:_sandPipeline];
    [encoder setVertexBytes:&constants length:sizeof(constants) atIndex:ShaderBufferFrame];
    [encoder setFragmentBytes:&constants length:sizeof(constants) atIndex:ShaderBufferFrame];
    [encoder setDepthStencilState:_sandDepth];
    [encoder setVertexBuffer:grains offset:0 atIndex:ShaderBufferGrains];
    [encoder setVertexTexture:skyOnSand atIndex:0];
    [encoder drawPrimitives:MTLPrimitiveTypePoint vertexStart:0 vertexCount:_stage.drawn()];
  }
  [encoder endEncoding];
  dispatch_semaphore_t released = _free;
  [commands addCompletedHandler:^(id<MTLCommandBuffer> finished) {
    (void)finished;
    dispatch_semaphore_signal(released);
  }];
  [commands presentDrawable:view.currentDrawable];
  [commands commit];
}

- (void)mtkView:(MTKView *)view drawableSizeWillChange:(CGSize)size {
  (void)view, (void)size;
}

@end
