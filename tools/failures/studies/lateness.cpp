// F16: the first cycle in which two parts overlap is the first that reports a contact, however fast they come.
#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/failures/loop.hpp"
#include "tools/failures/studies/studies.hpp"
#include "tools/failures/tool_on_plate.hpp"
#include "vps/oracle/body_distance.hpp"
#include "vps/testing/shapes.hpp"

namespace failures {
namespace {

constexpr int kNever = std::numeric_limits<int>::max();

// Cycles from the first overlap of the device's tool to the first force.
int FirstForce(const Variant& variant, const vps::TriangleMesh& field, const core::Pose& X_WE,
               const vps::TriangleMesh& tool, const std::function<core::Pose(double t_s)>& device) {
  SceneKit kit(variant);
  const auto fixed = kit.AddFixed(field, X_WE, kVoxel_m);
  const auto hand = kit.AddHand(tool, device(0.0), kToolPoints);
  kit.AddPair(hand, fixed);
  Loop loop(kit.scenario);
  const vps::oracle::MeshDistance exact_E(field);
  const vps::oracle::MeshDistance exact_T(tool);
  int overlap = kNever;
  for (int i = 0; i < 1500; ++i) {
    const core::Pose X_WD = device(1e-3 * i);
    loop.Tick(X_WD);
    if (overlap == kNever &&
        vps::oracle::SignedBodyDistance(exact_E, exact_T, X_WE.inverse() * X_WD).signed_distance_m < -1e-6) {
      overlap = i;
    }
    if (glm::length(loop.command().force_N) > 0.0) return overlap == kNever ? 0 : i - overlap;
    if (overlap != kNever && i > overlap + 50) break;
  }
  return kNever;
}

// A free part flies at a fixed plate at 3 m/s, or at a hand that comes to meet it at 1 m/s with 1 m/s of its own.
int FirstContactOfBody(const Variant& variant, double speed_m_per_s, double hand_m_per_s) {
  SceneKit kit(variant);
  const vps::TriangleMesh part = vps::MakeBox(glm::dvec3(0.04));
  const auto body = kit.AddBody(part, {{1, 0, 0, 0}, {0, 0, 0.3}}, 0.5, 0.0, kToolPoints);
  kit.scenario.objects[body].V_WO.linear_m_per_s = {0, 0, -speed_m_per_s};
  const vps::TriangleMesh target = vps::MakeBox({0.1, 0.1, 0.04});
  const bool has_hand = hand_m_per_s > 0.0;
  if (has_hand) {
    kit.scenario.objects[body].voxel_size_m = kVoxel_m;
    const auto hand = kit.AddHand(target, {}, kToolPoints);
    kit.AddPair(hand, body);
  } else {
    const auto plate = kit.AddFixed(target, {}, kVoxel_m);
    kit.AddIdleHand();
    kit.AddPair(body, plate);
  }
  Loop loop(kit.scenario);
  double known_z = 0.3;  // of the part, as haptic_node has it
  int overlap = kNever;
  for (int i = 0; i < 400; ++i) {
    const double z = has_hand ? 1e-3 * hand_m_per_s * i : 0.0;
    if (has_hand) {
      loop.Tick({{1, 0, 0, 0}, {0, 0, z}});
    } else {
      loop.Tick();
    }
    if (overlap == kNever && known_z - z < 0.04 - 1e-6) overlap = i;
    if (loop.haptic().is_in_contact) return overlap == kNever ? 0 : i - overlap;
    known_z = loop.body(body).X_WO.translation.z;
    if (overlap != kNever && i > overlap + 50) break;
  }
  return kNever;
}

Reading Lateness(const Variant& variant, int cycles) {
  return {variant.name, cycles == kNever ? "never" : std::to_string(cycles), cycles <= 1};
}

}  // namespace

void StudyLateness(Report* report) {
  Row hand{"F16",
           "honest coherence",
           "hand at 2 m/s into a box",
           "cycles from the first overlap to the first force",
           "<= 1",
           {},
           "a pair that was found apart is not tested in time"};
  Row bar = hand;
  bar.set_up = "tool of 1 m that turns at 2 rad/s into a post";
  Row flung = hand;
  flung.set_up = "part flung at a plate at 3 m/s";
  flung.observable = "cycles from the first overlap to the first contact";
  Row met = flung;
  met.set_up = "part at 1 m/s towards a hand at 1 m/s";
  for (const Variant& variant : Variants()) {
    hand.readings.push_back(Lateness(
        variant, FirstForce(variant, vps::MakeBox({0.1, 0.1, 0.04}), {}, vps::MakeSphere(kBall_m, 64), [](double t_s) {
          return core::Pose{{1, 0, 0, 0}, {0, 0, 1.0003 - 2.0 * t_s}};
        })));
    bar.readings.push_back(Lateness(
        variant, FirstForce(variant, vps::MakeBox({0.05, 0.05, 0.2}), {{1, 0, 0, 0}, {0, 0.95, 0}},
                            vps::MakeBox({2.0, 0.02, 0.02}), [](double t_s) {
                              return core::Pose{core::QuaternionFromRotationVector({0, 0, 2.0 * t_s}), {0, 0, 0}};
                            })));
    flung.readings.push_back(Lateness(variant, FirstContactOfBody(variant, 3.0, 0.0)));
    met.readings.push_back(Lateness(variant, FirstContactOfBody(variant, 1.0, 1.0)));
  }
  for (const Row& row : {hand, bar, flung, met}) AddRow(report, row);
}

}  // namespace failures
