#include <sstream>
#include <stdexcept>

#include "physics/testing/mujoco_arm.hpp"
#include "tools/dynamics_peers/peers.hpp"

namespace dynamics_peers {
namespace {

std::string Mjcf(const dynamics::SpinnerParams& params, const char* integrator) {
  std::ostringstream out;
  out.precision(17);
  const glm::dvec3& I = params.moments_kg_m2;
  out << R"(<mujoco><compiler balanceinertia="false"/><option gravity="0 0 0" integrator=")" << integrator
      << "\" timestep=\"" << params.dt_s << R"("><flag contact="disable"/></option><worldbody>)";
  for (int i = 0; i < params.num_bodies; ++i) {
    out << "<body pos=\"" << 100 * i << R"( 0 0"><freejoint/><inertial mass="1" pos="0 0 0" diaginertia=")" << I.x
        << ' ' << I.y << ' ' << I.z << "\"/></body>";
  }
  out << "</worldbody></mujoco>";
  return out.str();
}

class MujocoSpinner final : public dynamics::Spinner {
 public:
  MujocoSpinner(const dynamics::SpinnerParams& params, const char* integrator)
      : model_(physics::test::LoadMujoco(Mjcf(params, integrator))), data_(nullptr, mj_deleteData) {
    if (model_ == nullptr) throw std::runtime_error("MuJoCo does not take the model");
    data_.reset(mj_makeData(model_.get()));
    for (int i = 0; i < params.num_bodies; ++i) {
      for (int k = 0; k < 3; ++k) data_->qvel[6 * i + 3 + k] = params.w_B_rad_per_s[k];
    }
  }
  void Step() override { mj_step(model_.get(), data_.get()); }
  [[nodiscard]] glm::dquat R_WB() const override {
    const mjtNum* q = data_->qpos + 3;
    return {q[0], q[1], q[2], q[3]};
  }
  [[nodiscard]] glm::dvec3 w_B_rad_per_s() const override { return {data_->qvel[3], data_->qvel[4], data_->qvel[5]}; }

 private:
  physics::test::MujocoModel model_;
  physics::test::MujocoData data_;
};

}  // namespace

std::vector<dynamics::SpinnerMaker> MujocoSpinners() {
  std::vector<dynamics::SpinnerMaker> makers;
  for (const char* integrator : {"Euler", "implicit", "RK4"}) {
    makers.push_back({std::string("MuJoCo, ") + integrator, [integrator](const dynamics::SpinnerParams& params) {
                        return std::make_unique<MujocoSpinner>(params, integrator);
                      }});
  }
  return makers;
}

}  // namespace dynamics_peers
