#pragma once
// The part of Foundation, ARKit, AVFoundation, Metal, CoreVideo and simd that the iOS sample uses, so that a compiler
// can check it.
#include <stddef.h>
#include <stdint.h>

typedef signed char BOOL;
typedef double CGFloat, NSTimeInterval;
typedef long NSInteger;
typedef unsigned long NSUInteger;
typedef struct {
  CGFloat width, height;
} CGSize;
typedef struct {
  CGFloat origin[2];
  CGSize size;
} CGRect;
typedef struct {
  CGFloat a, b, c, d, tx, ty;
} CGAffineTransform;
extern "C" CGAffineTransform CGAffineTransformInvert(CGAffineTransform t);
#define YES ((BOOL)1)
#define NO ((BOOL)0)
typedef float simd_float4 __attribute__((ext_vector_type(4)));
typedef float simd_float2 __attribute__((ext_vector_type(2)));
typedef float simd_float3 __attribute__((ext_vector_type(3)));
typedef struct {
  simd_float3 columns[3];
} simd_float3x3;
typedef struct {
  simd_float4 columns[4];
} simd_float4x4;
simd_float2 simd_make_float2(float x, float y);
simd_float3 simd_make_float3(float x, float y, float z);
simd_float4 simd_make_float4(float x, float y, float z, float w);
simd_float4x4 simd_mul(simd_float4x4 a, simd_float4x4 b);

#define nil ((id)0)
__attribute__((objc_root_class))
@interface NSObject
+ (instancetype)alloc;
- (instancetype)init;
@end
@interface NSString : NSObject
@end
@interface NSConstantString : NSString {
  const char* text;
  unsigned length;
}
@end
extern void* _NSConstantStringClassReference;
@interface NSError : NSObject
@end
@interface NSNumber : NSObject
@property(readonly) float floatValue;
@end
@interface NSDictionary<KeyType, ObjectType> : NSObject
- (ObjectType)objectForKeyedSubscript:(KeyType)key;
@end
@interface NSArray<ObjectType> : NSObject
@property(nonatomic, readonly) ObjectType firstObject;
@end
typedef enum : NSInteger {
  NSProcessInfoThermalStateNominal,
  NSProcessInfoThermalStateFair,
  NSProcessInfoThermalStateSerious
} NSProcessInfoThermalState;
@interface NSProcessInfo : NSObject
@property(class, readonly) NSProcessInfo* processInfo;
@property(readonly) NSProcessInfoThermalState thermalState;
@end
@class NSString, NSNotification;
extern "C" NSString* const NSProcessInfoThermalStateDidChangeNotification;
@interface NSNotificationCenter : NSObject
@property(class, readonly) NSNotificationCenter* defaultCenter;
- (void)addObserver:(id)observer selector:(SEL)selector name:(NSString*)name object:(id)object;
@end
typedef struct dispatch_semaphore_s* dispatch_semaphore_t;
#define DISPATCH_TIME_FOREVER (~0ull)
extern "C" dispatch_semaphore_t dispatch_semaphore_create(intptr_t value);
extern "C" intptr_t dispatch_semaphore_wait(dispatch_semaphore_t semaphore, uint64_t timeout);
extern "C" intptr_t dispatch_semaphore_signal(dispatch_semaphore_t semaphore);

typedef const void* CFTypeRef;
typedef const struct __CFString* CFStringRef;
typedef struct __CVBuffer* CVPixelBufferRef;
extern "C" {
void CFRelease(CFTypeRef object);
unsigned char CFEqual(CFTypeRef a, CFTypeRef b);
size_t CVPixelBufferGetWidth(CVPixelBufferRef image);
size_t CVPixelBufferGetHeight(CVPixelBufferRef image);
size_t CVPixelBufferGetBytesPerRow(CVPixelBufferRef image);
void* CVPixelBufferGetBaseAddress(CVPixelBufferRef image);
size_t CVPixelBufferGetWidthOfPlane(CVPixelBufferRef image, size_t plane);
size_t CVPixelBufferGetHeightOfPlane(CVPixelBufferRef image, size_t plane);
size_t CVPixelBufferGetBytesPerRowOfPlane(CVPixelBufferRef image, size_t plane);
void* CVPixelBufferGetBaseAddressOfPlane(CVPixelBufferRef image, size_t plane);
enum { kCVPixelBufferLock_ReadOnly = 1 };
int CVPixelBufferLockBaseAddress(CVPixelBufferRef image, uint64_t flags);
int CVPixelBufferUnlockBaseAddress(CVPixelBufferRef image, uint64_t flags);
CFTypeRef CVBufferCopyAttachment(CVPixelBufferRef buffer, CFStringRef key, unsigned* mode);
extern const CFStringRef kCVImageBufferYCbCrMatrixKey, kCVImageBufferYCbCrMatrix_ITU_R_709_2;
}

typedef enum : NSUInteger {
  MTLPixelFormatR8Unorm = 10,
  MTLPixelFormatR32Float = 55,
  MTLPixelFormatBGRA8Unorm_sRGB = 81
} MTLPixelFormat;
typedef enum : NSUInteger { MTLPrimitiveTypePoint = 0, MTLPrimitiveTypeTriangleStrip = 4 } MTLPrimitiveType;
typedef enum : NSUInteger { MTLBlendFactorSourceAlpha = 4, MTLBlendFactorOneMinusSourceAlpha = 5 } MTLBlendFactor;
typedef struct {
  NSUInteger origin[3], size[3];
} MTLRegion;
extern "C" MTLRegion MTLRegionMake2D(NSUInteger x, NSUInteger y, NSUInteger width, NSUInteger height);
@protocol MTLTexture
@property(readonly) NSUInteger width;
- (void)replaceRegion:(MTLRegion)region
          mipmapLevel:(NSUInteger)level
            withBytes:(const void*)bytes
          bytesPerRow:(NSUInteger)pitch;
