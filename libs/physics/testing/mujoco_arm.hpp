#pragma once

#include <mujoco/mujoco.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "physics/testing/chain_samples.hpp"

// Only where MuJoCo is installed (VR_OOS_PEERS).
namespace physics::test {

// The model as MJCF. Inertias are given in their principal axes: MuJoCo diagonalises a full tensor to about 1e-7 only.
inline std::string Mjcf(const std::vector<ChainLink>& links, const std::vector<PrincipalInertia>& inertias) {
  std::ostringstream out;
  out.precision(17);
  out << R"(<mujoco><compiler angle="radian" balanceinertia="false" boundmass="0" boundinertia="0"/>)"
      << R"(<option gravity="0 0 0"><flag contact="disable"/></option><worldbody>)";
  const auto vector = [&](const glm::dvec3& v) { out << v.x << ' ' << v.y << ' ' << v.z; };
  const auto rotation = [&](const glm::dquat& q) { out << q.w << ' ' << q.x << ' ' << q.y << ' ' << q.z; };
  for (std::size_t i = 0; i < links.size(); ++i) {
    out << "<body pos=\"";
    vector(links[i].X_PJ.translation);
    out << "\" quat=\"";
    rotation(links[i].X_PJ.rotation);
    out << "\"><inertial mass=\"" << links[i].mass.mass_kg << "\" pos=\"";
    vector(links[i].mass.p_OCm_m);
    out << "\" quat=\"";
    rotation(inertias[i].R_OB);
    out << "\" diaginertia=\"";
    vector(inertias[i].moments_kg_m2);
    out << "\"/><joint type=\"hinge\" axis=\"0 0 1\" limited=\"false\"/>";
  }
  for (std::size_t i = 0; i < links.size(); ++i) out << "</body>";
  out << "</worldbody></mujoco>";
  return out.str();
}

using MujocoModel = std::unique_ptr<mjModel, void (*)(mjModel*)>;
using MujocoData = std::unique_ptr<mjData, void (*)(mjData*)>;

// MuJoCo reads models from files only. Null when MuJoCo refuses the model.
inline MujocoModel LoadMujoco(const std::string& mjcf) {
  const auto file = std::filesystem::temp_directory_path() / ("vr_oos_" + std::to_string(::getpid()) + ".xml");
  std::ofstream(file) << mjcf;
  char error[1000] = "";
  MujocoModel model(mj_loadXML(file.c_str(), nullptr, error, sizeof(error)), mj_deleteModel);
  std::filesystem::remove(file);
  return model;
}

// Largest difference of a joint acceleration from MuJoCo's, relative to the largest acceleration of the same arm, over
// 1,000 random states of 20 arms; NaN when MuJoCo refuses a model.
inline double WorstArmError() {
  Draws draws(11);
  double worst = 0.0;
  for (int arm = 0; arm < 20; ++arm) {
    std::vector<PrincipalInertia> inertias;
    const std::vector<ChainLink> links = RandomArm(&draws, &inertias);
    auto chain = Chain::Create(links);
    const MujocoModel model = LoadMujoco(Mjcf(links, inertias));
    if (model == nullptr) return std::numeric_limits<double>::quiet_NaN();
    const MujocoData data(mj_makeData(model.get()), mj_deleteData);
    for (int i = 0; i < 50; ++i) {
      const ChainState state = RandomState(*chain, &draws);
      std::vector<double> torque(7);
      for (std::size_t k = 0; k < 7; ++k) {
        torque[k] = draws.In(-10.0, 10.0);
        data->qpos[k] = state.position[k];
        data->qvel[k] = state.speed[k];
        data->qfrc_applied[k] = torque[k];
      }
      mj_forward(model.get(), data.get());
      ChainAcceleration found;
      found.joint.resize(7);
      chain->Accelerate(state, torque, {}, &found);
      double scale = 0.0;
      for (std::size_t k = 0; k < 7; ++k) scale = std::max(scale, std::abs(data->qacc[k]));
      for (std::size_t k = 0; k < 7; ++k) worst = std::max(worst, std::abs(found.joint[k] - data->qacc[k]) / scale);
    }
  }
  return worst;
}

}  // namespace physics::test
