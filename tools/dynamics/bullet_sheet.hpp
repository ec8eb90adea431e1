#pragma once

#include "physics/testing/trials/drape.hpp"

namespace dynamics {

// physics::Drape with Bullet's soft body of links (position-based, no bending stiffness in SI units: links over two
// cells, as its helper makes them), otherwise as it comes.
physics::DrapeResult BulletDrape(int cells);

}  // namespace dynamics
