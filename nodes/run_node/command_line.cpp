#include "nodes/run_node/command_line.hpp"

#include <cstdio>
#include <limits>
#include <sstream>

#include "collision/resolution/choose_resolutions.hpp"

namespace run_node {

int Report(const std::string& program, const std::string& what, int status) {
  std::fprintf(stderr, "%s: %s\n", program.c_str(), what.c_str());
  return status;
}

std::vector<cli::Option> BusOptions() {
  return {
      {"--registry", "ENDPOINT", "of the session, e.g. tcp://127.0.0.1:7450"},
      {"--session", "N", "its number", "0", cli::Count(0, std::numeric_limits<std::uint64_t>::max())},
      {"--keys", "DIR", "keys of the run, bus/security/keys.hpp; either this or --no_encryption"},
      {"--no_encryption", "", "the run has no keys"},
      {"--bind", "ADDRESS", "of this machine, where the others reach it", "127.0.0.1"},
      {"--record", "FILE.mcap", "what this node sends and takes"},
      {"--split_MB", "N", "with --record: a new file at that size"},
      {"--split_s", "N", "with --record: a new file at that age"},
  };
}

core::Result<void> CheckBusOptions(const cli::Arguments& arguments) {
  for (const char* name : {"--scenario", "--registry", "--session", "--out"}) {
    if (arguments.has(name)) continue;
    return core::Fail(core::ErrorCode::kInvalidInput, std::string(name) + " is missing; 'oos run' starts the nodes");
  }
  if (arguments.has("--keys") == arguments.has("--no_encryption")) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "either --keys DIR or --no_encryption must be given; 'oos run' starts the nodes");
  }
  return {};
}

bus::NodeOptions MakeNodeOptions(const std::string& name, const cli::Arguments& arguments) {
  bus::NodeOptions options;
  options.name = name;
  options.registry = arguments.text("--registry");
  options.session = arguments.checked_count("--session");
  options.keys = arguments.text("--keys");
  options.is_encrypted = !arguments.has("--no_encryption");
  options.bind_address = arguments.text("--bind");
  options.multicast = arguments.text("--multicast");
  std::istringstream patterns(arguments.text("--tcp_topics"));
  for (std::string pattern; std::getline(patterns, pattern, ',');) options.tcp_topics.push_back(pattern);
  return options;
}

bus::log::RecordingOptions MakeRecordingOptions(const cli::Arguments& arguments) {
  return {arguments.text("--record"), arguments.text("--split_MB"), arguments.text("--split_s"),
          arguments.text("--scenario")};
}

std::optional<cli::Arguments> ReadCommandLine(int argc, char** argv, const cli::Syntax& syntax, int* status) {
  const auto arguments = cli::Arguments::Parse(std::vector<std::string>(argv + 1, argv + argc), syntax);
  if (!arguments) {
    *status = Report(syntax.program, arguments.error().detail + "; '" + syntax.program + " --help' lists the options",
                     kBadUsage);
    return std::nullopt;
  }
  if (arguments->wants_help()) {
    std::printf("%s", cli::Help(syntax).c_str());
    *status = kDone;
    return std::nullopt;
  }
  return *arguments;
}

std::optional<scene::Scenario> ReadScenario(const std::string& program, const std::filesystem::path& file) {
  auto scenario = collision::LoadResolvedScenario(file);
  if (scenario) return std::move(*scenario);
  for (const scene::Diagnostic& diagnostic : scenario.error()) {
    Report(program, scene::Format(diagnostic), kBadUsage);
  }
  return std::nullopt;
}

}  // namespace run_node
