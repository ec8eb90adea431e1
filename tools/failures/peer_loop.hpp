#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/pose.hpp"
#include "core/wrench.hpp"
#include "scene/scenario.hpp"
#include "tools/dynamics/stack.hpp"
#include "vps/mesh/triangle_mesh.hpp"

namespace failures {

// Another engine alone as a peer: its own collision detection between meshes, its own solver, steps of 1 ms, no
// gravity. A tool is a body that the default coupling's springs draw to the device, damped critically; it is as light
// as an explicit step can hold. That is the simplest way to couple a hand to such an engine.
class PeerLoop {
 public:
  virtual ~PeerLoop() = default;

  virtual void AddFixed(const vps::TriangleMesh& mesh, const core::Pose& X_WO) = 0;
  // The mesh's origin is its centre of mass. The last body that was added is the one that is coupled or observed.
  virtual void AddBody(const vps::TriangleMesh& mesh, const core::Pose& X_WO, double mass_kg) = 0;
  void AddTool(const vps::TriangleMesh& mesh, const core::Pose& X_WD);

  // As failures::Loop: a tick with the device at this pose; the same with the tool put there, at rest.
  void Tick(const core::Pose& X_WD);
  void LetGo(const core::Pose& X_WD);
  virtual void Tick() = 0;  // without a device

  [[nodiscard]] virtual core::Pose X_WC() const = 0;
  [[nodiscard]] virtual core::Twist V_WC() const = 0;
  [[nodiscard]] double speed_m_per_s() const { return glm::length(V_WC().linear_m_per_s); }
  [[nodiscard]] const core::Wrench& command() const { return command_; }  // on the hand
  [[nodiscard]] virtual bool is_in_contact() const = 0;

 protected:
  // As AddBody, with this inertia about every axis.
  virtual void AddBall(const vps::TriangleMesh& mesh, const core::Pose& X_WO, double mass_kg, double inertia_kg_m2) = 0;
  // On the last body, for the next tick, at its centre of mass.
  virtual void Push(const core::Wrench& F_W) = 0;
  virtual void PutAtRest(const core::Pose& X_WO) = 0;

 private:
  const scene::Coupling coupling_;
  core::Pose X_WD_before_;
  core::Wrench command_;
};

// What rows are measured with beside the variants, where it has the same test.
struct Peer {
  std::string name;  // heading of its column: one of PeerNames()
  // Meshes as they are. Else by their convex hulls, so that only convex parts are the same test, and no sheets.
  bool takes_concave = false;
  std::function<std::unique_ptr<PeerLoop>(double friction)> make_loop;
  dynamics::StackMaker stack;
};
using Peers = std::vector<Peer>;

// Also of those that are not built: a table always has the same columns.
inline const std::vector<std::string>& PeerNames() {
  static const std::vector<std::string> names{"Bullet", "MuJoCo"};
  return names;
}

}  // namespace failures
