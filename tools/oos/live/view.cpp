// Another viewer of a running session: a second window, or lines of text. No node waits for it.

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>
#include <vector>

#include "collision/resolution/choose_resolutions.hpp"
#include "core/clock.hpp"
#include "core/names.hpp"
#include "lab/load_lab.hpp"
#include "lab/plan.hpp"
#include "tiles/seats.hpp"
#include "tools/oos/attach/attach.hpp"
#include "tools/oos/attach/places.hpp"
#include "tools/oos/attach/session_note.hpp"
#include "tools/oos/live/verbs.hpp"
#include "tools/oos/pictures/shot.hpp"
#include "tools/oos/pictures/video.hpp"
#include "tools/oos/verb/find_scenario.hpp"
#include "tools/process/group.hpp"
#include "tools/process/spawn.hpp"
#include "view/bus_feed.hpp"
#include "view/scene_digest.hpp"

namespace oos {
namespace {

constexpr std::int64_t kWait_ns = 10'000'000;
constexpr std::int64_t kFiguresPeriod_ns = 100'000'000;
constexpr std::int64_t kLinePeriod_ns = core::kNanosecondsPerSecond;
constexpr double kMoved_m = 1e-3;  // an object that moved so far since the last line is printed
constexpr std::int64_t kSilence_ns = 2 * core::kNanosecondsPerSecond;
constexpr double kStopPatience_s = 10.0;  // a viewer writes its last pictures
constexpr double kForever_s = 1e9;
constexpr double kFilmRate_Hz = 30.0;  // as visual_node's pictures
constexpr int kFilmNice = 10;          // as its drawing

// Prints the scene as text: all of it once, then its changes.
class TextViewer {
 public:
  TextViewer(const scene::Scenario& scenario, bus::Node* node)
      : scenario_(scenario),
        node_(node),
        mirror_(scenario),
        feed_(scenario, node),
        figures_(node->WriteState<bus::Figures>(bus::FiguresTopic(node->name()))) {}

  // Runs until interrupted, or until `seconds` of bus time have passed.
  void Run(const std::atomic<int>& interrupted, double seconds) {
    begin_ns_ = core::MonotonicNow_ns();
    const std::int64_t end_ns = begin_ns_ + static_cast<std::int64_t>(1e9 * std::min(seconds, 1e9));
    while (interrupted.load() == 0 && core::MonotonicNow_ns() < end_ns) {
      node_->Wait(core::MonotonicNow_ns() + kWait_ns);
      const std::int64_t now_ns = core::MonotonicNow_ns();
      if (feed_.Apply(now_ns, &mirror_)) last_state_ns_ = now_ns;
      mirror_.Refresh(now_ns);
      PrintProcedure();
      if (now_ns >= next_line_ns_) PrintMotion(now_ns);
      if (now_ns >= next_figures_ns_) PublishFigures(now_ns);
    }
  }

 private:
  void PrintProcedure() {
    const view::Scene& scene = mirror_.scene();
    if (scene.step != step_) {
      step_ = scene.step;
      const std::string& hint = feed_.logic().value().hint;
      std::printf("step %s%s%s%s\n", step_.c_str(), hint.empty() ? "" : ": ", hint.c_str(),
                  scene.is_failed  ? " (failed)"
                  : scene.is_final ? " (done)"
                                   : "");
    }
    for (const view::Lamp& lamp : scene.lamps) {
      glm::vec3& shown = lamps_.try_emplace(lamp.instance, glm::vec3(-1.0f)).first->second;
      if (shown == lamp.color) continue;
      shown = lamp.color;
      std::printf("lamp %s: red %.2f green %.2f blue %.2f\n", NameOf(lamp.instance), static_cast<double>(lamp.color.r),
                  static_cast<double>(lamp.color.g), static_cast<double>(lamp.color.b));
    }
    std::fflush(stdout);
  }

