// swift-tools-version:5.9
// Sandglass as a Swift package: the XCFramework beside this file, and the privacy manifest for the app's report.
import PackageDescription

let package = Package(
  name: "Sandglass",
  platforms: [.iOS(.v15), .visionOS(.v1)],
  products: [.library(name: "Sandglass", targets: ["Sandglass", "SandglassPrivacy"])],
  targets: [
    .binaryTarget(name: "Sandglass", path: "Sandglass.xcframework"),
    .target(name: "SandglassPrivacy", path: "Privacy", resources: [.copy("PrivacyInfo.xcprivacy")]),
  ])
