#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "lab/load_lab.hpp"
#include "picture/glyph_atlas.hpp"
#include "tools/oos/attach/attach.hpp"
#include "tools/oos/doctor/doctor_devices.hpp"
#include "tools/oos/doctor/doctor_limits.hpp"
#include "tools/oos/doctor/doctor_network.hpp"
#include "tools/oos/doctor/verbs.hpp"
#include "vps/asset/cooked_object.hpp"

namespace oos {
namespace {

Finding CheckCores() {
  const unsigned cores = std::thread::hardware_concurrency();
  if (cores >= 4) return {"cores", Grade::kOk, std::to_string(cores) + " cores", ""};
  if (cores >= 2) {
    return {"cores", Grade::kWarn,
            std::to_string(cores) + " cores: five processes share them, expect late cycles under load",
            "use 4 cores or more, or 'oos run --without visual_node' when measuring"};
  }
  return {"cores", Grade::kFail, "1 core: the haptic and the physics loop cannot run beside each other",
          "use 2 cores or more"};
}

Finding CheckClockSource() {
  std::ifstream file("/sys/devices/system/clocksource/clocksource0/current_clocksource");
  std::string source;
  if (!(file >> source)) return {"clock_source", Grade::kWarn, "clock source is unknown", "mount /sys"};
  if (source == "tsc" || source == "kvm-clock" || source == "arch_sys_counter" || source.rfind("hyperv", 0) == 0) {
    return {"clock_source", Grade::kOk, "clock source " + source, ""};
  }
  return {"clock_source", Grade::kWarn, "clock source " + source + " is slow to read",
          "boot with clocksource=tsc tsc=reliable"};
}

bool IsOnPath(const std::string& program) {
  const char* path = std::getenv("PATH");
  if (path == nullptr) return false;
  const std::string folders = path;
  std::size_t begin = 0;
  while (begin <= folders.size()) {
    const std::size_t end = std::min(folders.find(':', begin), folders.size());
    if (access((folders.substr(begin, end - begin) + "/" + program).c_str(), X_OK) == 0) return true;
    begin = end + 1;
  }
  return false;
}

Finding CheckDisplay() {
  const char* display = std::getenv("DISPLAY");
  if (display != nullptr && *display != '\0') return {"display", Grade::kOk, std::string("DISPLAY is ") + display, ""};
  if (IsOnPath("Xvfb"))
    return {"display", Grade::kOk, "no DISPLAY; Xvfb is here, pictures are rendered without a window", ""};
  return {"display", Grade::kFail, "neither DISPLAY nor Xvfb: visual_node cannot start",
          "apt-get install xvfb, or 'oos run --without visual_node'"};
}

Finding CheckDrawing() {
  for (const char* folder : {"/usr/lib/x86_64-linux-gnu/dri", "/usr/lib/aarch64-linux-gnu/dri", "/usr/lib/dri"}) {
    if (!std::filesystem::exists(std::string(folder) + "/swrast_dri.so")) continue;
    if (std::filesystem::exists("/dev/dri/renderD128"))
      return {"drawing", Grade::kOk, "OpenGL drivers and a GPU are here", ""};
    return {"drawing", Grade::kOk, "OpenGL by software (llvmpipe); no GPU", ""};
  }
  return {"drawing", Grade::kFail, "no OpenGL drivers", "apt-get install libgl1-mesa-dri"};
}

// Loads the font as visual_node does, which does not start without it.
Finding CheckFonts() {
  constexpr int kAnySize_px = 16;
  for (const bool is_bold : {false, true}) {
    const auto atlas = picture::GlyphAtlas::Create(kAnySize_px, is_bold);
    if (atlas) continue;
    const std::string& detail = atlas.error().detail;  // what is wrong; how to fix it
    return {"drawing", Grade::kFail, "no captions can be drawn: " + detail.substr(0, detail.find("; ")),
            "apt-get install fonts-dejavu-core"};
  }
  return {"drawing", Grade::kOk, "the font of the captions is here", ""};
}

Finding CheckCache() {
  const std::filesystem::path folder = vps::DefaultCacheFolder();
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error && access(folder.c_str(), W_OK) == 0) {
    const auto space = std::filesystem::space(folder, error);
    if (!error && space.available < (1ULL << 30)) {
      return {"cache", Grade::kWarn, "less than 1 GB left for cooked structures in " + folder.string(),
              "free some space"};
    }
    return {"cache", Grade::kOk, "cooked structures go to " + folder.string(), ""};
  }
  return {"cache", Grade::kFail, "cannot write " + folder.string(), "set VR_OOS_CACHE to a folder that you can write"};
}

const char* WordOf(Grade grade) {
  return grade == Grade::kOk ? "OK" : grade == Grade::kWarn ? "WARN" : "FAIL";
}

bool WriteJson(const std::vector<Finding>& findings, const std::string& file) {
  nlohmann::json json = nlohmann::json::array();
  for (const Finding& finding : findings) {
    json.push_back({{"subject", finding.subject},
                    {"grade", WordOf(finding.grade)},
                    {"what", finding.what},
                    {"remedy", finding.remedy}});
  }
  return static_cast<bool>(std::ofstream(file) << json.dump(2) << "\n" << std::flush);
}

int RunDoctor(const Arguments& arguments) {
  if (arguments.has("--lab")) {
    if (const auto lab = lab::LoadLab(arguments.text("--lab")); !lab) {
      return Complain("doctor", scene::Format(lab.error().front()), kBadUsage);
    }
  }
  std::vector<Finding> findings = {CheckCores(),   CheckClockSource(), CheckDisplay(),
                                   CheckDrawing(), CheckFonts(),       CheckCache()};
  findings.push_back(CheckDeviceFiles("/dev"));
  for (Finding& finding : CheckLimits()) findings.push_back(std::move(finding));
  for (Finding& finding : CheckNetwork(arguments)) findings.push_back(std::move(finding));
  bool any_fail = false;
  for (const Finding& finding : findings) {
    any_fail = any_fail || finding.grade == Grade::kFail;
    std::printf("%-4s  %s\n", WordOf(finding.grade), finding.what.c_str());
    if (!finding.remedy.empty()) std::printf("      remedy: %s\n", finding.remedy.c_str());
  }
  if (arguments.has("--json") && !WriteJson(findings, arguments.text("--json"))) {
    return Complain("doctor", "cannot write " + arguments.text("--json"), kBadUsage);
  }
  return any_fail ? kDoesNotHold : kHolds;
}

}  // namespace

Verb DoctorVerb() {
  std::vector<Option> options = AttachOptions();
  options.push_back({"--json", "FILE", "write the findings as JSON"});
  return {"doctor", "finds what on this machine, its network and the running session hinders a run, and the remedy",
          "",       0,
          0,        options,
          RunDoctor};
}

}  // namespace oos