  void PrintMotion(std::int64_t now_ns) {
    // The first line comes with the first state.
    if (last_state_ns_ == 0 && now_ns - begin_ns_ < kSilence_ns) return;
    next_line_ns_ = now_ns + kLinePeriod_ns;
    const view::Scene& scene = mirror_.scene();
    if (last_state_ns_ == 0 || now_ns - last_state_ns_ > kSilence_ns) {
      std::printf("physics_node is silent\n");
    } else {
      std::printf("t %.1f s  %zu contact arrows\n", 1e-9 * static_cast<double>(scene.time_ns), scene.arrows.size());
      for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        if (scene.instances[i].is_scenery) continue;  // no object of the scenario
        const glm::dvec3& p_W = scene.instances[i].X_WM.translation;
        const auto [printed, is_first] = printed_.try_emplace(i, p_W);
        if (!is_first && glm::distance(printed->second, p_W) < kMoved_m) continue;
        printed->second = p_W;
        std::printf("  %-24s %8.3f %8.3f %8.3f m\n", NameOf(i), p_W.x, p_W.y, p_W.z);
      }
    }
    std::fflush(stdout);
  }

  void PublishFigures(std::int64_t now_ns) {
    next_figures_ns_ = now_ns + kFiguresPeriod_ns;
    bus::Figures figures;
    figures.items = {{view::kSceneDigestFigure, static_cast<double>(view::SceneDigest(mirror_.scene()))},
                     {"dropped", static_cast<double>(node_->counters().dropped)}};
    figures_.Set(figures);
  }

  [[nodiscard]] const char* NameOf(std::size_t object) const { return scenario_.objects[object].name.c_str(); }

  const scene::Scenario& scenario_;
  bus::Node* node_;
  view::SceneMirror mirror_;
  view::BusFeed feed_;
  bus::StateWriter<bus::Figures> figures_;
  std::string step_;
  std::map<std::uint32_t, glm::vec3> lamps_;
  std::map<std::size_t, glm::dvec3> printed_;
  std::int64_t begin_ns_ = 0;
  std::int64_t last_state_ns_ = 0;
  std::int64_t next_line_ns_ = 0;
  std::int64_t next_figures_ns_ = 0;
};

// Those that a window takes over as they are.
const std::vector<Option>& WindowOptions() {
  static const std::vector<Option> kOptions = {
      {"--view", "NAME", "the camera to stay with; default: that of the procedure's step"},
      {"--layout", "TEXT", "several views in the window, e.g. 'overview | gripper / *'; *: that of the step"},
      {"--stereo", "MODE", "side_by_side, top_bottom, anaglyph or interlaced"},
      {"--eye_distance_mm", "MM", "between the pupils; default: 63"},
      {"--head", "USER", "draw for where this user's head is"},
      {"--size", "WxH", "of the window, or of the picture, in pixels"},
      {"--show", "LIST", "what is shown over the scene, e.g. \"paths phantom no_contacts hide.cover\""},
      {"--headless", "", "draw, but show no window"},
      {"--full_size", "", "pictures as large as the window, also when that is too slow for 30 in a second"}};
  return kOptions;
}

bool IsSessionHere(const Arguments& arguments) {
  return !arguments.has("--registry") && !arguments.has("--lab");
}

// Until the child has ended, or Ctrl-C if that counts, or for so long.
void AwaitChild(const process::Command& child, double seconds, process::Group* group,
                const std::atomic<int>* interrupted = nullptr) {
  const timespec pause{0, kWait_ns};
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  const auto is_over = [&] {
    const bool is_interrupted = interrupted != nullptr && interrupted->load() != 0;
    return is_interrupted || 1e-9 * static_cast<double>(core::MonotonicNow_ns() - begin_ns) > seconds;
  };
  for (; group->IsRunning(child.name) && !is_over(); group->Reap()) nanosleep(&pause, nullptr);
}

// Ends the window if it has not been closed: at Ctrl-C, or after so long.
void AwaitWindow(const process::Command& window, double seconds, process::Group* group) {
  AwaitChild(window, seconds, group, &CatchInterrupt());
  group->StopAll(kStopPatience_s, {window.name});
}

core::Result<void> StartAll(const std::vector<process::Command>& commands, process::Group* group) {
  for (const process::Command& command : commands) {
    if (const auto started = group->Spawn(command); !started) return tl::unexpected(started.error());
  }
  std::printf("the window and what helps it write their logs to %s\n", commands.front().log.parent_path().c_str());
  std::fflush(stdout);
  return {};
}

// How the window, the first child, ended.
int ReportWindow(const process::Group& group, const process::Command& window) {
  const auto& exit = group.children().front().exit;
  if (exit && exit->is_clean()) return kHolds;
  return Complain("view", "the window ended: " + (exit ? exit->Describe() : "killed") + "; see " + window.log.string(),
                  kDoesNotHold);
}

// Workers draw the window's tiles until it ends.
int ShowWithWorkers(const process::Command& window, const std::vector<process::Command>& workers, double seconds) {
  process::Group group;
  std::vector<process::Command> all = {window};
  all.insert(all.end(), workers.begin(), workers.end());
  if (const auto started = StartAll(all, &group); !started) {
    return Complain("view", started.error().detail, kDoesNotHold);
  }
  AwaitWindow(window, seconds, &group);
  return ReportWindow(group, window);
}

// The same, and ffmpeg makes a film of what the window shows. The film's end is written after that of the window.
int ShowAndFilm(process::Command window, const std::vector<process::Command>& workers, double seconds,
                const std::filesystem::path& file) {
  if (!HasFfmpeg()) return Complain("view", "ffmpeg is missing: apt-get install ffmpeg", kDoesNotHold);
  std::error_code error;
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), error);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return Complain("view", "cannot open a pipe", kDoesNotHold);
  window.arguments.insert(window.arguments.end(), {"--film_fd", std::to_string(ends[1])});
  window.inherited_fd = ends[1];
  process::Command encoder = FilmEncoder("pipe:" + std::to_string(ends[0]), file, kFilmRate_Hz);
  encoder.inherited_fd = ends[0];
  encoder.nice = kFilmNice;
  encoder.log = window.log.parent_path() / "ffmpeg.log";
  std::vector<process::Command> all = {window, encoder};
  all.insert(all.end(), workers.begin(), workers.end());
  process::Group group;
  const auto started = StartAll(all, &group);
  for (const int end : ends) close(end);  // only the two processes have it now
  if (!started) return Complain("view", started.error().detail, kDoesNotHold);
  AwaitWindow(window, seconds, &group);
  AwaitChild(encoder, kStopPatience_s, &group);
  const auto& exit = group.children()[1].exit;
  if (!exit || !exit->is_clean()) {
    return Complain("view", "ffmpeg could not make " + file.string() + "; see " + encoder.log.string(), kDoesNotHold);
  }
  return ReportWindow(group, window);
}

