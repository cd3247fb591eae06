// What the program does to files: nothing that it reads is written over, no two outputs have one name, a folder says when
// it is incomplete, what is no file of a sensible size is refused at once, and Ctrl-C is answered within a second.
#include <sys/file.h>
#include <sys/stat.h>

#include "models/files/command_files.h"
#include "models/files/image.h"
#include "models/lighting/dataset.h"
#include "tests/program/cli.h"

namespace sandglass {
namespace {

constexpr double k_answer_s = 1.0;  // Ctrl-C and refusals, as promised
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool k_sanitized = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
constexpr bool k_sanitized = true;
#else
constexpr bool k_sanitized = false;
#endif
#else
constexpr bool k_sanitized = false;
#endif
// The promise holds on a machine that has time for the program: not for an emulated, instrumented one.
const bool k_patient = k_sanitized || *SANDGLASS_EMULATOR != '\0';
const double k_limit_s = k_patient ? 10 * k_answer_s : 2 * k_answer_s;

class CliFiles : public Cli {
 protected:
  std::string cube(const std::string& name = "cube.obj") const { return write(name, k_cube); }
  Running start(const std::string& arguments) const { return Running(arguments, path("stdout"), path("stderr")); }
  double seconds_of(const std::string& arguments, int code) const {
    const auto from = std::chrono::steady_clock::now();
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, code) << arguments << "\n" << outcome.err;
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
  }
  // Expects that the command is refused and the file stays as it is.
  void expect_kept(const std::string& file, const std::string& arguments, const std::string& said = "reads it") const {
    const std::string before = read(file);
    expect_refused(arguments, said);
    EXPECT_EQ(read(file), before) << arguments;
  }
  // A scene that takes far longer than a test.
  std::string endless() const { return "run '" + tiny_scene() + "' --frames 100000000 "; }
};

TEST_F(CliFiles, NoInputIsWrittenOver) {
  if (!k_assimp) GTEST_SKIP() << "reads mesh files";
  const std::string mesh = cube(), sample = "sample " + mesh + " --surface --distance 0.3 ";
  expect_kept(mesh, sample + "-o " + mesh);
  expect_kept(mesh, sample + "-o " + path("x.ply") + " --picture " + mesh);
  expect_kept(mesh, sample + "-o " + path("./nothing/../cube.obj"), "nothing");
  fs::create_directories(folder / "sub");
  expect_kept(mesh, sample + "-o " + path("sub/../cube.obj"));
  fs::create_hard_link(mesh, path("hard.ply"));
  expect_kept(mesh, sample + "-o " + path("hard.ply"));
  fs::create_symlink(mesh, path("soft.ply"));
  expect_kept(mesh, sample + "-o " + path("soft.ply"));
  fs::create_symlink(path("cube.obj"), path("soft.obj"));
  expect_kept(mesh, "sample " + path("soft.obj") + " --surface --distance 0.3 -o " + mesh);
  EXPECT_TRUE(fs::is_symlink(path("soft.ply")));

  const std::string scene = mesh_scene(), recording = path("r.sgrec");
  expect_kept(scene, "run " + scene + " --mesh " + mesh + " --record " + scene);
  expect_kept(mesh, "run " + scene + " --mesh " + mesh + " --record " + mesh);
  fs::create_directories(folder / "out");
  fs::copy(scene, path("out/summary.json"));
  expect_kept(path("out/summary.json"),
              "run " + path("out/summary.json") + " --mesh " + mesh + " --out " + path("out"));
  ASSERT_EQ(run("run " + scene + " --mesh " + mesh + " --record " + recording).code, 0);
  ASSERT_EQ(run("run " + scene + " --mesh " + mesh + " --record " + recording).code, 0)
      << "an earlier output is no input";
}

TEST_F(CliFiles, ThePartsBesideAMeshAreInputs) {
  if (!k_assimp) GTEST_SKIP() << "reads mesh files";
  const std::string mesh = write("painted.obj", "mtllib painted.mtl\nusemtl red\n" + std::string(k_cube));
  const std::string paint = write("painted.mtl", "newmtl red\nKd 1 0 0\n");
  fs::create_hard_link(paint, path("paint.ply"));
  expect_kept(paint, "sample " + mesh + " --surface --distance 0.3 -o " + path("paint.ply"));
}

TEST_F(CliFiles, NoInputOfTheLightingToolsIsWrittenOver) {
  const std::string network = write("random.light", random_network());
  fs::create_directories(folder / "set/images");
  host::write_png(path("set/images/a.png"), host::Picture(256, 192, {90, 120, 40}));
  const std::string manifest = write("set/manifest.csv", "image\nimages/a.png\n");
  const std::string features = "light-features " + network + " " + path("set") + " -o ";
  expect_kept(network, features + network);
  expect_kept(manifest, features + manifest);
  expect_kept(path("set/images/a.png"), features + path("set/images/a.png"));
  const std::string room = panorama("rooms/room.hdr", 20);
  fs::create_directories(folder / "out");
  fs::create_hard_link(room, path("out/sheet.png"));
  expect_kept(room, "dataset " + room + " -o " + path("out"));
}

TEST_F(CliFiles, ABakeKeepsItsMesh) {
  if (!k_bake || !k_assimp) GTEST_SKIP() << "this build bakes no shadows of mesh files";
  const std::string mesh = cube(), small = " --size 8x1 --steps 1 --textures 1 ";
  expect_kept(mesh, "bake " + mesh + small + "-o " + mesh);
  expect_kept(mesh, "bake " + mesh + small + "-o " + path("x.shadow") + " --picture " + mesh);
  expect_kept(mesh, "bake " + mesh + small + "-o " + path("x.shadow") + " --json " + mesh);
  fs::create_symlink(mesh, path("x.shadow.png"));
  expect_kept(mesh, "bake " + mesh + small + "-o " + path("x.shadow"));
  const std::string twice = "two outputs";
  expect_refused("bake box" + small + "-o " + path("y") + " --picture " + path("y"), twice);
  expect_refused("bake box" + small + "-o " + path("y") + " --json " + path("y.png"), twice);
  expect_refused("bake box" + small + "-o " + path("y") + " --json " + path("y.checkpoint"), twice);
}

TEST_F(CliFiles, ACheckpointReplacesNoOtherFile) {
  if (!k_bake || !k_assimp) GTEST_SKIP() << "this build bakes no shadows of mesh files";
  const std::string mesh = cube(), small = " --size 8x1 --steps 1 --textures 1 ", out = "-o " + path("y");
  const std::string checkpoint = path("y.checkpoint");
  fs::create_symlink(mesh, checkpoint);
  expect_kept(mesh, "bake " + mesh + small + out);
  expect_kept(mesh, "bake box" + small + out, "no checkpoint");
  fs::remove(checkpoint);
  fs::create_hard_link(mesh, checkpoint);
  expect_kept(mesh, "bake " + mesh + small + out + " --resume");
  fs::remove(checkpoint);
  write("y.checkpoint", k_cube);
  for (const char* resume : {"", " --resume"}) {
    expect_kept(checkpoint, "bake " + checkpoint + small + out + resume);
    expect_kept(checkpoint, "bake box" + small + out + resume, "no checkpoint");
  }
  EXPECT_FALSE(fs::exists(path("y")));
}

TEST_F(CliFiles, NoTwoOutputsHaveOneName) {
  const std::string twice = "two outputs", box = "sample box --surface --distance 0.3 -o ";
  expect_refused(box + path("x") + " --picture " + path("x"), twice);
  fs::create_directories(folder / "sub");
  expect_refused(box + path("x") + " --picture " + path("sub/../x"), twice);
  write("old.ply", "old");
  fs::create_hard_link(path("old.ply"), path("old.png"));
  expect_refused(box + path("old.ply") + " --picture " + path("old.png"), twice);
  EXPECT_EQ(read(path("old.ply")), "old");
  fs::create_directories(folder / "out");
  const std::string tiny = "run '" + tiny_scene() + "' --out " + path("out") + " --record ";
  for (const char* name : {"report.csv", "trace.json", "summary.txt", "report.html", "last_frame.png"})
    expect_refused(tiny + path(std::string("out/") + name), twice);
  EXPECT_EQ(run(tiny + path("out/r.sgrec") + " --frames 1").code, 0);
  expect_refused("room --width 16 --samples 1 -o " + path("a.hdr") + " --picture " + path("a.hdr"), twice);
  expect_refused("room --width 16 --samples 1 -o " + path("a.hdr") + " --picture " + path("a_depth.npy"), twice);
  EXPECT_FALSE(fs::exists(path("x")) || fs::exists(path("a.hdr")));
  const std::string run_to = "run '" + tiny_scene() + "' --out ", both = "a file is no folder";
  expect_refused(run_to + path("new") + " --record " + path("new"), both);
  expect_refused(run_to + path("new/inner") + " --record " + path("new"), both);
  EXPECT_FALSE(fs::exists(path("new"))) << "refused before the work";
}

TEST_F(CliFiles, AnOutputBehindALinkKeepsTheLink) {
  write("old.ply", "old");
  fs::create_symlink(path("old.ply"), path("link.ply"));
  ASSERT_EQ(run("sample box --surface --distance 0.3 -o " + path("link.ply")).code, 0);
  EXPECT_TRUE(fs::is_symlink(path("link.ply")));
  EXPECT_EQ(read(path("old.ply")).substr(0, 3), "ply");
}

TEST_F(CliFiles, AFolderSaysWhenItIsIncomplete) {
  const std::string out = " --out " + path("out"), mark = path(std::string("out/") + host::k_incomplete);
  {
    Running longer = start(endless() + out);
    ASSERT_TRUE(longer.makes(mark));
    // Another process may not write there, and says so before it begins.
    const Outcome second = run("run '" + tiny_scene() + "'" + out);
    EXPECT_EQ(second.code, 2) << second.err;
    EXPECT_NE(second.err.find("another process"), std::string::npos) << second.err;
  }  // killed, without a chance to tidy up
  EXPECT_TRUE(fs::exists(mark));
  write("out/truth.png", "of an earlier run"), write("out/mine.txt", "of no run");
  ASSERT_EQ(run("run '" + tiny_scene() + "' --frames 1" + out).code, 0) << "a dead process locks nothing";
  EXPECT_FALSE(fs::exists(mark));
  EXPECT_FALSE(fs::exists(path("out/truth.png"))) << "it would be taken for a result of this run";
  EXPECT_TRUE(fs::exists(path("out/mine.txt")) && fs::exists(path("out/last_frame.png")));
  EXPECT_TRUE(fs::exists(path("out/film.mp4")) || fs::exists(path("out/film.gif")));
  Running interrupted = start(endless() + out);
  ASSERT_TRUE(interrupted.makes(mark));
  interrupted.interrupt();
  EXPECT_EQ(interrupted.wait(), 130);
  EXPECT_TRUE(fs::exists(mark)) << "the film is that of the run before";
}

TEST_F(CliFiles, TheMarkOfAFolderReplacesNoOtherFile) {
  const std::string scene = tiny_scene(), out = path("out"), mark = path(std::string("out/") + host::k_incomplete);
  fs::create_directories(out);
  fs::copy(scene, mark);
  expect_kept(mark, "run " + mark + " --out " + out);
  host::write_png(path("wall.png"), host::Picture(256, 192, {90, 120, 40}));
  fs::copy(path("wall.png"), mark, fs::copy_options::overwrite_existing);
  const std::string network = write("random.light", random_network());
  expect_kept(mark, "light " + mark + " -o " + out + " --network " + network);
  // A file that would be read only later.
  expect_kept(mark, "run " + mesh_scene() + " --mesh " + mark + " --out " + out, "the name of the mark");
  fs::remove(mark);
  fs::create_symlink("../tiny.json", mark);
  expect_kept(scene, "run " + scene + " --out " + out);
  expect_kept(scene, "run demo --frames 1 --out " + out, "the name of the mark");
  fs::remove(mark);
  fs::create_hard_link(scene, mark);
  expect_kept(scene, "run " + scene + " --out " + out);
  expect_kept(scene, "run demo --frames 1 --out " + out, "the name of the mark");
  fs::remove(mark);
  ASSERT_EQ(::mkfifo(mark.c_str(), 0600), 0);
  expect_refused("run " + scene + " --out " + out, "the name of the mark");
}

TEST_F(CliFiles, NoResultHasTheNameOfTheMark) {
  const std::string out = path("out"), mark = path(std::string("out/") + host::k_incomplete);
  fs::create_directories(out);
  expect_refused("run " + tiny_scene() + " --out " + out + " --record " + mark, "two outputs");
  write("out/" + std::string(host::k_incomplete), "of a run that was killed");
  expect_refused("run " + tiny_scene() + " --out " + out + " --record " + mark, "two outputs");
}

TEST_F(CliFiles, AnOldFrameThatIsReadStays) {
  constexpr int k_old = 10;  // of a run that was longer than one of three frames
  const std::string scene = tiny_scene(), out = " --out " + path("out");
  fs::create_directories(folder / "out/frames");
  const auto frame = [&](int index) { return path("out/frames/frame_00000" + std::to_string(index) + ".png"); };
  for (int index = 0; index < k_old; ++index) fs::copy(scene, frame(index));
  expect_kept(frame(k_old - 1), "run " + frame(k_old - 1) + out);
  EXPECT_FALSE(fs::exists(path("out/last_frame.png"))) << "it is refused before the work";
  expect_kept(frame(0), "run " + mesh_scene() + " --mesh " + frame(0) + out);
  ASSERT_EQ(run("run " + scene + out).code, 0);
  for (int index = 0; index < k_old; ++index)
    EXPECT_TRUE(!fs::exists(frame(index)) || read(frame(index)).substr(1, 3) == "PNG") << index;
  EXPECT_FALSE(fs::exists(frame(4))) << "three frames and the start make at most four pictures";
}

TEST_F(CliFiles, ACommandThatWritesNothingLeavesTheFolderAsItWas) {
  // The mesh is asked for after the folder was begun.
  const std::string refused = "run " + mesh_scene() + " --mesh " + path("none.obj") + " --out ";
  expect_refused(refused + path("new/inner"), "none.obj");
  EXPECT_FALSE(fs::exists(folder / "new"));
  ASSERT_EQ(run("run '" + tiny_scene() + "' --out " + path("out")).code, 0);
  const std::string summary = read(path("out/summary.json")), mark = path(std::string("out/") + host::k_incomplete);
  expect_refused(refused + path("out"), "none.obj");
  EXPECT_FALSE(fs::exists(mark)) << "it is still whole";
  EXPECT_EQ(read(path("out/summary.json")), summary);
  {
    Running killed = start(endless() + "--out " + path("out"));
    ASSERT_TRUE(killed.makes(mark));
  }
  expect_refused(refused + path("out"), "none.obj");
  EXPECT_TRUE(fs::exists(mark)) << "whoever was killed may have written something";
}

TEST_F(CliFiles, AFolderIsTakenBeforeTheWork) {
  const std::string out = path("out"), mark = path(std::string("out/") + host::k_incomplete);
  fs::create_directories(out);
  const std::string room = panorama("rooms/room.hdr", 20), network = write("random.light", random_network());
  const std::string panoramas = " --panoramas " + room + " --network " + network;
  std::vector<std::string> commands = {"verify granular --quick", "verify follow", "bench ladder --frames 10000",
                                       "verify lighting" + panoramas};
  if (k_embree) commands.push_back("verify room" + panoramas), commands.push_back("verify shot" + panoramas);
  const auto every = [&](const std::string& said) {
    for (const std::string& command : commands) {
      const auto from = std::chrono::steady_clock::now();
      expect_refused(command + " --out " + out, said);
      const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
      EXPECT_LT(seconds, k_limit_s) << command;
    }
  };
  const int lock = ::open(write("out/" + std::string(host::k_incomplete), "").c_str(), O_RDWR);
  ASSERT_EQ(::flock(lock, LOCK_EX), 0);
  every("another process");
  // It asks before it reads what is no panorama.
  expect_refused("dataset " + write("rooms/no.hdr", "no panorama") + " -o " + out, "another process");
  ::close(lock);
  expect_refused("dataset " + path("rooms/no.hdr") + " -o " + out, "no.hdr");
  for (const char* name : {"verify.md", "ladder.md"}) fs::create_directories(fs::path(out) / name);
  every("it is a folder");
}

TEST_F(CliFiles, TheFilmsFolderIsNoOtherResult) {
  const std::string tiny = "run '" + tiny_scene() + "' --out " + path("out");
  fs::create_directories(folder / "out");
  expect_refused(tiny + " --record " + path("out/frames"), "two outputs");
  EXPECT_TRUE(fs::is_empty(folder / "out"));
  expect_kept(write("out/frames", "of no run"), tiny, "a file has that name");
  EXPECT_FALSE(fs::exists(path("out/last_frame.png")));
  const std::string images = write("out/images", "of no run");
  expect_kept(images, "dataset " + panorama("room.hdr", 20) + " -o " + path("out"), "a file has that name");
}

TEST_F(CliFiles, ADatasetDoesNotMixWithAnother) {
  const std::string room = panorama("rooms/room.hdr", 20), hall = panorama("rooms/hall.hdr", 20, 0.3);
  ASSERT_EQ(run("dataset " + room + " -o " + path("out")).code, 0);
  const std::string manifest = read(path("out/manifest.csv"));
  expect_refused("dataset " + hall + " -o " + path("out"), "earlier run");
  EXPECT_EQ(read(path("out/manifest.csv")), manifest);
  EXPECT_FALSE(fs::exists(path(std::string("out/") + host::k_incomplete)));
  EXPECT_EQ(host::images_of_dataset(path("out")).size(), 8u);
  write(std::string("out/") + host::k_incomplete, "");
  expect_refused(
      "light-features " + write("random.light", random_network()) + " " + path("out") + " -o " + path("x.npy"),
      "incomplete");
}

TEST_F(CliFiles, WhatIsNoFileOfASensibleSizeIsRefusedAtOnce) {
  const std::string huge = path("huge"), out = " -o " + path("out");
  for (const char* name : {"huge.light", "huge.png", "huge.hdr", "huge.obj", "huge.json"}) {
    write(name, "{");
    fs::resize_file(path(name), uintmax_t{5} << 30);  // takes no room on the disk
  }
  for (const char* name : {"pipe.png", "pipe.hdr", "pipe.obj", "pipe.exr"})
    ASSERT_EQ(::mkfifo(path(name).c_str(), 0600), 0);
  const std::string network = write("random.light", random_network());
  host::write_png(path("fine.png"), host::Picture(64, 48, {9, 9, 9}));
  const std::vector<std::string> commands = {
      "inspect " + path("huge.light"),
      "inspect /dev/zero",
      "inspect " + path("pipe.obj"),
      "inspect " + folder.string(),
      "light " + path("fine.png") + out + " --network " + path("huge.light"),
      "light " + path("fine.png") + out + " --network /dev/zero",
      "light " + path("huge.png") + out + " --network " + network,
      "light " + path("pipe.png") + out + " --network " + network,
      "light /dev/zero" + out + " --network " + network,
      "run " + path("huge.json"),
      "run /dev/zero",
      "run " + mesh_scene() + " --mesh " + path("huge.obj"),
      "run " + mesh_scene() + " --mesh " + path("pipe.obj"),
      "run demo --replay " + path("huge.light"),
      "run demo --replay /dev/zero",
      "run demo --replay " + path("pipe.png"),
      "sample " + path("huge.obj") + " --surface --distance 1" + out,
      "sample /dev/zero --surface --distance 1" + out,
      "dataset " + path("huge.hdr") + out,
      "dataset " + path("pipe.hdr") + out,
      "dataset " + path("pipe.exr") + out,
      "dataset " + panorama("room.hdr", 20) + " --manifest /dev/zero" + out,
      "light-features " + path("huge.light") + " " + folder.string() + out,
  };
  for (const std::string& command : commands) {
    EXPECT_LT(seconds_of(command, 2), k_limit_s) << command;
    EXPECT_FALSE(fs::exists(path("out"))) << command;
  }
}

TEST_F(CliFiles, ShadowsAndNetworksHaveTheSmallerLimit) {
  const std::string kinds[] = {"SGSH", "SGLN"};
  for (const std::string& kind : kinds) {
    write(kind, std::string(4, '\0') + kind);
    fs::resize_file(path(kind), uintmax_t{300} << 20);
    expect_refused("inspect " + path(kind), "256 MiB");
  }
  if (k_bake) expect_refused("bake chair --ambient-only -o " + path("SGSH"), "256 MiB");
  if (k_embree)
    expect_refused("verify shot --panoramas " + panorama("room.hdr", 20) + " --network " + path("SGLN"), "256 MiB");
  write("long.json", "{");
  fs::resize_file(path("long.json"), uintmax_t{17} << 20);
  expect_refused("inspect " + path("long.json"), "16 MiB");
}

TEST_F(CliFiles, ASceneThatIsNoFileIsSaidToBeNone) {
  ASSERT_EQ(::mkfifo(path("pipe.json").c_str(), 0600), 0);
  for (const char* command : {"run ", "inspect ", "budget "}) {
    expect_refused(command + path("pipe.json"), "no ordinary file");
    expect_refused(std::string(command) + "/dev/zero", "no ordinary file");
    expect_refused(command + folder.string(), "it is a folder");
  }
  expect_refused("run " + path("none.json"), "no file and no shipped scene");
}

TEST_F(CliFiles, OutputsAreOrdinaryFiles) {
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  for (const std::string& output : {path("pipe"), std::string("/dev/full"), folder.string(), path("none/x")})
    EXPECT_LT(seconds_of("sample box --surface --distance 0.3 -o " + output, 2), k_limit_s) << output;
}

TEST_F(CliFiles, AWriteProtectedOutputStays) {
  const auto protect = [&](const std::string& name) {
    EXPECT_EQ(::chmod(write(name, "kept").c_str(), 0444), 0);  // who asks may be root, whom the system lets write
    return path(name);
  };
  const std::string sample = "sample box --surface --distance 0.3 -o ", protected_file = protect("a.ply");
  expect_kept(protected_file, sample + protected_file, "write-protected");
  fs::create_symlink(protected_file, path("link.ply"));
  expect_kept(protected_file, sample + path("link.ply"), "write-protected");
  expect_kept(protect("b.png"), sample + path("b.ply") + " --picture " + path("b.png"), "write-protected");
  EXPECT_FALSE(fs::exists(path("b.ply"))) << "it is refused before the work";
  fs::create_directories(folder / "out");
  expect_kept(protect("out/report.csv"), "run " + tiny_scene() + " --out " + path("out"), "write-protected");
  EXPECT_FALSE(fs::exists(path("out/last_frame.png")));
  struct stat status = {};
  ASSERT_EQ(::stat(protected_file.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777u, 0444u);
  ASSERT_EQ(::chmod(protected_file.c_str(), 0200), 0);
  EXPECT_EQ(run(sample + protected_file).code, 0) << "one bit is enough";
}

TEST_F(CliFiles, MoreThanAMachineHoldsIsRefusedInTheSceneFile) {
  const std::string sand = R"({"particle_radius": 0.001, "bodies": [{"shape": )";
  const std::string many[] = {
      sand + R"("box", "particles": 100000000}]})",
      sand + R"("lattice", "counts": [1000, 1000, 100]}]})",
      sand + R"("box", "size": [10, 10, 10]}]})",
      sand + R"("sphere", "size": 0.1, "grains": 100000000}]})",
      sand + R"("sphere", "size": 0.1, "grain_distance": 0.00001}]})",
      sand + R"("box", "particles": 3000000}, {"shape": "box", "particles": 3000000}]})",
      R"({"particle_radius": 0.01, "particle_capacity": 100000000, "emitters": [{"position": [0, 1, 0], "radius": 0.1}]})"};
  for (const std::string& scene : many)
    for (const char* command : {"run ", "inspect "})
      EXPECT_LT(seconds_of(command + write("many.json", scene), 2), k_limit_s) << scene;
}

TEST_F(CliFiles, CtrlCIsAnsweredWithinASecond) {
  const std::string out = " -o " + path("out");
  panorama("rooms/room.hdr", 20);
  struct Case {
    std::string command;
    int milliseconds;  // until the key is pressed
  };
  std::vector<Case> cases = {
      {"sample sphere --volume --distance 0.0015" + out, 200},
      {"inspect " + write("fill.json", R"({"particle_radius": 0.0004, "bodies": [{"shape": "sphere", "size": 0.1,
                                           "grains": 4000000}]})"),
       200},
      {"run " + path("fill.json"), 200},
      {endless(), 200},
      {endless() + "--threads 2 --record " + path("r.sgrec"), 200},
      {"verify granular", 300},
      {"verify follow", 300}};
  // It asks after every frame, and an emulated one of 14,280 particles takes half a minute.
  if (*SANDGLASS_EMULATOR == '\0') cases.push_back({"bench granular", 300});
  if (k_embree) cases.push_back({"room --width 4096 --samples 64" + out + ".hdr", 300});
  if (k_bake) cases.push_back({"bake chair" + out, 500});
  cases.push_back({"budget " + tiny_scene() + " --frames 1000000", 300});
  const std::string network = write("random.light", random_network());
  host::write_png(path("wall.png"), host::Picture(256, 192, {90, 120, 40}));
  std::string photographs = "light --network " + network + out + "_light", panoramas = "dataset" + out + "_set";
  for (int copy = 0; copy < 500; ++copy) {
    photographs += " " + path("wall.png");
    const std::string other = path("rooms/" + std::to_string(copy) + ".hdr");
    fs::create_hard_link(path("rooms/room.hdr"), other);
    panoramas += " " + other;
  }
  cases.push_back({photographs, 500});
  cases.push_back({panoramas, 500});
  cases.push_back({"bench lighting --asset " + network, 500});
  cases.push_back({"bench lighting --asset " + network, 2500});
  if (k_bake) cases.push_back({"bench shadow", 500}), cases.push_back({"bench shadow", 3000});
  for (const Case& each : cases) {
    // A busy machine needs time even for a process that does nothing.
    const double limit = k_patient ? k_limit_s : k_answer_s + seconds_of("--version", 0);
    Running program = start(each.command);
    std::this_thread::sleep_for(std::chrono::milliseconds(each.milliseconds));
    program.interrupt();
    double seconds = 0;
    EXPECT_EQ(program.wait(&seconds), 130) << each.command << read(path("stderr"));
    EXPECT_LT(seconds, limit) << each.command.substr(0, 60);
    EXPECT_NE(read(path("stderr")).find("sandglass: interrupted"), std::string::npos) << each.command;
    for (const auto& entry : fs::directory_iterator(folder))
      EXPECT_EQ(entry.path().string().find(".unfinished."), std::string::npos) << entry.path();
  }
}

