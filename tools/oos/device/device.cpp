#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <memory>
#include <sstream>

#include "core/clock.hpp"
#include "device/calibration.hpp"
#include "nodes/device_bridge/devices/conformance.hpp"
#include "nodes/device_bridge/devices/make_device.hpp"
#include "tools/oos/attach/attach.hpp"
#include "tools/oos/device/candidates.hpp"
#include "tools/oos/device/verbs.hpp"
#include "tools/oos/device/wiggle.hpp"

namespace oos {
namespace {

using device_bridge::Device;
using device_bridge::DeviceHealth;
using device_bridge::DeviceStatus;

constexpr std::int64_t kListen_ns = 1'500'000'000;  // two windows of a link's figures, and a device's start
constexpr std::int64_t kWigglePatience_ns = 60'000'000'000;
constexpr std::int64_t kPointPatience_ns = 300'000'000'000;  // for a person to find a point
constexpr std::int64_t kHold_ns = 300'000'000;               // over which a touched point is averaged

void WaitUntil(std::int64_t time_ns) {
  const timespec until{static_cast<time_t>(time_ns / core::kNanosecondsPerSecond),
                       static_cast<long>(time_ns % core::kNanosecondsPerSecond)};
  while (core::MonotonicNow_ns() < time_ns && CatchInterrupt().load() == 0) {
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
  }
}

// `calibrated`: with the calibrations that are kept; otherwise poses are in the device's own base.
core::Result<std::unique_ptr<Device>> Open(const std::string& text, bool calibrated) {
  auto named = device_bridge::DeviceNamed(text);
  if (!named) return tl::unexpected(named.error());
  named->role = text;
  device_bridge::ThreadedOptions threads;
  threads.rt = bus::RealTimeMode::kTry;
  if (calibrated) threads.find_calibration = device_bridge::KeptCalibration;
  return device_bridge::MakeDevice(*named, threads);
}

struct Opened {
  std::string text;
  std::unique_ptr<Device> device;
  std::string why;  // it could not be opened
};

std::vector<Opened> OpenAll(const std::vector<std::string>& texts) {
  std::vector<Opened> all;
  for (const std::string& text : texts) {
    auto device = Open(text, true);
    if (device) {
      all.push_back({text, std::move(*device), ""});
    } else {
      all.push_back({text, nullptr, device.error().detail});
    }
  }
  return all;
}

void Print(const Opened& opened, std::int64_t now_ns) {
  if (opened.device == nullptr) {
    std::printf("%-32s  %s\n", opened.text.c_str(), opened.why.c_str());
    return;
  }
  const DeviceHealth& health = opened.device->Health(now_ns);
  const oos_device_description& d = opened.device->description();
  if (opened.device->num_found() == 0) {
    std::printf("%-32s  %s%s%s\n", opened.text.c_str(), health.why[0] != 0 ? "" : "nothing has answered",
                health.why.data(), "");
    return;
  }
  std::printf("%-32s  %s %s: %s, link %s, %.0f Hz, lost %.1f %%, round trip %.2f ms, %s\n", opened.text.c_str(), d.name,
              d.serial, device_bridge::NameOf(health.status), device_bridge::NameOf(health.quality),
              health.link.rate_hz, 1e2 * health.link.loss, 1e3 * health.link.round_trip_s,
              health.is_calibrated ? ("calibrated to " + std::to_string(1e3 * health.residual_m) + " mm").c_str()
                                   : "not calibrated");
}

// Says which device the person moves for each role.
int Identify(std::vector<Opened>* all, const std::vector<std::string>& roles) {
  std::vector<Device*> devices;
  for (const Opened& opened : *all) devices.push_back(opened.device.get());
  std::string options;
  for (const std::string& role : roles) {
    std::printf("move the device for role %s to and fro\n", role.c_str());
    std::fflush(stdout);
    Wiggle wiggle(devices.size());
    const std::int64_t begin_ns = core::MonotonicNow_ns();
    while (!wiggle.winner() && CatchInterrupt().load() == 0) {
      const std::int64_t now_ns = core::MonotonicNow_ns();
      if (now_ns - begin_ns > kWigglePatience_ns) {
        return Complain("device", "no device was moved for role " + role + " in a minute", kDoesNotHold);
      }
      for (std::size_t i = 0; i < devices.size(); ++i) {
        if (devices[i] == nullptr) continue;
        devices[i]->Read(now_ns);
        const auto& X = devices[i]->state().X_BD;
        if (devices[i]->state().sequence != 0) wiggle.Add(i, {X[4], X[5], X[6]});
      }
      WaitUntil(now_ns + core::kTick_ns);
    }
    if (!wiggle.winner()) return kDoesNotHold;
    const std::string text = (*all)[*wiggle.winner()].text;
    std::printf("  role %s is %s, %s %s\n", role.c_str(), text.c_str(), devices[*wiggle.winner()]->description().name,
                devices[*wiggle.winner()]->description().serial);
    options += " --device " + role + "=" + text;
    devices[*wiggle.winner()] = nullptr;  // a device has one role
  }
  std::printf("oos run SCENARIO%s\n", options.c_str());
  return kHolds;
}

int List(const Arguments& arguments) {
  std::vector<std::string> texts(arguments.positional().begin() + 1, arguments.positional().end());
  if (texts.empty()) texts = FindCandidates("/dev/serial/by-id", device::CalibrationFolder().string());
  std::vector<Opened> all = OpenAll(texts);
  WaitUntil(core::MonotonicNow_ns() + kListen_ns);
  bool is_any_there = false;
  for (const Opened& opened : all) {
    Print(opened, core::MonotonicNow_ns());
    is_any_there = is_any_there || (opened.device != nullptr && opened.device->num_found() > 0);
  }
  if (!arguments.has("--wiggle")) return is_any_there ? kHolds : kDoesNotHold;
  std::vector<std::string> roles;
  std::stringstream words(arguments.text("--wiggle"));
  for (std::string role; std::getline(words, role, ',');) roles.push_back(role);
  return Identify(&all, roles);
}

int Check(const Arguments& arguments) {
  const auto force = arguments.positive("--force_N");
  if (!force) return Complain("device", force.error().detail, kBadUsage);
  auto device = Open(arguments.positional()[1], false);
  if (!device) return Complain("device", device.error().detail, kBadUsage);
  device_bridge::ConformanceOptions options;
  options.force_N = std::min(force->value_or(options.force_N), 20.0);
  options.clock = core::MonotonicNow_ns;
  options.wait_until = WaitUntil;
  options.is_interrupted = [] { return CatchInterrupt().load() != 0; };
  std::printf("hold the dead-man; it will push with up to %.1f N\n", options.force_N);
  std::fflush(stdout);
  bool holds = true;
  for (const auto& finding : device_bridge::CheckConformance(device->get(), options)) {
    const char* word = finding.verdict == device_bridge::Verdict::kHolds   ? "OK"
                       : finding.verdict == device_bridge::Verdict::kFails ? "FAIL"
                                                                           : "skip";
    holds = holds && finding.verdict != device_bridge::Verdict::kFails;
    std::printf("%-4s  %-12s  %s\n", word, finding.subject.c_str(), finding.what.c_str());
  }
  return holds ? kHolds : kDoesNotHold;
}

// "x y z; x y z; ..."
core::Result<std::vector<glm::dvec3>> ReadPoints(const std::string& text) {
  std::vector<glm::dvec3> points;
  std::stringstream pieces(text);
  for (std::string piece; std::getline(pieces, piece, ';');) {
    std::stringstream numbers(piece);
    glm::dvec3 point;
    std::string rest;
    if (!(numbers >> point.x >> point.y >> point.z) || (numbers >> rest)) {
      return core::Fail(core::ErrorCode::kInvalidInput, "--points: '" + piece + "' is not three numbers [m]");
    }
    points.push_back(point);
  }
  if (points.size() < 3) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "--points \"x y z; x y z; x y z\": give three points in W or more, in metres");
  }
  return points;
}

