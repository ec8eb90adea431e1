#include "tools/oos/launch/preflight.hpp"

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <set>

#include "tools/oos/launch/clock_series.hpp"

namespace oos {
namespace {

constexpr int kNumClockReadings = 20;
constexpr int kClockPatience_ms = 3000;

// Collects what is wrong, one line each.
class Complaints {
 public:
  void Add(const std::string& host, const std::string& what) {
    text_ += (text_.empty() ? "" : "\n") + ("host " + host) + ": " + what;
  }
  [[nodiscard]] core::Result<void> result() const {
    if (text_.empty()) return {};
    return core::Fail(core::ErrorCode::kInvalidInput, text_);
  }

 private:
  std::string text_;
};

std::string ProbeScriptFor(const lab::Lab& lab, const lab::Host& host) {
  std::string script = "r='" + host.run_folder +
                       "'\nmkdir -p \"$r\" 2>&1 && cd \"$r\" && [ -w . ] || { echo unwritable=1; exit 0; }\n" +
                       "echo root=$(pwd -P)\necho home=$HOME\n"
                       "set -- $SSH_CONNECTION\necho connected=$3\n"
                       "df -Pk . | awk 'NR == 2 { print \"free_kB=\" $4 }'\n";
  // A free display number, in case a node needs an X server of its own.
  script +=
      "n=120; while [ -e /tmp/.X$n-lock ] || [ -e /tmp/.X11-unix/X$n ]; do n=$((n + 1)); done; echo display=:$n\n";
  std::string tools = "rsync sha256sum tail awk taskset ip ss";
  tools += host.supervisor == lab::SupervisorKind::kSystemd ? " systemctl" : " supervisord supervisorctl";
  if (lab.HasPageOn(host.name)) tools += " node";
  script += "for t in " + tools + "; do command -v $t >/dev/null || echo missing=$t; done\n";
  script += "ip -4 -o addr show | awk '{ split($4, a, \"/\"); print \"address=\" $2 \" \" a[1] }'\n";
  if (host.name == lab.registry_host) {
    const std::string port = std::to_string(lab.registry_port);
    script += "ss -Hltn 'sport = :" + port + "' | awk '{ print \"busy=\" $4 }'\n";
  }
  return script;
}

// The address to bind to, from the host's list of lines such as "eth1 10.0.0.1".
std::string BindAddress(const lab::Host& host, const Answer& answer) {
  const std::string wanted = host.bind.empty() ? answer.value("connected") : host.bind;
  for (const std::string& line : answer.values("address")) {
    const std::size_t blank = line.find(' ');
    const std::string name = line.substr(0, blank), address = line.substr(blank + 1);
    if (wanted == name || wanted == address) return address;
  }
  return {};
}

void Judge(const lab::Lab& lab, const lab::Host& host, const Answer& answer, lab::HostFacts* facts,
           Complaints* complaints) {
  if (!answer.is_good()) return complaints->Add(host.name, "the first check failed: " + answer.err + answer.out);
  if (!answer.value("unwritable").empty()) {
    return complaints->Add(host.name, "cannot write the run folder " + host.run_folder +
                                          "; choose another in run_folder, or give the user the right");
  }
  facts->root = answer.value("root");
  facts->home = answer.value("home");
  facts->display = answer.value("display");
  facts->bind = BindAddress(host, answer);
  const std::vector<std::string> missing = answer.values("missing");
  for (const std::string& tool : missing) {
    complaints->Add(host.name, tool + " is missing; apt-get install " +
                                   (tool == "node" ? "nodejs" : "supervisor rsync util-linux iproute2") + " there");
  }
  // Without `ip` its addresses are not known.
  if (facts->bind.empty() && std::find(missing.begin(), missing.end(), "ip") == missing.end()) {
    complaints->Add(host.name,
                    (host.bind.empty() ? "its address towards us is not IPv4" : "it has no '" + host.bind + "'") +
                        "; give one of its IPv4 addresses or interfaces in bind");
  }
  const double free_MB = std::strtod(answer.value("free_kB").c_str(), nullptr) / 1024.0;
  if (free_MB < lab.min_free_MB) {
    complaints->Add(host.name, "only " + std::to_string(static_cast<long>(free_MB)) + " MB are free in " + facts->root +
                                   ", min_free_MB requires " + std::to_string(static_cast<long>(lab.min_free_MB)) +
                                   "; free some, or choose another run_folder");
  }
  if (!answer.value("busy").empty()) {
    complaints->Add(host.name, "port " + std::to_string(lab.registry_port) + " is in use (" + answer.value("busy") +
                                   "); end what uses it, or choose another port in <registry>");
  }
}

// Files below `base` that the hosts need, with their hashes.
struct Load {
  std::filesystem::path base;
  std::vector<std::string> files;  // relative to base
  std::string manifest;            // lines of sha256sum
  std::string key;                 // of the manifest
};

core::Result<Load> HashFiles(const std::filesystem::path& base, std::vector<std::string> files) {
  Load load{base, std::move(files), "", ""};
  std::sort(load.files.begin(), load.files.end());
  load.files.erase(std::unique(load.files.begin(), load.files.end()), load.files.end());
  std::string names;
  for (const std::string& file : load.files) names += file + '\0';
  const auto sums = RunHere({"sh", "-c", "cd \"$1\" && xargs -0 sha256sum --", "sh", base.string()}, names);
  if (!sums) return tl::unexpected(sums.error());
  if (!sums->is_good()) return core::Fail(core::ErrorCode::kNotFound, "cannot read what is to be pushed: " + sums->err);
  load.manifest = sums->out;
  const auto key = RunHere({"sha256sum"}, load.manifest);
  if (!key) return tl::unexpected(key.error());
  load.key = key->out.substr(0, 16);
  return load;
}

bool IsBelow(const std::filesystem::path& file, const std::filesystem::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), file.begin(), file.end()).first == folder.end();
}

