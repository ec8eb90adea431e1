#include "nodes/visual_node/viewer.hpp"

#include <epoxy/gl.h>
#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "bus/log/node_recording.hpp"
#include "core/clock.hpp"
#include "nodes/visual_node/camera_feed.hpp"
#include "nodes/visual_node/draw/renderer.hpp"
#include "nodes/visual_node/film/exposure.hpp"
#include "nodes/visual_node/film/render_scale.hpp"
#include "nodes/visual_node/gl/gl_context.hpp"
#include "nodes/visual_node/pictures/contact_sheet.hpp"
#include "nodes/visual_node/pictures/still.hpp"
#include "nodes/visual_node/receiver.hpp"
#include "nodes/visual_node/sky/earth_air.hpp"
#include "nodes/visual_node/structures.hpp"
#include "nodes/visual_node/summary.hpp"
#include "nodes/visual_node/window/camera_control.hpp"
#include "nodes/visual_node/window/interaction.hpp"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace visual_node {
namespace {

constexpr int kDrawingNice = 10;  // chosen without a study

// Of a frame's period, for drawing; the rest is for what else the machine does between two pictures.
constexpr double kDrawingShare = 0.9;

std::set<pid_t> Threads() {
  std::set<pid_t> threads;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/task", ignored)) {
    threads.insert(static_cast<pid_t>(std::strtol(entry.path().filename().c_str(), nullptr, 10)));
  }
  return threads;
}

// Lowers the priority of the calling thread and of those that are not in `others` (llvmpipe's), in favour of the force
// loop. Threads that have a policy of their own keep it.
void LowerPriority(const std::set<pid_t>& others) {
  const sched_param none{};
  for (const pid_t thread : Threads()) {
    const bool is_drawing = thread == gettid() || others.count(thread) == 0;
    if (!is_drawing || sched_getscheduler(thread) != SCHED_OTHER) continue;
    sched_setscheduler(thread, SCHED_BATCH, &none);
    const auto who = static_cast<id_t>(thread);
    if (getpriority(PRIO_PROCESS, who) < kDrawingNice) setpriority(PRIO_PROCESS, who, kDrawingNice);
  }
}

// CPU time of all threads of this process [s].
double CpuTime_s() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// A picture's name comes over the bus, so only characters that are safe in a file name are kept.
std::string SafeName(const std::string& name, std::uint64_t number) {
  std::string safe;
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-') safe += c;
  }
  return safe.empty() ? "screenshot_" + std::to_string(number) : safe;
}

class Viewer {
 public:
  Viewer(const Options& options, const scene::Scenario& scenario, Signals& signals, Surfaces* surfaces)
      : options_(options),
        signals_(signals),
        surfaces_(surfaces),
        receiver_(scenario, &log_),
        structures_(scenario),
        scale_(kDrawingShare / options.max_frames_per_s) {
    summary_.scenario = scenario.name;
  }

  core::Result<void> Run(const scene::Scenario& scenario) {
    if (auto opened = log_.Open(options_.out / "latency_visual.csv"); !opened) return opened;
    auto recording = bus::log::StartRecording(options_.node.name, options_.recording);
    if (!recording) return tl::unexpected(recording.error());
    recording_ = std::move(*recording);
    if (auto kept = receiver_.Record(options_.out / "scene.mcap"); !kept) return kept;
    if (auto started = receiver_.Start(bus::log::WithTap(options_.node, recording_.get())); !started) return started;
    other_threads_ = Threads();
    auto context =
        GlContext::Create({options_.window_width, options_.window_height, scenario.title, !options_.is_headless});
    if (!context) return tl::unexpected(context.error());
    context_ = std::move(*context);
    summary_.gl_renderer = context_->renderer_name();
    receiver_.Update();
    shown_ = receiver_.scene();
    if (auto known = view::CheckCamera(*shown_.assets, options_.view); !known) return known;
    const auto chosen = view::ReadChoices(options_.show, shown_.assets->instance_names);
    if (!chosen) return tl::unexpected(chosen.error());
    receiver_.Choose([&](view::Choices& choices) { choices = *chosen; });
    auto renderer =
        Renderer::Create(shown_, [](const std::filesystem::path& file) { return vps::LoadVisualMesh(file); });
    if (!renderer) return tl::unexpected(renderer.error());
    renderer_ = std::move(*renderer);
    summary_.num_triangles = renderer_->num_triangles();
    std::printf("drawing %zu triangles with %s\n", renderer_->num_triangles(), summary_.gl_renderer.c_str());
    if (!renderer_->sky_note().empty()) std::printf("%s\n", renderer_->sky_note().c_str());
    if (const auto air = CachedAir()) {
      renderer_->SetAir(*air);
    } else {
      std::printf("the Earth has no air until it is computed, in about a minute of a core that is free\n");
      air_in_work_ = std::make_unique<AirInWork>();
    }
    std::fflush(stdout);
    auto result = Loop();
    if (auto finished = Finish(); !finished && result) result = finished;
    return result;
  }

