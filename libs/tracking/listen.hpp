#pragma once

#include <cstdint>
#include <string>

#include "core/result.hpp"

namespace tracking {

// A socket that hears what a tracker sends; whoever gets it closes it.
struct Listener {
  int fd = -1;
  std::uint16_t port = 0;  // that was asked for, or the one that was free for 0
};

// Address: PORT, ADDRESS:PORT or GROUP:PORT. Several programs of a machine may hear one group. Errors: kInvalidInput
// for another text, kIo when nothing can be received there.
core::Result<Listener> Listen(const std::string& address);

}  // namespace tracking
