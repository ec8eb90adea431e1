#pragma once

#include <cstddef>

namespace oos {
class Heartbeat;
}

namespace bus::detail {

struct NodeCore;

// What each LATEST writer has meant for each reader travels in heartbeats, a few spans at a time; so the reader knows
// of messages that were lost before the first and after the last that it got.
void AddLatestSpans(const NodeCore& core, std::size_t* next, oos::Heartbeat* heartbeat);
void TakeLatestSpans(const oos::Heartbeat& heartbeat, NodeCore* core);

}  // namespace bus::detail
