// The program as a script sees it: exit code 0, 1 or 2, one line on stderr when it refuses, and the hash on the last
// line of a run.
#include <set>

#include "models/mesh/generated.h"
#include "sandglass/sandglass.h"
#include "tests/program/cli.h"

namespace sandglass {
namespace {

std::string hash_in(const std::string& output) {
  return output.substr(std::min(output.size(), output.rfind("hash 0x")));
}

// ------------------------------------------------------------------------------------------------------ command line

// Every command that the program's help lists has its own help. Together they have fewer options than a user can know.
TEST_F(Cli, EveryCommandHasHelpAndAllHaveFewerThanSixtyOptions) {
  const std::string help = done("").out;
  EXPECT_LT(std::count(help.begin(), help.end(), '\n'), 25);
  size_t options = 0;
  const std::vector<std::string> commands = listed("");
  EXPECT_GT(commands.size(), 5u);
  for (const std::string& command : commands) {
    EXPECT_NE(done(command + " --help").out.find("Usage: sandglass " + command), std::string::npos);
    for (const std::string& name : listed(command)) options += name.starts_with("-") && name != "-h,--help";
  }
  EXPECT_GT(options, 30u);
  EXPECT_LT(options, 60u);
}

// One sentence says what is wrong with a command line, and points to the help.
TEST_F(Cli, AWrongCommandLineIsOneSentence) {
  expect_refusals(R"(
bnech granular | cannot start "sandglass": The following arguments were not expected:
bnech granular | See: sandglass --help.
run demo --thread 2 | cannot start "run": The following arguments were not expected:
run demo --thread 2 | See: sandglass run --help.
run demo chair | cannot start "run": The following argument was not expected: chair. See: sandglass run --help.
run | cannot start "run": SCENE is required. See: sandglass run --help.
run '' | is empty
run demo --replay= | --replay: 1 required FILE missing
run demo --frames | cannot start "run": --frames: 1 required N
run demo --frames 2 --frames 3 | cannot start "run": --frames:
run demo --clock reel | cannot use "--clock" of "run": "reel" is not real or virtual. See: sandglass run --help.
run demo --isa quantum | cannot use "--isa" of "run": "quantum" is not automatic, scalar, neon, avx2, avx512, neon_dotprod,
run demo --as cortex-a79 | cortex-a78
run demo --as cortex-a78 --clock virtual | excludes
run demo --budget-ms nan | cannot use "--budget-ms" of "run": "nan" is not a number from 0 to 1000000. See:
run demo --threads 1.5 | cannot use "--threads" of "run": "1.5" is not a whole number from 1 to 256. See:
run demo --record a --replay b | cannot start "run": --record excludes --replay.
run shot --fov 70 | cannot start "run": --fov requires --photo.
verify granular --frames 3 | See: sandglass_lab verify granular --help.
verify --json | See: sandglass_lab verify --help.
verify granular --quick --case column | it takes minutes, and --quick leaves such cases out. Leave --quick out, or name
dataset x | cannot start "dataset": --output is required. See: sandglass dataset --help.
sample box --distance 1 -o x | WHERE
sample box inside --distance 1 -o x | "inside" is not surface, volume or lattice
sample box volume -o x | --distance is required
room -o room.png | .hdr
room --width 33 -o room.hdr | --width
)");
}

// A bad number is refused before the command reads, makes or computes anything.
TEST_F(Cli, RefusesNumbersThatAreNone) {
  const auto refused = [&](const std::string& command, const std::string& option, const std::string& value) {
    const bool left_out = !k_bake && command.starts_with("bake");
    expect_refused(command + " " + option + " '" + value + "'", left_out ? "no ray tracer" : option.substr(2));
  };
  const std::pair<const char*, const char*> options[] = {{"--max-polar", "bake chair -o out"},
                                                         {"--size", "bake chair -o out"},
                                                         {"--seed", "room -o out.hdr"},
                                                         {"--fov", "light a.png -o out"},
                                                         {"--samples", "room -o out.hdr"},
                                                         {"--budget-ms", "run demo"},
                                                         {"--frames", "run demo"},
                                                         {"--distance", "sample box surface -o out"}};
  for (const auto& [option, command] : options)
    for (const char* value : {"nan", "-1", "1e999"}) refused(command, option, value);
  expect_refused("room -o out.hdr --seed 18446744073709551616", "--seed");
  // 2^32 + 8 and 8 - 2^32 become valid sizes if they are cut to 32 bits. A parser that guesses the base reads 0x14 as 20.
  for (const char* size : {"4294967304", "-4294967288", "8 ", " 8", "+8", "0x14", "99999999999999999999999", "8x"})
    refused("bake chair -o out", "--size", size);
  for (const char* angle : {"20 deg", "20rad", "inf", "deg", ""}) refused("bake chair -o out", "--angle", angle);
  EXPECT_TRUE(names().empty());
}

// -------------------------------------------------------------------------------------------------------------- runs

// An instruction set that the library has runs and gives the same hash. One that it lacks is refused by name.
TEST_F(Cli, ARunEndsWithOneHashOnEveryInstructionSetAndNumberOfThreads) {
  tiny_scene();
  const std::string command = "run tiny.json --clock virtual --isa ";
  std::set<std::string> hashes = {hash_in(done(command + "automatic --threads 2").out)};
  EXPECT_EQ(hashes.begin()->size(), std::string("hash 0x0123456789abcdef\n").size());
  for (sandglass_isa isa = SANDGLASS_ISA_SCALAR; isa <= SANDGLASS_ISA_WASM; ++isa) {
    const std::string name = sandglass_isa_name(isa);
    if (sandglass_isa_available(isa) != 0) hashes.insert(hash_in(done(command + name).out));
    else
      expect_refused(command + name, "cannot use \"" + name + "\": this CPU, or this build, lacks the instruction set");
  }
  EXPECT_EQ(hashes.size(), 1u);
}

TEST_F(Cli, ARecordedRunReplaysToTheSameHash) {
  tiny_scene();
  const std::string recorded = hash_in(done("run tiny.json --record r.sgrec").out);
  EXPECT_EQ(hash_in(done("run tiny.json --isa scalar --replay r.sgrec").out), recorded);
  EXPECT_NE(hash_in(done("run tiny.json --frames 2 --replay r.sgrec").out), recorded);
  EXPECT_NE(done("inspect r.sgrec").out.find("frames       3"), std::string::npos);
  write("cut.sgrec", read("r.sgrec").substr(0, 200));
  mesh_scene();
  // The last is refused before its mesh is looked for.
  expect_refusals(R"(
run tiny.json --frames 4 --replay r.sgrec | cannot replay "r.sgrec": it holds 3 frames. Ask for no more by --frames
run tiny.json --replay cut.sgrec | cut.sgrec
run tiny.json --replay tiny.json | tiny.json
run mesh.json --mesh none.obj --replay r.sgrec | cannot replay "r.sgrec": it was recorded from scene "tiny"
)");
}

// Estimated times do not depend on the machine, and say what they are.
TEST_F(Cli, EstimatesAPhonesFrameAndTheBudgetThatASceneNeeds) {
  tiny_scene();
  const std::string as = done("run tiny.json --as cortex-a78 --budget-ms 4").out;
  EXPECT_NE(as.find("Estimated, not measured"), std::string::npos) << as;
  EXPECT_NE(as.find("at its slowest"), std::string::npos) << as;
  EXPECT_EQ(hash_in(done("run tiny.json --as cortex-a78 --budget-ms 4 --isa scalar").out), hash_in(as));
  const std::string all = done("budget tiny.json").out;
  for (const char* words : {"cortex-x3", "cortex-a78", "cortex-a55", "0 (full)", "not measured", " ms",
                            "M instructions, most", "all of these frames"})
    EXPECT_NE(all.find(words), std::string::npos) << words;
  EXPECT_EQ(all.find("99.9 %"), std::string::npos) << "three frames tell no percentile";
  EXPECT_EQ(done("budget tiny.json").out, all);
}

TEST_F(Cli, RefusesBadScenes) {
  write("cut.json", "{\"frames\": 3,\n\"bod");
  tiny_scene("\"seed\": 1, \"particle_radius\": 0.02, ", "twice.json");
  write("inner.json", R"({"bodies": [{"shape": "box", "size": 1}, {"shape": "box", "size": 1, "shape": "sphere"}]})");
  write("cube.obj", k_cube);
  mesh_scene();
  expect_refusals(R"(
run nowhere | nowhere
run cut.json | line 2 is not valid JSON
run twice.json | cannot read "twice.json": one object has "particle_radius" twice. Remove one.
inspect inner.json | one object has "shape" twice
run demo --mesh cube.obj | --mesh
run mesh.json | --mesh
)");
  // More than a machine holds is refused in the scene file.
  const std::string sand = R"({"particle_radius": 0.001, "bodies": [{"shape": )";
  for (const std::string& scene :
       {sand + R"("box", "particles": 100000000}]})", sand + R"("lattice", "counts": [1000, 1000, 100]}]})",
        sand + R"("box", "size": [10, 10, 10]}]})", sand + R"("sphere", "size": 0.1, "grains": 100000000}]})",
        sand + R"("sphere", "size": 0.1, "grain_distance": 0.00001}]})",
        sand + R"("box", "particles": 3000000}, {"shape": "box", "particles": 3000000}]})",
        std::string(R"({"particle_radius": 0.01, "particle_capacity": 100000000,
                        "emitters": [{"position": [0, 1, 0], "radius": 0.1}]})")}) {
    write("many.json", scene);
    expect_refused("run many.json", "many.json");
  }
}

TEST_F(Cli, RefusesBadMeshes) {
  const std::string cube = k_cube;
  mesh_scene();
  write("cube.obj", cube);
  done("run mesh.json --mesh cube.obj");
  write("fin.obj", cube + "v 3 0 0\nf 1 2 9\n");
  write("sheet.obj", "v 0 1 0\nv 1 2 0\nv 1 2 1\nv 0 1 1\nf 1 2 3\nf 1 3 4\n");
  write("two_sided.obj", read("sheet.obj") + "f 3 2 1\nf 4 3 1\n");
  done("sample sheet.obj surface --distance 0.1 -o x.ply");
  EXPECT_TRUE(fs::remove(folder / "x.ply"));
  expect_refusals(R"(
run mesh.json --mesh missing.obj | missing.obj
run mesh.json --mesh fin.obj | manifold
sample sheet.obj volume --distance 0.1 -o x.ply | "sheet.obj": it encloses no volume
sample sheet.obj lattice --distance 0.1 -o x.ply | "sheet.obj": it encloses no volume
sample two_sided.obj volume --distance 0.1 -o x.ply | it encloses no volume. Take "surface", or a mesh that is a solid.
sample teapot surface --distance 1 -o x.ply | Name a mesh file, or trefoil,
)");
}

TEST_F(Cli, SamplesAMesh) {
  const std::string points = done("sample box surface --distance 0.02 --picture box.png -o box.ply").out;
  EXPECT_NE(points.find(" points on the surface of box"), std::string::npos) << points;
  EXPECT_EQ(read("box.png").substr(1, 3), "PNG");
  for (const char* where : {"volume", "lattice"}) {
    done("sample box " + std::string(where) + " --distance 0.05 -o box.ply");
    EXPECT_EQ(read("box.ply").substr(0, 3), "ply");
  }
}

TEST_F(Cli, RunsAndRefusesCollidersOfMeshes) {
  const auto scene = [&](const std::string& name, const std::string& collider) {
    write(name, R"({"frames": 2, "particle_radius": 0.01,
        "bodies": [{"shape": "box", "size": [0.06, 0.08, 0.06], "position": [0, 0.3, 0]}],
        "colliders": [{"shape": "mesh", )" +
                    collider + "}]}");
  };
  for (const char* mesh : {"trefoil", "torus", "box", "sphere", "hourglass", "bucket", "silo"}) {
    scene("mesh.json", R"("size": 0.2, "mesh": ")" + std::string(mesh) + '"');
    done("run mesh.json");
  }
  scene("teapot.json", R"("size": 0.2, "mesh": "teapot")");
  scene("none.json", R"("size": 0.2)");
  scene("coarse.json", R"("size": 0.2, "mesh": "bucket", "field_spacing": 0.5)");
  scene("fine.json", R"("size": 0.2, "mesh": "bucket", "field_spacing": 0.0002)");
  tiny_scene();
  write("cube.obj", k_cube);
  expect_refusals(R"(
run teapot.json | teapot
run none.json | --collider-mesh
run coarse.json | spacing
run fine.json | Enlarge the spacing
run mesh.json --collider-mesh missing.obj | missing.obj
run tiny.json --collider-mesh cube.obj | --collider-mesh
)");
  done("run mesh.json --collider-mesh cube.obj");  // the file goes before the name
}

// ------------------------------------------------------------------------------------------------------------- shots

// The test makes a room, a photograph of it, and the program's own chair as if it were the user's mesh.
TEST_F(Cli, RunsShotsOfFiles) {
  if (*SANDGLASS_EMULATOR != '\0')
    GTEST_SKIP() << "fills 25,000 grains three times; nothing of it is the instruction set's";
  if (!k_embree) GTEST_SKIP() << "needs a room, and this build has no Embree to trace one";
  done("room --seed 3 --width 64 --samples 1 -o room.hdr --picture room.png");
  done("room --seed 3 --width 64 --samples 1 --lamps-off -o dark.hdr");
  const auto hash_of = [&](const std::string& arguments) {
    return hash_in(done("run shot --frames 2 --clock virtual " + arguments).out);
  };
  const std::set<std::string> hashes = {hash_of("--panorama room.hdr --light truth"),
                                        hash_of("--photo room.png --fov 70 --light nothing"),
                                        hash_of("--panorama room.hdr --later dark.hdr --light truth")};
  EXPECT_EQ(hashes.size(), 3u) << "another light, another shadow";
  // A frame's time is the library's. It leaves out the made-up camera's image, which takes some 9 ms. Beside the work
  // units it has only colliders and lights.
  const std::string timed = done("run shot --frames 4 --light estimate --panorama room.hdr").out;
  const auto mean_of = [&](const std::string& row) {
    const size_t at = timed.find(row);
    return at == std::string::npos ? -1.0 : std::strtod(timed.c_str() + at + row.size(), nullptr);
  };
  EXPECT_GT(mean_of("  budget used"), 0.0) << timed;
  EXPECT_LT(mean_of("  CPU time, one thread"), mean_of("  budget used") + 3.0);
  write("cut.hdr", read("room.hdr").substr(0, 600));
  write("cube.obj", k_cube);
  expect_refusals(R"(
run shot --panorama missing.hdr | missing.hdr
run shot --panorama room.png | neither Radiance .hdr nor OpenEXR
run shot --panorama cut.hdr | cut.hdr
run shot --photo missing.png --fov 70 | missing.png
run shot --photo room.hdr --fov 70 | PNG or JPEG
run shot --photo room.png | --fov
run shot --photo room.png --fov 179 | --fov
run shot --photo room.png --fov 70 --panorama room.hdr | excludes
run shot --photo room.png --fov 70 --light truth | truth
run shot --light moon | moon
run demo --photo room.png --fov 70 | no shot
run demo --asset chair | --asset
run shot --asset missing.shadow | missing.shadow
run shot --asset room.hdr | room.hdr":
)");
  expect_refusals(R"(
run shot --object cube.obj | --asset
run shot --object missing.obj --asset chair | missing.obj
run shot --object cube.obj --asset chair | another object
)");
  const host::Mesh chair = host::make_named("chair").mesh;
  std::ostringstream mine;
  for (size_t i = 0; i < chair.vertices.size(); ++i) mine << (i % 3 == 0 ? "\nv " : " ") << chair.vertices[i];
  for (size_t i = 0; i < chair.indices.size(); ++i) mine << (i % 3 == 0 ? "\nf " : " ") << chair.indices[i] + 1;
  write("mine.obj", mine.str() + "\n");
  hash_of("--panorama room.hdr --light truth --object mine.obj --asset chair");
}

// What `bake` prints and writes for the smallest network, and what `inspect` says about it.
TEST_F(Cli, BakesAndInspectsAShadow) {
  if (!k_bake) GTEST_SKIP() << "this build bakes no shadows: Embree or Eigen is missing";
  const std::string baked = done("bake chair --quick --size 8 --threads 2 -o x.shadow --json x.json").out;
  for (const char* line : {"4 unseen lights", "SSIM and block: of 4 whole textures", "1 made-up"})
    EXPECT_NE(baked.find(line), std::string::npos) << line << "\n" << baked;
  for (const char* name : {"whole_textures", "rmse_occlusion"})
    EXPECT_NE(read("x.json").find(name), std::string::npos) << name;
  EXPECT_EQ(read("x.shadow.png").substr(1, 3), "PNG");
  const std::string output = done("inspect x.shadow").out;
  for (const char* line :
       {"baked shadow, version 2", "24 components of 16 x 16 texels, 3.6 m a side", "surface      2381 points",
        "8 neurons x (1 + 2) hidden layers, 136 MAC a texel", "20 degrees wide, up to 70 degrees from the zenith",
        "fitted to the light", "over 4 unseen lights", "float copy   no"})
    EXPECT_NE(output.find(line), std::string::npos) << line << "\n" << output;
  write("cut.shadow", read("x.shadow").substr(0, 1000));
  expect_refused("inspect cut.shadow", "cut.shadow");
}

TEST_F(Cli, InspectSaysWhatAFileIs) {
  tiny_scene();
  photograph("wall.png");
  photograph("picture");  // its content tells, not its name
  panorama("room.hdr", 20);
  write("cut.light", random_network().substr(0, 900));
  write("empty", "");
  write("notes.txt", "Sand, light and shadow.\n");
  write("cube.obj", k_cube);
  write("broken.obj", "no mesh");
  write("old.gif", "GIF89a, and so on");
  write("cut.exr", "\x76\x2f\x31\x01 cut off");
  const std::pair<const char*, const char*> lines[] = {{"tiny.json", "memory"},
                                                       {"random.light", "lighting network 'random'"},
                                                       {"wall.png", "picture, 64 x 48 pixels"},
                                                       {"picture", "picture, 64 x 48 pixels"},
                                                       {"room.hdr", "panorama, 64 x 32 pixels"}};
  for (const auto& [file, line] : lines)
    EXPECT_NE(done("inspect " + std::string(file)).out.find(line), std::string::npos) << file;
  expect_refusals(R"(
inspect empty | the file is empty
inspect missing | missing
inspect cut.light | cut off
inspect cut.exr | cut.exr
inspect old.gif | it is a GIF picture. Convert it to PNG or JPEG.
inspect notes.txt | it is no kind of mesh that is known here, and no recording, shadow, lighting network, scene,
inspect broken.obj | broken.obj
inspect cube.obj --up x | --up
)");
  const std::string mesh = done("inspect cube.obj").out;
  for (const char* line : {"watertight   yes", "orientation  outward"})
    EXPECT_NE(mesh.find(line), std::string::npos) << mesh;
}

// ------------------------------------------------------------------------------------------------------------- light

// A network of random numbers knows nothing about light, but its answers are written like those of any other.
TEST_F(Cli, LightWritesNumbersAndPicturesForEveryPhotograph) {
  random_network();
  // Names that are equal, and one that is no UTF-8.
  for (const char* name : {"one.png", "sub/one.png", "caf\xe9.png"}) {
    fs::create_directories((folder / name).parent_path());
    photograph(name);
  }
  const std::string out = done("light one.png sub/one.png 'caf\xe9.png' --fov 60 --network random.light -o out").out;
  EXPECT_EQ(std::count(out.begin(), out.end(), '\n'), 3);
  for (const char* name : {"one", "one_2", "caf\xe9"})
    EXPECT_EQ(read("out/" + std::string(name) + ".png").substr(1, 3), "PNG") << name;
  const std::string json = read("out/caf\xe9.json");
  for (const char* part : {"\"image\": \"caf\xef\xbf\xbd.png\"", "direction_camera", "direction_world", "light",
                           "ambient", "contrast", "strength", "sh"})
    EXPECT_NE(json.find(part), std::string::npos) << part << "\n" << json;
}

TEST_F(Cli, LightsBadInputIsOneSentence) {
  write("cut.light", random_network().substr(0, 900));
  write("text.png", "not a picture");
  photograph("fine.png");
  photograph("dot.png", {90, 120, 40}, 1);
  photograph("black.png", {8, 8, 8});
  expect_refusals(R"(
light fine.png -o out --network nowhere | nowhere
light fine.png -o out --network cut.light | cut off
light fine.png -o out --network text.png | not a lighting network
light gone.png -o out --network random.light | gone.png
light text.png -o out --network random.light | text.png
light '' -o out --network random.light | is empty
light dot.png -o out --network random.light | dot.png
light fine.png black.png -o out --network random.light | "black.png": it is black everywhere. Take a photograph that shows something.
)");
}

TEST_F(Cli, PanoramasAreToldApartByTheirNames) {
  panorama("x/room.hdr", 20);
  panorama("x/hall.hdr", 20, 0.3);
  panorama("y/room.hdr", 20, 0.5);
  write("empty.csv", "");
  write("one.csv", "file,group,fold\nroom.hdr,a,1\n");
  write("typo.csv", "file,group,fold\nroom.hdr,a,1\nhal.hdr,b,2\n");
  write("good.csv", "file,group,fold\nroom.hdr,a,1\nhall.hdr,b,2\n");
  write("late/room.hdr", read("x/room.hdr"));
  write("late/z.hdr", read("x/room.hdr").substr(0, 300));
  expect_refusals(R"(
dataset nowhere -o out | nowhere
dataset late -o out | z.hdr
dataset x y -o out | "y/room.hdr": "x/room.hdr" has the same name
dataset x -o out --manifest empty.csv | empty.csv
dataset x -o out --manifest one.csv | "hall.hdr"
dataset x -o out --manifest typo.csv | "hall.hdr"
)");
  done("dataset x --manifest good.csv -o out");
  const std::string made = read("out/manifest.csv");
  EXPECT_NE(made.find("hall.hdr,b,2"), std::string::npos) << made;
  EXPECT_NE(made.find("room.hdr,a,1"), std::string::npos) << made;
}

// -------------------------------------------------------------------------------------------------------- laboratory

TEST_F(Cli, VerifiesAChosenCase) {
  const std::string out = done("verify granular --case refinement").out;
  for (const char* words : {"7 rows, 0 failed", "refinement  uniform field reproduced", "fails, as it must"})
    EXPECT_NE(out.find(words), std::string::npos) << out;
}

// A verification that would check nothing must not pass.
TEST_F(Cli, AVerificationOfNoPanoramasIsRefused) {
  fs::create_directories(folder / "none");
  expect_refusals(R"(
verify shot | no panoramas are named. Name .hdr or .exr files
verify shot --panoramas none | no .hdr or .exr
verify lighting | no panoramas are named. Name .hdr or .exr files
)");
}

// Without arguments, `verify lighting` takes the data folder's interiors and studios, place by place, with their
// cross-validated estimates. For panoramas that are named it takes the shipped network, and says at once if that was
// fitted to them. The manifest then stops it, before the network has run some hundred times.
TEST_F(Cli, VerifiesLightingOnTheDataFolder) {
  panorama("hdri/indoor/vestibule_1k.hdr", 20);
  panorama("hdri/studio/studio_small_05_1k.hdr", 40);
  write("manifest.csv", "file,group,fold\nvestibule_1k.hdr,a,1\nstudio_small_05_1k.hdr,b,2\n");
  ::setenv("SANDGLASS_DATA_DIR", folder.c_str(), 1);
  const Outcome whole = run("verify lighting");
  ::unsetenv("SANDGLASS_DATA_DIR");
  EXPECT_LE(whole.code, 1) << whole.err;  // made-up panoramas under real names prove nothing
  for (const char* words : {"cross_validated_estimates.csv", "direction against mean light, 97.5 %"})
    EXPECT_NE(whole.out.find(words), std::string::npos) << whole.out;
  panorama("named/vestibule_1k.hdr", 20);
  panorama("named/elsewhere.hdr", 40);
  write("other.csv", "file,group,fold\nother.hdr,a,1\n");
  const Outcome known = run("verify lighting --panoramas named --manifest other.csv");
  EXPECT_EQ(known.code, 2) << known.err;
  EXPECT_TRUE(known.out.starts_with("1 of 2 panoramas are of places that the network was fitted to")) << known.out;
  fs::remove(folder / "named/vestibule_1k.hdr");
  EXPECT_EQ(run("verify lighting --panoramas named --manifest other.csv").out, "");
}

}  // namespace
}  // namespace sandglass
