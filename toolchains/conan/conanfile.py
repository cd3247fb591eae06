"""Conan 2 recipe over this checkout:  conan create toolchains/conan"""

import os

from conan import ConanFile
from conan.errors import ConanInvalidConfiguration
from conan.tools.cmake import CMake, CMakeToolchain, cmake_layout
from conan.tools.files import copy


class SandglassRecipe(ConanFile):
    name = "sandglass"
    version = "0.2.0"
    license = "Apache-2.0"
    description = "Sand, light and shadow for augmented reality, inside a fixed slice of every frame"
    package_type = "static-library"
    settings = "os", "arch", "compiler", "build_type"

    def validate(self):
        built = {"Linux": ("x86_64", "armv8"), "Android": ("armv8",), "iOS": ("armv8",)}
        system, processor = str(self.settings.os), str(self.settings.arch)
        if processor not in built.get(system, ()):
            raise ConanInvalidConfiguration(
                f"Sandglass is built for Linux on x86_64 and armv8, and for Android and iOS on armv8, not for "
                f"{system} on {processor}: set os and arch to one of these."
            )

    def export_sources(self):
        checkout = os.path.join(self.recipe_folder, "..", "..")
        for part in (
            "CMakeLists.txt",
            "LICENSE",
            "platform/*",
            "kernels/*",
            "runtime/*",
            "toolchains/cmake/*",
            "toolchains/bindings/*",
            "toolchains/unity/*",
            "toolchains/android/*",
            "toolchains/ios/*",
        ):
            copy(self, part, checkout, self.export_sources_folder)

    def layout(self):
        cmake_layout(self)

    def generate(self):
        toolchain = CMakeToolchain(self)
        toolchain.cache_variables["SANDGLASS_DEVELOPER"] = False
        toolchain.cache_variables["SANDGLASS_INSTALL"] = True
        toolchain.generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        copy(self, "LICENSE", self.source_folder, os.path.join(self.package_folder, "licenses"))
        CMake(self).install()

    def package_info(self):
        # The package has its own CMake files, which define sandglass::sandglass. Conan need not write others.
        self.cpp_info.set_property("cmake_find_mode", "none")
        self.cpp_info.builddirs.append(os.path.join("lib", "cmake", "sandglass"))
        self.cpp_info.libs = ["sandglass"]
        if self.settings.os in ("Linux", "Android"):
            self.cpp_info.system_libs = ["m"]
