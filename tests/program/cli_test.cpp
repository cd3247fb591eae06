// The program as a script sees it: exit code 0, 1 or 2, one line on stderr when it refuses, and the hash on the last
// line of a run.
#include <algorithm>
#include <set>

#include "models/files/image.h"
#include "models/mesh/generated.h"
#include "models/mesh/ply.h"
#include "sandglass/sandglass.h"
#include "tests/program/cli.h"

namespace sandglass {
namespace {

TEST_F(Cli, AnEmptyValueIsRefused) {
  const std::string tiny = "run '" + tiny_scene() + "' --frames 1 ", empty = "is empty";
  // Each of these named nothing, and so nothing was written, or something else was read.
  for (const char* option : {"--out", "--record", "--replay", "--mesh", "--asset"})
    for (const char* value : {" ''", "=", "=''"}) {
      expect_refused(tiny + option + value, empty);
      expect_refused(tiny + option + value, option);
    }
  expect_refused("run ''", empty);
  expect_refused("bench machine --json ''", empty);
  expect_refused("bench machine --json=", empty);
  expect_refused("verify granular --quick --out ''", empty);
  expect_refused("sample box --surface --distance 0.3 -o ''", empty);
  expect_refused("light '' -o " + path("out"), empty);
}

TEST_F(Cli, RunEndsWithTheHashAndRepeatsOnVirtualClock) {
  const std::string command = "run '" + tiny_scene() + "' --clock virtual";
  const Outcome first = run(command), second = run(command + " --isa scalar --threads 2");
  ASSERT_EQ(first.code, 0) << first.err;
  const auto last_line = [](const std::string& text) { return text.substr(text.rfind('\n', text.size() - 2) + 1); };
  const std::string hash = last_line(first.out);
  EXPECT_EQ(hash.substr(0, 7), "hash 0x");
  EXPECT_EQ(hash.size(), 7u + 16u + 1u);
  EXPECT_EQ(last_line(second.out), hash);
}

TEST_F(Cli, ARecordedRunReplaysToTheSameHash) {
  const Outcome recorded = run("run '" + tiny_scene() + "' --record '" + path("r.sgrec") + "'");
  ASSERT_EQ(recorded.code, 0) << recorded.err;
  const Outcome replayed = run("run '" + path("tiny.json") + "' --isa scalar --replay '" + path("r.sgrec") + "'");
  EXPECT_EQ(replayed.code, 0) << replayed.err;
  EXPECT_EQ(recorded.out.substr(recorded.out.find("hash")), replayed.out.substr(replayed.out.find("hash")));
  const Outcome inspected = run("inspect '" + path("r.sgrec") + "'");
  EXPECT_EQ(inspected.code, 0);
  EXPECT_NE(inspected.out.find("frames       3"), std::string::npos) << inspected.out;
  expect_refused("run demo --replay '" + path("r.sgrec") + "'", "r.sgrec");
}

TEST_F(Cli, OutWritesReportsAndPictures) {
  const Outcome outcome = run("run '" + tiny_scene() + "' --out '" + path("out") + "'");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  for (const char* file : {"contact_sheet.png", "last_frame.png", "frames/frame_000000.png", "trace.json", "report.csv",
                           "summary.json", "summary.txt", "report.html"})
    EXPECT_GT(fs::file_size(folder / "out" / file), 100u) << file;
  EXPECT_NE(fs::exists(folder / "out" / "film.mp4"), outcome.err.find("needs ffmpeg") != std::string::npos);
  const std::string csv = read(path("out/report.csv"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 3);
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder / "out"))
    EXPECT_EQ(entry.path().string().find("unfinished"), std::string::npos) << entry.path();
}

// Estimated times do not depend on the machine, and say what they are.
TEST_F(Cli, EstimatesAPhonesFrameAndTheBudgetThatASceneNeeds) {
  const std::string scene = "'" + tiny_scene() + "'";
  const Outcome as = run("run " + scene + " --as cortex-a78 --budget-ms 4 --out '" + path("as") + "'");
  ASSERT_EQ(as.code, 0) << as.err;
  EXPECT_NE(as.out.find("Estimated, not measured"), std::string::npos) << as.out;
  EXPECT_NE(as.out.find("at its slowest"), std::string::npos) << as.out;
  EXPECT_NE(read(path("as/report.html")).find("data-fastest="), std::string::npos);
  const Outcome again = run("run " + scene + " --as cortex-a78 --budget-ms 4 --isa scalar");
  EXPECT_EQ(again.out.substr(again.out.find("hash")), as.out.substr(as.out.find("hash")));

  const Outcome all = run("budget " + scene), one = run("budget " + scene + " --as cortex-a55");
  ASSERT_EQ(all.code, 0) << all.err;
  for (const char* words : {"cortex-x3", "cortex-a78", "cortex-a55", "0 (full)", "not measured", " ms",
                            "M instructions, most", "all of these frames"})
    EXPECT_NE(all.out.find(words), std::string::npos) << words;
  EXPECT_EQ(all.out.find("99.9 %"), std::string::npos) << "three frames tell no percentile";
  EXPECT_EQ(one.out.find("cortex-x3"), std::string::npos);
  EXPECT_EQ(run("budget " + scene).out, all.out);
  expect_refused("run demo --as cortex-a79", "cortex-a78");
  expect_refused("run demo --as cortex-a78 --clock virtual", "excludes");
}

// An instruction set that the library has runs and gives the same hash. One that it lacks is refused by name.
TEST_F(Cli, EveryInstructionSetRunsOrIsSaidToBeMissing) {
  const std::string command = "run '" + tiny_scene() + "' --clock virtual --isa ";
  std::set<std::string> hashes;
  for (sandglass_isa isa = SANDGLASS_ISA_SCALAR; isa <= SANDGLASS_ISA_WASM; ++isa) {
    const std::string name = sandglass_isa_name(isa);
    if (sandglass_isa_available(isa) == 0) {
      expect_refused(command + name, "cannot use \"" + name + "\": this CPU, or this build, lacks the instruction set");
      continue;
    }
    const Outcome outcome = run(command + name);
    EXPECT_EQ(outcome.code, 0) << name << "\n" << outcome.err;
    hashes.insert(outcome.out.substr(outcome.out.find("hash")));
  }
  EXPECT_EQ(hashes.size(), 1u);
}

// Every command that the program's help lists has its own help. So has every suite.
TEST_F(Cli, EveryCommandAndSuiteHasHelp) {
  const Outcome without_argument = run("");
  EXPECT_EQ(without_argument.code, 0);
  EXPECT_LT(std::count(without_argument.out.begin(), without_argument.out.end(), '\n'), 25);
  const std::vector<std::string> commands = listed("");
  EXPECT_EQ(commands.size(), 10u);
  for (const std::string& command : commands) {
    const Outcome help = run(command + " --help");
    EXPECT_EQ(help.code, 0) << command;
    EXPECT_NE(help.out.find("Usage: sandglass " + command), std::string::npos) << help.out;
  }
}

// One sentence says what is wrong with a command line, and points to the help. Each line below has what is typed, the
// message, and the help.
TEST_F(Cli, AWrongCommandLineIsOneSentence) {
  std::istringstream cases(
      R"(bnech granular | cannot start "sandglass": The following arguments were not expected: | sandglass --help
run demo --thread 2 | cannot start "run": The following arguments were not expected: | sandglass run --help
run demo chair | cannot start "run": The following argument was not expected: chair. | sandglass run --help
run | cannot start "run": SCENE is required. | sandglass run --help
run demo --frames | cannot start "run": --frames: 1 required N | sandglass run --help
run demo --frames 2 --frames 3 | cannot start "run": --frames: | sandglass run --help
run demo --clock reel | cannot use "--clock" of "run": "reel" is not real or virtual. | sandglass run --help
run demo --isa quantum | cannot use "--isa" of "run": "quantum" is not automatic, scalar, neon, avx2, avx512, neon_dotprod, neon_i8mm or wasm. | sandglass run --help
run demo --budget-ms nan | cannot use "--budget-ms" of "run": "nan" is not a number from 0 to 1000000. | sandglass run --help
run demo --threads 1.5 | cannot use "--threads" of "run": "1.5" is not a whole number from 1 to 256. | sandglass run --help
run demo --record a --replay b | cannot start "run": --record excludes --replay. | sandglass run --help
run shot --fov 70 | cannot start "run": --fov requires --photo. | sandglass run --help
verify granular --frames 3 | cannot start "verify granular": The following arguments were not expected: | sandglass_lab verify granular --help
verify --json | cannot start "verify": | sandglass_lab verify --help
dataset x | cannot start "dataset": --output is required. | sandglass dataset --help
)");
  for (std::string line; std::getline(cases, line);) {
    const size_t first = line.find(" | "), last = line.rfind(" | ");
    const std::string arguments = line.substr(0, first);
    expect_refused(arguments, line.substr(first + 3, last - first - 3));
    expect_refused(arguments, " See: " + line.substr(last + 3) + ".\n");
  }
}

TEST_F(Cli, TakesOptionsInEveryUsualForm) {
  const std::string scene = "'" + tiny_scene() + "'", dump = "'" + path("dump") + "'";
  for (const std::string& form :
       {"run " + scene + " --frames 2 --clock virtual", "run --clock=virtual --frames=2 " + scene,
        "run --frames 2 --clock virtual -- " + scene}) {
    const Outcome outcome = run(form);
    EXPECT_EQ(outcome.code, 0) << form << outcome.err;
    EXPECT_NE(outcome.out.find("hash 0x"), std::string::npos) << form;
  }
  for (const char* form : {"-o", "-o ", "--output=", "--output "}) {
    EXPECT_EQ(run("sample box --volume --distance 0.05 " + (form + path("box.ply"))).code, 0) << form;
    EXPECT_TRUE(fs::remove(path("box.ply"))) << form;
  }
}

TEST_F(Cli, RefusesOptionsThatWouldDoNothing) {
  if (k_bake) expect_refused("bench shadow --asset a,b", "--out");
  expect_refused("verify lighting --samples 0 --object torus", "--object");
  expect_refused("verify lighting --isa scalar --panoramas p --estimates e.csv", "--isa");
  expect_refused("verify lighting --isa scalar --panoramas p --network n.npz", "--isa");
  expect_refused("inspect '" + write("cube.obj", k_cube) + "' --mesh x", "--mesh");
  expect_refused("run demo --network x.light", "--network");
}

// A verification that would check nothing must not pass.
TEST_F(Cli, AVerificationThatWouldCheckNothingIsRefused) {
  for (const char* slow : {"column", "janssen", "repose", "beverloo", "rest column"})
    expect_refused(
        "verify granular --quick --case " + std::string(slow),
        "it takes minutes, and --quick leaves such cases out. Leave --quick out, or name quick cases: particle, "
        "rest, momentum, refinement, hard or far.");
  for (const char* suite : {"verify shot", "verify lighting --samples 0"})
    expect_refused(suite, "no panoramas are named. Name .hdr or .exr files");
  fs::create_directories(folder / "none");
  expect_refused("verify shot --panoramas '" + path("none") + "'", "no .hdr or .exr");
}

// Every command refuses a bad number before it reads, makes or computes anything. The message names the option.
TEST_F(Cli, RefusesNumbersThatAreNone) {
  const std::string out = " -o '" + path("out") + "' ";
  const std::pair<const char*, std::string> commands[] = {
      {"--angle", "bake chair" + out},     {"--max-polar", "bake chair" + out},
      {"--rate", "bake chair" + out},      {"--size", "bake chair" + out},
      {"--seed", "bake chair" + out},      {"--threads", "bench granular"},
      {"--thresholds", "bench shadow"},    {"--tiles", "dataset a.hdr" + out},
      {"--seed", "dataset a.hdr" + out},   {"--fov", "light a.png" + out},
      {"--turn", "light a.png" + out},     {"--images", "quantise-light a.npz --calibrate a" + out},
      {"--samples", "room" + out},         {"--seed", "room" + out},
      {"--budget-ms", "run demo"},         {"--frames", "run demo"},
      {"--fov", "run shot --photo a.png"}, {"--distance", "sample box --surface" + out},
      {"--views", "verify lighting"},      {"--seed", "verify lighting"},
      {"--seed", "verify follow"},         {"--threads", "verify shot"},
  };
  const auto refused = [&](const std::string& command, const std::string& option, const std::string& value) {
    const bool left_out = !k_bake && (command.starts_with("bake") || command == "bench shadow");
    expect_refused(command + " " + option + " '" + value + "'", left_out ? "no ray tracer" : option.substr(2));
  };
  for (const auto& [option, command] : commands)
    for (const char* value : {"nan", "-1"}) refused(command, option, value);
  // 2^32 + 8, 8 - 2^32 and 2^32 + 128 become valid sizes if they are cut to 32 bits. A parser that guesses the base
  // reads 0x14 as 20.
  for (const char* size : {"4294967304x1", "-4294967288x1", "8x4294967297", "4294967424x2", "8x1 ", " 8x1", "8x+1",
                           "0x8x1", "99999999999999999999999x1", "8x", "x1", "8", "8x1x1"})
    refused("bake chair" + out, "--size", size);
  for (const char* angle : {"0x14", "+20", " 20", "20 deg", "20rad", "1e999", "inf", "deg", ""})
    refused("bake chair" + out, "--angle", angle);
  expect_refused("room --seed 18446744073709551616" + out, "--seed");
  expect_refused("light a.png --fov 1e999" + out, "--fov");
  EXPECT_FALSE(fs::exists(path("out")));
}

// A bake takes minutes. It refuses a place that it cannot write to before it starts, and leaves that place as it is.
TEST_F(Cli, ABakeIsRefusedBeforeItsWorkWhereItCouldNotWrite) {
  if (!k_bake) GTEST_SKIP() << "this build bakes no shadows: Embree or Eigen is missing";
  fs::create_directories(path("folder"));
  const std::string kept = write("kept.png", "an older picture"), out = " -o '" + path("out") + "' ";
  const std::string nowhere = path("nowhere/x"), bake = "bake chair --textures 3000 --steps 100000000 ";
  expect_refused(bake + "-o '" + path("folder") + "'", "folder");
  expect_refused(bake + "-o ''", "is empty");
  expect_refused(bake + "-o '" + nowhere + "'", "nowhere");
  expect_refused(bake + "-o '" + path("kept.png/x") + "'", "kept.png/x");
  expect_refused(bake + "-o '" + path(std::string(240, 'n')) + "'", "nnn");  // too long once ".checkpoint" is added
  expect_refused(bake + out + "--picture '" + kept + "' --json '" + nowhere + "'", "nowhere");
  expect_refused(bake + out + "--picture '" + nowhere + ".png'", "nowhere");
  expect_refused(bake + out + "--json /dev/null", "/dev/null");
  EXPECT_EQ(read(kept), "an older picture");
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    EXPECT_TRUE(name == "folder" || name == "kept.png" || name == "stdout" || name == "stderr") << name;
  }
}

