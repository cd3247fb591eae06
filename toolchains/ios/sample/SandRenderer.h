// Sand in an app of ARKit and Metal: make it once, pour where a ray of the session hits a real plane, and encode it in
// every frame behind the camera's image.
#import <ARKit/ARKit.h>
#import <MetalKit/MetalKit.h>

@interface SandRenderer : NSObject
- (instancetype)initWithView:(MTKView*)view;
// While the phone is hot: run the session's configuration without sceneDepth. Read it after encode, on the same thread.
@property(nonatomic, readonly) BOOL rests;
- (void)pour:(ARRaycastResult*)hit;
// What else stands on the table and is drawn by the app: it casts. Poses are from the place that was poured on; arrays stay.
- (BOOL)stand:(const struct sandglass_cast_mesh*)meshes count:(uint32_t)count;
// Before the commands are committed. `upright` is the window's orientation.
- (void)encode:(ARFrame*)frame
          into:(id<MTLCommandBuffer>)commands
          with:(id<MTLRenderCommandEncoder>)encoder
          view:(MTKView*)view
       upright:(UIInterfaceOrientation)upright;
@end
