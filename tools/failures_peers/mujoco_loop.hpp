#pragma once

#include "tools/failures/peer_loop.hpp"

namespace failures_peers {

// MuJoCo with its collision detection between convex hulls and its default solver. Contacts are the stiffest that it
// documents for steps of 1 ms.
failures::Peer MujocoPeer();

}  // namespace failures_peers