// What `bake` prints and writes for the smallest network, and what `inspect` says about it.
TEST_F(Cli, BakesAndInspectsAShadow) {
  if (!k_bake) GTEST_SKIP() << "this build bakes no shadows: Embree or Eigen is missing";
  const std::string options =
      " --size 8x1 --textures 1 --steps 20 --quantised-steps 5 --validation-lights 4 --ambient-texels 16 --threads 2 ";
  const Outcome baked = run("bake chair -o '" + path("x.shadow") + "' --json '" + path("x.json") + "'" + options);
  ASSERT_EQ(baked.code, 0) << baked.err;
  EXPECT_NE(baked.out.find("4 unseen lights"), std::string::npos) << baked.out;
  EXPECT_NE(baked.out.find("SSIM and block: of 4 whole textures"), std::string::npos) << baked.out;
  EXPECT_NE(read(path("x.json")).find("whole_textures"), std::string::npos);
  EXPECT_NE(read(path("x.json")).find("rmse_occlusion"), std::string::npos);
  EXPECT_NE(baked.out.find("8 made-up"), std::string::npos) << baked.out;
  EXPECT_TRUE(fs::exists(path("x.shadow.png")));
  const Outcome told = run("inspect '" + path("x.shadow") + "'");
  ASSERT_EQ(told.code, 0) << told.err;
  for (const char* line :
       {"baked shadow, version 2", "24 components of 16 x 16 texels, 3.6 m a side", "surface      2381 points",
        "8 neurons x (1 + 1) hidden layers, 72 MAC a texel", "20 degrees wide, up to 70 degrees from the zenith",
        "fitted to the light", "over 4 unseen lights", "float copy   no"})
    EXPECT_NE(told.out.find(line), std::string::npos) << line << "\n" << told.out;
  write("cut.shadow", read(path("x.shadow")).substr(0, 1000));
  expect_refused("inspect '" + path("cut.shadow") + "'", "cut.shadow");
}

