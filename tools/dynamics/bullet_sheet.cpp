#include "tools/dynamics/bullet_sheet.hpp"

#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>

#include "physics/testing/trials/build.hpp"

namespace dynamics {

physics::DrapeResult BulletDrape(int cells) {
  constexpr double kHalf = 0.5 * physics::kDrapeSide_m;
  const btVector3 gravity(0, 0, -physics::trials::kGravity);
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btSoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  world.setGravity(gravity);
  world.getWorldInfo().m_gravity = gravity;
  world.getWorldInfo().m_sparsesdf.Initialize();
  const int side = cells + 1;
  btSoftBody* const sheet =
      btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), {-kHalf, -kHalf, 0}, {kHalf, -kHalf, 0}, {-kHalf, kHalf, 0},
                                     {kHalf, kHalf, 0}, side, side, 0, true);
  sheet->generateBendingConstraints(2);
  sheet->setTotalMass(physics::kDrapeWeight_N_per_m2 / physics::trials::kGravity * physics::kDrapeSide_m *
                      physics::kDrapeSide_m);
  for (int j = 0; j < side; ++j) sheet->setMass(j * side + cells / 2, 0.0);
  sheet->m_cfg.kDP = 0.01;  // so that it comes to rest
  sheet->setActivationState(DISABLE_DEACTIVATION);
  world.addSoftBody(sheet);
  physics::DrapeResult result;
  result.num_nodes = sheet->m_nodes.size();
  result.num_steps = 2000;
  for (std::uint64_t i = 0; i < result.num_steps; ++i) world.stepSimulation(physics::trials::kDt, 0);
  const int row = cells / 2 * side;
  result.sag_m = -0.5 * (sheet->m_nodes[row].m_x.z() + sheet->m_nodes[row + cells].m_x.z());
  for (int i = 0; i < sheet->m_nodes.size(); ++i) {
    result.speed_m_per_s = std::max(result.speed_m_per_s, sheet->m_nodes[i].m_v.length());
  }
  world.removeSoftBody(sheet);
  delete sheet;
  return result;
}

}  // namespace dynamics
