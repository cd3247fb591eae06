// The window's mouse and keys and a script take the same way: both become InputEvents, which Hands takes.
#include "models/view/window.h"

#include <GLFW/glfw3.h>

#include <algorithm>
#include <set>

#include "models/files/failure.h"
#include "models/view/head_up.h"
#include "models/view/input_script.h"
#include "models/view/orbit.h"
#include "models/view/painter.h"
#include "models/work/progress.h"

namespace sandglass::host {

namespace {

constexpr double k_display_step = 1.0 / 60.0;  // seconds
constexpr double k_turn = 0.006;               // radians per pixel
constexpr double k_zoom = 0.9;                 // factor of the distance per notch of the wheel
constexpr double k_light_speed = 60.0;         // degrees per second while an arrow key is held
constexpr double k_budget_step = 1.25;
constexpr double k_pour_height = 40.0;  // particle radii above the floor
constexpr int k_margin = 12;            // pixels between overlays and the window's edge

// What the mouse and the keys do to the scene.
struct Hands {
  LiveScene& live;
  Orbit& orbit;
  int width, height;
  double x = 0.0, y = 0.0;
  bool turning = false, pushing = false, paused = false, particles = false, closing = false;
  std::set<std::string> held = {};

  void take(const InputEvent& event) {
    switch (event.kind) {
      case InputKind::cursor:
        if (turning) orbit.turn(-k_turn * (event.x - x), k_turn * (event.y - y));
        x = event.x, y = event.y;
        break;
      case InputKind::press:
      case InputKind::release:
        (event.right_button ? pushing : turning) = event.kind == InputKind::press;
        break;
      case InputKind::scroll:
        orbit.zoom(std::pow(k_zoom, event.y));
        break;
      case InputKind::key_down:
        held.insert(event.key);
        once(event.key);
        break;
      case InputKind::key_up:
        held.erase(event.key);
        break;
    }
  }

  void once(const std::string& key) {
    if (key == "-") live.scale_budget(1.0 / k_budget_step);
    if (key == "=") live.scale_budget(k_budget_step);
    if (key == "G") particles = !particles;
    if (key == "R") live.restart();
    if (key == "Space") paused = !paused;
    if (key == "Q") closing = true;
  }

  bool holds(const char* key) const { return held.count(key) > 0; }

  // Applies the keys and buttons that are held down, for `seconds`.
  void act(double seconds) {
    const double turn = k_light_speed * seconds;
    live.turn_light(turn * (holds("Down") - holds("Up")), turn * (holds("Right") - holds("Left")));
    const Ray ray = orbit.ray(x, y, width, height);
    const double reach = 4.0 * length(orbit.camera().eye - orbit.camera().target), r = live.scene().particle_radius;
    const double low = live.floor() + 0.8 * live.push_radius();
    live.push_at(pushing ? std::optional(on_plane(ray, low, reach)) : std::nullopt);
    Vec3 nozzle = on_plane(ray, live.floor(), reach);
    nozzle.y += k_pour_height * r;
    live.pour_at(holds("P") ? std::optional(nozzle) : std::nullopt);
  }
};

std::string key_name(int key) {
  constexpr std::pair<int, const char*> k_named[] = {
      {GLFW_KEY_LEFT, "Left"},   {GLFW_KEY_RIGHT, "Right"},   {GLFW_KEY_UP, "Up"},    {GLFW_KEY_DOWN, "Down"},
      {GLFW_KEY_SPACE, "Space"}, {GLFW_KEY_KP_SUBTRACT, "-"}, {GLFW_KEY_KP_ADD, "="}, {GLFW_KEY_ESCAPE, "Q"},
      {GLFW_KEY_MINUS, "-"},     {GLFW_KEY_EQUAL, "="}};
  for (const auto& [code, name] : k_named)
    if (code == key) return name;
  const bool plain = (key >= GLFW_KEY_A && key <= GLFW_KEY_Z) || (key >= GLFW_KEY_0 && key <= GLFW_KEY_9);
  return plain ? std::string(1, static_cast<char>(key)) : "";
}

Hands& hands_of(GLFWwindow* window) { return *static_cast<Hands*>(glfwGetWindowUserPointer(window)); }

void listen(GLFWwindow* window, Hands* hands) {
  glfwSetWindowUserPointer(window, hands);
  glfwSetCursorPosCallback(
      window, [](GLFWwindow* w, double x, double y) { hands_of(w).take({.kind = InputKind::cursor, .x = x, .y = y}); });
  glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int action, int) {
    const InputKind kind = action == GLFW_PRESS ? InputKind::press : InputKind::release;
    hands_of(w).take({.kind = kind, .right_button = button != GLFW_MOUSE_BUTTON_LEFT});
  });
  glfwSetScrollCallback(window,
                        [](GLFWwindow* w, double, double y) { hands_of(w).take({.kind = InputKind::scroll, .y = y}); });
  glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int) {
    const InputKind kind = action == GLFW_PRESS ? InputKind::key_down : InputKind::key_up;
    if (const std::string name = key_name(key); !name.empty() && action != GLFW_REPEAT)
      hands_of(w).take({.kind = kind, .key = name});
  });
}