TEST_F(Cli, VerifiesAChosenCaseAndWritesItsTable) {
  const Outcome outcome = run("verify granular --case refinement --out '" + path("out") + "'");
  EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
  EXPECT_NE(outcome.out.find("7 rows, 0 failed"), std::string::npos) << outcome.out;
  const std::string markdown = read(path("out/verify.md"));
  EXPECT_EQ(std::count(markdown.begin(), markdown.end(), '\n'), 9);
  EXPECT_NE(markdown.find("| refinement | uniform field reproduced |"), std::string::npos);
  EXPECT_NE(markdown.find("fails, as it must"), std::string::npos);
  EXPECT_FALSE(fs::exists(path("out/runout.png"))) << "no curve without its case";
}

// The test makes a room, a photograph of it, and the program's own chair as if it were the user's mesh.
TEST_F(Cli, RunsShotsOfFiles) {
  if (*SANDGLASS_EMULATOR != '\0')
    GTEST_SKIP() << "fills 25,000 grains three times; nothing of it is the instruction set's";
  if (!k_embree) GTEST_SKIP() << "needs a room, and this build has no Embree to trace one";
  const std::string files = "-o '" + path("room.hdr") + "' --picture '" + path("room.png") + "'";
  ASSERT_EQ(run("room --seed 3 --width 64 --samples 1 " + files).code, 0);
  const auto light_of = [&](const std::string& arguments) {
    const Outcome outcome = run("run shot --frames 2 --clock virtual " + arguments);
    EXPECT_EQ(outcome.code, 0) << arguments << "\n" << outcome.err;
    EXPECT_NE(outcome.out.find("hash 0x"), std::string::npos) << outcome.out;
    return outcome.out;
  };
  const std::string panorama = light_of("--panorama '" + path("room.hdr") + "' --light truth");
  const std::string photo = light_of("--photo '" + path("room.png") + "' --fov 70 --light nothing");
  EXPECT_NE(panorama.substr(panorama.find("hash")), photo.substr(photo.find("hash")))
      << "another light, another shadow";
  ASSERT_EQ(run("room --seed 3 --width 64 --samples 1 --lamps-off -o '" + path("dark.hdr") + "'").code, 0);
  const std::string later =
      light_of("--panorama '" + path("room.hdr") + "' --later '" + path("dark.hdr") + "' --light truth");
  EXPECT_NE(later.substr(later.find("hash")), panorama.substr(panorama.find("hash"))) << "the lamps went off";
  // The scene's own room, named, is the same run; looked at from elsewhere it has another light.
  const Outcome own = run("run shot --frames 2 --clock virtual");
  const std::string hash = own.out.substr(own.out.find("hash 0x"));
  const std::string rooms = light_of("--rooms 35:90,35:0");
  EXPECT_NE(rooms.find(hash), std::string::npos) << rooms;
  EXPECT_NE(rooms.substr(rooms.rfind("hash 0x")), hash);
  // A frame's time is the library's. It leaves out the made-up camera's image, which takes some 9 ms. Beside the work
  // units it has only colliders and lights.
  const Outcome timed = run("run shot --frames 4 --light estimate --panorama '" + path("room.hdr") + "'");
  const auto mean_of = [&](const std::string& row) {
    const size_t at = timed.out.find(row);
    return at == std::string::npos ? -1.0 : std::strtod(timed.out.c_str() + at + row.size(), nullptr);
  };
  EXPECT_GT(mean_of("  budget used"), 0.0) << timed.out << timed.err;
  EXPECT_LT(mean_of("  CPU time, one thread"), mean_of("  budget used") + 3.0);
  if (!k_assimp) return;
  const host::MeshResult chair = host::make_named("chair");
  ASSERT_EQ(host::write_mesh_obj(path("mine.obj"), chair.mesh), "");
  light_of("--panorama '" + path("room.hdr") + "' --light truth --object '" + path("mine.obj") + "' --asset chair");
}

