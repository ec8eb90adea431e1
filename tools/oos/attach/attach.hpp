#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "bus/node.hpp"
#include "tools/oos/verb/verb.hpp"

namespace oos {

// Options of every verb that observes a running system.
const std::vector<Option>& AttachOptions();

// Options to join the running session: the one that `oos run` noted down on this machine, or the one given by
// --registry and --session. The caller sets the node's name.
core::Result<bus::NodeOptions> FindSession(const Arguments& arguments);

// An observer of that session. It is not started yet, so that topics can still be declared.
core::Result<std::unique_ptr<bus::Node>> Attach(const Arguments& arguments, const std::string& verb);

// From now on SIGINT and SIGTERM set the returned flag.
const std::atomic<int>& CatchInterrupt();

}  // namespace oos