// One thread has noticed Ctrl-C when the other is still in the middle of a long task.
TEST_F(CliFiles, OneOfSeveralThreadsDoesNotAnswerForAll) {
  if (k_patient) GTEST_SKIP() << "its picture takes long to make";
  const auto write_room = [&](const std::string& name, int height) {
    host::RadianceMap room(2 * height, height);
    for (size_t i = 0; i < room.rgb.size(); ++i) room.rgb[i] = i % 9999 == 0 ? 90.0f : 0.3f;
    host::write_hdr(path(name), room);
  };
  write_room("a.hdr", 4096);
  write_room("b.hdr", 512);
  std::string command = "dataset " + path("a.hdr") + " --threads 2 -o " + path("out");
  for (int copy = 0; copy < 200; ++copy) {
    command += " " + path("b" + std::to_string(copy) + ".hdr");
    fs::create_hard_link(path("b.hdr"), path("b" + std::to_string(copy) + ".hdr"));
  }
  Running program = start(command);
  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  program.interrupt();
  double seconds = 0;
  EXPECT_EQ(program.wait(&seconds), 130) << read(path("stderr"));
  EXPECT_LT(seconds, k_limit_s);
  EXPECT_NE(read(path("stderr")).find("sandglass: interrupted"), std::string::npos);
}

