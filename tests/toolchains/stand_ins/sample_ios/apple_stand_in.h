#pragma once
// The part of UIKit, ARKit, Metal and CoreVideo that the sample uses: classes, methods and types, so that a compiler
// can check the sample.
#include <simd/simd.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
#define STAND_IN_C extern "C"
#else
#define STAND_IN_C
#endif
#define nil ((id)0)
#ifndef NULL
#define NULL 0
#endif
typedef signed char BOOL;
#define YES ((BOOL)1)
#define NO ((BOOL)0)
typedef double CGFloat, NSTimeInterval;
typedef long NSInteger;
typedef unsigned long NSUInteger;
typedef const void* CFTypeRef;
typedef const struct __CFString* CFStringRef;
STAND_IN_C void CFRelease(CFTypeRef object);
STAND_IN_C unsigned char CFEqual(CFTypeRef a, CFTypeRef b);

typedef struct {
  CGFloat x, y;
} CGPoint;
typedef struct {
  CGFloat width, height;
} CGSize;
typedef struct {
  CGPoint origin;
  CGSize size;
} CGRect;
typedef struct {
  CGFloat a, b, c, d, tx, ty;
} CGAffineTransform;
STAND_IN_C CGRect CGRectMake(CGFloat x, CGFloat y, CGFloat width, CGFloat height);
STAND_IN_C CGPoint CGPointMake(CGFloat x, CGFloat y);
STAND_IN_C CGPoint CGPointApplyAffineTransform(CGPoint point, CGAffineTransform transform);
STAND_IN_C CGAffineTransform CGAffineTransformInvert(CGAffineTransform transform);

// ---- Foundation
__attribute__((objc_root_class))
@interface NSObject
+ (instancetype)alloc;
- (instancetype)init;
+ (Class)class;
@end
@protocol NSObject
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
@interface NSData : NSObject
+ (instancetype)dataWithContentsOfFile:(NSString*)path;
@property(readonly) NSUInteger length;
@property(readonly) const void* bytes;
@end
@interface NSBundle : NSObject
@property(class, readonly, strong) NSBundle* mainBundle;
- (NSString*)pathForResource:(NSString*)name ofType:(NSString*)ext;
@end
@interface NSArray<ObjectType> : NSObject
@property(nonatomic, readonly) ObjectType firstObject;
@end
typedef enum : NSInteger {
  NSProcessInfoThermalStateNominal,
  NSProcessInfoThermalStateFair,
  NSProcessInfoThermalStateSerious,
  NSProcessInfoThermalStateCritical
} NSProcessInfoThermalState;
@interface NSProcessInfo : NSObject
@property(class, readonly) NSProcessInfo* processInfo;
@property(readonly) NSProcessInfoThermalState thermalState;
@end
STAND_IN_C void NSLog(NSString* format, ...);
STAND_IN_C NSString* NSStringFromClass(Class of);
typedef struct dispatch_semaphore_s* dispatch_semaphore_t;
#define DISPATCH_TIME_FOREVER (~0ull)
STAND_IN_C dispatch_semaphore_t dispatch_semaphore_create(intptr_t value);
STAND_IN_C intptr_t dispatch_semaphore_wait(dispatch_semaphore_t semaphore, uint64_t timeout);
STAND_IN_C intptr_t dispatch_semaphore_signal(dispatch_semaphore_t semaphore);

// ---- CoreVideo and Metal
typedef struct __CVBuffer* CVPixelBufferRef;
typedef struct __CVTexture* CVMetalTextureRef;
typedef struct __CVCache* CVMetalTextureCacheRef;
typedef enum : NSUInteger {
  MTLPixelFormatR8Unorm = 10,
  MTLPixelFormatRG8Unorm = 30,
  MTLPixelFormatBGRA8Unorm_sRGB = 81,
  MTLPixelFormatDepth32Float = 252
} MTLPixelFormat;
typedef enum : NSUInteger { MTLCompareFunctionLess = 1, MTLCompareFunctionAlways = 7 } MTLCompareFunction;
typedef enum : NSUInteger { MTLPrimitiveTypePoint = 0, MTLPrimitiveTypeTriangleStrip = 4 } MTLPrimitiveType;
typedef enum : NSUInteger { MTLBlendFactorSourceAlpha = 4, MTLBlendFactorOneMinusSourceAlpha = 5 } MTLBlendFactor;
typedef struct {
  NSUInteger x, y, z;
} MTLOrigin;
typedef struct {
  NSUInteger width, height, depth;
} MTLSize;
typedef struct {
  MTLOrigin origin;
  MTLSize size;
} MTLRegion;
STAND_IN_C MTLRegion MTLRegionMake2D(NSUInteger x, NSUInteger y, NSUInteger width, NSUInteger height);
typedef enum : NSUInteger { MTLResourceStorageModeShared = 0 } MTLResourceOptions;
@protocol MTLFunction
@end
@protocol MTLTexture
- (void)replaceRegion:(MTLRegion)region
          mipmapLevel:(NSUInteger)level
            withBytes:(const void*)bytes
          bytesPerRow:(NSUInteger)bytes_per_row;
