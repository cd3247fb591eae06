// The viewer's window as a user sees it: the program runs on a display of its own, drawn on the CPU, with mouse and
// keys from a script. The tests look at pixels of its screenshots.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "models/drawing/render.h"
#include "models/files/image.h"
#include "models/geometry/vec3.h"
#include "models/view/head_up.h"
#include "tests/temporary_folder.h"

namespace sandglass::host {
namespace {

namespace fs = std::filesystem;

constexpr int k_skipped = 77, k_width = 640, k_height = 480;
constexpr int k_overlay = 12;  // pixels from the window's corner to the panel

class Window : public ::testing::Test {
 protected:
  const tests::TemporaryFolder place;
  const fs::path& folder = place.path;
  std::string said;
  void SetUp() override { write_scene({0, 0.9, 0.9}); }
  // A block of sand on the floor in front of the camera, with a budget far beyond what it needs.
  void write_scene(Vec3 eye) {
    std::ofstream file(folder / "small.json");
    file.precision(17);
    file << R"({"name": "small", "frame_step": 0.02, "particle_radius": 0.01,
      "bodies": [{"shape": "lattice", "counts": [12, 5, 12], "grains": 9000, "position": [0, 0.012, 0]}],
      "colliders": [{"shape": "half_space"}],
      "camera": {"eye": [)"
         << eye.x << ", " << eye.y << ", " << eye.z << R"(], "target": [0, 0.05, 0], "fov_deg": 40}})";
  }
  std::string view_small() const {
    return std::string("'") + SANDGLASS_PROGRAM + "' view '" + (folder / "small.json").string() +
           "' --budget-ms 1000 --width " + std::to_string(k_width) + " --height " + std::to_string(k_height) + " ";
  }
  // Returns the exit code of `sandglass view small` on the display.
  int show(const std::string& arguments) { return on_display(view_small() + arguments); }
  int on_display(const std::string& what) {
    const std::string log = (folder / "said").string();
    const std::string command = std::string("bash '") + SANDGLASS_WITH_DISPLAY + "' " + what + " >'" + log + "' 2>&1";
    const int status = std::system(command.c_str());
    std::ostringstream text;
    text << std::ifstream(log).rdbuf();
    said = text.str();
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  static std::string scripted(const std::string& script) { return script.empty() ? "" : " --script '" + script + "'"; }
  Picture screenshot(const std::string& script, int frames) {
    const std::string file = (folder / "view.png").string();
    const int code = show("--frames " + std::to_string(frames) + " --screenshot '" + file + "'" + scripted(script));
    if (code == k_skipped) return {};
    EXPECT_EQ(code, 0) << said;
    const Picture picture = read_picture(file);
    EXPECT_EQ(picture.width, k_width);
    EXPECT_EQ(picture.height, k_height);
    return picture;
  }
};

struct Box {
  int left, top, right, bottom;
};

template <class Is>
int count(const Picture& picture, Box box, Is is) {
  int sum = 0;
  for (int y = box.top; y < box.bottom; ++y)
    for (int x = box.left; x < box.right; ++x) sum += is(picture.at(x, y));
  return sum;
}
bool is_sand(const uint8_t* p) { return p[0] > p[1] + 12 && p[1] > p[2] + 12; }
bool is_solid(const uint8_t* p) { return p[2] > p[0] + 30 && p[2] > p[1] + 12; }

constexpr Box k_below_the_panel = {0, 200, k_width, k_height - 40}, k_middle = {290, 220, 350, 270};

TEST_F(Window, ShowsSandOnTheFloorAndTheBudget) {
  const Picture picture = screenshot("", 6);
  if (picture.width == 0) GTEST_SKIP() << said;
  EXPECT_GT(count(picture, k_below_the_panel, is_sand), 8000);
  EXPECT_EQ(count(picture, {0, 400, 100, 440}, is_sand), 0);  // the floor's own grey
  EXPECT_EQ(count(picture, k_below_the_panel, is_solid), 0);

  // The bar begins with the time of the particles, in that stage's colour seen through the panel. The budget is marked
  // in the colour of the panel's text.
  const BudgetBar bar = budget_bar();
  const Colour ink = stage_colour(SANDGLASS_STAGE_GRANULAR);
  const uint8_t* mark = picture.at(k_overlay + bar.x + bar.budget_width, k_overlay + bar.y - 1);
  EXPECT_GT(mark[0] + mark[1] + mark[2], 3 * 190);
  const auto is_granular = [&](const uint8_t* p) {
    return std::abs(p[0] - ink.r) < 30 && std::abs(p[1] - ink.g) < 30 && std::abs(p[2] - ink.b) < 40;
  };
  const int top = k_overlay + bar.y, left = k_overlay + bar.x;
  EXPECT_GT(count(picture, {left, top + 20, left + 80, top + 40}, is_granular), 20);  // the legend's first word
}

// A grain's size is that of films (models/drawing/render.h). One grain from far away, so that it matters little where in
// its particle it is.
TEST_F(Window, AGrainIsAsLargeAsInFilms) {
  constexpr double k_radius = 0.1, k_distance = 10.0, k_fov = 8.0 * 3.14159265358979 / 180.0;
  std::ofstream(folder / "small.json") << R"({"name": "small", "frame_step": 0.001, "particle_radius": 0.1,
    "bodies": [{"shape": "lattice", "counts": [1, 1, 1], "grains": 1, "position": [0, 0.1, 0]}],
    "colliders": [{"shape": "half_space"}],
    "camera": {"eye": [0, 8.1, 6], "target": [0, 0.1, 0], "fov_deg": 8}})";
  const Picture picture = screenshot("", 1);
  if (picture.width == 0) GTEST_SKIP() << said;
  const double mean = k_radius / (k_distance * std::tan(k_fov / 2.0)) * k_height / 2.0;  // pixels
  const double seen = std::sqrt(count(picture, {0, 190, k_width, k_height - 40}, is_sand) / 3.14159265358979);
  ASSERT_GT(std::fabs(grain_size(0) - 1.0F), 0.06F) << "this grain is like the mean one, and tells nothing";
  EXPECT_NEAR(seen / mean, grain_size(0), 0.03);
}

TEST_F(Window, TheMousePushesSandAway) {
  const Picture before = screenshot("", 32);
  if (before.width == 0) GTEST_SKIP() << said;
  const Picture pushed = screenshot(
      "2 cursor 200 320; 3 press right; 8 cursor 220 310; 12 cursor 240 300; 16 cursor 260 290; 20 cursor 280 280; "
      "24 cursor 300 265; 28 cursor 320 250",
      32);
  EXPECT_EQ(count(before, k_middle, is_solid), 0);
  EXPECT_GT(count(pushed, k_middle, is_solid), 400);  // the sphere, where the cursor is
  EXPECT_LT(count(pushed, k_middle, is_sand), count(before, k_middle, is_sand) / 2);
}

TEST_F(Window, KeysPourSandAndTurnTheLight) {
  const Picture before = screenshot("", 24);
  if (before.width == 0) GTEST_SKIP() << said;
  const Picture poured = screenshot("1 cursor 560 330; 2 down P", 24), lit = screenshot("1 down Right", 24);
  const Box beside = {480, 150, 640, 400};
  EXPECT_EQ(count(before, beside, is_sand), 0);
  EXPECT_GT(count(poured, beside, is_sand), 500);
  // The shadow of the pile on the floor moves. Pixels of the floor change; the sand's colour and place hardly do.
  int changed = 0;
  for (int y = 200; y < 440; ++y)
    for (int x = 0; x < k_width; ++x) {
      const uint8_t *a = before.at(x, y), *b = lit.at(x, y);
      changed += !is_sand(a) && !is_sand(b) && std::abs(a[0] - b[0]) > 20;
    }
  EXPECT_GT(changed, 300);
}

// A drag by (100, 50) pixels turns the camera by 0.6 radians and raises it by 0.3. The picture is then that of a camera
// that stood there from the start. Moving the cursor without the button turns nothing.
TEST_F(Window, ADragTurnsTheCamera) {
  const Picture before = screenshot("", 8);
  if (before.width == 0) GTEST_SKIP() << said;
  const Picture dragged = screenshot(
      "1 cursor 300 280; 2 press left; 3 cursor 350 300; 4 cursor 400 330; 5 release left; 6 cursor 50 80", 8);
  const double distance = std::hypot(0.85, 0.9), azimuth = -0.6, elevation = std::asin(0.85 / distance) + 0.3;
  write_scene(Vec3{0, 0.05, 0} + Vec3{std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                                      std::cos(azimuth) * std::cos(elevation)} *
                                     distance);
  const Picture there = screenshot("", 8);
  const auto differing = [&](const Picture& a, const Picture& b) {
    int sum = 0;
    for (int y = k_below_the_panel.top; y < k_below_the_panel.bottom; ++y)
      for (int x = 0; x < k_width; ++x) sum += std::abs(a.at(x, y)[0] - b.at(x, y)[0]) > 12;
    return sum;
  };
  const int all = k_width * (k_below_the_panel.bottom - k_below_the_panel.top);
  EXPECT_LT(differing(dragged, there), all / 100);
  EXPECT_GT(differing(dragged, before), all / 10);
}

// Whether a line of the panel begins with this text, pixel by pixel: the text's colour or red where letters are, the
// background elsewhere.
bool reads(const Picture& picture, int line, const std::string& text) {
  Picture letters(text_width(k_panel_scale, text), 7 * k_panel_scale, {0, 0, 0});
  draw_text(&letters, 0, 0, k_panel_scale, text, {255, 255, 255});
  for (int y = 0; y < letters.height; ++y)
    for (int x = 0; x < letters.width; ++x) {
      const uint8_t* p =
          picture.at(k_overlay + k_panel_margin + x, k_overlay + k_panel_margin + k_panel_line * line + y);
      const bool ink = *std::max_element(p, p + 3) > 140;
      if (ink != (letters.at(x, y)[0] > 0)) return false;
    }
  return true;
}

std::string presses(const char* key, int times, int frame) {
  std::string script;
  const std::string at = std::to_string(frame);
  for (int i = 0; i < times; ++i) script += at + " down " + key + "; " + at + " up " + key + "; ";
  return script;
}

// From 1,000 ms, ten steps down and four up give 1000 / 1.25^6. Then down to the least budget, in which the sand cannot
// be computed: the quality falls, and the panel names the error of the quality level that is reached.
TEST_F(Window, KeysChangeTheBudgetAndTheQualityAnswers) {
  const Picture rich = screenshot(presses("-", 10, 1) + presses("=", 4, 2), 12);
  if (rich.width == 0) GTEST_SKIP() << said;
  EXPECT_TRUE(reads(rich, 1, "budget 262.14 ms"));
  EXPECT_FALSE(reads(rich, 1, "budget 262.15 ms"));
  const auto quality_of = [](uint32_t level) {
    return "quality " + std::to_string(level) + ": " + sandglass_level_describe(level)->name;
  };
  EXPECT_TRUE(reads(rich, 4, quality_of(0)));
  const Picture poor = screenshot(presses("-", 50, 1), 12);
  EXPECT_TRUE(reads(poor, 1, "budget 0.10 ms"));
  EXPECT_FALSE(reads(poor, 4, quality_of(0)));
  int named = 0;
  for (uint32_t level = 0; sandglass_level_describe(level) != nullptr; ++level) {
    char error[48];
    std::snprintf(error, sizeof error, "overlap p99 %.2f %% of r",
                  100.0 * static_cast<double>(sandglass_level_describe(level)->overlap_p99));
    if (reads(poor, 4, quality_of(level))) {
      ++named;
      EXPECT_TRUE(reads(poor, 5, error)) << level;
    }
    if (level == 0) {
      EXPECT_TRUE(reads(rich, 5, error));
    }
  }
  EXPECT_EQ(named, 1);
}

// Keys as a person presses them: events of the X server, through GLFW's callbacks. X does nothing; Q closes the window.
TEST_F(Window, ARealKeyClosesTheWindow) {
  if (std::system("command -v xdotool >/dev/null") != 0)
    GTEST_SKIP() << "no xdotool is installed (Debian's package of that name)";
  std::ofstream(folder / "press.sh") << "timeout 100 " << view_small() << R"( &
viewer=$!
window=$(timeout 60 xdotool search --sync --onlyvisible --name '^Sandglass: small$') || exit 3
xdotool windowfocus --sync "$window"
xdotool key x
sleep 1
kill -0 "$viewer" || exit 4
xdotool key q
wait "$viewer"
)";
  const int code = on_display("bash '" + (folder / "press.sh").string() + "'");
  if (code == k_skipped) GTEST_SKIP() << said;
  EXPECT_EQ(code, 0) << said;  // 124: the key did not arrive
}

TEST_F(Window, SaysWhatIsWrong) {
  if (show("--frames 1") == k_skipped) GTEST_SKIP() << said;
  EXPECT_EQ(show("--frames 1 --script 'dance'"), 2);
  EXPECT_NE(said.find("\"dance\": it is no event"), std::string::npos) << said;
  EXPECT_EQ(show("--screenshot x.png"), 2);
  const std::string command = "env -u DISPLAY -u WAYLAND_DISPLAY '" SANDGLASS_PROGRAM "' view '" +
                              (folder / "small.json").string() + "' 2>'" + (folder / "said").string() + "'";
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), 2);
  std::ostringstream text;
  text << std::ifstream(folder / "said").rdbuf();
  EXPECT_NE(text.str().find("there is no display here"), std::string::npos) << text.str();
}

}  // namespace
}  // namespace sandglass::host