TEST_F(Cli, RefusesBadShots) {
  if (!k_embree) GTEST_SKIP() << "needs a room, and this build has no Embree to trace one";
  ASSERT_EQ(
      run("room --seed 3 --width 64 --samples 1 -o '" + path("room.hdr") + "' --picture '" + path("room.png") + "'")
          .code,
      0);
  const std::string room = "'" + path("room.hdr") + "'", photo = "'" + path("room.png") + "'";
  const std::string cube = "'" + write("cube.obj", k_cube) + "'";
  expect_refused("run shot --panorama '" + path("missing.hdr") + "'", "missing.hdr");
  expect_refused("run shot --panorama " + photo, "neither .hdr nor .exr");
  expect_refused("run shot --panorama '" + write("cut.hdr", read(path("room.hdr")).substr(0, 600)) + "'", "cut.hdr");
  expect_refused("run shot --photo '" + path("missing.png") + "' --fov 70", "missing.png");
  expect_refused("run shot --photo " + room + " --fov 70", "PNG or JPEG");
  expect_refused("run shot --photo " + photo, "--fov");
  expect_refused("run shot --photo " + photo + " --fov 0", "--fov");
  expect_refused("run shot --photo " + photo + " --fov 179", "--fov");
  expect_refused("run shot --photo " + photo + " --fov nan", "--fov");
  expect_refused("run shot --photo " + photo + " --fov wide", "--fov");
  expect_refused("run shot --fov 70", "--photo");
  expect_refused("run shot --photo " + photo + " --fov 70 --panorama " + room, "excludes");
  expect_refused("run shot --photo " + photo + " --fov 70 --light truth", "truth");
  for (const char* bad : {"35", "35:", ":90", "35:360", "35:-9", "+3:90", "35:90:1", "x:90"})
    expect_refused(std::string("run shot --rooms ") + bad, "SEED:AZIMUTH");
  expect_refused("run shot --rooms 35:90 --panorama " + room, "excludes");
  expect_refused("run shot --rooms 35:90 --photo " + photo + " --fov 70", "--photo");
  expect_refused("run demo --rooms 35:90", "no shot");
  expect_refused("run shot --light moon", "moon");
  expect_refused("run shot --network '" + path("missing.light") + "'", "missing.light");
  expect_refused("run shot --network " + room, "room.hdr\": ");
  expect_refused("run shot --light truth --network '" + path("missing.light") + "'", "--network");
  expect_refused("run demo --photo " + photo + " --fov 70", "no shot");
  expect_refused("run demo --asset chair", "--asset");
  expect_refused("run shot --asset '" + path("missing.shadow") + "'", "missing.shadow");
  expect_refused("run shot --asset " + room, "room.hdr\": ");
  if (!k_assimp) return;
  expect_refused("run shot --object " + cube, "--asset");
  expect_refused("run shot --object '" + path("missing.obj") + "' --asset chair", "missing.obj");
  expect_refused("run shot --object " + cube + " --asset chair", "another object");
}

