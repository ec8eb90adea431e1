#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "physics/testing/mujoco_arm.hpp"
#include "physics/testing/trials/build.hpp"
#include "physics/testing/trials/heavy_on_light.hpp"
#include "tools/dynamics_peers/peers.hpp"

namespace dynamics_peers {
namespace {

using physics::trials::HeavyOnLight;
constexpr double kHalf_m = 0.5 * HeavyOnLight::kSide_m;

// `solref`: time constant and damping ratio of a contact; 2 steps is the least that MuJoCo allows.
std::string Mjcf(double ratio, const char* solref) {
  std::ostringstream out;
  out.precision(17);
  const auto block = [&](double mass_kg, double z_m) {
    out << "<body pos=\"0 0 " << z_m << R"("><freejoint/><geom type="box" size=")" << kHalf_m << ' ' << kHalf_m << ' '
        << kHalf_m << "\" mass=\"" << mass_kg << "\" friction=\"0.3\" solref=\"" << solref << "\"/></body>";
  };
  out << "<mujoco><option gravity=\"0 0 " << -physics::trials::kGravity << "\" timestep=\"" << physics::trials::kDt
      << R"("/><worldbody><geom type="plane" size="5 5 1" friction="0.3" solref=")" << solref << "\"/>";
  block(HeavyOnLight::kLight_kg, kHalf_m);
  block(HeavyOnLight::kLight_kg * ratio, 3 * kHalf_m);
  out << "</worldbody></mujoco>";
  return out.str();
}

class MujocoStack final : public dynamics::Stack {
 public:
  MujocoStack(double ratio, const char* solref)
      : model_(physics::test::LoadMujoco(Mjcf(ratio, solref))), data_(nullptr, mj_deleteData) {
    if (model_ == nullptr) throw std::runtime_error("MuJoCo does not take the model");
    data_.reset(mj_makeData(model_.get()));
  }
  void Step() override {
    mj_step(model_.get(), data_.get());
    for (int i = 0; i < data_->ncon; ++i) deepest_m_ = std::max(deepest_m_, -data_->contact[i].dist);
  }
  [[nodiscard]] double deepest_m() const override { return deepest_m_; }

 private:
  physics::test::MujocoModel model_;
  physics::test::MujocoData data_;
  double deepest_m_ = 0.0;
};

dynamics::StackMaker Maker(const char* name, const char* solref) {
  return {name, [solref](double ratio) { return std::make_unique<MujocoStack>(ratio, solref); }};
}

}  // namespace

std::vector<dynamics::StackMaker> MujocoStacks() {
  return {Maker("MuJoCo, default", "0.02 1"), Maker("MuJoCo, stiffest", "0.002 1")};
}

}  // namespace dynamics_peers