@end
@interface MTLTextureDescriptor : NSObject
+ (MTLTextureDescriptor*)texture2DDescriptorWithPixelFormat:(MTLPixelFormat)format
                                                      width:(NSUInteger)width
                                                     height:(NSUInteger)height
                                                  mipmapped:(BOOL)mipmapped;
@end
typedef enum : NSUInteger { MTLResourceStorageModeShared = 0 } MTLResourceOptions;
@protocol MTLFunction
@end
@protocol MTLRenderPipelineState
@end
@protocol MTLBuffer
- (void*)contents;
@end
@protocol MTLLibrary
- (id<MTLFunction>)newFunctionWithName:(NSString*)name;
@end
@interface MTLRenderPipelineColorAttachmentDescriptor : NSObject
@property(nonatomic) MTLPixelFormat pixelFormat;
@property(nonatomic, getter=isBlendingEnabled) BOOL blendingEnabled;
@property(nonatomic) MTLBlendFactor sourceRGBBlendFactor, destinationRGBBlendFactor;
@end
@interface MTLRenderPipelineColorAttachmentDescriptorArray : NSObject
- (MTLRenderPipelineColorAttachmentDescriptor*)objectAtIndexedSubscript:(NSUInteger)index;
@end
@interface MTLRenderPipelineDescriptor : NSObject
@property(nonatomic, strong) id<MTLFunction> vertexFunction, fragmentFunction;
@property(nonatomic, readonly) MTLRenderPipelineColorAttachmentDescriptorArray* colorAttachments;
@property(nonatomic) MTLPixelFormat depthAttachmentPixelFormat;
@end
@protocol MTLRenderCommandEncoder
- (void)setVertexBytes:(const void*)bytes length:(NSUInteger)length atIndex:(NSUInteger)index;
- (void)setVertexBuffer:(id<MTLBuffer>)buffer offset:(NSUInteger)offset atIndex:(NSUInteger)index;
- (void)setFragmentBytes:(const void*)bytes length:(NSUInteger)length atIndex:(NSUInteger)index;
- (void)setFragmentTexture:(id<MTLTexture>)texture atIndex:(NSUInteger)index;
- (void)setRenderPipelineState:(id<MTLRenderPipelineState>)state;
- (void)drawPrimitives:(MTLPrimitiveType)type vertexStart:(NSUInteger)start vertexCount:(NSUInteger)count;
@end
@protocol MTLCommandBuffer
- (void)addCompletedHandler:(void (^)(id<MTLCommandBuffer>))handler;
@end
@protocol MTLDevice
- (id<MTLLibrary>)newDefaultLibrary;
- (id<MTLBuffer>)newBufferWithLength:(NSUInteger)length options:(MTLResourceOptions)options;
- (id<MTLTexture>)newTextureWithDescriptor:(MTLTextureDescriptor*)descriptor;
- (id<MTLRenderPipelineState>)newRenderPipelineStateWithDescriptor:(MTLRenderPipelineDescriptor*)descriptor
                                                             error:(NSError**)error;
@end
@interface MTKView : NSObject
@property(nonatomic, readonly) CGRect bounds;
@property(nonatomic, strong) id<MTLDevice> device;
@property(nonatomic) MTLPixelFormat colorPixelFormat, depthStencilPixelFormat;
@property(nonatomic) CGSize drawableSize;
@end

typedef struct {
  float redGain, greenGain, blueGain;
} AVCaptureWhiteBalanceGains;
@interface AVCaptureDevice : NSObject
@property(nonatomic, readonly) AVCaptureWhiteBalanceGains deviceWhiteBalanceGains;
@end
@interface ARWorldTrackingConfiguration : NSObject
@property(class, nonatomic, nullable, readonly) AVCaptureDevice* configurableCaptureDeviceForPrimaryCamera;
@end

typedef enum : NSInteger { UIInterfaceOrientationPortrait = 1 } UIInterfaceOrientation;
@interface ARRaycastResult : NSObject
@property(nonatomic, readonly) simd_float4x4 worldTransform;
@end
typedef enum : NSInteger { ARTrackingStateNotAvailable, ARTrackingStateLimited, ARTrackingStateNormal } ARTrackingState;
@interface ARCamera : NSObject
@property(nonatomic, readonly) ARTrackingState trackingState;
@property(nonatomic, readonly) simd_float4x4 transform;
@property(nonatomic, readonly) simd_float3x3 intrinsics;
- (simd_float4x4)projectionMatrixForOrientation:(UIInterfaceOrientation)orientation
                                   viewportSize:(CGSize)size
                                          zNear:(CGFloat)near
                                           zFar:(CGFloat)far;
- (simd_float4x4)viewMatrixForOrientation:(UIInterfaceOrientation)orientation;
@end
@interface ARDepthData : NSObject
@property(nonatomic, readonly) CVPixelBufferRef depthMap;
@end
@interface ARFrame : NSObject
@property(nonatomic, readonly) ARDepthData* sceneDepth;
- (CGAffineTransform)displayTransformForOrientation:(UIInterfaceOrientation)orientation viewportSize:(CGSize)size;
@property(nonatomic, readonly) NSTimeInterval timestamp;
@property(nonatomic, readonly) CVPixelBufferRef capturedImage;
@property(nonatomic, readonly) ARCamera* camera;
@property(nonatomic, readonly) NSDictionary<NSString*, id>* exifData;
@end
