#pragma once

#include <cstddef>
#include <memory>

#include "tools/transport/channel.hpp"

namespace transport_peers {

// LCM over multicast on this machine (ttl 0). Null if multicast does not work here.
std::unique_ptr<transport::Channel> MakeLcm(std::size_t num_bytes);

}  // namespace transport_peers