@end
@interface MTLTextureDescriptor : NSObject
+ (MTLTextureDescriptor*)texture2DDescriptorWithPixelFormat:(MTLPixelFormat)format
                                                      width:(NSUInteger)width
                                                     height:(NSUInteger)height
                                                  mipmapped:(BOOL)mipmapped;
@end
@protocol MTLDrawable
@end
@protocol MTLRenderPipelineState
@end
@protocol MTLDepthStencilState
@end
@protocol MTLBuffer
- (void*)contents;
@end
@protocol MTLLibrary
- (id<MTLFunction>)newFunctionWithName:(NSString*)name;
@end
@interface MTLRenderPassDescriptor : NSObject
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
@interface MTLDepthStencilDescriptor : NSObject
@property(nonatomic) MTLCompareFunction depthCompareFunction;
@property(nonatomic, getter=isDepthWriteEnabled) BOOL depthWriteEnabled;
@end
@protocol MTLRenderCommandEncoder
- (void)setVertexBytes:(const void*)bytes length:(NSUInteger)length atIndex:(NSUInteger)index;
- (void)setVertexBuffer:(id<MTLBuffer>)buffer offset:(NSUInteger)offset atIndex:(NSUInteger)index;
- (void)setFragmentBytes:(const void*)bytes length:(NSUInteger)length atIndex:(NSUInteger)index;
- (void)setFragmentTexture:(id<MTLTexture>)texture atIndex:(NSUInteger)index;
- (void)setVertexTexture:(id<MTLTexture>)texture atIndex:(NSUInteger)index;
- (void)setRenderPipelineState:(id<MTLRenderPipelineState>)state;
- (void)setDepthStencilState:(id<MTLDepthStencilState>)state;
- (void)drawPrimitives:(MTLPrimitiveType)type vertexStart:(NSUInteger)start vertexCount:(NSUInteger)count;
- (void)endEncoding;
@end
@protocol MTLCommandBuffer
- (id<MTLRenderCommandEncoder>)renderCommandEncoderWithDescriptor:(MTLRenderPassDescriptor*)descriptor;
- (void)addCompletedHandler:(void (^)(id<MTLCommandBuffer>))handler;
- (void)presentDrawable:(id<MTLDrawable>)drawable;
- (void)commit;
@end
@protocol MTLCommandQueue
- (id<MTLCommandBuffer>)commandBuffer;
@end
@protocol MTLDevice
- (id<MTLCommandQueue>)newCommandQueue;
- (id<MTLLibrary>)newDefaultLibrary;
- (id<MTLTexture>)newTextureWithDescriptor:(MTLTextureDescriptor*)descriptor;
- (id<MTLBuffer>)newBufferWithLength:(NSUInteger)length options:(MTLResourceOptions)options;
- (id<MTLRenderPipelineState>)newRenderPipelineStateWithDescriptor:(MTLRenderPipelineDescriptor*)descriptor
                                                             error:(NSError**)error;
- (id<MTLDepthStencilState>)newDepthStencilStateWithDescriptor:(MTLDepthStencilDescriptor*)descriptor;
@end
STAND_IN_C id<MTLDevice> MTLCreateSystemDefaultDevice(void) __attribute__((ns_returns_retained));
STAND_IN_C int CVMetalTextureCacheCreate(const void* allocator, const void* attributes, id<MTLDevice> device,
                                         const void* texture_attributes, CVMetalTextureCacheRef* cache);
STAND_IN_C int CVMetalTextureCacheCreateTextureFromImage(const void* allocator, CVMetalTextureCacheRef cache,
                                                         CVPixelBufferRef image, const void* attributes,
                                                         MTLPixelFormat format, size_t width, size_t height,
                                                         size_t plane, CVMetalTextureRef* texture);
STAND_IN_C id<MTLTexture> CVMetalTextureGetTexture(CVMetalTextureRef texture);
STAND_IN_C size_t CVPixelBufferGetWidthOfPlane(CVPixelBufferRef image, size_t plane);
STAND_IN_C size_t CVPixelBufferGetHeightOfPlane(CVPixelBufferRef image, size_t plane);
STAND_IN_C size_t CVPixelBufferGetBytesPerRowOfPlane(CVPixelBufferRef image, size_t plane);
STAND_IN_C void* CVPixelBufferGetBaseAddressOfPlane(CVPixelBufferRef image, size_t plane);
enum { kCVPixelBufferLock_ReadOnly = 1 };
STAND_IN_C int CVPixelBufferLockBaseAddress(CVPixelBufferRef image, uint64_t flags);
STAND_IN_C int CVPixelBufferUnlockBaseAddress(CVPixelBufferRef image, uint64_t flags);
STAND_IN_C CFTypeRef CVBufferCopyAttachment(CVPixelBufferRef buffer, CFStringRef key, unsigned* mode);
STAND_IN_C const CFStringRef kCVImageBufferYCbCrMatrixKey;
STAND_IN_C const CFStringRef kCVImageBufferYCbCrMatrix_ITU_R_709_2;