TEST_F(Cli, RefusesBadScenes) {
  expect_refused("run nowhere", "nowhere");
  expect_refused("run '" + write("empty.json", "") + "'", "empty.json");
  expect_refused("run '" + write("cut.json", "{\"frames\": 3, \"bod") + "'", "cut.json");
  expect_refused("run '" + tiny_scene("\"grvity\": [0, 0, 0], ") + "'", "\"grvity\"");
  expect_refused("run '" + tiny_scene("\"particle_capacity\": 5, ") + "'", "\"particle_capacity\"");
  expect_refused("run '" + tiny_scene("\"grain_capacity\": 5, ") + "'", "\"grain_capacity\"");
  expect_refused("run '" + path("") + "'", "");
  expect_refused("run demo --mesh '" + write("cube.obj", k_cube) + "'", "--mesh");
  expect_refused("run '" + mesh_scene() + "'", "--mesh");
}

TEST_F(Cli, RefusesBadMeshes) {
  const std::string command = "run '" + mesh_scene() + "' --mesh ";
  if (!k_assimp) {
    expect_refused(command + "'" + write("cube.obj", k_cube) + "'", "Assimp");
    return;
  }
  EXPECT_EQ(run(command + "'" + write("cube.obj", k_cube) + "'").code, 0);
  const std::string cube = k_cube;
  expect_refused(command + "'" + path("missing.obj") + "'", "missing.obj");
  expect_refused(command + "'" + write("empty.obj", "") + "'", "empty.obj");
  expect_refused(command + "'" + write("vertices.obj", cube.substr(0, cube.find('f'))) + "'", "vertices.obj");
  expect_refused(command + "'" + write("nan.obj", "v nan 0 0\n" + cube.substr(cube.find('\n') + 1)) + "'", "nan.obj");
  expect_refused(command + "'" + write("fin.obj", cube + "v 3 0 0\nf 1 2 9\n") + "'", "manifold");
  expect_refused(command + "'" + write("range.obj", cube + "f 1 2 99\n") + "'", "range.obj");
}

