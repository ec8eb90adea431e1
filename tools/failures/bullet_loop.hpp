#pragma once

#include "tools/failures/peer_loop.hpp"

namespace failures {

// Bullet with its own collision detection between meshes (GImpact, margin 0.1 mm) and its solver with 10 sweeps.
Peer BulletPeer();

}  // namespace failures