// ffmpeg is another process, with its own half-written file.
TEST_F(CliFiles, AnEndedProgramEndsTheFilm) {
  if (k_patient) GTEST_SKIP() << "its pictures take long to draw";
  fs::create_directories(folder / "bin");
  const std::string slow = write("bin/ffmpeg",
                                 "#!/bin/sh\n"
                                 "[ \"$1\" = -version ] && exit 0\n"
                                 "for last; do :; done\n"
                                 "echo half > \"$last\"\n"
                                 "echo $$ > \"${0%/*}/pid\"\n"
                                 "exec sleep 60\n");
  fs::permissions(slow, fs::perms::owner_all);
  const std::string before = std::getenv("PATH");
  ::setenv("PATH", (path("bin") + ":" + before).c_str(), 1);
  Running program = start("run '" + tiny_scene() + "' --out " + path("out"));
  ::setenv("PATH", before.c_str(), 1);
  for (int look = 0; look < 3000 && read(path("bin/pid")).empty(); ++look)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  ASSERT_FALSE(read(path("bin/pid")).empty()) << "no film was begun";
  program.interrupt();
  double seconds = 0;
  EXPECT_EQ(program.wait(&seconds), 130);
  EXPECT_LT(seconds, k_limit_s);
  EXPECT_EQ(::kill(std::stoi(read(path("bin/pid"))), 0), -1) << "ffmpeg goes on";
  for (const auto& entry : fs::directory_iterator(path("out")))
    EXPECT_EQ(entry.path().string().find(".unfinished."), std::string::npos) << entry.path();
}