struct Window {
  GLFWwindow* handle = nullptr;
  Window(int width, int height, const std::string& title, bool visible) {
    if (glfwInit() == 0)
      throw Failure(
          "cannot open a window: there is no display here. Run: xvfb-run sandglass view ... --frames 200 --screenshot "
          "view.png");
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_FORWARD_COMPAT, GLFW_TRUE);
    glfwWindowHint(GLFW_SAMPLES, visible ? 4 : 0);
    glfwWindowHint(GLFW_RESIZABLE, visible ? GLFW_TRUE : GLFW_FALSE);
    handle = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
    if (handle == nullptr) {
      glfwTerminate();
      throw Failure(
          "cannot open a window: this display has no OpenGL 3.3. Set LIBGL_ALWAYS_SOFTWARE=1 to draw on the CPU.");
    }
    glfwMakeContextCurrent(handle);
  }
  ~Window() {
    glfwDestroyWindow(handle);
    glfwTerminate();
  }
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;
};

Camera first_camera(const LiveScene& live, double aspect) {
  if (live.scene().camera) return *live.scene().camera;
  // Sand spreads beyond where it stood. Half of its height on every side is enough for the first picture.
  Bounds room = live.bounds();
  const Vec3 size = room.high - room.low, spread = {0.5 * size.y, 0.0, 0.5 * size.y};
  room.low = room.low - spread, room.high = room.high + spread;
  return automatic_camera({&room, 1}, aspect);
}

}  // namespace

void view_scene(const ViewOptions& options) {
  const std::vector<InputEvent> script = parse_input_script(options.script);
  LiveScene live(options.live);
  const bool scripted = options.frames > 0;
  const Window window(options.width, options.height, "Sandglass: " + live.scene().name, !scripted);
  glfwSwapInterval(scripted ? 0 : 1);
  Painter painter;
  Orbit orbit(first_camera(live, static_cast<double>(options.width) / options.height));
  Hands hands = {live, orbit, options.width, options.height};
  if (!scripted) listen(window.handle, &hands);  // a film must not depend on the real mouse

  const Picture help = key_help();
  Picture picture;
  auto next = script.begin();
  double before = glfwGetTime(), period = k_display_step;  // `period` is a running mean
  for (uint32_t frame = 0; !scripted || frame < options.frames; ++frame) {
    glfwPollEvents();
    for (; next != script.end() && next->frame <= frame; ++next) hands.take(*next);
    if (hands.closing || glfwWindowShouldClose(window.handle) != 0 || interrupted()) break;
    glfwGetWindowSize(window.handle, &hands.width, &hands.height);
    int width = 0, height = 0;
    glfwGetFramebufferSize(window.handle, &width, &height);

    const double now = glfwGetTime(), seconds = scripted ? k_display_step : std::min(now - before, 0.25);
    if (frame > 0) period += 0.05 * (now - before - period);
    before = now;
    hands.act(seconds);
    if (!hands.paused) live.advance(seconds);
    if (width < 1 || height < 1) continue;  // minimised

    Painted scene;
    const std::vector<FloorShadow> shadows = live.shadows();
    const bool particles = hands.particles || live.grains().empty();
    if (particles) {
      scene.spheres = live.particles(), scene.sphere_floats = 3, scene.radius = live.scene().particle_radius;
    } else {
      static_assert(sizeof(sandglass_grain) == 4 * sizeof(float));
      scene.spheres = {live.grains().data()->position, 4 * live.grains().size()};
      scene.radius = live.grain_radius(), scene.grains = true;
    }
    scene.colliders = live.colliders(), scene.fields = &live.fields(), scene.shadows = shadows;
    const std::optional<FloorShadow> pile = live.pile(false), on_sand = live.pile(true);
    if (pile) scene.pile = &*pile, scene.pile_on_sand = &*on_sand;
    scene.to_light = live.to_light(), scene.camera = orbit.camera(), scene.bounds = live.bounds();
    const LightTrack& light = *live.scene().light;
    HeadUp state = {live.scene().name,  &live.report(),       live.budget_ms(), 1.0 / period,
                    light.polar_deg[0], light.azimuth_deg[0], hands.paused};
    for (sandglass_stage stage = 0; stage < SANDGLASS_STAGE_COUNT; ++stage) state.runs[stage] = live.runs(stage);
    const Picture panel = head_up_panel(state);
    const Overlay overlays[] = {{&panel, k_margin, k_margin}, {&help, k_margin, height - help.height - k_margin}};
    painter.paint(scene, width, height, overlays);
    if (scripted && frame + 1 == options.frames) picture = painter.read_back(width, height);
    glfwSwapBuffers(window.handle);
  }
  if (!options.screenshot.empty() && picture.width > 0) write_png(options.screenshot, picture);
}

}  // namespace sandglass::host
