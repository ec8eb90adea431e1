#include "nodes/visual_node/options.hpp"

#include <charconv>
#include <cstdlib>
#include <string_view>

namespace visual_node {
namespace {

template <typename T>
bool Parse(std::string_view text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

bool ParseSize(std::string_view text, Options& options) {
  const std::size_t x = text.find('x');
  return x != std::string_view::npos && Parse(text.substr(0, x), options.width) &&
         Parse(text.substr(x + 1), options.height) && options.width >= 64 && options.height >= 64 &&
         options.width <= 8192 && options.height <= 8192;
}

}  // namespace

core::Result<Options> ParseOptions(int argc, char** argv) {
  Options options;
  const auto fail = [](const std::string& what) { return core::Fail(core::ErrorCode::kInvalidInput, what); };
  for (int i = 1; i < argc; ++i) {
    const std::string_view name = argv[i];
    if (name == "--headless") {
      options.is_headless = true;
      continue;
    }
    if (name == "--no_encryption") {
      options.is_encrypted = false;
      continue;
    }
    if (i + 1 >= argc) return fail(std::string(name) + " wants a value, or is unknown");
    const std::string value = argv[++i];
    bool is_good = true;
    if (name == "--scenario" || name == "--still") {
      options.scenario = value;
      options.is_still = options.is_still || name == "--still";
    } else if (name == "--name") {
      options.name = value;
    } else if (name == "--record" || name == "--split_MB" || name == "--split_s") {
      options.recording[std::string(name)] = value;
    } else if (name == "--registry") {
      options.registry = value;
    } else if (name == "--session") {
      is_good = Parse(value, options.session);
    } else if (name == "--keys") {
      options.keys = value;
    } else if (name == "--bind") {
      options.bind_address = value;
    } else if (name == "--out") {
      options.out = value;
    } else if (name == "--size") {
      is_good = ParseSize(value, options);
    } else if (name == "--view") {
      options.view = value;
    } else if (name == "--fps") {
      is_good = Parse(value, options.max_frames_per_s) && options.max_frames_per_s >= 1.0 &&
                options.max_frames_per_s <= 1000.0;
    } else {
      return fail("unknown option " + std::string(name));
    }
    if (!is_good) return fail("'" + value + "' is no value for " + std::string(name));
  }
  if (options.scenario.empty()) return fail("--scenario FILE is missing");
  if (!options.is_still && options.registry.empty()) return fail("--registry ENDPOINT is missing");
  if (!options.is_still && options.is_encrypted == options.keys.empty()) {
    return fail("either --keys DIRECTORY or --no_encryption must be given");
  }
  return options;
}

}  // namespace visual_node