// Links to files count as files. A link to a folder is followed only if one of the `named` files is behind it, since it
// may lead anywhere.
void AddFilesBelow(const std::filesystem::path& folder, const std::vector<std::filesystem::path>& named,
                   std::vector<std::filesystem::path>* files) {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::filesystem::path& path = entry.path();
    if (entry.is_directory(error)) {
      const bool is_named =
          std::any_of(named.begin(), named.end(), [&path](const auto& file) { return IsBelow(file, path); });
      if (!entry.is_symlink(error) || is_named) AddFilesBelow(path, named, files);
    } else if (entry.is_regular_file(error) && path.filename().string().front() != '.') {
      files->push_back(path);
    }
  }
}

// Files keep the names that the scenario uses, also behind links: the nodes open them by these names.
core::Result<Load> LoadOfScenario(const scene::Scenario& scenario) {
  std::vector<std::filesystem::path> named = {scenario.file};
  for (const auto* file : {&scenario.procedure, &scenario.operator_script}) {
    if (!file->empty()) named.push_back(*file);
  }
  for (const scene::Object& object : scenario.objects) {
    for (const auto* file : {&object.visual_mesh, &object.collision_mesh}) {
      if (!file->empty()) named.push_back(*file);
    }
  }
  for (const scene::Scenery& scenery : scenario.scenery) named.push_back(scenery.mesh);
  for (const scene::ShownArm& arm : scenario.shown_arms) {
    for (const scene::ShownArm::Link& link : arm.links) {
      if (!link.visual_mesh.empty()) named.push_back(link.visual_mesh);
    }
  }
  named.insert(named.end(), scenario.hand_files.begin(), scenario.hand_files.end());
  std::vector<std::filesystem::path> files = named;
  AddFilesBelow(scenario.folder, named, &files);  // all of the folder, since the named files may name others
  std::filesystem::path base = scenario.folder;
  for (const std::filesystem::path& file : files) {
    while (!IsBelow(file, base)) base = base.parent_path();
  }
  std::vector<std::string> names;
  for (const std::filesystem::path& file : files) names.push_back(file.lexically_relative(base).string());
  return HashFiles(base, names);
}

core::Result<Load> LoadOfPrograms(const PreflightOptions& options) {
  std::set<std::string> names(std::begin(lab::kNodeNames), std::end(lab::kNodeNames));
  names.insert({"oos", lab::kColocatedProgram});
  names.insert(options.viewer_programs.begin(), options.viewer_programs.end());
  return HashFiles(options.programs, {names.begin(), names.end()});
}