TEST_F(Cli, RunsAndRefusesCollidersOfMeshes) {
  const auto scene = [&](const std::string& collider) {
    return "run '" + write("solid.json", R"({"frames": 2, "particle_radius": 0.01,
        "bodies": [{"shape": "box", "size": [0.06, 0.08, 0.06], "position": [0, 0.3, 0]}],
        "colliders": [)" + collider + "]}") +
           "'";
  };
  for (const char* mesh : {"trefoil", "torus", "box", "sphere", "hourglass", "bucket", "silo"}) {
    const Outcome outcome = run(scene(R"({"shape": "mesh", "size": 0.2, "mesh": ")" + std::string(mesh) + R"("})"));
    EXPECT_EQ(outcome.code, 0) << mesh << ": " << outcome.err;
  }
  expect_refused(scene(R"({"shape": "mesh", "size": 0.2, "mesh": "teapot"})"), "teapot");
  expect_refused(scene(R"({"shape": "mesh", "size": 0.2})"), "--collider-mesh");
  expect_refused(scene(R"({"shape": "mesh", "mesh": "torus"})"), "size");
  expect_refused(scene(R"({"shape": "mesh", "size": 0.2, "mesh": "torus", "solid": "both"})"), "solid");
  const std::string bucket = R"({"shape": "mesh", "size": 0.2, "mesh": "bucket", "field_spacing": )";
  expect_refused(scene(bucket + "0.5}"), "spacing");
  expect_refused(scene(bucket + "0.0002}"), "enlarge the spacing");
  const std::string torus = scene(R"({"shape": "mesh", "size": 0.2, "mesh": "torus"})");
  expect_refused(torus + " --collider-mesh '" + path("missing.obj") + "'", "missing.obj");
  expect_refused("run '" + tiny_scene() + "' --collider-mesh '" + write("cube.obj", k_cube) + "'", "--collider-mesh");
  if (!k_assimp) return;
  EXPECT_EQ(run(torus + " --collider-mesh '" + path("cube.obj") + "'").code, 0) << "the file goes before the name";
}

TEST_F(Cli, InspectTellsScenesAndMeshesApart) {
  const Outcome scene = run("inspect '" + tiny_scene() + "'");
  EXPECT_EQ(scene.code, 0) << scene.err;
  EXPECT_NE(scene.out.find("memory"), std::string::npos);
  expect_refused("inspect '" + write("empty", "") + "'", "empty");
  expect_refused("inspect '" + path("missing") + "'", "missing");
  const std::string network = random_network();
  const Outcome light = run("inspect '" + write("n.light", network) + "'");
  EXPECT_EQ(light.code, 0) << light.err;
  EXPECT_NE(light.out.find("lighting network 'random'"), std::string::npos) << light.out;
  expect_refused("inspect '" + write("cut.light", network.substr(0, network.size() - 9)) + "'", "cut off");
  if (!k_assimp) return;
  const Outcome mesh = run("inspect '" + write("cube.obj", k_cube) + "'");
  EXPECT_EQ(mesh.code, 0) << mesh.err;
  EXPECT_NE(mesh.out.find("watertight   yes"), std::string::npos) << mesh.out;
  EXPECT_NE(mesh.out.find("orientation  outward"), std::string::npos) << mesh.out;
}

TEST_F(Cli, CtrlCFinishesCleanlyWithExitCode130) {
  const std::string command = "run '" + tiny_scene() + "' --frames 100000000 --out '" + path("out") + "'";
  const std::string emulator = SANDGLASS_EMULATOR, seconds = emulator.empty() ? "0.5 " : "2 ";
  const std::string shell = "timeout --foreground --preserve-status -s INT " + seconds + emulator + " '" +
                            SANDGLASS_PROGRAM + "' " + command + " >'" + path("stdout") + "' 2>'" + path("stderr") +
                            "'";
  const int status = std::system(shell.c_str());
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  EXPECT_NE(read(path("stdout")).find("interrupted after"), std::string::npos) << read(path("stdout"));
  const std::string said = read(path("stderr"));  // written when the key is pressed, before the reports
  EXPECT_NE(said.find("sandglass: interrupted; reports and sheet of "), std::string::npos) << said;
  EXPECT_TRUE(fs::exists(folder / "out" / "report.csv"));
  EXPECT_TRUE(fs::exists(folder / "out" / "contact_sheet.png"));
}

TEST_F(Cli, SamplesAMesh) {
  const Outcome points =
      run("sample box --surface --distance 0.02 --picture " + path("box.png") + " -o " + path("box.ply"));
  EXPECT_EQ(points.code, 0) << points.err;
  EXPECT_NE(points.out.find(" points on the surface of box"), std::string::npos) << points.out;
  EXPECT_EQ(read(path("box.png")).substr(1, 3), "PNG");
  expect_refused("sample teapot --surface --distance 1 -o " + path("x.ply"), "Name a mesh file, or trefoil, ");
  expect_refused("sample trefoil --surface --distance nan -o " + path("x.ply"), "--distance");
  expect_refused("sample --surface --distance 1 -o " + path("x.ply"), "MESH");
  EXPECT_FALSE(fs::exists(path("x.ply")));
}

