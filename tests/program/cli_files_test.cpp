// What the program does to files: nothing that it reads is written over, no two outputs have one name, a folder appears
// whole, what is no file of a sensible size is refused at once, and Ctrl-C is answered within a second.
#include <sys/stat.h>

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
  const std::string scene = tiny_scene(), room = panorama("rooms/room.hdr", 20);
  fs::create_directories(folder / "sub");
  fs::create_hard_link(scene, path("hard.sgrec"));
  fs::create_symlink(scene, path("soft.sgrec"));
  for (const std::string& name : {scene, path("sub/../tiny.json"), path("hard.sgrec"), path("soft.sgrec")})
    expect_kept(scene, "run " + scene + " --record " + name);
  EXPECT_TRUE(fs::is_symlink(path("soft.sgrec")));
  expect_kept(room, "dataset " + path("rooms") + " -o " + path("rooms"), "it is there already");
  const std::string network = write("random.light", random_network());
  host::write_png(path("wall.png"), host::Picture(256, 192, {90, 120, 40}));
  expect_kept(network, "light " + path("wall.png") + " --network " + network + " -o " + network, "reads it");
  if (!k_assimp) return;
  const std::string mesh = cube();
  expect_kept(mesh, "sample " + mesh + " --surface --distance 0.3 -o " + mesh);
  expect_kept(mesh, "sample " + mesh + " --surface --distance 0.3 -o " + path("x.ply") + " --picture " + mesh);
  if (k_bake) expect_kept(mesh, "bake " + mesh + " --size 8x1 --steps 1 --textures 1 -o " + mesh);
}

TEST_F(CliFiles, NoTwoOutputsHaveOneName) {
  const std::string twice = "two outputs", box = "sample box --surface --distance 0.3 -o ";
  fs::create_directories(folder / "sub");
  expect_refused(box + path("x") + " --picture " + path("x"), twice);
  expect_refused(box + path("x") + " --picture " + path("sub/../x"), twice);
  expect_refused("run '" + tiny_scene() + "' --out " + path("new") + " --record " + path("new"), twice);
  EXPECT_FALSE(fs::exists(path("x")) || fs::exists(path("new")));
}

TEST_F(CliFiles, AnOutputBehindALinkKeepsTheLink) {
  write("old.ply", "old");
  fs::create_symlink(path("old.ply"), path("link.ply"));
  ASSERT_EQ(run("sample box --surface --distance 0.3 -o " + path("link.ply")).code, 0);
  EXPECT_TRUE(fs::is_symlink(path("link.ply")));
  EXPECT_EQ(read(path("old.ply")).substr(0, 3), "ply");
}

// It is filled under another name beside, which goes when nothing comes of it.
TEST_F(CliFiles, AFolderAppearsWhole) {
  const auto entries = [&] {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename().string());
    std::erase_if(names, [](const std::string& name) { return !name.starts_with("out"); });
    return names;
  };
  const std::string out = " --out " + path("out");
  expect_refused("run " + mesh_scene() + " --mesh " + path("none.obj") + out, "none.obj");
  EXPECT_TRUE(entries().empty());
  fs::create_directories(folder / "out");  // an empty one is as good as none
  ASSERT_EQ(run("run '" + tiny_scene() + "' --frames 1" + out).code, 0);
  EXPECT_TRUE(fs::exists(path("out/last_frame.png")) && fs::exists(path("out/report.html")));
  const std::string summary = read(path("out/summary.json"));
  expect_kept(path("out/summary.json"), "run '" + tiny_scene() + "'" + out, "it is there already");
  for (const char* suite : {"verify granular --quick", "bench ladder"})
    expect_refused(suite + out, "it is there already");
  expect_refused("run '" + tiny_scene() + "' --out " + path("tiny.json/inner"), "make folder");
  EXPECT_EQ(entries(), std::vector<std::string>{"out"});
  // What Ctrl-C ends is whole, but for a suite: half a table says nothing.
  Running longer = start(endless() + "--out " + path("out_run"));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  longer.interrupt();
  EXPECT_EQ(longer.wait(), 130);
  EXPECT_TRUE(fs::exists(path("out_run/report.html")));
  Running suite = start("verify granular --out " + path("out_suite"));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  suite.interrupt();
  EXPECT_EQ(suite.wait(), 130);
  EXPECT_EQ(entries().size(), 2u);
}

// What a run that ends early has recorded is not what was asked for.
TEST_F(CliFiles, CtrlCLeavesAnOlderRecording) {
  const std::string recording = path("r.sgrec");
  ASSERT_EQ(run("run '" + tiny_scene() + "' --record " + recording).code, 0);
  const std::string before = read(recording);
  Running longer = start(endless() + "--record " + recording);
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  longer.interrupt();
  EXPECT_EQ(longer.wait(), 130);
  EXPECT_EQ(read(recording), before);
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
    EXPECT_NE(read(path("stderr")).find("interrupted"), std::string::npos) << each.command;
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
  EXPECT_NE(read(path("stderr")).find("interrupted"), std::string::npos);
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

TEST_F(CliFiles, TheSecondCtrlCEndsAtOnce) {
  // Interrupted after some frames, a run draws them. The second key ends that.
  Running program = start(endless() + "--out " + path("out"));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  program.interrupt();
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  program.interrupt();
  double seconds = 0;
  EXPECT_EQ(program.wait(&seconds), -SIGINT);
  EXPECT_LT(seconds, 0.5 * k_limit_s);
}

}  // namespace
}  // namespace sandglass
