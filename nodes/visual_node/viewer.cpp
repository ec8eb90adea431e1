#include "nodes/visual_node/viewer.hpp"

#include <epoxy/gl.h>
#include <malloc.h>
#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <future>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "bus/log/node_recording.hpp"
#include "core/clock.hpp"
#include "nodes/visual_node/camera_feed.hpp"
#include "nodes/visual_node/composition.hpp"
#include "nodes/visual_node/draw/composer.hpp"
#include "nodes/visual_node/draw/ingredients.hpp"
#include "nodes/visual_node/draw/renderer.hpp"
#include "nodes/visual_node/film/exposure.hpp"
#include "nodes/visual_node/film/render_scale.hpp"
#include "nodes/visual_node/gl/detail_in_work.hpp"
#include "nodes/visual_node/gl/gl_context.hpp"
#include "nodes/visual_node/pictures/contact_sheet.hpp"
#include "nodes/visual_node/pictures/live_film.hpp"
#include "nodes/visual_node/pictures/still.hpp"
#include "nodes/visual_node/receiver.hpp"
#include "nodes/visual_node/sky/earth_air.hpp"
#include "nodes/visual_node/structures.hpp"
#include "nodes/visual_node/summary.hpp"
#include "nodes/visual_node/walls/walls.hpp"
#include "nodes/visual_node/window/camera_control.hpp"
#include "nodes/visual_node/window/fit_target.hpp"
#include "nodes/visual_node/window/interaction.hpp"
#include "nodes/visual_node/window/pointer.hpp"
#include "nodes/visual_node/window/saved_views.hpp"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace visual_node {
namespace {

constexpr int kDrawingNice = 10;  // chosen without a study

// Whoever is farther behind the rate of pictures, as at the start, does not draw all of them.
constexpr std::int64_t kMostBehind_ns = 500'000'000;

// How far a surface may be off its place in a live picture: what smoothing hides.
constexpr double kLiveDetail_px = 0.25;

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
    if (!options.head.empty()) receiver_.ReadHead(options.head);
    if (!options.wall) return;
    link_.emplace(*options.wall);
    receiver_.JoinWalls(&*link_);
    walls_.emplace(&*link_, [this] { return signals_.is_stop_wanted != 0; });
  }

  core::Result<void> Run(const scene::Scenario& scenario) {
    IngredientsInWork ingredients_in_work(view::SceneMirror(scenario).scene().assets->meshes);
    auto air_in_cache = std::async(std::launch::async, [] { return CachedAir(); });
    std::error_code error;
    std::filesystem::create_directories(options_.out, error);  // else the first file that is written complains
    if (auto opened = log_.Open(options_.out / "latency_visual.csv"); !opened) return opened;
    auto recording = bus::log::StartRecording(options_.node.name, options_.recording);
    if (!recording) return tl::unexpected(recording.error());
    recording_ = std::move(*recording);
    if (auto kept = receiver_.Record(options_.out / "scene.mcap"); !kept) return kept;
    if (SteersHand()) receiver_.Steer();
    if (auto begun = receiver_.Begin(bus::log::WithTap(options_.node, recording_.get())); !begun) return begun;
    other_threads_ = Threads();
    ContextOptions window{options_.window_width, options_.window_height, scenario.title};
    window.is_visible = !options_.is_headless;
    window.is_placed = options_.window_place_px.has_value();
    if (window.is_placed) {
      window.x = options_.window_place_px->x;
      window.y = options_.window_place_px->y;
    }
    auto context = GlContext::Create(window);
    if (!context) return tl::unexpected(context.error());
    context_ = std::move(*context);
    summary_.gl_renderer = context_->renderer_name();
    if (auto joined = JoinSession(); !joined) return joined;
    receiver_.Update();
    shown_ = receiver_.scene();
    if (auto known = view::CheckCamera(*shown_.assets, options_.view); !known) return known;
    auto chosen = view::ReadChoices(options_.show, shown_.assets->instance_names);
    if (!chosen) return tl::unexpected(chosen.error());
    if (options_.stereo != view::Stereo::kNone) chosen->stereo = options_.stereo;
    chosen->eye_distance_m = options_.eye_distance_m;
    receiver_.Choose([&](view::Choices& choices) { choices = *chosen; });
    auto composition = CompositionOf(options_, *shown_.assets);
    if (!composition) return tl::unexpected(composition.error());
    composition_ = std::move(*composition);
    auto composer = Composer::Create();
    if (!composer) return tl::unexpected(composer.error());
    composer_.emplace(std::move(*composer));
    Ingredients ingredients = ingredients_in_work.Take();
    auto renderer = Renderer::Create(shown_, ingredients);
    if (!renderer) return tl::unexpected(renderer.error());
    renderer_ = std::move(*renderer);
    summary_.num_triangles = renderer_->num_triangles();
    std::printf("drawing %zu triangles with %s\n", renderer_->num_triangles(), summary_.gl_renderer.c_str());
    if (!renderer_->sky_note().empty()) std::printf("%s\n", renderer_->sky_note().c_str());
    if (const auto air = air_in_cache.get()) {
      renderer_->SetAir(*air);
    } else {
      std::printf("the Earth has no air until it is computed, in about a minute of a core that is free\n");
      air_in_work_ = std::make_unique<AirInWork>();
    }
    std::fflush(stdout);
    for (MeshData& data : *ingredients.meshes) meshes_.push_back(std::move(data.mesh));
    auto result = Loop();
    if (auto finished = Finish(); !finished && result) result = finished;
    return result;
  }

 private:
  // The receiver's thread does not draw.
  core::Result<void> JoinSession() {
    const std::set<pid_t> before = Threads();
    if (auto joined = receiver_.Join(); !joined) return joined;
    for (const pid_t thread : Threads()) {
      if (before.count(thread) == 0) other_threads_.insert(thread);
    }
    return {};
  }

  core::Result<void> Loop() {
    CameraControl control(*shown_.assets, composition_.layout.steered());
    if (!options_.is_headless) {
      control.Attach(context_->window());
      TakeViews(&control);
    }
    if (SteersHand()) {
      pointer_.emplace(receiver_.scenario());
      pointer_->Attach(context_->window());
    }
    Interaction interaction(&receiver_, renderer_.get());
    CameraFeed feed(renderer_.get());
    if (options_.film_fd >= 0) film_.emplace(options_.film_fd, options_.max_frames_per_s);
    const double frames_per_s =
        options_.is_rate_given || context_->is_software() ? options_.max_frames_per_s : context_->refresh_rate_Hz();
    const double picture_s = kDrawingShare / frames_per_s;
    const bool begins_small = context_->is_software() && !options_.is_full_size;
    scale_ = begins_small ? RenderScale::FromLeast(picture_s) : RenderScale(picture_s);
    const auto period_ns = static_cast<std::int64_t>(1e9 / frames_per_s);
    auto target = std::make_unique<RenderTarget>(options_.width, options_.height);
    std::int64_t last_ns = core::MonotonicNow_ns(), next_ns = last_ns;
    first_frame_ns_ = last_ns;
    first_frame_cpu_s_ = CpuTime_s();
    while (signals_.is_stop_wanted == 0 && glfwWindowShouldClose(context_->window()) == GLFW_FALSE) {
      glfwPollEvents();
      if (!options_.is_headless) FitTo(context_->window(), &target);
      TakeAir();
      TakeDetail();
      waited_ns_ = 0;
      const std::int64_t start_ns = core::MonotonicNow_ns();
      const double dt_s = 1e-9 * static_cast<double>(start_ns - std::exchange(last_ns, start_ns));
      if (pointer_) Steer(start_ns, &control);
      const auto camera = BeginFrame(control, dt_s, interaction.is_menu_open());
      if (!camera) return tl::unexpected(camera.error());
      if (pointer_) {
        camera_ = *camera;
        DescribeSteering();
      }
      const std::optional<Frame> frame = NextFrame(*camera, *target, start_ns + waited_ns_);
      if (!frame) continue;
      const std::int64_t draw_ns = core::MonotonicNow_ns();
      Composition composition = composition_;
      if (frame->viewing != nullptr) composition.viewing = *frame->viewing;
      const Composer::Shown shown{*frame->scene, *frame->camera, composition};
      if (auto drawn = DrawPicture(shown, *frame, feed, *target); !drawn) return drawn;
      exposure_.Update(mean_luminance_, dt_s);
      log_.Drain();
      if (auto sent = SendCameras(feed); !sent) return sent;
      if (!options_.is_headless) {
        const bool is_mouse_down = glfwGetMouseButton(context_->window(), GLFW_MOUSE_BUTTON_LEFT) == GLFW_PRESS;
        if (auto drawn = interaction.DrawMenu(*shown_.assets, *target, is_mouse_down, dt_s, &control); !drawn) {
          return drawn;
        }
        AwaitShow();
        Show(*target);
        if (walls_) walls_->Shown();
        const auto wishes = interaction.Take(shown, *target, &control);
        if (!wishes) return tl::unexpected(wishes.error());
        if (wishes->is_full_screen_wanted) context_->ToggleFullScreen();
        if (wishes->is_screenshot_wanted) Take("", shown);
        if (wishes->is_view_saved) KeepViews(control);
      } else if (walls_) {
        AwaitShow();
        walls_->Shown();
      }
      const std::int64_t drawing_ns = core::MonotonicNow_ns() - draw_ns - waited_to_show_ns_;
      if (film_) TakeForFilm(*target);
      if (!options_.is_full_size) {
        scale_.Update(1e-9 * static_cast<double>(std::max(drawing_ns, frame->elsewhere_ns)));
      }
      if (signals_.is_screenshot_wanted != 0) {
        signals_.is_screenshot_wanted = 0;
        Take("", shown);
      }
      for (const std::string& name : receiver_.TakeScreenshotRequests()) Take(name, shown);
      if (walls_ && walls_->is_led()) continue;  // the first wall has the pace
      // A picture that is late does not delay those behind it, for the time that one that is kept takes.
      next_ns = std::max(next_ns + period_ns, core::MonotonicNow_ns() - kMostBehind_ns);
      const std::int64_t left_ns = next_ns - core::MonotonicNow_ns();
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
    const view::Viewing* viewing = nullptr;  // null: the newest
    Look look;
    std::int64_t start_ns = 0;
    std::int64_t elsewhere_ns = 0;  // that others took for it meanwhile
  };

  [[nodiscard]] Surfaces::View ViewOf(const Composer::Shown& shown, int width, int height, int samples = 1) const {
    return {shown.scene, renderer_->LightAround(shown.scene), view::PlaceCamera(shown.steered, shown.scene),
            shown.composition.viewing, Composer::Views(shown, width, height, samples)};
  }

  [[nodiscard]] bool IsTraced() const { return surfaces_ != nullptr && !surfaces_->is_alone(); }

  // A picture that is kept.
  core::Result<Image> Paint(const Composer::Shown& shown) {
    std::span<const Pasted> surfaces;
    if (IsTraced()) {
      const Surfaces::Picture* picture =
          surfaces_->Paint(ViewOf(shown, options_.width, options_.height, kSmoothSamples), 1.0, true);
      if (picture != nullptr) surfaces = picture->surfaces;
    }
    return RenderSmooth(*renderer_, *composer_, shown, options_.width, options_.height, {.surfaces = surfaces});
  }

  // None: whoever draws the surfaces is not done.
  std::optional<Frame> NextFrame(const scene::Camera& camera, const RenderTarget& target, std::int64_t start_ns) {
    Frame frame{.scene = &shown_, .camera = &camera, .look = Live(), .start_ns = start_ns};
    if (!IsTraced()) return frame;
    const Surfaces::View view = ViewOf({shown_, camera, composition_}, target.width(), target.height());
    const Surfaces::Picture* picture = nullptr;
    if (walls_) {  // they all show the same state, and wait for it
      picture = surfaces_->Paint(view, scale_.value(), false);
      if (picture == nullptr) return frame;
    } else {
      surfaces_->Offer(view, scale_.value());
      picture = surfaces_->Take();
      if (picture == nullptr) return std::nullopt;
    }
    frame.scene = picture->scene;
    frame.camera = picture->camera;
    frame.viewing = picture->viewing;
    frame.look.surfaces = picture->surfaces;
    frame.start_ns = picture->begin_ns;
    frame.elsewhere_ns = picture->work_ns;
    is_new_scene_ = true;
    return frame;
  }

  [[nodiscard]] bool SteersHand() const { return options_.steers_hand && !options_.is_headless; }

  void Steer(std::int64_t now_ns, CameraControl* control) {
    const double dt_s = steered_ns_ != 0 ? 1e-9 * static_cast<double>(now_ns - steered_ns_) : 0.0;
    steered_ns_ = now_ns;
    if (!camera_) camera_ = control->ForStep(*shown_.assets, shown_.step);
    receiver_.SendHand(pointer_->Update(shown_, *camera_, dt_s, control));
  }
  void DescribeSteering() {
    if (!is_new_scene_) return;  // the scene has the lines already
    view::DescribeSteering(receiver_.scenario(), pointer_->state(), view::PlaceCamera(*camera_, shown_), &shown_);
  }

  // The newest scene, its camera, and for whom it is drawn, as late as possible before drawing. A wall takes these from
  // the first wall, and waits for it.
  core::Result<scene::Camera> BeginFrame(CameraControl& control, double dt_s, bool is_menu_open) {
    const bool is_first_wall = walls_ && options_.wall->is_first(), is_led = walls_ && !is_first_wall;
    const std::int64_t begin_ns = core::MonotonicNow_ns();
    Walls::Frame frame;
    if (is_led) frame = walls_->Begin({});
    if (is_led) AwaitState(frame.tick);
    waited_ns_ += core::MonotonicNow_ns() - begin_ns;
    if (is_first_wall) frame.tick = walls_->NextTick(receiver_.kept().ticks());
    if (auto taken = TakeScene(control, frame.tick); !taken) {
      return tl::unexpected(taken.error());
    }
    scene::Camera camera = control.Update(*shown_.assets, shown_.step, dt_s);
    const view::Choices choices = receiver_.choices();
    const view::Head head = receiver_.head();
    view::Viewing& viewing = composition_.viewing;
    viewing.stereo = is_menu_open ? view::Stereo::kNone : choices.stereo;  // a menu is for both eyes, and for a mouse
    viewing.eye_distance_m = choices.eye_distance_m;
    viewing.X_RH = head.X_RH;
    if (is_first_wall) {
      walls_->Begin({.tick = shown_tick_,
                     .X_WR = view::RoomOf(view::PlaceCamera(camera, shown_)),
                     .X_RH = head.X_RH,
                     .eye_distance_m = viewing.eye_distance_m});
    } else if (is_led) {
      camera = view::CameraOf(frame.X_WR);
      viewing.X_RH = frame.X_RH;
      viewing.eye_distance_m = frame.eye_distance_m;
    }
    WriteViewing(head);
    return camera;
  }

  // The state that the first wall has named may arrive here a moment later; or it was lost on the way.
  void AwaitState(std::uint64_t tick) {
    constexpr std::int64_t kPatience_ns = 30'000'000, kLook_ns = 1'000'000;  // a picture's time at 30 per second
    const std::int64_t end_ns = core::MonotonicNow_ns() + kPatience_ns;
    for (std::int64_t now_ns = 0; receiver_.kept().newest_tick() < tick && now_ns < end_ns;) {
      now_ns = core::MonotonicNow_ns();
      link_->Wait(now_ns + kLook_ns);
    }
  }

  // Lines about how the picture is drawn.
  void WriteViewing(const view::Head& head) {
    const auto write = [this](const std::string& line, bool is_warning) {
      if (line.empty()) return;
      const glm::vec3 color = is_warning ? glm::vec3(1.0f, 0.62f, 0.10f) : glm::vec3(0.62f, 0.80f, 0.90f);
      shown_.texts.push_back({view::Anchor::kTopLeft, view::TextStyle::kSmall, color, line});
    };
    write(view::Describe(head, options_.head), head.source == view::HeadSource::kMissing);
    if (!walls_) return;
    write(walls_->Describe(), !walls_->is_in_step());
    receiver_.SetWalls(static_cast<double>(walls_->num_in_step()), walls_->apart_ms());
  }

  // The inset is part of both eyes' pictures; of a single picture it is drawn after its time was taken.
  core::Result<void> DrawPicture(const Composer::Shown& shown, const Frame& frame, CameraFeed& feed,
                                 const RenderTarget& target) {
    if (auto drawn = composer_->DrawEyes(*renderer_, shown, frame.look, target); !drawn) return drawn;
    const view::Stereo stereo = shown.composition.viewing.stereo;
    const bool is_joined = stereo != view::Stereo::kNone;
    if (is_joined) {
      if (auto drawn = DrawInset(stereo, feed); !drawn) return drawn;
    }
    composer_->Join(stereo, target);
    glFinish();
    if (!std::exchange(has_drawn_, true)) {
      std::printf("first picture %.3f s after the machine's start\n",
                  1e-9 * static_cast<double>(core::MonotonicNow_ns()));
      std::fflush(stdout);
      // Not before: on a busy machine the start would take many times as long, and a session waits for it.
      LowerPriority(other_threads_);
      detail_in_work_ = std::make_unique<DetailInWork>(std::exchange(meshes_, {}));
    }
    CountFrame(frame, core::MonotonicNow_ns());
    // A picture that is kept is drawn at twice its width and height. What that took is free once the film has the size
    // of live pictures again; malloc would keep it, in pieces that the next one does not fit into.
    if (std::exchange(has_kept_, false)) malloc_trim(0);
    return is_joined ? core::Result<void>{} : DrawInset(stereo, feed);
  }

  core::Result<void> DrawInset(view::Stereo stereo, CameraFeed& feed) {
    mean_luminance_ = renderer_->film().MeanLuminance();  // before the film has another picture
    if (!receiver_.choices().has(view::Overlay::kCamera)) return {};
    const std::int64_t now_ns = core::MonotonicNow_ns();
    const RenderTarget& first = *composer_->eyes().front();
    const glm::ivec2 half = view::EyeSize(stereo, 2, 2);
    const double aspect = static_cast<double>(first.width() * half.y) / (first.height() * half.x);
    for (const RenderTarget* eye : composer_->eyes()) {
      if (auto drawn = feed.DrawInset(shown_, Live(), now_ns, aspect, *eye); !drawn) return drawn;
    }
    return {};
  }

  void AwaitShow() {
    if (!walls_) return;
    glFinish();
    const std::int64_t begin_ns = core::MonotonicNow_ns();
    walls_->AwaitShow(shown_tick_);
    waited_to_show_ns_ = core::MonotonicNow_ns() - begin_ns;
  }

  // Topics of cameras, beside the picture.
  core::Result<void> SendCameras(CameraFeed& feed) {
    auto seen = feed.Take(shown_, receiver_.image_rates_hz(), Live(), core::MonotonicNow_ns());
    if (!seen) return tl::unexpected(seen.error());
    for (CameraFeed::Seen& one : *seen) receiver_.SendImage(std::move(one));
    return {};
  }

  // Lines for a scenario file.
  void KeepViews(const CameraControl& control) const {
    const std::filesystem::path file = ViewsFile(receiver_.scenario().name);
    const auto written = WriteViews(file, control.saved_views(), *shown_.assets);
    std::fprintf(stderr, "views %s: %s\n", file.c_str(), written ? "done" : written.error().detail.c_str());
  }

  // Those of an earlier window. Without them it goes on.
  void TakeViews(CameraControl* control) const {
    auto views = ReadViews(ViewsFile(receiver_.scenario().name), *shown_.assets);
    if (views) {
      control->SetSavedViews(std::move(*views));
    } else {
      std::fprintf(stderr, "no saved views: %s\n", views.error().detail.c_str());
    }
  }

  [[nodiscard]] Look Live() const {
    return {.exposure = exposure_.value(),
            .scale = scale_.value(),
            .with_penumbra = !context_->is_software(),
            .detail_px = kLiveDetail_px};
  }

  // Takes the newest scene, as late as possible before drawing. When the step has changed, this scene is the result of
  // the previous step and is added to the contact sheet with that step's caption.
  core::Result<void> TakeScene(const CameraControl& control, std::uint64_t tick = 0) {
    is_new_scene_ = receiver_.Update();
    shown_.texts.resize(std::min(num_texts_, shown_.texts.size()));  // without those of WriteViewing
    if (!is_new_scene_ && !walls_) return {};
    if (walls_) shown_tick_ = receiver_.kept().Take(tick, &kept_);
    const view::Scene& next = walls_ && shown_tick_ != 0 ? kept_ : receiver_.scene();
    if (!shown_.step.empty() && next.step != shown_.step) {
      view::Scene end = next;
      end.step = shown_.step;
      end.texts = shown_.texts;
      if (auto kept = Keep(end, control.ForStep(*end.assets, end.step)); !kept) return kept;
    }
    shown_ = next;
    structures_.AddTo(receiver_.choices(), &shown_);
    num_texts_ = shown_.texts.size();
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

  void TakeDetail() {
    if (detail_in_work_ == nullptr) return;
    const auto made = detail_in_work_->Take();
    if (!made) return;
    for (std::size_t i = 0; i < made->size(); ++i) renderer_->SetDetail(i, (*made)[i].mesh, (*made)[i].pieces);
    detail_in_work_.reset();
  }

  core::Result<void> Keep(const view::Scene& scene, const scene::Camera& camera) {
    const Composition plain;
    const auto image = IsTraced() ? Paint({scene, camera, plain})
                                  : RenderSmooth(*renderer_, scene, camera, options_.width, options_.height);
    if (!image) return tl::unexpected(image.error());
    const std::string name = SafeName(scene.step, 0);
    sheet_.Add(name, *image);
    has_kept_ = true;
    return WritePng(*image, options_.out / "frames" / (name + ".png"));
  }

  void Take(const std::string& name, const Composer::Shown& shown) {
    const std::filesystem::path file = options_.out / (SafeName(name, ++num_screenshots_) + ".png");
    const auto image = Paint(shown);
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

  // A film has one size.
  void TakeForFilm(const RenderTarget& target) {
    if (film_target_ == nullptr) film_target_ = std::make_unique<RenderTarget>(target.width(), target.height());
    glBlitNamedFramebuffer(target.framebuffer(), film_target_->framebuffer(), 0, 0, target.width(), target.height(), 0,
                           0, film_target_->width(), film_target_->height(), GL_COLOR_BUFFER_BIT, GL_LINEAR);
    film_->Show(film_target_->Read(), core::MonotonicNow_ns());
  }

  void Show(const RenderTarget& target) const {
    glBlitNamedFramebuffer(target.framebuffer(), 0, 0, 0, target.width(), target.height(), 0, 0, target.width(),
                           target.height(), GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glfwSwapBuffers(context_->window());
  }

  // Pictures last: they take long on a busy machine, so that a node that is still on the bus would seem to be stalled,
  // or lost when whoever stops it does not wait.
  core::Result<void> Finish() {
    film_.reset();
    core::Result<void> result = FinishFigures();
    receiver_.Leave();
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
    if (walls_ && result) result = walls_->Write(options_.out / "walls.csv");
    if (auto stopped = bus::log::StopRecording(recording_.get()); !stopped && result) result = stopped;
    return result;
  }

  core::Result<void> FinishPictures() {
    // The procedure's last status may have arrived after the last frame.
    const CameraControl control(*shown_.assets, composition_.layout.steered());
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
  std::optional<Composer> composer_;
  Composition composition_;
  std::optional<WallLink> link_;
  std::optional<Walls> walls_;
  std::uint64_t shown_tick_ = 0;  // of a wall
  view::Scene kept_;              // likewise
  std::size_t num_texts_ = 0;     // of the scene itself
  std::optional<float> mean_luminance_;
  std::int64_t waited_ns_ = 0, waited_to_show_ns_ = 0;  // for other walls, before drawing this frame and after it
  std::unique_ptr<AirInWork> air_in_work_;
  std::vector<vps::VisualMesh> meshes_;  // until their levels of detail are in work
  std::unique_ptr<DetailInWork> detail_in_work_;
  std::set<pid_t> other_threads_;  // those that do not draw
  bool has_drawn_ = false;
  bool has_kept_ = false;  // since the last live picture
  RenderScale scale_;
  Exposure exposure_;  // of the window; pictures that are kept have the same exposure in every run
  view::Scene shown_;
  std::optional<Pointer> pointer_;       // of a person who steers a hand
  std::optional<scene::Camera> camera_;  // of the last picture
  std::int64_t steered_ns_ = 0;
  std::unique_ptr<RenderTarget> film_target_;
  std::optional<LiveFilm> film_;
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
