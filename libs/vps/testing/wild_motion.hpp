#pragma once

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include "core/parallel_for.hpp"
#include "vps/multibody/collision_world.hpp"
#include "vps/multibody/fast_pair_query.hpp"
#include "vps/oracle/closed_form.hpp"
#include "vps/testing/brute_force.hpp"
#include "vps/testing/flat_walk.hpp"
#include "vps/testing/shapes.hpp"

// For tests: a scene whose motion is hard on coherence, with reference answers for its contacts.
namespace vps::test {

struct WildBody {
  enum class Mode { kRest, kFly, kClose, kSwing };
  std::shared_ptr<const CookedObject> data;
  glm::dvec3 size_m{0.0};  // of a box
  double radius_m = 0.0;   // of a ball; 0: a box
  core::Pose X_WO;
  Mode mode = Mode::kRest;
  std::size_t prey = 0;
  int steps_left = 0;
  glm::dvec3 velocity_W{0.0};  // m/s
  glm::dvec3 spin_W{0.0};      // rad/s
  glm::dvec3 pivot_m{0.0};     // body's point that a swing keeps at W's origin

  // Exact distance of a point of W from the surface.
  [[nodiscard]] double Distance(const glm::dvec3& p_W) const {
    const glm::dvec3 p = X_WO.inverse() * p_W;
    return radius_m > 0.0 ? oracle::SphereDistance(p, radius_m) : oracle::BoxDistance(p, size_m);
  }
};

// A tool of 1 m that swings about its end or its middle at 2 rad/s and changes its axis at once, balls and boxes that
// are flung at up to 5 m/s and 30 rad/s, that close on each other at 2 m/s, bounce, stand still, and jump. One step is
// 1 ms.
class WildScene {
 public:
  static constexpr double kStep_s = 1e-3;
  static constexpr double kRho = 0.01;
  static constexpr double kRoom_m = 0.45;  // bodies turn round at the walls of this cube (half edge)

  WildScene(Method method, std::uint64_t seed) : method_(method), random_(seed) {
    const auto cook = [&](const TriangleMesh& mesh, std::uint32_t points) {
      return std::make_shared<const CookedObject>(*Cook(mesh, {0.004, points, method}));
    };
    const glm::dvec3 tool_m{1.0, 0.03, 0.03};
    const glm::dvec3 brick_m{0.12, 0.06, 0.03};
    const auto ball = cook(MakeSphere(0.05, 32), 400);
    const auto brick = cook(MakeBox(brick_m), 400);
    bodies_.resize(7);
    bodies_[0].data = cook(MakeBox(tool_m), 400);
    bodies_[0].size_m = tool_m;
    bodies_[0].mode = WildBody::Mode::kSwing;
    for (std::size_t i = 1; i < 4; ++i) {
      bodies_[i].data = ball;
      bodies_[i].radius_m = 0.05;
      bodies_[i + 3].data = brick;
      bodies_[i + 3].size_m = brick_m;
    }
    WorldDescription description;
    description.method = method;
    description.rho = kRho;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      bodies_[i].X_WO.translation = Inside(kRoom_m);
      description.objects.push_back({bodies_[i].data, bodies_[i].X_WO});
    }
    for (std::uint16_t i = 0; i < bodies_.size(); ++i) {
      for (std::uint16_t j = 0; j < i; ++j) {
        description.pairs.push_back({.sampled = i, .field = j});
      }
    }
    world_ = *CollisionWorld::Create(description);
  }

  [[nodiscard]] CollisionWorld& world() { return *world_; }
  [[nodiscard]] const WildBody& body(std::size_t i) const { return bodies_[i]; }

