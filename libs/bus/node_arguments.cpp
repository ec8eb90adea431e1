#include "bus/node_arguments.hpp"

#include <cstdlib>
#include <sstream>

namespace bus {

core::Result<NodeArguments> ParseNodeArguments(int argc, char** argv, NodeArguments defaults) {
  NodeArguments arguments = std::move(defaults);
  const auto fail = [](const std::string& what) { return core::Fail(core::ErrorCode::kInvalidInput, what); };
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--no_encryption") {
      arguments[name] = "yes";
    } else if (i + 1 < argc) {
      arguments[name] = argv[++i];
    } else {
      return fail(name + " wants a value");
    }
  }
  for (const char* name : {"--scenario", "--registry", "--session", "--out"}) {
    if (arguments.count(name) == 0) return fail(std::string(name) + " is missing; 'oos run' starts the nodes");
  }
  if (arguments.count("--keys") == arguments.count("--no_encryption")) {
    return fail("either --keys DIRECTORY or --no_encryption must be given; 'oos run' starts the nodes");
  }
  return arguments;
}

NodeOptions MakeNodeOptions(const std::string& name, const NodeArguments& arguments) {
  const auto value = [&arguments](const char* key, const char* otherwise) {
    const auto found = arguments.find(key);
    return found == arguments.end() ? std::string(otherwise) : found->second;
  };
  NodeOptions options;
  options.name = name;
  options.registry = value("--registry", "");
  options.session = std::strtoull(value("--session", "0").c_str(), nullptr, 10);
  options.keys = value("--keys", "");
  options.is_encrypted = arguments.count("--no_encryption") == 0;
  options.bind_address = value("--bind", options.bind_address.c_str());
  options.multicast = value("--multicast", "");
  std::istringstream patterns(value("--tcp_topics", ""));
  for (std::string pattern; std::getline(patterns, pattern, ',');) options.tcp_topics.push_back(pattern);
  return options;
}

}  // namespace bus