// A worker on a seat of the viewer.
process::Command WorkerFor(const process::Command& window, const std::string& viewer, std::size_t seat) {
  process::Command worker = window;
  worker.name = tiles::WorkerName(viewer, seat);
  worker.program = ProgramFolder() / "rt_worker";
  const auto name = std::find(worker.arguments.begin(), worker.arguments.end(), "--name");
  if (name != worker.arguments.end()) *(name + 1) = worker.name;
  worker.log = window.log.parent_path() / (worker.name + ".log");
  return worker;
}

// How visual_node joins the session under that name, in a folder of its own.
process::Command ViewerNamed(const std::string& name, const bus::NodeOptions& session, const Arguments& arguments,
                             const std::string& scenario) {
  const auto note = FindSessionNote();
  const bool is_noted = note && !note->out.empty() && IsSessionHere(arguments);
  const std::filesystem::path out = std::filesystem::path(is_noted ? note->out : "out") / name;
  std::error_code error;
  std::filesystem::create_directories(out, error);
  process::Command window;
  window.name = "visual_node";
  window.program = ProgramFolder() / "visual_node";
  window.arguments = {"--name",     name,
                      "--scenario", scenario,
                      "--registry", session.registry,
                      "--session",  std::to_string(session.session),
                      "--bind",     session.bind_address,
                      "--out",      out.string()};
  if (session.keys.empty()) {
    window.arguments.emplace_back("--no_encryption");
  } else {
    window.arguments.insert(window.arguments.end(), {"--keys", session.keys});
  }
  window.log = out / "visual_node.log";
  return window;
}

