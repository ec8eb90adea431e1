#include "tools/failures_peers/mujoco_loop.hpp"

#include <mutex>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "physics/testing/mujoco_arm.hpp"
#include "tools/dynamics_peers/peers.hpp"
#include "vps/mesh/mass_properties.hpp"

namespace failures_peers {
namespace {

// Time constant and damping ratio of a contact; 2 steps is the least that MuJoCo allows.
constexpr const char* kStiffest = "0.002 1";

void Write(const glm::dvec3& v, std::ostream* out) {
  *out << v.x << ' ' << v.y << ' ' << v.z;
}
void WritePose(const core::Pose& X, std::ostream* out) {
  *out << " pos=\"";
  Write(X.translation, out);
  *out << "\" quat=\"" << X.rotation.w << ' ' << X.rotation.x << ' ' << X.rotation.y << ' ' << X.rotation.z << '"';
}

// MuJoCo's models are complete when they are made: bodies are gathered, and the model is made with the first look at
// it.
class MujocoLoop final : public failures::PeerLoop {
 public:
  explicit MujocoLoop(double friction)
      : friction_(friction), model_(nullptr, mj_deleteModel), data_(nullptr, mj_deleteData) {
    meshes_.precision(17);
    bodies_.precision(17);
  }

  void AddFixed(const vps::TriangleMesh& mesh, const core::Pose& X_WO) override {
    bodies_ << "<geom";
    WriteShape(mesh);
    WritePose(X_WO, &bodies_);
    bodies_ << "/>";
  }
  void AddBody(const vps::TriangleMesh& mesh, const core::Pose& X_WO, double mass_kg) override {
    const auto solid = vps::ComputeMassProperties(mesh, 1.0);
    if (!solid) throw std::runtime_error(solid.error().detail);
    const glm::dmat3 I = mass_kg / solid->mass_kg * solid->inertia_Com_kg_m2;  // its axes are the mesh's, as of a box
    AddMoving(mesh, X_WO, mass_kg, {I[0][0], I[1][1], I[2][2]});
  }
  using PeerLoop::Tick;
  void Tick() override {
    mjModel* const m = model();  // makes the data, too
    mj_step(m, data_.get());
  }

  [[nodiscard]] core::Pose X_WC() const override {
    model();
    const mjtNum* const q = data_->qpos;
    return {glm::dquat(q[3], q[4], q[5], q[6]), {q[0], q[1], q[2]}};
  }
  // MuJoCo has a free body's angular velocity in the body's own axes.
  [[nodiscard]] core::Twist V_WC() const override {
    const core::Pose X = X_WC();
    const mjtNum* const v = data_->qvel;
    return {X.rotate({v[3], v[4], v[5]}), {v[0], v[1], v[2]}};
  }
  [[nodiscard]] bool is_in_contact() const override {
    model();
    for (int i = 0; i < data_->ncon; ++i) {
      if (data_->contact[i].dist < 0.0) return true;
    }
    return false;
  }

 protected:
  void AddBall(const vps::TriangleMesh& mesh, const core::Pose& X_WO, double mass_kg, double inertia_kg_m2) override {
    AddMoving(mesh, X_WO, mass_kg, glm::dvec3(inertia_kg_m2));
  }
  void Push(const core::Wrench& F_W) override {
    model();
    mjtNum* const to = data_->xfrc_applied + 6;  // body 0 is the world
    for (int axis = 0; axis < 3; ++axis) {
      to[axis] = F_W.force_N[axis];
      to[3 + axis] = F_W.torque_Nm[axis];
    }
  }
  void PutAtRest(const core::Pose& X_WO) override {
    model();
    mj_resetData(model_.get(), data_.get());
    mjtNum* const q = data_->qpos;
    for (int axis = 0; axis < 3; ++axis) q[axis] = X_WO.translation[axis];
    q[3] = X_WO.rotation.w;
    q[4] = X_WO.rotation.x;
    q[5] = X_WO.rotation.y;
    q[6] = X_WO.rotation.z;
  }

 private:
  void AddMoving(const vps::TriangleMesh& mesh, const core::Pose& X_WO, double mass_kg,
                 const glm::dvec3& moments_kg_m2) {
    bodies_ << "<body";
    WritePose(X_WO, &bodies_);
    bodies_ << "><freejoint/><inertial pos=\"0 0 0\" mass=\"" << mass_kg << "\" diaginertia=\"";
    Write(moments_kg_m2, &bodies_);
    bodies_ << "\"/><geom";
    WriteShape(mesh);
    bodies_ << "/></body>";
  }
  void WriteShape(const vps::TriangleMesh& mesh) {
    meshes_ << "<mesh name=\"m" << num_meshes_ << "\" vertex=\"";
    for (const glm::dvec3& v : mesh.vertices) meshes_ << v.x << ' ' << v.y << ' ' << v.z << ' ';
    meshes_ << "\"/>";
    bodies_ << " type=\"mesh\" mesh=\"m" << num_meshes_ << "\" friction=\"" << friction_ << "\" solref=\"" << kStiffest
            << '"';
    ++num_meshes_;
  }
  mjModel* model() const {
    if (model_ != nullptr) return model_.get();
    std::ostringstream all;
    all << R"(<mujoco><compiler balanceinertia="false" boundmass="0" boundinertia="0"/><option gravity="0 0 0" timestep="0.001"/><asset>)"
        << meshes_.str() << "</asset><worldbody>" << bodies_.str() << "</worldbody></mujoco>";
    static std::mutex one_at_a_time;  // through a file of the process
    const std::lock_guard lock(one_at_a_time);
    model_ = physics::test::LoadMujoco(all.str());
    if (model_ == nullptr) throw std::runtime_error("MuJoCo does not take the model");
    data_.reset(mj_makeData(model_.get()));
    return model_.get();
  }

  double friction_;
  int num_meshes_ = 0;
  std::ostringstream meshes_, bodies_;
  mutable physics::test::MujocoModel model_;
  mutable physics::test::MujocoData data_;
};

}  // namespace

failures::Peer MujocoPeer() {
  failures::Peer peer;
  peer.name = "MuJoCo";
  peer.make_loop = [](double friction) { return std::make_unique<MujocoLoop>(friction); };
  peer.stack = dynamics_peers::MujocoStacks().back();  // the stiffest
  return peer;
}

}  // namespace failures_peers
