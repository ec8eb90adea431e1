#pragma once

#include <memory>

#include "core/pose.hpp"
#include "core/wrench.hpp"
#include "scene/scenario.hpp"
#include "vps/mesh/triangle_mesh.hpp"

namespace failures {

// Bullet alone as a peer: its own collision detection between meshes (GImpact, margin 0.1 mm), its solver with 10
// sweeps, steps of 1 ms. A tool is a body that the default coupling's springs draw to the device, damped critically;
// it is as light as an explicit step can hold. That is the simplest way to couple a hand to Bullet.
class BulletLoop {
 public:
  explicit BulletLoop(double friction);
  ~BulletLoop();
  BulletLoop(const BulletLoop&) = delete;
  BulletLoop& operator=(const BulletLoop&) = delete;

  void AddFixed(const vps::TriangleMesh& mesh, const core::Pose& X_WO);
  // The mesh's origin is its centre of mass. The last body that was added is the one that is coupled or observed.
  void AddBody(const vps::TriangleMesh& mesh, const core::Pose& X_WO, double mass_kg);
  void AddTool(const vps::TriangleMesh& mesh, const core::Pose& X_WD);

  // As failures::Loop: a tick with the device at this pose; the same with the tool put there, at rest.
  void Tick(const core::Pose& X_WD);
  void LetGo(const core::Pose& X_WD);
  void Tick();  // without a device

  [[nodiscard]] core::Pose X_WC() const;
  [[nodiscard]] double speed_m_per_s() const;
  [[nodiscard]] const core::Wrench& command() const { return command_; }  // on the hand
  [[nodiscard]] bool is_in_contact() const;

 private:
  struct World;
  std::unique_ptr<World> world_;
  const scene::Coupling coupling_;
  core::Pose X_WD_before_;
  core::Wrench command_;
};

}  // namespace failures
