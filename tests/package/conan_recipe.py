#!/usr/bin/env python3
"""Runs the Conan recipe as `conan create` would. The names that it imports are defined here, as Conan 2 documents them.

    conan_recipe.py CONANFILE WORK_FOLDER [COMPILER_LAUNCHER]
    conan_recipe.py CONANFILE WORK_FOLDER --settings          only for which settings it says to build

The exported sources are first copied to a folder of their own, so a file that the recipe does not export fails the build.
"""

import importlib.util
import pathlib
import shutil
import subprocess
import sys
import types

recipe_path, work = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
settings_only = sys.argv[3:] == ["--settings"]
launcher = sys.argv[3] if len(sys.argv) > 3 and not settings_only else None


class ConanInvalidConfiguration(Exception):
    pass


class ConanFile:
    pass


class CMakeToolchain:
    def __init__(self, recipe):
        self.recipe, self.cache_variables = recipe, {}

    def generate(self):
        self.recipe.cache_variables = self.cache_variables


class CMake:
    def __init__(self, recipe):
        self.recipe = recipe

    def run(self, *arguments):
        subprocess.run(["cmake", *arguments], check=True, stdout=subprocess.DEVNULL)

    def configure(self):
        variables = [
            f"-D{name}={'ON' if value is True else 'OFF' if value is False else value}"
            for name, value in self.recipe.cache_variables.items()
        ]
        if launcher:
            variables.append(f"-DCMAKE_CXX_COMPILER_LAUNCHER={launcher}")
        self.run(
            "-S",
            self.recipe.source_folder,
            "-B",
            self.recipe.build_folder,
            "-G",
            "Ninja",
            "-DCMAKE_BUILD_TYPE=Release",
            f"-DCMAKE_INSTALL_PREFIX={self.recipe.package_folder}",
            "-DCMAKE_INSTALL_LIBDIR=lib",
            *variables,
        )

    def build(self):
        self.run("--build", self.recipe.build_folder, "--parallel", "2")

    def install(self):
        self.run("--install", self.recipe.build_folder)


def copy(recipe, pattern, source, destination):
    """Files that match the pattern, with those of the folders below, keeping their places."""
    source, destination = pathlib.Path(source), pathlib.Path(destination)
    found = [p for p in source.glob(pattern.replace("/*", "/**/*")) if p.is_file()]
    for path in found:
        target = destination / path.relative_to(source)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(path, target)
    return found


def module(name, **names):
    made = types.ModuleType(name)
    made.__dict__.update(names)
    sys.modules[name] = made


def expect(condition, sentence):
    if not condition:
        sys.exit(sentence)


def main():
    module("conan", ConanFile=ConanFile)
    module("conan.errors", ConanInvalidConfiguration=ConanInvalidConfiguration)
    module("conan.tools")
    module("conan.tools.cmake", CMake=CMake, CMakeToolchain=CMakeToolchain, cmake_layout=lambda recipe: None)
    module("conan.tools.files", copy=copy)
    spec = importlib.util.spec_from_file_location("conanfile", recipe_path)
    conanfile = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(conanfile)

    shutil.rmtree(work, ignore_errors=True)
    recipe = conanfile.SandglassRecipe()
    recipe.recipe_folder = str(recipe_path.parent)
    recipe.export_sources_folder = recipe.source_folder = str(work / "source")
    recipe.build_folder, recipe.package_folder = str(work / "build"), str(work / "package")
    recipe.settings = types.SimpleNamespace(os="Linux", arch="armv7", compiler="gcc", build_type="Release")
    recipe.cpp_info = types.SimpleNamespace(builddirs=[], libs=[], system_libs=[], set_property=lambda name, value: None)

    # The rows of the table of targets in tests/README.md.
    for system, processor, built in (
        ("Linux", "armv7", False),
        ("Android", "armv7", False),
        ("Android", "x86_64", False),
        ("iOS", "x86_64", False),
        ("Macos", "armv8", False),
        ("Windows", "x86_64", False),
        ("Android", "armv8", True),
        ("iOS", "armv8", True),
        ("Linux", "armv8", True),
        ("Linux", "x86_64", True),
    ):
        recipe.settings.os, recipe.settings.arch = system, processor
        try:
            recipe.validate()
            expect(built, f"{system} on {processor} was not refused")
        except ConanInvalidConfiguration as refusal:
            expect(not built, str(refusal))
    if settings_only:
        return print("the recipe builds for what is built")
    for step in (recipe.validate, recipe.export_sources, recipe.layout, recipe.generate, recipe.build, recipe.package, recipe.package_info):
        step()

    package = pathlib.Path(recipe.package_folder)
    for file in ("lib/libsandglass.a", "include/sandglass/sandglass.h", "lib/cmake/sandglass/sandglassConfig.cmake", "licenses/LICENSE"):
        expect((package / file).is_file(), f"the recipe did not package {file}")
    expect(all((package / folder).is_dir() for folder in recipe.cpp_info.builddirs), "builddirs names a folder that is not there")
    expect(recipe.cpp_info.libs == ["sandglass"], "libs")
    print("the recipe packages what a consumer needs")


if __name__ == "__main__":
    main()
