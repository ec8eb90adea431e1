#pragma once

#include <cstddef>

namespace oos {
class Heartbeat;
}

namespace bus::detail {

struct NodeCore;

// The span of messages that each LATEST writer has sent to each reader travels in heartbeats, a few spans at a time. It
// reveals to the reader losses before its first and after its last arrival.
void AddLatestSpans(const NodeCore& core, std::size_t* next, oos::Heartbeat* heartbeat);
void TakeLatestSpans(const oos::Heartbeat& heartbeat, NodeCore* core);

}  // namespace bus::detail
