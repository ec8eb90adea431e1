#pragma once

#include "tools/oos/verb/verb.hpp"

namespace oos {

// `oos replay FILE` without a node to feed: publishes the recording on the running session.
int RunBusReplay(const Arguments& arguments);

}  // namespace oos