TEST_F(Cli, RoomsAndPanoramasBadInputIsOneSentence) {
  expect_refused("room -o " + path("room.png"), ".hdr");
  expect_refused("room --width 33 -o " + path("room.hdr"), "--width");
  expect_refused("room --samples 0 -o " + path("room.hdr"), "--samples");
  EXPECT_FALSE(fs::exists(path("room.hdr")));
  expect_refused("dataset " + path("nowhere") + " -o " + path("out"), "nowhere");
  EXPECT_FALSE(fs::exists(path("out")));
  expect_refused("dataset " + write("text.hdr", "not a panorama\n") + " -o " + path("out"), "not a Radiance");
  fs::create_directories(folder / "none");
  expect_refused("dataset '" + path("none") + "' -o " + path("out"), "no .hdr or .exr");
  EXPECT_FALSE(fs::exists(path("out"))) << "refused before anything is made";
}

TEST_F(Cli, PanoramasAreToldApartByTheirNames) {
  const std::string one = panorama("x/room.hdr", 20), same = panorama("y/room.hdr", 20, 0.5);
  const std::string two = panorama("x/hall.hdr", 20, 0.3), out = " -o " + path("out");
  for (const char* command : {"dataset ", "verify lighting --samples 0 --panoramas "}) {
    const std::string to = command == std::string("dataset ") ? out : "";
    const std::string all = command + path("x") + to + " --manifest ";
    expect_refused(command + path("x") + " " + path("y") + to, "\"" + same + "\": \"" + one + "\" has the same name");
    expect_refused(all + "'" + write("empty.csv", "") + "'", "empty.csv");
    expect_refused(all + "'" + write("blank.csv", "\n\n") + "'", "blank.csv");
    expect_refused(all + "'" + write("one.csv", "file,group,fold\nroom.hdr,a,1\n") + "'", "\"hall.hdr\"");
    expect_refused(all + "'" + write("typo.csv", "file,group,fold\nroom.hdr,a,1\nhal.hdr,b,2\n") + "'", "\"hall.hdr\"");
  }
  const std::string cut = write("x/late.hdr", read(one).substr(0, 300));
  expect_refused("dataset " + path("x") + out, "late.hdr");
  fs::remove(cut);
  EXPECT_FALSE(fs::exists(path("out"))) << "refused before anything is made";
  const std::string good = write("x/manifest.csv", "file,group,fold\nroom.hdr,a,1\nhall.hdr,b,2\n");
  expect_refused("dataset " + path("x") + " --manifest " + good + " -o " + path("x"), "manifest.csv");
  EXPECT_EQ(run("dataset " + path("x") + " --manifest " + good + out).code, 0);
  const std::string made = read(path("out/manifest.csv"));
  EXPECT_NE(made.find("hall.hdr,b,2"), std::string::npos) << made;
  EXPECT_NE(made.find("room.hdr,a,1"), std::string::npos) << made;
}

// An earlier data set in the same folder has left images that the manifest does not name. They do not count.
TEST_F(Cli, QuantisesByTheManifest) {
  fs::create_directories(folder / "set" / "images");
  const host::Picture excerpt(256, 192, {90, 120, 40});
  for (const char* name : {"a_0", "a_1", "b_0", "b_1"})
    host::write_png(path("set/images/" + std::string(name) + ".png"), excerpt);
  const std::string command = "quantise-light none.npz --calibrate " + path("set") + " -o " + path("x.light");
  expect_refused(command, "manifest.csv");
  write("set/manifest.csv", "image,panorama\nimages/a_0.png,a.hdr\nimages/a_1.png,a.hdr\n");
  expect_refused(command, "fewer than 4");
  write("set/manifest.csv", "image\nimages/a_0.png\nimages/a_1.png\nimages/b_0.png\nimages/b_1.png\n");
  expect_refused(command, "none.npz");
}