TEST_F(CliFiles, AnInterruptedCommandSaysWhatItLeaves) {
  const auto expect_said = [&](const std::string& command, const fs::path& first, const std::string& said) {
    Running program = start(command);
    if (!first.empty()) ASSERT_TRUE(program.makes(first)) << read(path("stderr"));
    else std::this_thread::sleep_for(std::chrono::milliseconds(500));
    program.interrupt();
    EXPECT_EQ(program.wait(), 130);
    EXPECT_TRUE(read(path("stderr")).ends_with(said)) << said << read(path("stderr"));
  };
  expect_said("budget " + tiny_scene() + " --frames 100000000", "", "sandglass: interrupted; nothing was written.\n");
  expect_said(endless() + "--record " + path("r.sgrec"), "",
              "sandglass: interrupted; each file that was written is whole.\n");
  if (*SANDGLASS_EMULATOR != '\0') return;  // one estimate takes longer than the program's patience
  host::write_png(path("wall.png"), host::Picture(256, 192, {90, 120, 40}));
  std::string photographs = "light -o " + path("out") + " --network " + write("random.light", random_network());
  for (int copy = 0; copy < 500; ++copy) photographs += " " + path("wall.png");
  expect_said(photographs, path("out/wall.png"), "out\" is incomplete.\n");
}