// ---- UIKit and MetalKit
typedef enum : NSInteger { UIInterfaceOrientationPortrait = 1 } UIInterfaceOrientation;
@class UIView, UIWindow, UIViewController, UIApplication;
@interface UIResponder : NSObject
@end
@interface UIGestureRecognizer : NSObject
- (instancetype)initWithTarget:(id)target action:(SEL)action;
- (CGPoint)locationInView:(UIView*)view;
@end
@interface UITapGestureRecognizer : UIGestureRecognizer
@end
@interface UIView : UIResponder
@property(nonatomic) CGRect bounds;
- (void)addGestureRecognizer:(UIGestureRecognizer*)recognizer;
- (void)addSubview:(UIView*)view;
@end
@interface UILabel : UIView
- (instancetype)initWithFrame:(CGRect)frame;
@property(nonatomic, copy) NSString* text;
@end
@interface UIViewController : UIResponder
@property(nonatomic, strong) UIView* view;
- (void)viewDidLoad;
- (void)viewWillAppear:(BOOL)animated;
- (void)viewWillDisappear:(BOOL)animated;
@end
@interface UIWindow : UIView
@property(nonatomic, strong) UIViewController* rootViewController;
- (instancetype)initWithFrame:(CGRect)frame;
- (void)makeKeyAndVisible;
@end
@interface UIScreen : NSObject
@property(class, readonly) UIScreen* mainScreen;
@property(nonatomic, readonly) CGRect bounds;
@end
@protocol UIApplicationDelegate <NSObject>
@end
STAND_IN_C int UIApplicationMain(int argc, char** argv, NSString* principal, NSString* delegate);
@class MTKView;
@protocol MTKViewDelegate
- (void)drawInMTKView:(MTKView*)view;
- (void)mtkView:(MTKView*)view drawableSizeWillChange:(CGSize)size;
@end
@interface MTKView : UIView
- (instancetype)initWithFrame:(CGRect)frame device:(id<MTLDevice>)device;
@property(nonatomic) MTLPixelFormat colorPixelFormat, depthStencilPixelFormat;
@property(nonatomic, weak) id<MTKViewDelegate> delegate;
@property(nonatomic, readonly) MTLRenderPassDescriptor* currentRenderPassDescriptor;
@property(nonatomic, readonly) id<MTLDrawable> currentDrawable;
@property(nonatomic) CGSize drawableSize;
@end

// ---- ARKit
typedef enum : NSUInteger { ARPlaneDetectionHorizontal = 1 } ARPlaneDetection;
typedef enum : NSInteger { ARRaycastTargetExistingPlaneGeometry = 0 } ARRaycastTarget;
typedef enum : NSInteger { ARRaycastTargetAlignmentHorizontal = 0 } ARRaycastTargetAlignment;
@interface ARRaycastQuery : NSObject
@end
@interface ARRaycastResult : NSObject
@property(nonatomic, readonly) simd_float4x4 worldTransform;
@end
@interface ARCamera : NSObject
@property(nonatomic, readonly) simd_float4x4 transform;
@property(nonatomic, readonly) simd_float3x3 intrinsics;
- (simd_float4x4)projectionMatrixForOrientation:(UIInterfaceOrientation)orientation
                                   viewportSize:(CGSize)size
                                          zNear:(CGFloat)near
                                           zFar:(CGFloat)far;
- (simd_float4x4)viewMatrixForOrientation:(UIInterfaceOrientation)orientation;
@end
@interface ARFrame : NSObject
@property(nonatomic, readonly) NSTimeInterval timestamp;
@property(nonatomic, readonly) CVPixelBufferRef capturedImage;
@property(nonatomic, readonly) ARCamera* camera;
@property(nonatomic, readonly) NSDictionary<NSString*, id>* exifData;
- (CGAffineTransform)displayTransformForOrientation:(UIInterfaceOrientation)orientation viewportSize:(CGSize)size;
- (ARRaycastQuery*)raycastQueryFromPoint:(CGPoint)point
                          allowingTarget:(ARRaycastTarget)target
                               alignment:(ARRaycastTargetAlignment)alignment;
@end
@interface ARConfiguration : NSObject
@end
@interface ARWorldTrackingConfiguration : ARConfiguration
@property(nonatomic) ARPlaneDetection planeDetection;
@end
@protocol ARSessionDelegate <NSObject>
@end
@interface ARSession : NSObject
@property(nonatomic, weak) id<ARSessionDelegate> delegate;
@property(nonatomic, readonly) ARFrame* currentFrame;
- (void)runWithConfiguration:(ARConfiguration*)configuration;
- (void)pause;
- (NSArray<ARRaycastResult*>*)raycast:(ARRaycastQuery*)query;
@end
