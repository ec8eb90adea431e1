#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "vps/multibody/collision_world.hpp"
#include "vps/testing/shapes.hpp"

// For tests and benchmarks: a cabinet of parts, each circling in its own compartment, ten of them with another one
// leaning on it. All pairs are active. The motion repeats after kPeriod steps of 1 ms; nothing is faster than 0.3 m/s.
namespace vps::test {

class ManyObjects {
 public:
  static constexpr int kPeriod = 2000;
  static constexpr std::size_t kCouples = 10;
  static constexpr double kPitch_m = 0.3;

  using Parts = std::array<std::shared_ptr<const CookedObject>, 5>;
  static Parts CookParts(Method method, std::uint32_t num_points, double voxel_size_m) {
    const auto cook = [&](const TriangleMesh& mesh) {
      return std::make_shared<const CookedObject>(*Cook(mesh, {voxel_size_m, num_points, method}));
    };
    return {cook(MakeTorus(0.04, 0.015, 96, 48)), cook(MakeBox({0.06, 0.05, 0.03})), cook(MakeSphere(0.04, 64)),
            cook(MakeCylinder(0.03, 0.06, 96)), cook(MakeBlockWithHole(0.06, 0.03, 0.015, 96))};
  }

  // `num_objects` counts both parts of the couples. `num_far` more stand 100 m away, and move as well.
  ManyObjects(Method method, const Parts& parts, std::size_t num_objects, std::size_t num_far) {
    // What leans on each: ring on ring, cylinder on box, box on ball, ball on cylinder, cylinder on block.
    const std::size_t leans_on[] = {0, 3, 1, 2, 3};
    const double half_height_m[] = {0.015, 0.015, 0.04, 0.03, 0.015};
    WorldDescription description;
    description.method = method;
    for (std::size_t i = 0; i < num_objects + num_far; ++i) {
      const bool is_couple = i < 2 * kCouples;
      Mover mover;
      std::size_t kind = is_couple ? i / 2 % 5 : i % 5;
      if (is_couple && i % 2 == 1) {
        mover.leader = static_cast<int>(i) - 1;
        mover.lean_m = half_height_m[kind] + half_height_m[leans_on[kind]];
        kind = leans_on[kind];
      }
      const std::size_t place = is_couple ? i / 2 : i - kCouples;
      mover.home_W = kPitch_m * glm::dvec3(place % 5, place / 5 % 5, place / 25);
      if (i >= num_objects) mover.home_W.x += 100.0;
      mover.phase = 0.7 * static_cast<double>(i);
      movers_.push_back(mover);
      description.objects.push_back({parts[kind], {}});
    }
    for (std::size_t i = 0; i < description.objects.size(); ++i) description.objects[i].X_WO = PoseAt(i, 0);
    for (std::uint16_t i = 0; i < description.objects.size(); ++i) {
      for (std::uint16_t j = 0; j < i; ++j) description.pairs.push_back({.sampled = i, .field = j});
    }
    world_ = *CollisionWorld::Create(description);
  }

  [[nodiscard]] CollisionWorld& world() { return *world_; }

  void MoveTo(int step) {
    for (std::size_t i = 0; i < movers_.size(); ++i) world_->SetPose(i, PoseAt(i, step));
  }

 private:
  struct Mover {
    glm::dvec3 home_W{0.0};
    double phase = 0.0;
    int leader = -1;  // leans on this one
    double lean_m = 0.0;
  };

  [[nodiscard]] core::Pose PoseAt(std::size_t i, int step) const {
    const Mover& mover = movers_[i];
    const double t = 2.0 * M_PI * step / kPeriod;
    if (mover.leader >= 0) {
      // 0.3 mm into the leader, and sliding on it.
      const double slide_m = 0.002 * std::sin(3.0 * t);
      const core::Pose X_LO{core::QuaternionFromRotationVector({0.0, 0.0, 0.2 * std::sin(t)}),
                            {slide_m, 0.5 * slide_m, mover.lean_m - 0.0003 + 0.0001 * std::sin(7.0 * t)}};
      return PoseAt(static_cast<std::size_t>(mover.leader), step) * X_LO;
    }
    const double a = t + mover.phase;
    return {core::QuaternionFromRotationVector({std::sin(a), 0.5 * std::cos(t), 0.7 * std::sin(2.0 * t)}),
            mover.home_W + 0.05 * glm::dvec3(std::cos(a), std::sin(a), std::sin(a + 1.0))};
  }

  std::vector<Mover> movers_;
  std::unique_ptr<CollisionWorld> world_;
};

}  // namespace vps::test