// The page's bridge with npm's packages, from the project's folder: <source>/build/<preset>/bin has our programs.
core::Result<Load> LoadOfPage(const std::filesystem::path& programs) {
  const std::filesystem::path base = (programs / "../../..").lexically_normal();
  const std::filesystem::path stubs = (programs / "../clients/stubs").lexically_normal();
  std::vector<std::filesystem::path> files;
  for (const char* folder : {"tools/web_bridge", "clients/javascript"}) {
    std::error_code error;
    if (!std::filesystem::exists(base / folder / "node_modules", error)) {
      return core::Fail(core::ErrorCode::kNotFound,
                        "the lab file has a view of renderer=\"page\", and npm's packages "
                        "for it are missing here: (cd " +
                            (base / folder).string() + " && npm ci --ignore-scripts)");
    }
    AddFilesBelow(base / folder, {}, &files);
  }
  if (std::error_code error; !std::filesystem::exists(stubs, error)) {
    return core::Fail(core::ErrorCode::kNotFound, "the lab file has a view of renderer=\"page\", and " +
                                                      stubs.string() + " is missing here: ./dev build makes it");
  }
  AddFilesBelow(stubs, {}, &files);
  files.push_back(base / "clients/topics.json");
  std::vector<std::string> names;
  for (const std::filesystem::path& file : files) names.push_back(file.lexically_relative(base).string());
  return HashFiles(base, names);
}

// Lists the files of `load` that differ in a folder of the host.
std::string Compare(const Load& load, const std::string& folder) {
  return "mkdir -p " + folder + " 2>/dev/null; cd " + folder + " || { echo differs=" + folder +
         "; exit 0; }\nsha256sum -c - 2>/dev/null <<'END_OF_LIST' | sed -n 's/: FAILED.*//p' | sed 's/^/differs=/'\n" +
         load.manifest + "END_OF_LIST\n";
}

core::Result<void> PushOne(const Load& load, const std::string& title, std::size_t host, const std::string& folder,
                           const PreflightOptions& options, Remotes* remotes) {
  const std::string& name = remotes->hosts()[host].name;
  const std::size_t num_missing = remotes->Run(host, Compare(load, folder)).values("differs").size();
  if (num_missing == 0) return {};
  options.say(name + ": bringing " + std::to_string(num_missing) + " of " + std::to_string(load.files.size()) +
              " files (" + title + ")");
  auto words = remotes->Rsync(host);
  // Links are copied as the files they lead to. Names begin with "./", because rsync takes lines with '#' or ';' for
  // comments, and end with zero bytes, because they may contain any other character.
  words.insert(words.end(), {"--checksum", "--copy-links", "--from0", "--files-from=-", load.base.string() + "/",
                             remotes->Target(host, folder + "/")});
  std::string names;
  for (const std::string& file : load.files) names += "./" + file + '\0';
  const auto sent = RunHere(words, names, 600.0);
  if (!sent) return tl::unexpected(sent.error());
  if (!sent->is_good()) return core::Fail(core::ErrorCode::kIo, "host " + name + ": rsync failed: " + sent->err);
  if (const Answer after = remotes->Run(host, Compare(load, folder));
      !after.is_good() || !after.values("differs").empty()) {
    return core::Fail(core::ErrorCode::kDamaged, "host " + name + ": " + after.value("differs") + " in " + folder +
                                                     " differs from ours even after a copy; is the disk full?");
  }
  return {};
}

core::Result<void> PushPage(const lab::Lab& lab, const PreflightOptions& options, Remotes* remotes, AllFacts* facts) {
  if (!lab.HasPageOn("")) return {};
  const auto page = LoadOfPage(options.programs);
  if (!page) return tl::unexpected(page.error());
  for (std::size_t i = 0; i < remotes->hosts().size(); ++i) {
    const std::string& name = remotes->hosts()[i].name;
    if (!lab.HasPageOn(name)) continue;
    lab::HostFacts& its = facts->at(name);
    its.page = its.root + "/page/" + page->key;
    const auto stubs = (options.programs / "../clients/stubs").lexically_normal().lexically_relative(page->base);
    its.stubs = its.page + "/" + stubs.string();
    if (const auto done = PushOne(*page, "page", i, its.page, options, remotes); !done) return done;
  }
  return {};
}