  void Advance() {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      WildBody& body = bodies_[i];
      if (--body.steps_left < 0) Decide(&body);
      if (body.mode == WildBody::Mode::kRest) continue;
      if (body.mode == WildBody::Mode::kSwing) {
        body.X_WO.rotation =
            glm::normalize(core::QuaternionFromRotationVector(kStep_s * body.spin_W) * body.X_WO.rotation);
        body.X_WO.translation = -(body.X_WO.rotation * body.pivot_m);
      } else {
        if (body.mode == WildBody::Mode::kClose) {
          const glm::dvec3 way = bodies_[body.prey].X_WO.translation - body.X_WO.translation;
          body.velocity_W = 2.0 / (glm::length(way) + 1e-9) * way;
        }
        body.X_WO.translation += kStep_s * body.velocity_W;
        body.X_WO.rotation =
            glm::normalize(core::QuaternionFromRotationVector(kStep_s * body.spin_W) * body.X_WO.rotation);
        for (int k = 0; k < 3; ++k) {
          if (std::abs(body.X_WO.translation[k]) > kRoom_m) {
            body.velocity_W[k] = std::copysign(body.velocity_W[k], -body.X_WO.translation[k]);
          }
        }
      }
      world_->SetPose(i, body.X_WO);
    }
  }

  // Whether any sampled point of the pair is inside the field: every point is tested, unless the ball around all of
  // them is clear of the other body.
  [[nodiscard]] bool IsTouching(std::size_t pair) const {
    const WildBody& S = bodies_[world_->pair(pair).sampled];
    const WildBody& G = bodies_[world_->pair(pair).field];
    // The field's surface may lie up to a voxel, here 4 mm, beside the body's.
    if (G.Distance(S.X_WO.translation) > S.data->bounding_radius_m + 0.008) return false;
    const core::Pose X_GS = G.X_WO.inverse() * S.X_WO;
    if (method_ == Method::kFast) {
      return WalkFieldFlat(*S.data->samples, *G.data->field, X_GS, 0.0).num_colliding > 0;
    }
    return !QueryBruteForce(*S.data->points, *G.data->voxmap, X_GS, 0.0).empty();
  }

  // Whether a contact that is not found is below twice the error that the result tells, or below the field's own error,
  // a tenth of a voxel, at one sample. Of `paper` none is.
  [[nodiscard]] bool IsInDoubt(std::size_t pair) const {
    if (method_ != Method::kFast) return false;
    const PairDescription& d = world_->pair(pair);
    const WildBody& S = bodies_[d.sampled];
    const WildBody& G = bodies_[d.field];
    const SampleTree& samples = *S.data->samples;
    const FieldWalkResult walk = WalkFieldFlat(samples, *G.data->field, G.X_WO.inverse() * S.X_WO, 0.0);
    const double error_m3 =
        world_->result(pair).force_error_N / d.stiffness_N_per_m / AreaScale(0.0, 0.0, samples.area_m2, kRho);
    const double field_error_m3 = samples.area_m2 / samples.num_points * 0.1 * G.data->field->voxel_size_m;
    return walk.volume_m3 < std::max(2.0 * error_m3, field_error_m3);
  }

  // Of two balls the exact distance of S's surface from G, least where S is nearest to G's centre: of one in the middle
  // of the other nothing is deep. 1e9 for other pairs.
  [[nodiscard]] double BallDistance(std::size_t pair) const {
    const WildBody& S = bodies_[world_->pair(pair).sampled];
    const WildBody& G = bodies_[world_->pair(pair).field];
    if (S.radius_m == 0.0 || G.radius_m == 0.0) return 1e9;
    return std::abs(glm::distance(S.X_WO.translation, G.X_WO.translation) - S.radius_m) - G.radius_m;
  }

 private:
  double Signed() { return static_cast<double>(random_() >> 11) * 0x1p-52 - 1.0; }
  glm::dvec3 Inside(double half_m) { return half_m * glm::dvec3(Signed(), Signed(), Signed()); }

  void Decide(WildBody* body) {
    body->steps_left = static_cast<int>(random_() % 200);
    body->spin_W = glm::dvec3(30.0 * Signed() * Signed(), 30.0 * Signed() * Signed(), 30.0 * Signed() * Signed());
    if (body->mode == WildBody::Mode::kSwing) {
      const glm::dvec3 axis = Inside(1.0) + glm::dvec3(0.0, 0.0, 0.1);
      body->spin_W = 2.0 / (glm::length(axis) + 1e-9) * axis;
      body->pivot_m.x = random_() % 2 == 0 ? -0.5 : 0.0;
      return;
    }
    const std::uint64_t die = random_() % 16;
    body->prey = random_() % bodies_.size();
    if (die == 0) {  // jumps close to another
      body->X_WO.translation = glm::clamp(bodies_[body->prey].X_WO.translation + Inside(0.15), -kRoom_m, kRoom_m);
      body->mode = WildBody::Mode::kFly;
    } else if (die < 5) {
      body->mode = WildBody::Mode::kRest;
    } else if (die < 9) {
      body->mode = WildBody::Mode::kClose;
    } else {
      body->mode = WildBody::Mode::kFly;
      body->velocity_W = (die < 13 ? 0.3 : 3.0) * glm::dvec3(Signed(), Signed(), Signed());
      if (die == 9) body->spin_W = glm::dvec3(0.0);
    }
  }

  Method method_;
  std::mt19937_64 random_;
  std::vector<WildBody> bodies_;
  std::unique_ptr<CollisionWorld> world_;
};

struct WildCounts {
  std::uint64_t contacts = 0;
  std::uint64_t begins = 0;   // of contacts
  std::uint64_t skipped = 0;  // pairs not walked thanks to coherence
  std::uint64_t late = 0;     // touching, and not asked about in this cycle, or answered wrongly
  std::uint64_t too_far = 0;  // two balls are nearer than the signed distance by more than the method's error
  std::uint64_t missed = 0;   // two balls are deeper than the method's error, and not found
};

inline WildCounts RunWildly(Method method, std::uint64_t seed, int num_steps) {
  WildScene scene(method, seed);
  core::SerialFor serial;
  WildCounts counts;
  CollisionWorld& world = scene.world();
  std::vector<std::uint8_t> was_touching(world.num_pairs(), 0);
  // Error of a distance of two balls: 400 points on a ball of 50 mm leave holes of 9 mm radius, so (9 mm)^2 / 50 mm =
  // 1.6 mm, and 0.5 mm for the facets of the meshes; `paper` adds a voxel, 4 mm.
  const double max_error_m = method == Method::kFast ? 0.003 : 0.006;
  for (int step = 0; step < num_steps; ++step) {
    scene.Advance();
    counts.skipped += world.Step(&serial).pairs_coherent;
    for (std::size_t i = 0; i < world.num_pairs(); ++i) {
      const bool is_found = world.result(i).is_in_contact;
      const bool is_touching = scene.IsTouching(i);
      const double exact_m = scene.BallDistance(i);
      counts.contacts += is_touching ? 1 : 0;
      counts.begins += is_touching && was_touching[i] == 0 ? 1 : 0;
      counts.late += is_touching && !is_found && (!world.is_fresh(i) || !scene.IsInDoubt(i)) ? 1 : 0;
      counts.missed += exact_m < -max_error_m && !is_found ? 1 : 0;
      if (exact_m < 1e8 && !is_found && world.signed_distance_m(i) > exact_m + max_error_m) ++counts.too_far;
      was_touching[i] = is_touching ? 1 : 0;
    }
  }
  return counts;
}

}  // namespace vps::test
