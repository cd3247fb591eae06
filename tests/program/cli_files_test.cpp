// What the program does to files: nothing that it reads is written over, no two outputs have one name, a folder appears
// whole, what is no file of a sensible size is refused before it is read, and Ctrl-C is answered within a second.
#include <sys/resource.h>
#include <sys/stat.h>

#include "tests/program/cli.h"

namespace sandglass {
namespace {

constexpr double k_answer_s = 1.0;  // to Ctrl-C, as promised
// The promise holds on a machine that has time for the program: not for an emulated, instrumented one.
const bool k_patient = SANDGLASS_SANITIZED || *SANDGLASS_EMULATOR != '\0';

// A scene that takes far longer than a test.
constexpr const char* k_endless = "run tiny.json --frames 100000000 ";

class CliFiles : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    tiny_scene();
  }
  void expect_nothing_unfinished() const {
    for (const std::string& name : names()) EXPECT_EQ(name.find(".unfinished."), std::string::npos) << name;
  }
  // Interrupts the command in the middle of its work.
  static double children_cpu_seconds() {
    rusage usage = {};
    getrusage(RUSAGE_CHILDREN, &usage);
    const auto seconds = [](const timeval& t) {
      return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
  }
  void expect_answered(const std::string& command, double cpu_seconds) const {
    // A busy machine needs time even for a process that does nothing, and a sanitizer CPU time before it begins.
    const auto from = std::chrono::steady_clock::now();
    const double cpu_from = children_cpu_seconds();
    run("--version");
    const double startup = std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
    const double cpu_startup = children_cpu_seconds() - cpu_from;
    Running program(folder, command);
    ASSERT_TRUE(program.works(cpu_seconds + 2 * cpu_startup)) << command << "\n" << read("stderr");
    program.interrupt();
    double seconds = 0;
    EXPECT_EQ(program.wait(&seconds), 130) << command << "\n" << read("stderr");
    EXPECT_LT(seconds, k_patient ? 10 * k_answer_s : k_answer_s + startup) << command.substr(0, 60);
    EXPECT_NE(read("stderr").find("interrupted"), std::string::npos) << command;
    expect_nothing_unfinished();
  }
};

TEST_F(CliFiles, NoInputIsWrittenOverAndNoTwoOutputsHaveOneName) {
  panorama("rooms/room.hdr", 20);
  fs::create_directories(folder / "sub");
  fs::create_hard_link(folder / "tiny.json", folder / "hard.sgrec");
  fs::create_symlink("tiny.json", folder / "soft.sgrec");
  random_network();
  photograph("wall.png");
  write("cube.obj", k_cube);
  const auto contents = [&] { return read("tiny.json") + read("random.light") + read("cube.obj") + read("wall.png"); };
  const std::string before = contents();
  expect_refusals(R"(
run tiny.json --record tiny.json | reads it
run tiny.json --record sub/../tiny.json | reads it
run tiny.json --record hard.sgrec | reads it
run tiny.json --record soft.sgrec | reads it
dataset rooms -o rooms | reads it
light wall.png --network random.light -o random.light | reads it
light wall.png --network random.light -o . | it is there already
light wall.png --network random.light -o out/.. | it is there already
sample cube.obj surface --distance 0.3 -o cube.obj | reads it
sample cube.obj surface --distance 0.3 -o x.ply --picture cube.obj | reads it
sample box surface --distance 0.3 -o x --picture x | two outputs
sample box surface --distance 0.3 -o x --picture sub/../x | two outputs
run tiny.json --out new --record new | two outputs
)");
  if (k_bake) expect_refused("bake cube.obj --quick -o cube.obj", "reads it");
  EXPECT_EQ(contents(), before);
  EXPECT_TRUE(fs::is_symlink(folder / "soft.sgrec"));
}

TEST_F(CliFiles, OutputsAreOrdinaryFilesThatMayBeWritten) {
  ASSERT_EQ(::mkfifo((folder / "pipe").c_str(), 0600), 0);
  fs::create_directories(folder / "sub");
  for (const char* name : {"a.ply", "b.png"}) {
    write(name, "kept");
    ASSERT_EQ(::chmod((folder / name).c_str(), 0444), 0);  // who asks may be root, whom the system lets write
  }
  fs::create_symlink("a.ply", folder / "link.ply");
  expect_refusals(R"(
sample box surface --distance 0.3 -o pipe | no ordinary file
sample box surface --distance 0.3 -o /dev/full | no ordinary file
sample box surface --distance 0.3 -o sub | it is a folder
sample box surface --distance 0.3 -o none/x | its folder is missing
sample box surface --distance 0.3 -o a.ply | write-protected
sample box surface --distance 0.3 -o link.ply | write-protected
sample box surface --distance 0.3 -o b.ply --picture b.png | write-protected
sample box surface --distance 0.3 -o '' | is empty
run tiny.json --out= | --out: 1 required FOLDER missing
run tiny.json --out --replay | "--replay" is an option
run tiny.json --out tiny.json/inner | make folder
)");
  if (k_bake) {
    write("kept.shadow.png", "a picture that is there already is written anew, but not this one");
    ASSERT_EQ(::chmod((folder / "kept.shadow.png").c_str(), 0444), 0);
    expect_refused("bake chair -o kept.shadow", "write-protected");
    expect_refused("bake chair -o x.shadow --json none/x", "none/x");
  }
  EXPECT_EQ(read("a.ply") + read("b.png"), "keptkept");
  ASSERT_EQ(::chmod((folder / "a.ply").c_str(), 0200), 0);
  done("sample box surface --distance 0.3 -o link.ply");  // one bit is enough
  EXPECT_TRUE(fs::is_symlink(folder / "link.ply"));
  EXPECT_EQ(read("a.ply").substr(0, 3), "ply");
}

TEST_F(CliFiles, AFullDiskIsToldBeforeTheWork) {
  fs::create_directories(folder / "full");
  const auto mounted = [&](const std::string& command) {
    return std::system(("cd '" + folder.string() + "' && unshare -rm sh -c \"mount -t tmpfs -o size=64k none full && " +
                        command + "\" 2>>stderr")
                           .c_str());
  };
  if (mounted("true") != 0) GTEST_SKIP() << "nobody may mount a small disk here";
  for (const char* output : {"tiny.json --record full/x", "tiny.json --out full/new/x"}) {
    EXPECT_NE(mounted(command_line("run " + std::string(output))), 0);
    EXPECT_NE(read("stderr").find("the disk has less than 1 MiB left. Make room"), std::string::npos) << read("stderr");
  }
}

// It is filled under another name beside, which goes when nothing comes of it.
TEST_F(CliFiles, AFolderAppearsWhole) {
  mesh_scene();
  expect_refusals("run mesh.json --mesh none.obj --out out | none.obj");
  fs::create_directories(folder / "out");  // an empty one is as good as none
  tiny_scene("", "sand\xe9.json");         // no UTF-8, which JSON must be
  done("run 'sand\xe9.json' --as cortex-a78 --out out");
  for (const char* file : {"contact_sheet.png", "last_frame.png", "frames/frame_000000.png", "trace.json", "report.csv",
                           "summary.json", "summary.txt", "report.html"})
    EXPECT_GT(fs::file_size(folder / "out" / file), 100u) << file;
  EXPECT_NE(exists("out/film.mp4"), read("stderr").find("needs ffmpeg") != std::string::npos);
  EXPECT_NE(read("out/summary.json").find("\"scene\": \"sand\xef\xbf\xbd\""), std::string::npos);
  EXPECT_NE(read("out/report.html").find("data-fastest="), std::string::npos);
  const std::string csv = read("out/report.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 3);
  expect_refusals(R"(
run tiny.json --out out | it is there already
bench ladder --out out | it is there already
)");
  EXPECT_EQ(read("out/report.csv"), csv);
  // What Ctrl-C ends is whole, but for a suite: half a table says nothing.
  Running longer(folder, k_endless + std::string("--out out_run"));
  ASSERT_TRUE(longer.works(0.2));
  longer.interrupt();
  EXPECT_EQ(longer.wait(), 130);
  EXPECT_NE(read("stdout").find("interrupted after"), std::string::npos) << read("stdout");
  EXPECT_NE(read("stderr").find("sandglass: interrupted; reports and sheet of "), std::string::npos);
  EXPECT_TRUE(exists("out_run/report.html") && exists("out_run/contact_sheet.png"));
  expect_answered("bench ladder --out out_suite", 0.2);
  EXPECT_EQ(names(), (std::vector<std::string>{"mesh.json", "out", "out_run", "sand\xe9.json", "tiny.json"}));
}

// What a run that ends early has recorded is not what was asked for.
TEST_F(CliFiles, CtrlCLeavesAnOlderRecording) {
  done("run tiny.json --record r.sgrec");
  const std::string before = read("r.sgrec");
  expect_answered(k_endless + std::string("--threads 2 --record r.sgrec"), 0.1);
  EXPECT_EQ(read("r.sgrec"), before);
}

// The limits are those of the kind: 16 MiB of text, 256 MiB of pictures, shadows and networks, 1 GiB of all else.
TEST_F(CliFiles, WhatIsNoFileOfASensibleSizeIsRefusedUnread) {
  const auto large = [&](const std::string& name, const std::string& begin, uintmax_t mib) {
    write(name, begin);
    fs::resize_file(folder / name, mib << 20);  // takes no room on the disk
  };
  for (const char* name : {"huge.light", "huge.png", "huge.obj", "huge.json"}) large(name, "{", 5 << 10);
  large("long.json", "{", 17);
  large("shadow", std::string(4, '\0') + "SGSH", 300);
  large("network", std::string(4, '\0') + "SGLN", 300);
  for (const char* name : {"pipe.png", "pipe.hdr", "pipe.obj", "pipe.json"})
    ASSERT_EQ(::mkfifo((folder / name).c_str(), 0600), 0);
  mesh_scene();
  random_network();
  photograph("fine.png");
  panorama("room.hdr", 20);
  expect_refusals(R"(
inspect huge.light | has more than 1024 MiB
inspect long.json | has more than 16 MiB
inspect shadow | has more than 256 MiB
inspect network | has more than 256 MiB
inspect /dev/zero | no ordinary file
inspect pipe.obj | no ordinary file
inspect pipe.json | no ordinary file
inspect . | it is a folder
light fine.png -o out --network huge.light | has more than 256 MiB
light fine.png -o out --network /dev/zero | no ordinary file
light huge.png -o out --network random.light | has more than 256 MiB
light pipe.png -o out --network random.light | no ordinary file
run huge.json | has more than 16 MiB
run pipe.json | no ordinary file
run /dev/zero | no ordinary file
run . | it is a folder
run none.json | no file and no shipped scene
budget pipe.json | no ordinary file
run demo --replay huge.light | has more than 1024 MiB
run demo --replay pipe.png | no ordinary file
dataset pipe.hdr -o out | pipe.hdr
dataset room.hdr --manifest /dev/zero -o out | no ordinary file
)");
  expect_refusals(R"(
run mesh.json --mesh huge.obj | huge.obj
run mesh.json --mesh pipe.obj | pipe.obj
sample huge.obj surface --distance 1 -o out | huge.obj
sample /dev/zero surface --distance 1 -o out | /dev/zero
)");
}

TEST_F(CliFiles, CtrlCIsAnsweredWithinASecond) {
  write("fill.json", R"({"particle_radius": 0.0004, "bodies": [{"shape": "sphere", "size": 0.1, "grains": 4000000}]})");
  random_network();
  photograph("wall.png", {90, 120, 40}, 256);
  panorama("rooms/room.hdr", 20);
  for (int copy = 0; copy < 500; ++copy)
    fs::create_hard_link(folder / "rooms/room.hdr", folder / ("rooms/" + std::to_string(copy) + ".hdr"));
  std::string photographs;
  for (int copy = 0; copy < 500; ++copy) photographs += " wall.png";
  std::vector<std::string> commands = {"sample sphere volume --distance 0.0015 -o out",
                                       "inspect fill.json",
                                       "run fill.json",
                                       "budget tiny.json --frames 1000000",
                                       "light --network random.light -o out_light" + photographs,
                                       "dataset rooms -o out_set",
                                       "verify follow",
                                       "bench lighting"};
  if (k_embree) commands.emplace_back("room --width 4096 --samples 64 -o out.hdr");
  if (k_bake) commands.insert(commands.end(), {"bake chair -o out.shadow", "bench shadow"});
  for (const std::string& command : commands) expect_answered(command, 0.1);
  EXPECT_EQ(names(), (std::vector<std::string>{"fill.json", "random.light", "rooms", "tiny.json", "wall.png"}));
}

// ffmpeg is another process, with its own half-written file.
TEST_F(CliFiles, AnEndedProgramEndsTheFilm) {
  if (k_patient) GTEST_SKIP() << "its pictures take long to draw";
  write("bin/ffmpeg",
        "#!/bin/sh\n"
        "[ \"$1\" = -version ] && exit 0\n"
        "for last; do :; done\n"
        "echo half > \"$last\"\n"
        "echo $$ > \"${0%/*}/pid\"\n"
        "exec sleep 60\n");
  fs::permissions(folder / "bin/ffmpeg", fs::perms::owner_all);
  const std::string before = std::getenv("PATH");
  ::setenv("PATH", ((folder / "bin").string() + ":" + before).c_str(), 1);
  Running program(folder, "run tiny.json --out out");
  ::setenv("PATH", before.c_str(), 1);
  ASSERT_TRUE(program.reaches([&] { return read("bin/pid").ends_with("\n"); })) << "no film was begun";
  program.interrupt();
  double seconds = 0;
  EXPECT_EQ(program.wait(&seconds), 130);
  EXPECT_LT(seconds, 2 * k_answer_s);
  EXPECT_EQ(::kill(std::stoi(read("bin/pid")), 0), -1) << "ffmpeg goes on";
  EXPECT_FALSE(exists("out/film.mp4"));
  expect_nothing_unfinished();
}

// Interrupted after some frames, a run draws them. The second key ends that.
TEST_F(CliFiles, TheSecondCtrlCEndsAtOnce) {
  Running program(folder, k_endless + std::string("--out out"));
  ASSERT_TRUE(program.works(0.2));
  program.interrupt();
  ASSERT_TRUE(program.reaches([&] { return read("stderr").find("again ends at once") != std::string::npos; }));
  program.interrupt();
  double seconds = 0;
  EXPECT_EQ(program.wait(&seconds), -SIGINT);
  EXPECT_LT(seconds, k_patient ? 5 * k_answer_s : k_answer_s);
  EXPECT_EQ(names(), std::vector<std::string>{"tiny.json"});
}

}  // namespace
}  // namespace sandglass