TEST_F(CliFiles, TheSecondCtrlCEndsAtOnce) {
  // Interrupted after some frames, a run draws them. The second key ends that.
  Running program = start(endless() + "--out " + path("out"));
  ASSERT_TRUE(program.makes(path(std::string("out/") + host::k_incomplete)));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  program.interrupt();
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  program.interrupt();
  double seconds = 0;
  EXPECT_EQ(program.wait(&seconds), -SIGINT);
  EXPECT_LT(seconds, 0.5 * k_limit_s);
}

TEST_F(CliFiles, NoPictureIsDrawnOfZeroFrames) {
  // The key is pressed while the scene is filled, so no frame is run. A busy machine may press it too late.
  const std::string scene = write("slow.json", R"({"particle_radius": 0.004, "frames": 1000, "bodies":
      [{"shape": "lattice", "counts": [40, 40, 40]}], "colliders": [{"shape": "half_space"}]})");
  bool before_the_first = false;
  for (int attempt = 0; attempt < 5 && !before_the_first; ++attempt) {
    fs::remove_all(folder / "out");
    Running program = start("run " + scene + " --out " + path("out"));
    ASSERT_TRUE(program.makes(path(std::string("out/") + host::k_incomplete)));
    program.interrupt();
    double seconds = 0;
    EXPECT_EQ(program.wait(&seconds), 130);
    before_the_first = read(path("stdout")).find("interrupted after 0 of 1000") != std::string::npos;
    EXPECT_TRUE(!before_the_first || seconds < k_limit_s) << seconds;
  }
  ASSERT_TRUE(before_the_first) << read(path("stdout"));
  for (const char* name : {"contact_sheet.png", "last_frame.png", "report.html", "frames"})
    EXPECT_FALSE(fs::exists(folder / "out" / name)) << name;
}

}  // namespace
}  // namespace sandglass
