#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "bus/node.hpp"
#include "tools/oos/verb/verb.hpp"

namespace oos {

// Options of every verb that looks into a running system.
const std::vector<Option>& AttachOptions();

// How to reach the running session: the one whose registry `oos run` noted down, or the one named by --registry and
// --session. The name is left open.
core::Result<bus::NodeOptions> FindSession(const Arguments& arguments);

// An observer on that session. Not started yet, so that topics can still be declared.
core::Result<std::unique_ptr<bus::Node>> Attach(const Arguments& arguments, const std::string& verb);

// SIGINT and SIGTERM set the returned flag from now on.
const std::atomic<int>& CatchInterrupt();

}  // namespace oos
