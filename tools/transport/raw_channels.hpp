#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "tools/transport/channel.hpp"

namespace transport {

// Bare transports to compare with, on the loopback of the calling thread's network. Null if one does not work here.

std::unique_ptr<Channel> MakeUdp(std::size_t num_bytes);
// `endpoint`: "tcp://127.0.0.1:*" or "ipc://*".
std::unique_ptr<Channel> MakeZeroMq(const std::string& name, const std::string& endpoint, std::size_t num_bytes);
// Shared memory, a counter, and the kernel's futex to sleep on: the lower bound for transports between processes.
std::unique_ptr<Channel> MakeSharedMemory(std::size_t num_bytes);

}  // namespace transport