// Waits until button 0 is pressed, and gives the mean place of the hand while it is held there.
std::optional<glm::dvec3> TouchPoint(Device* device) {
  const std::int64_t begin_ns = core::MonotonicNow_ns();
  std::int64_t pressed_ns = 0;
  bool was_pressed = true;  // a button that is held from the point before does not count
  glm::dvec3 sum(0.0);
  int num = 0;
  while (CatchInterrupt().load() == 0) {
    const std::int64_t now_ns = core::MonotonicNow_ns();
    if (now_ns - begin_ns > kPointPatience_ns) return std::nullopt;
    device->Read(now_ns);
    const bool is_pressed =
        (device->state().buttons & 1U) != 0 && device->Health(now_ns).status == DeviceStatus::kAlive;
    if (is_pressed && !was_pressed) pressed_ns = now_ns;
    was_pressed = is_pressed;
    if (pressed_ns != 0) {
      const auto& X = device->state().X_BD;
      sum += glm::dvec3(X[4], X[5], X[6]);
      ++num;
      if (now_ns - pressed_ns > kHold_ns) return sum / static_cast<double>(num);
    }
    WaitUntil(now_ns + core::kTick_ns);
  }
  return std::nullopt;
}

int Calibrate(const Arguments& arguments) {
  const auto p_Ws = ReadPoints(arguments.text("--points"));
  if (!p_Ws) return Complain("device", p_Ws.error().detail, kBadUsage);
  auto device = Open(arguments.positional()[1], false);
  if (!device) return Complain("device", device.error().detail, kBadUsage);
  std::vector<glm::dvec3> p_Bs;
  for (const glm::dvec3& p_W : *p_Ws) {
    std::printf("put the hand at %g %g %g, press the first button and keep still\n", p_W.x, p_W.y, p_W.z);
    std::fflush(stdout);
    const auto p_B = TouchPoint(device->get());
    if (!p_B) return Complain("device", "the button was not pressed in five minutes", kDoesNotHold);
    std::printf("  there the device says %.4f %.4f %.4f\n", p_B->x, p_B->y, p_B->z);
    p_Bs.push_back(*p_B);
  }
  auto fit = device::FitRigid(p_Bs, *p_Ws);
  if (!fit) return Complain("device", fit.error().detail, kDoesNotHold);
  fit->name = (*device)->description().name;
  fit->serial = (*device)->description().serial;
  const std::filesystem::path folder = device::CalibrationFolder();
  if (const auto kept = device::Keep(*fit, folder); !kept) {
    return Complain("device", kept.error().detail, kDoesNotHold);
  }
  std::printf("residual %.2f mm (root mean square), %.2f mm at the worst of %d points\nkept in %s\n",
              1e3 * fit->residual_m, 1e3 * fit->largest_residual_m, fit->num_points,
              device::CalibrationFile(folder, fit->name, fit->serial).c_str());
  return kHolds;
}