// Without arguments, `verify lighting` takes the data folder's interiors and studios, place by place, with their
// cross-validated estimates.
TEST_F(Cli, VerifiesLightingOnTheDataFolder) {
  panorama("hdri/indoor/vestibule_1k.hdr", 20), panorama("hdri/studio/studio_small_05_1k.hdr", 40);
  write("manifest.csv", "file,group,fold\nvestibule_1k.hdr,a,1\nstudio_small_05_1k.hdr,b,2\n");
  ::setenv("SANDGLASS_DATA_DIR", folder.c_str(), 1);
  const Outcome whole = run("verify lighting --samples 0");
  ::unsetenv("SANDGLASS_DATA_DIR");
  EXPECT_LE(whole.code, 1) << whole.err;  // made-up panoramas under real names prove nothing
  EXPECT_NE(whole.out.find("16 views of 2 panoramas"), std::string::npos) << whole.out;
  EXPECT_NE(whole.out.find("cross_validated_estimates.csv"), std::string::npos) << whole.out;
  EXPECT_NE(whole.out.find("direction against mean light, 97.5 %"), std::string::npos) << whole.out;
  const std::string row = whole.out.substr(whole.out.find("\nestimate"));
  EXPECT_NE(row.substr(0, row.find('\n', 1)).find("-        -        -        -        -"), std::string::npos) << row;
  // For panoramas that are named, it takes the shipped network. It says at once if the network was fitted to them. The
  // manifest then stops it, before the network has run some hundred times.
  panorama("named/vestibule_1k.hdr", 20), panorama("named/elsewhere.hdr", 40);
  const std::string manifest = " --manifest " + write("other.csv", "file,group,fold\nother.hdr,a,1\n");
  const Outcome known = run("verify lighting --samples 0 --panoramas " + path("named") + manifest);
  EXPECT_EQ(known.code, 2) << known.err;
  EXPECT_EQ(known.out.find("1 of 2 panoramas are of places that the network was fitted to"), 0u) << known.out;
  fs::remove(path("named/vestibule_1k.hdr"));
  EXPECT_EQ(run("verify lighting --samples 0 --panoramas " + path("named") + manifest).out, "");
}

// A network of random numbers knows nothing about light, but its answers are written like those of any other.
TEST_F(Cli, LightWritesNumbersAndPicturesForEveryPhotograph) {
  const std::string network = write("random.light", random_network());
  host::Picture picture(120, 90, {90, 120, 40});
  for (int y = 20; y < 60; ++y) picture.at(y, y)[0] = 255;
  for (const char* name : {"one.png", "two.png"}) host::write_png(path(name), picture);
  const std::string images = path("one.png") + " " + path("two.png") + " " + path("two.png");
  const Outcome done = run("light " + images + " --fov 60 --turn 90 --network " + network + " -o " + path("out"));
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_EQ(std::count(done.out.begin(), done.out.end(), '\n'), 3);
  for (const char* name : {"one", "two", "two_2", "sheet"})
    EXPECT_EQ(read((folder / "out" / (std::string(name) + ".png")).string()).substr(1, 3), "PNG") << name;
  const std::string json = read((folder / "out" / "two_2.json").string());
  for (const char* key : {"direction_camera", "direction_world", "light", "ambient", "contrast", "strength", "sh"})
    EXPECT_NE(json.find(key), std::string::npos) << key;
  EXPECT_EQ(json, read((folder / "out" / "two.json").string()));  // the same photograph
}

TEST_F(Cli, LightDestroysNoPhotograph) {
  const std::string network = " --network " + write("random.light", random_network());
  for (const char* name : {"one.png", "sheet.png"}) host::write_png(path(name), host::Picture(64, 48, {90, 120, 40}));
  const std::string one = read(path("one.png")), sheet = read(path("sheet.png"));
  expect_refused("light " + path("one.png") + network + " -o " + folder.string(), "one.png");
  expect_refused("light " + path("one.png") + network + " -o " + path("out/.."), "one.png");
  fs::create_directories(folder / "elsewhere");
  fs::copy(path("one.png"), path("elsewhere/two.png"));
  const std::string both = path("sheet.png") + " " + path("elsewhere/two.png");
  expect_refused("light " + both + network + " -o " + folder.string(), "sheet.png");
  EXPECT_EQ(read(path("one.png")), one);
  EXPECT_EQ(read(path("sheet.png")), sheet);
  EXPECT_FALSE(fs::exists(path("out"))) << "refused before anything is made";
  // A photograph that is called "sheet" and the sheet of all photographs must become two files.
  EXPECT_EQ(run("light " + both + network + " -o " + path("out")).code, 0);
  EXPECT_TRUE(fs::exists(path("out/sheet_2.png")));
  EXPECT_NE(read(path("out/sheet_2.png")), read(path("out/sheet.png")));
}

TEST_F(Cli, LightsBadInputIsOneSentence) {
  const std::string good = write("good.light", random_network());
  const std::string cut = write("cut.light", random_network().substr(0, random_network().size() - 9));
  host::write_png(path("fine.png"), host::Picture(64, 48, {9, 9, 9}));
  host::write_png(path("dot.png"), host::Picture(1, 1, {9, 9, 9}));
  const std::string text = write("text.png", "not a picture"), out = " -o " + path("out");
  expect_refused("light " + path("fine.png") + out + " --network " + path("nowhere"), "nowhere");
  expect_refused("light " + path("fine.png") + out + " --network " + cut, "cut off");
  expect_refused("light " + path("fine.png") + out + " --network " + text, "not a lighting network");
  expect_refused("light " + path("gone.png") + out + " --network " + good, "gone.png");
  expect_refused("light " + text + out + " --network " + good, "text.png");
  expect_refused("light " + path("fine.png") + out + " --fov 200 --network " + good, "--fov");
  expect_refused("light " + path("fine.png") + out + " --fov nan --network " + good, "--fov");
  expect_refused("light " + path("fine.png") + out + " --turn 45 --network " + good, "--turn");
  EXPECT_FALSE(fs::exists(folder / "out"));
  expect_refused("light " + path("dot.png") + out + " --network " + good, "dot.png");
}

}  // namespace
}  // namespace sandglass
