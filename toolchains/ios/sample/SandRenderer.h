// Sand in an app of ARKit and Metal: make it once, pour where a ray of the session hits a real plane, and encode it in
// every frame behind the camera's image.
#import <ARKit/ARKit.h>
#import <MetalKit/MetalKit.h>

@interface SandRenderer : NSObject
- (instancetype)initWithView:(MTKView*)view;
- (void)pour:(ARRaycastResult*)hit;
// Before the commands are committed. `upright` is the window's orientation.
- (void)encode:(ARFrame*)frame
          into:(id<MTLCommandBuffer>)commands
          with:(id<MTLRenderCommandEncoder>)encoder
          view:(MTKView*)view
       upright:(UIInterfaceOrientation)upright;
@end