std::string InspectionFor(const lab::Lab& lab, const lab::Host& host, const lab::HostFacts& facts,
                          const std::vector<std::string>& without) {
  std::string script = "cd " + facts.programs + "\n";
  std::string programs = "oos";
  for (const lab::Placement& placement : lab.placements) {
    const bool is_out = std::find(without.begin(), without.end(), placement.node) != without.end();
    if (placement.host != host.name || is_out) continue;
    const bool is_traced = lab.traces_rays() && placement.node == "visual_node";
    programs += " " + (is_traced ? std::string(lab::kRayViewerProgram) : placement.node);
    if (lab.is_colocated && placement.node == "haptic_node") programs += std::string(" ") + lab::kColocatedProgram;
    for (const lab::DeviceAccess& device : placement.devices) {
      if (device.path.empty()) continue;
      script += "[ -r '" + device.path + "' ] && [ -w '" + device.path + "' ] || echo 'device=" + device.path + "'\n";
    }
    if (!placement.cores.empty()) {
      script += "taskset -c " + placement.cores + " true 2>/dev/null || echo 'cores=" + placement.cores + "'\n";
    }
  }
  for (const lab::RayWorkers& workers : lab.ray_workers) {
    if (workers.host == host.name) programs += std::string(" ") + lab::kRayWorkerProgram;
  }
  for (const std::string& program : lab.ProgramsOfViewersOn(host.name)) programs += " " + program;
  script += "for p in " + programs +
            "; do ldd ./$p | awk -v p=$p '/not found/ { print \"library=\" p \" lacks \" $1 }'; done\n";
  if (!host.cache.empty()) script += "export VR_OOS_CACHE=" + host.cache + "\n";
  script +=
      "f=$(mktemp) && ./oos doctor --json $f >/dev/null 2>&1; printf 'doctor='; tr '\\n' ' ' <$f; echo; rm -f $f\n";
  return script;
}

bool RunsThere(const lab::Lab& lab, const std::string& host, const std::string& node,
               const std::vector<std::string>& without) {
  const lab::Placement* placement = lab.FindPlacement(node);
  return placement != nullptr && placement->host == host &&
         std::find(without.begin(), without.end(), node) == without.end();
}

void JudgeDoctor(const lab::Lab& lab, const lab::Host& host, const std::string& text, const PreflightOptions& options,
                 Complaints* complaints) {
  const nlohmann::json findings = nlohmann::json::parse(text, nullptr, false);
  if (!findings.is_array()) return complaints->Add(host.name, "'oos doctor' does not run there: " + text);
  const bool enforces = std::any_of(lab.placements.begin(), lab.placements.end(), [&](const lab::Placement& placement) {
    return placement.host == host.name && placement.rt == "enforce";
  });
  const bool draws = RunsThere(lab, host.name, "visual_node", options.without) || !lab.ViewersOn(host.name).empty();
  for (const nlohmann::json& finding : findings) {
    const std::string subject = finding.value("subject", ""), grade = finding.value("grade", "");
    const bool is_picture = subject == "display" || subject == "drawing";
    const bool is_of_session = subject == "session" || subject == "node";  // of an earlier session
    if (grade == "OK" || is_of_session || (is_picture && !draws)) continue;
    const std::string line = finding.value("what", "") + "; " + finding.value("remedy", "");
    if (grade == "FAIL" || (subject == "realtime" && enforces)) {
      complaints->Add(host.name, line);
    } else {
      options.say("host " + host.name + ": WARN " + line);
    }
  }
}