// A session of the scenario device_view, with that device in its hand and the overlay `robot`: a viewer, and what
// gives the device its commands. Becomes `oos run`, and returns only if it cannot.
int View(const Arguments& arguments) {
  const std::string text = arguments.positional()[1];
  const auto named = device_bridge::DeviceNamed(text);
  if (!named) return Complain("device", named.error().detail, kBadUsage);
  std::vector<std::string> words = {"oos",           "run",    "device_view", "--device",
                                    "right=" + text, "--show", "robot",       "--no_film"};
  for (const char* option : {"--hand", "--duration", "--out"}) {
    if (arguments.has(option)) words.insert(words.end(), {option, arguments.text(option)});
  }
  if (arguments.has("--headless")) words.push_back("--headless");
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  execv("/proc/self/exe", argv.data());
  return Complain("device", std::string("cannot start oos run: ") + std::strerror(errno), kDoesNotHold);
}

int RunDevice(const Arguments& arguments) {
  const std::string what = arguments.positional()[0];
  if (what == "list") return List(arguments);
  if (what != "check" && what != "calibrate" && what != "view") {
    return Complain("device", "it is list, check, calibrate or view, not '" + what + "'", kBadUsage);
  }
  if (arguments.positional().size() != 2) {
    return Complain("device", what + " needs one TYPE:ADDRESS, as udp:7460", kBadUsage);
  }
  if (what == "view") return View(arguments);
  return what == "check" ? Check(arguments) : Calibrate(arguments);
}

}  // namespace

Verb DeviceVerb() {
  return {
      "device",
      "hand devices: lists them, checks one for conformance, calibrates one, shows one without a scene",
      "list|check|calibrate|view [TYPE:ADDRESS...]",
      1,
      16,
      {{"--wiggle", "ROLE,ROLE", "with list: asks to move each role's device, and prints what 'oos run' needs"},
       {"--force_N", "N", "with check: the most that it may push; default 1"},
       {"--points", "\"X Y Z; ...\"", "with calibrate: places in W [m], to be touched one after another"},
       {"--hand", "script|pointer", "with view: who moves a simulated arm, as in 'oos run'"},
       {"--duration", "S", "with view: time limit; default: until Ctrl-C"},
       {"--out", "DIR", "with view: folder for the recording and the logs"},
       {"--headless", "", "with view: draw, but show no window"}},
      RunDevice,
      "TYPE:ADDRESS is udp:PORT, udp:ADDRESS:PORT, serial:/dev/...[:SPEED], plugin:/path/of/lib.so, haply:ADDRESS:PORT"
      ", dtrack:PORT or "
      "replay:FILE.mcap; for view also hug, simulated_arm, simulated_hug or simulated_hand.\nWithout any, list looks "
      "at the serial "
      "lines, the plug-ins beside the calibrations, and UDP "
      "port 7460."};
}

}  // namespace oos
