#pragma once

#include <map>
#include <string>

#include "bus/node.hpp"
#include "core/result.hpp"

namespace bus {

// The command line that `oos run` and `oos launch` start nodes with: "--name value" pairs, and the lone
// --no_encryption.
using NodeArguments = std::map<std::string, std::string>;

// Defaults are replaced by what is given. Fails, with the name, when one of --scenario, --registry, --session, --out is
// missing, or neither --keys nor --no_encryption is there.
core::Result<NodeArguments> ParseNodeArguments(int argc, char** argv, NodeArguments defaults);

// From --registry, --session, --keys or --no_encryption, --bind, --multicast GROUP and --tcp_topics PATTERN,PATTERN,...
NodeOptions MakeNodeOptions(const std::string& name, const NodeArguments& arguments);

}  // namespace bus