void JudgeClock(const lab::Lab& lab, std::size_t host, const AllFacts& facts, const PreflightOptions& options,
                Remotes* remotes, Complaints* complaints) {
  const std::string& name = remotes->hosts()[host].name;
  auto series = ClockSeries::Open(remotes, host, facts.at(name).programs + "/oos");
  const auto reading = series ? series->Read(kNumClockReadings, kClockPatience_ms) : std::nullopt;
  if (!reading) return complaints->Add(name, "its clock cannot be read");
  const double bound_ms = static_cast<double>(reading->bound_ns) * 1e-6;
  char text[160];
  std::snprintf(text, sizeof text, "its clock is %.6f s ahead of ours, known within %.3f ms",
                static_cast<double>(reading->offset_ns) * 1e-9, bound_ms);
  options.say("host " + name + ": " + text);
  if (bound_ms > lab.max_clock_bound_ms) {
    complaints->Add(name, std::string(text) + ", max_clock_bound_ms requires less; is the network or the host busy?");
  }
}

}  // namespace

core::Result<AllFacts> AskHosts(const lab::Lab& lab, Remotes* remotes) {
  std::vector<std::string> scripts;
  for (const lab::Host& host : remotes->hosts()) scripts.push_back(ProbeScriptFor(lab, host));
  const std::vector<Answer> answers = remotes->RunAll(scripts);
  AllFacts facts;
  Complaints complaints;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const lab::Host& host = remotes->hosts()[i];
    Judge(lab, host, answers[i], &facts[host.name], &complaints);
  }
  if (const auto good = complaints.result(); !good) return tl::unexpected(good.error());
  return facts;
}

core::Result<void> Push(const lab::Lab& lab, const scene::Scenario& scenario, const PreflightOptions& options,
                        Remotes* remotes, AllFacts* facts) {
  const auto programs = LoadOfPrograms(options);
  if (!programs) return tl::unexpected(programs.error());
  const auto assets = LoadOfScenario(scenario);
  if (!assets) return tl::unexpected(assets.error());
  const std::string scenario_name = scenario.file.lexically_relative(assets->base).string();
  if (const auto done = PushPage(lab, options, remotes, facts); !done) return done;
  Complaints complaints;
  for (std::size_t i = 0; i < remotes->hosts().size(); ++i) {
    const lab::Host& host = remotes->hosts()[i];
    lab::HostFacts& its = facts->at(host.name);
    const std::string folder = its.root + "/assets/" + assets->key;
    its.scenario = folder + "/" + scenario_name;
    its.programs = host.programs.empty() ? its.root + "/programs/" + programs->key : host.programs;
    if (const auto done = PushOne(*assets, "scenario", i, folder, options, remotes); !done) return done;
    if (host.programs.empty()) {
      if (const auto done = PushOne(*programs, "programs", i, its.programs, options, remotes); !done) return done;
      continue;
    }
    const auto differing = remotes->Run(i, Compare(*programs, host.programs)).values("differs");
    if (!differing.empty()) {
      complaints.Add(host.name, differing.front() + " in " + host.programs + " is of another version than " +
                                    options.programs.string() +
                                    "; install the same build there, or leave programs out "
                                    "so that ours are brought");
    }
  }
  return complaints.result();
}

core::Result<void> CheckHosts(const lab::Lab& lab, const PreflightOptions& options, Remotes* remotes,
                              const AllFacts& facts) {
  std::vector<std::string> scripts;
  for (const lab::Host& host : remotes->hosts()) {
    scripts.push_back(InspectionFor(lab, host, facts.at(host.name), options.without));
  }
  const std::vector<Answer> answers = remotes->RunAll(scripts);
  Complaints complaints;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const lab::Host& host = remotes->hosts()[i];
    for (const std::string& library : answers[i].values("library")) {
      complaints.Add(host.name, library + "; apt-get install what docs/howto/lab.md names there");
    }
    for (const std::string& device : answers[i].values("device")) {
      complaints.Add(host.name,
                     "device " + device + " is not there or cannot be opened; plug it in, or add a udev rule");
    }
    for (const std::string& cores : answers[i].values("cores")) {
      complaints.Add(host.name, "it has no cores " + cores + "; 'nproc' there says how many it has");
    }
    if (answers[i].values("library").empty()) JudgeDoctor(lab, host, answers[i].value("doctor"), options, &complaints);
  }
  if (const auto good = complaints.result(); !good) return good;
  for (std::size_t i = 0; i < answers.size(); ++i) JudgeClock(lab, i, facts, options, remotes, &complaints);
  return complaints.result();
}

}  // namespace oos
