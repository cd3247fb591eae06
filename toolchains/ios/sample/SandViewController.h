// The sample's only screen: the camera image, and sand where a real table is tapped.
#import <UIKit/UIKit.h>

@interface SandViewController : UIViewController
@end
