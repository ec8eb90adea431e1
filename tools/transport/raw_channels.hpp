#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "tools/transport/channel.hpp"

namespace transport {

// The bare transports to compare with, on loopback of the calling thread's network. Null: not on this machine.

std::unique_ptr<Channel> MakeUdp(std::size_t num_bytes);
// `endpoint`: "tcp://127.0.0.1:*" or "ipc://*".
std::unique_ptr<Channel> MakeZeroMq(const std::string& name, const std::string& endpoint, std::size_t num_bytes);
// Memory that both see, a counter, and the kernel's futex to sleep on: what no transport between processes can beat.
std::unique_ptr<Channel> MakeSharedMemory(std::size_t num_bytes);

}  // namespace transport