// What the caller wants of a window, of those options.
void AddWishes(const Arguments& arguments, const std::vector<Option>& options, process::Command* window) {
  for (const Option& option : options) {
    const std::string name(option.name);
    if (!arguments.has(name)) continue;
    window->arguments.push_back(name);
    if (!option.value_name.empty()) window->arguments.push_back(arguments.text(name));
  }
}

// Replaces this process by a visual_node of its own name; one that traces rays runs beside it, with its workers.
int OpenWindow(const Arguments& arguments, const std::string& scenario, double seconds) {
  const auto rays = arguments.count("--rays", 1, tiles::kMostSeats);
  if (!rays) return Complain("view", rays.error().detail, kBadUsage);
  const auto session = FindSession(arguments);
  if (!session) return Complain("view", session.error().detail, kDoesNotHold);
  const std::string name = "visual_node-" + std::to_string(getpid());
  process::Command window = ViewerNamed(name, *session, arguments, scenario);
  std::vector<process::Command> workers;
  for (std::size_t seat = 1; seat <= rays->value_or(0); ++seat) workers.push_back(WorkerFor(window, name, seat));
  AddWishes(arguments, WindowOptions(), &window);
  if (rays->has_value()) {
    window.program = ProgramFolder() / "rt_visual_node";
    window.log = window.log.parent_path() / "rt_visual_node.log";
  }
  if (arguments.has("--video")) return ShowAndFilm(window, workers, seconds, arguments.text("--video"));
  if (rays->has_value()) return ShowWithWorkers(window, workers, seconds);
  return Complain("view", process::Replace(window).value().detail + ", or use --text", kDoesNotHold);
}

// The walls of a lab's first room, all on this machine, or one of them. Ends when they have ended.
int OpenWalls(const Arguments& arguments, const std::string& scenario) {
  const auto lab = lab::LoadLab(arguments.text("--walls"));
  if (!lab) return Complain("view", scene::Format(lab.error().front()), kBadUsage);
  if (lab->rooms.empty()) {
    return Complain("view", arguments.text("--walls") + " has no <room> with screens", kBadUsage);
  }
  const auto rays = arguments.count("--rays", 1, tiles::kMostSeats);
  if (!rays) return Complain("view", rays.error().detail, kBadUsage);
  const lab::Room& room = lab->rooms.front();
  const auto session = FindSession(arguments);
  if (!session) return Complain("view", session.error().detail, kDoesNotHold);
  process::Group group;
  std::vector<std::string> names;
  for (const lab::Wall& wall : room.walls) {
    names.push_back(wall.viewer.name);
    if (arguments.has("--wall") && arguments.text("--wall") != wall.viewer.name) continue;
    const std::string name = "visual_node-" + wall.viewer.name;
    process::Command window = ViewerNamed(name, *session, arguments, scenario);
    std::vector<process::Command> workers;
    const std::size_t num_workers = rays->value_or(wall.viewer.num_workers);
    for (std::size_t seat = 1; seat <= num_workers; ++seat) workers.push_back(WorkerFor(window, name, seat));
    if (num_workers > 0) window.program = ProgramFolder() / "rt_visual_node";
    AddWishes(arguments, {{"--show", "LIST"}, {"--headless"}}, &window);  // the lab file says the rest
    for (const std::string& argument : lab::ViewerArguments(wall.viewer)) window.arguments.push_back(argument);
    for (const std::string& argument : lab::WallArguments(room, wall)) window.arguments.push_back(argument);
    window.name = name;
    workers.insert(workers.begin(), window);
    for (const process::Command& command : workers) {
      if (const auto started = group.Spawn(command); !started) {
        return Complain("view", started.error().detail, kDoesNotHold);
      }
    }
    std::printf("wall %s: see %s\n", wall.viewer.name.c_str(), window.log.c_str());
  }
  std::fflush(stdout);
  if (group.children().empty()) {
    const std::string wanted = arguments.text("--wall");
    return Complain("view", "room " + room.name + " has no wall '" + wanted + "'; " + core::SuggestName(wanted, names),
                    kBadUsage);
  }
  const std::atomic<int>& interrupted = CatchInterrupt();
  const auto is_wall = [](const process::Group::Child& child) { return !tiles::ReadWorkerName(child.name); };
  auto num_running = std::count_if(group.children().begin(), group.children().end(), is_wall);
  bool are_clean = true;
  while (interrupted.load() == 0 && num_running > 0) {
    const timespec pause{0, 50'000'000};
    nanosleep(&pause, nullptr);
    for (const std::size_t ended : group.Reap()) {
      const process::Group::Child& child = group.children()[ended];
      if (!is_wall(child)) continue;
      if (!child.exit->is_clean()) std::fprintf(stderr, "%s: %s\n", child.name.c_str(), child.exit->Describe().c_str());
      are_clean = are_clean && child.exit->is_clean();
      --num_running;
    }
  }
  group.StopAll(kStopPatience_s);
  return are_clean ? kHolds : kDoesNotHold;
}