 private:
  core::Result<void> Loop() {
    CameraControl control(*shown_.assets, options_.view);
    if (!options_.is_headless) control.Attach(context_->window());
    Interaction interaction(&receiver_, renderer_.get());
    CameraFeed feed(renderer_.get());
    const auto period_ns = static_cast<std::int64_t>(1e9 / options_.max_frames_per_s);
    auto target = std::make_unique<RenderTarget>(options_.width, options_.height);
    std::int64_t last_ns = core::MonotonicNow_ns();
    first_frame_ns_ = last_ns;
    first_frame_cpu_s_ = CpuTime_s();
    while (signals_.is_stop_wanted == 0 && glfwWindowShouldClose(context_->window()) == GLFW_FALSE) {
      glfwPollEvents();
      if (!options_.is_headless) FitTo(context_->window(), target);
      const std::int64_t start_ns = core::MonotonicNow_ns();
      if (auto taken = TakeScene(control); !taken) return taken;
      TakeAir();
      const scene::Camera& camera =
          control.Update(*shown_.assets, shown_.step, 1e-9 * static_cast<double>(start_ns - last_ns));
      const std::optional<Frame> frame = NextFrame(camera, *target, start_ns);
      if (!frame) continue;
      const std::int64_t draw_ns = core::MonotonicNow_ns();
      if (auto drawn = renderer_->Draw(*frame->scene, *frame->camera, *target, frame->look); !drawn) return drawn;
      glFinish();
      // Not before: on a busy machine the start would take many times as long, and a session waits for it.
      if (!std::exchange(is_priority_low_, true)) LowerPriority(other_threads_);
      CountFrame(*frame, core::MonotonicNow_ns());
      exposure_.Update(renderer_->film().MeanLuminance(), 1e-9 * static_cast<double>(start_ns - last_ns));
      log_.Drain();
      if (auto sent = DrawCameras(feed, *target); !sent) return sent;
      if (!options_.is_headless) {
        const bool is_mouse_down = glfwGetMouseButton(context_->window(), GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS;
        const double dt_s = 1e-9 * static_cast<double>(start_ns - last_ns);
        if (auto drawn = interaction.DrawMenu(*shown_.assets, *target, is_mouse_down, dt_s, &control); !drawn) {
          return drawn;
        }
        Show(*target);
        const auto wishes = interaction.Take(*frame->scene, *frame->camera, *target, &control);
        if (!wishes) return tl::unexpected(wishes.error());
        if (wishes->is_full_screen_wanted) context_->ToggleFullScreen();
        if (wishes->is_screenshot_wanted) Take("", camera);
        if (wishes->is_view_saved) WriteViews(control);
      }
      scale_.Update(1e-9 * static_cast<double>(std::max(core::MonotonicNow_ns() - draw_ns, frame->elsewhere_ns)));
      if (signals_.is_screenshot_wanted != 0) {
        signals_.is_screenshot_wanted = 0;
        Take("", camera);
      }
      for (const std::string& name : receiver_.TakeScreenshotRequests()) Take(name, camera);
      last_ns = start_ns;
      const std::int64_t left_ns = start_ns + period_ns - core::MonotonicNow_ns();
      if (left_ns > 0) {
        const timespec pause{0, static_cast<long>(std::min<std::int64_t>(left_ns, 999'999'999))};
        nanosleep(&pause, nullptr);
      }
    }
    return {};
  }

  // What a picture shows, and since when it has been in work.
  struct Frame {
    const view::Scene* scene = nullptr;
    const scene::Camera* camera = nullptr;
    Look look;
    std::int64_t start_ns = 0;
    std::int64_t elsewhere_ns = 0;  // that others took for it meanwhile
  };

  // None: whoever draws the surfaces is not done.
  std::optional<Frame> NextFrame(const scene::Camera& camera, const RenderTarget& target, std::int64_t start_ns) {
    Frame frame{&shown_, &camera, Live(), start_ns};
    if (surfaces_ == nullptr || surfaces_->is_alone()) return frame;
    const auto scaled = [&](int pixels) { return std::max(1, static_cast<int>(std::lround(scale_.value() * pixels))); };
    surfaces_->Offer(shown_, renderer_->LightAround(shown_), view::PlaceCamera(camera, shown_), scaled(target.width()),
                     scaled(target.height()));
    const Surfaces::Picture* picture = surfaces_->Take();
    if (picture == nullptr) return std::nullopt;
    frame.scene = picture->scene;
    frame.camera = picture->camera;
    frame.look.surfaces = picture->canvas;
    frame.start_ns = picture->begin_ns;
    frame.elsewhere_ns = picture->work_ns;
    is_new_scene_ = true;
    return frame;
  }

  // Beside the picture, after its light was measured: inset and topics of cameras.
  core::Result<void> DrawCameras(CameraFeed& feed, const RenderTarget& target) {
    const std::int64_t now_ns = core::MonotonicNow_ns();
    auto seen = feed.Take(shown_, receiver_.image_rates_hz(), Live(), now_ns);
    if (!seen) return tl::unexpected(seen.error());
    for (CameraFeed::Seen& one : *seen) receiver_.SendImage(std::move(one));
    if (!receiver_.choices().has(view::Overlay::kCamera)) return {};
    return feed.DrawInset(shown_, Live(), now_ns, target);
  }

  // Lines for a scenario file.
  void WriteViews(const CameraControl& control) const {
    const std::filesystem::path file = options_.out / "views.xml";
    std::ofstream out(file);
    for (const scene::Camera& camera : control.saved_views()) out << view::CameraXml(camera, *shown_.assets) << "\n";
    std::fprintf(stderr, "views %s: %s\n", file.c_str(), out.flush() ? "done" : "cannot be written");
  }

  [[nodiscard]] Look Live() const {
    return {.exposure = exposure_.value(), .scale = scale_.value(), .with_penumbra = false};
  }

  // Takes the newest scene, as late as possible before drawing. When the step has changed, this scene is the result of
  // the previous step and is added to the contact sheet with that step's caption.
  core::Result<void> TakeScene(const CameraControl& control) {
    is_new_scene_ = receiver_.Update();
    if (!is_new_scene_) return {};
    const view::Scene& next = receiver_.scene();
    if (!shown_.step.empty() && next.step != shown_.step) {
      view::Scene end = next;
      end.step = shown_.step;
      end.texts = shown_.texts;
      if (auto kept = Keep(end, control.ForStep(*end.assets, end.step)); !kept) return kept;
    }
    shown_ = next;
    structures_.AddTo(receiver_.choices(), &shown_);
    return {};
  }

  void TakeAir() {
    if (air_in_work_ == nullptr) return;
    const auto air = air_in_work_->Take();
    if (!air) return;
    renderer_->SetAir(*air);
    air_in_work_.reset();
    std::printf("the Earth has its air\n");
    std::fflush(stdout);
  }

  core::Result<void> Keep(const view::Scene& scene, const scene::Camera& camera) {
    const auto image = RenderSmooth(*renderer_, scene, camera, options_.width, options_.height);
    if (!image) return tl::unexpected(image.error());
    const std::string name = SafeName(scene.step, 0);
    sheet_.Add(name, *image);
    return WritePng(*image, options_.out / "frames" / (name + ".png"));
  }

  void Take(const std::string& name, const scene::Camera& camera) {
    const std::filesystem::path file = options_.out / (SafeName(name, ++num_screenshots_) + ".png");
    const auto image = RenderSmooth(*renderer_, shown_, camera, options_.width, options_.height);
    const auto written = image ? WritePng(*image, file) : core::Result<void>(tl::unexpected(image.error()));
    std::fprintf(stderr, "screenshot %s: %s\n", file.c_str(), written ? "done" : written.error().detail.c_str());
  }

  void CountFrame(const Frame& frame, std::int64_t done_ns) {
    ++summary_.frames;
    summary_.draw.Add(done_ns - frame.start_ns);
    if (is_new_scene_) {
      core::Trace trace = frame.scene->through_physics;
      trace.Add(core::Stage::kFrameStart, frame.start_ns);
      trace.Add(core::Stage::kFrameDone, done_ns);
      log_.AddFrame(trace);
    }
    ++frames_in_window_;
    if (done_ns - window_start_ns_ > core::kNanosecondsPerSecond / 2) {
      receiver_.SetFramesPerSecond(frames_in_window_ * 1e9 / static_cast<double>(done_ns - window_start_ns_));
      window_start_ns_ = done_ns;
      frames_in_window_ = 0;
    }
    summary_.render_scale_sum += scale_.value();
    receiver_.SetFrames(summary_.frames);
    receiver_.SetRenderScale(scale_.value());
    receiver_.SetReady();
  }

  static void FitTo(GLFWwindow* window, std::unique_ptr<RenderTarget>& target) {
    int width = 0, height = 0;
    glfwGetFramebufferSize(window, &width, &height);
    if (width < 16 || height < 16 || (width == target->width() && height == target->height())) return;
    target = std::make_unique<RenderTarget>(width, height);
  }

  void Show(const RenderTarget& target) const {
    glBlitNamedFramebuffer(target.framebuffer(), 0, 0, 0, target.width(), target.height(), 0, 0, target.width(),
                           target.height(), GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glfwSwapBuffers(context_->window());
  }

  // Figures first: whoever stops this process does not wait long, and pictures take long on a busy machine.
  core::Result<void> Finish() {
    core::Result<void> result = FinishFigures();
    if (auto kept = FinishPictures(); !kept && result) result = kept;
    // A virtual display may have been stopped together with this node; closing the window would then abort the process.
    if (options_.is_headless) context_->LeaveToKernel();
    return result;
  }

  core::Result<void> FinishFigures() {
    summary_.cpu_s = CpuTime_s() - first_frame_cpu_s_;
    summary_.seconds = 1e-9 * static_cast<double>(core::MonotonicNow_ns() - first_frame_ns_);
    receiver_.Stop();
    log_.Drain();
    log_.Close();
    summary_.t2_state = log_.state();
    summary_.t2_state_direct = log_.state_direct();
    summary_.t2_image = log_.image();
    summary_.states = receiver_.num_states();
    summary_.counters = receiver_.counters();
    summary_.clock_bounds_ns = receiver_.clock_bounds_ns();
    auto result = summary_.Write(options_.out / "visual_node.json");
    if (auto stopped = bus::log::StopRecording(recording_.get()); !stopped && result) result = stopped;
    return result;
  }

  core::Result<void> FinishPictures() {
    // The procedure's last status may have arrived after the last frame.
    const CameraControl control(*shown_.assets, options_.view);
    core::Result<void> result = TakeScene(control);
    if (!shown_.step.empty() && result) result = Keep(shown_, control.ForStep(*shown_.assets, shown_.step));
    if (sheet_.size() > 0 && result) result = sheet_.Write(options_.out / "contact_sheet.png");
    return result;
  }

  const Options& options_;
  Signals& signals_;
  Surfaces* surfaces_;
  LatencyLog log_;
  std::unique_ptr<bus::log::TapRecorder> recording_;  // outlives the receiver's node
  Receiver receiver_;
  StructureShow structures_;
  std::unique_ptr<GlContext> context_;
  std::unique_ptr<Renderer> renderer_;  // after the context: deleted before it
  std::unique_ptr<AirInWork> air_in_work_;
  std::set<pid_t> other_threads_;  // those that do not draw
  bool is_priority_low_ = false;
  RenderScale scale_;
  Exposure exposure_;  // of the window; pictures that are kept have the same exposure in every run
  view::Scene shown_;
  ContactSheet sheet_;
  Summary summary_;
  bool is_new_scene_ = false;
  std::uint64_t num_screenshots_ = 0;
  std::int64_t first_frame_ns_ = 0;
  double first_frame_cpu_s_ = 0.0;
  std::int64_t window_start_ns_ = 0;
  int frames_in_window_ = 0;
};

}  // namespace

core::Result<void> RunViewer(const Options& options, const scene::Scenario& scenario, Signals& signals,
                             Surfaces* surfaces) {
  Viewer viewer(options, scenario, signals, surfaces);
  return viewer.Run(scenario);
}

}  // namespace visual_node
