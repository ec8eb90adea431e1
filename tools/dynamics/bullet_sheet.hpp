#pragma once

#include "physics/testing/trials/drape.hpp"

namespace dynamics {

// physics::Drape with Bullet's soft body of links: position-based, bending by links over two cells, as its helper makes
// them, so without a bending stiffness in SI units. Its other settings are Bullet's defaults.
physics::DrapeResult BulletDrape(int cells);

}  // namespace dynamics