int RunView(const Arguments& arguments) {
  if (IsShotWanted(arguments)) return MakeShot(arguments);
  const auto seconds = arguments.number("--seconds");
  if (!seconds) return Complain("view", seconds.error().detail, kBadUsage);
  std::string file;
  if (!arguments.positional().empty()) {
    file = FindScenario(arguments.positional()[0]).string();
  } else if (const auto note = FindSessionNote(); note && IsSessionHere(arguments)) {
    file = note->scenario;
  } else {
    return Complain("view", "no session runs here, so name its scenario: oos view SCENARIO --lab LAB.xml", kBadUsage);
  }
  const auto scenario = collision::LoadResolvedScenario(file);
  if (!scenario) {
    for (const scene::Diagnostic& diagnostic : scenario.error()) {
      std::fprintf(stderr, "%s\n", scene::Format(diagnostic).c_str());
    }
    return kBadUsage;
  }
  if (arguments.has("--video") && (arguments.has("--walls") || arguments.has("--text"))) {
    return Complain("view", "--video films one window: not --walls, not --text", kBadUsage);
  }
  if (arguments.has("--walls")) return OpenWalls(arguments, scenario->file.string());
  if (!arguments.has("--text")) return OpenWindow(arguments, scenario->file.string(), seconds->value_or(kForever_s));
  auto node = Attach(arguments, "view");
  if (!node) return Complain("view", node.error().detail, kDoesNotHold);
  TextViewer viewer(*scenario, node->get());
  if (const auto started = (*node)->Start(5'000'000'000); !started) {
    return Complain("view", started.error().detail, kDoesNotHold);
  }
  viewer.Run(CatchInterrupt(), seconds->value_or(kForever_s));
  return kHolds;
}

}  // namespace

Verb ViewVerb() {
  std::vector<Option> options = {
      {"--text", "", "print text instead of opening a window"},
      {"--rays", "N", "a window, or each wall, whose pictures N workers on this machine trace"},
      {"--video", "FILE", "film what the window shows, by ffmpeg: .mp4, .mkv or .mov; with --headless no window"},
      {"--seconds", "S", "with --text, --video or --rays: stop after so long; default: until Ctrl-C"},
      {"--walls", "LAB.xml", "the walls of that lab's room, all on this machine"},
      {"--wall", "NAME", "with --walls: this one alone"}};
  for (const auto* more : {&WindowOptions(), &ShotOptions(), &AttachOptions()}) {
    options.insert(options.end(), more->begin(), more->end());
  }
  return {
      "view",
      "opens another viewer of the running session: a window, or text; or makes a picture without a session",
      "[SCENARIO|RECORDING]",
      0,
      1,
      options,
      RunView,
      "A viewer can join and leave at any time and shows the whole scene at once; a session can have several.\n"
      "SCENARIO: the session's scenario, needed when the session does not run on this machine.\n"
      "With --shot, --depth, --ids or --hdr no session is needed: a scenario is shown as it begins, a recording at "
      "--at.\n"
      "A layout has views side by side with |, in rows with /; keys and mouse steer the first. --stereo and --layout "
      "go with --shot, too.\n"
      "Depths are along the viewing direction. Without a screen: xvfb-run -a oos view ..."};
}

}  // namespace oos
