// F1: tools pushed through thin and open parts.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <stdexcept>

#include "tools/failures/for_all.hpp"
#include "tools/failures/loop.hpp"
#include "tools/failures/studies/studies.hpp"
#include "tools/failures/tool_on_plate.hpp"
#include "vps/testing/shapes.hpp"

namespace failures {
namespace {

constexpr double kThickness_m = 5e-4;
constexpr double kStart_m = 0.02;  // of the tool's origin, over its own reach
constexpr double kPast_m = 0.05;
constexpr double kSide_m = 0.3;        // of the plate
constexpr double kThinVoxel_m = 5e-4;  // as thin as it is
constexpr double kResolution_m = 1e-10;

struct Tool {
  const char* name;
  vps::TriangleMesh mesh;
};

std::vector<Tool> Tools() {
  return {{"ball", vps::MakeSphere(0.01, 48)},
          {"box", vps::MakeBox({0.02, 0.02, 0.02})},
          {"handle", vps::MakeBox({0.1, 0.02, 0.015})}};
}

vps::TriangleMesh OpenSheet() {
  const double h = 0.5 * kSide_m;
  return {{{-h, -h, 0}, {h, -h, 0}, {h, h, 0}, {-h, h, 0}}, {{0, 1, 2}, {0, 2, 3}}};
}

struct Speed {
  double m_per_s;
  int directions;
  double bound;  // of the penetration shown, in voxels
};
constexpr Speed kSpeeds[] = {{0.05, 50, 0.1}, {0.2, 200, 0.1}, {1.0, 1000, 0.25}};

struct Passage {
  bool is_refused = false;  // the part, when it was cooked
  int flips = 0;
  double deepest_m = 0.0;
};

// The tool's lowest corner below the plane z = 0, of the side that it came from.
double Below_m(const vps::TriangleMesh& tool, const core::Pose& X_WT, double side) {
  double lowest = 1e9;
  for (const glm::dvec3& v : tool.vertices) lowest = std::min(lowest, side * (X_WT * v).z);
  return -lowest;
}

// The part of a polygon on which sign * p[axis] <= most_m.
void Clip(int axis, double sign, double most_m, std::vector<glm::dvec3>* polygon) {
  std::vector<glm::dvec3> kept;
  for (std::size_t i = 0; i < polygon->size(); ++i) {
    const glm::dvec3& a = (*polygon)[i];
    const glm::dvec3& b = (*polygon)[(i + 1) % polygon->size()];
    const double over_a = sign * a[axis] - most_m;
    const double over_b = sign * b[axis] - most_m;
    if (over_a <= 0.0) kept.push_back(a);
    if ((over_a <= 0.0) != (over_b <= 0.0)) kept.push_back(a + over_a / (over_a - over_b) * (b - a));
  }
  *polygon = kept;
}

// Whether a point of the tool's surface is deeper in the plate than this, by the ways out on the side that it came from
// and over the rims: a long tool that comes in flat starts beside the plate, is lower there, and meets its rim.
bool IsDeeper(const vps::TriangleMesh& tool, const core::Pose& X_WT, double side, double depth_m) {
  for (std::size_t t = 0; t < tool.triangles.size(); ++t) {
    const auto [a, b, c] = tool.corners(t);
    std::vector<glm::dvec3> polygon{X_WT * a, X_WT * b, X_WT * c};
    Clip(2, side, 0.5 * kThickness_m - depth_m, &polygon);
    for (const int axis : {0, 1}) {
      for (const double sign : {1.0, -1.0}) Clip(axis, sign, 0.5 * kSide_m - depth_m, &polygon);
    }
    if (!polygon.empty()) return true;
  }
  return false;
}

// That depth, by bisection: what is wholly over the plate can only go up.
double DepthInPlate_m(const vps::TriangleMesh& tool, const core::Pose& X_WT, double side) {
  double low_m = 0.0;
  double high_m = Below_m(tool, X_WT, side) + 0.5 * kThickness_m;
  if (high_m <= 0.0 || !IsDeeper(tool, X_WT, side, low_m)) return 0.0;
  if (IsDeeper(tool, X_WT, side, high_m - kResolution_m)) return high_m;
  while (high_m - low_m > kResolution_m) {
    const double middle_m = 0.5 * (low_m + high_m);
    (IsDeeper(tool, X_WT, side, middle_m) ? low_m : high_m) = middle_m;
  }
  return high_m;
}

vps::TriangleMesh Part(bool is_open) {
  return is_open ? OpenSheet() : vps::MakeBox({kSide_m, kSide_m, kThickness_m});
}
const core::Pose kAway{{1, 0, 0, 0}, {0, 0, 0.1}};

// `loop`: of this project's nodes, or of a peer.
template <class AnyLoop>
Passage PushThrough(AnyLoop& loop, const Tool& tool, const Speed& speed) {
  std::mt19937_64 engine(11);
  const auto uniform = [&engine](double low, double high) {
    return low + (high - low) * static_cast<double>(engine() >> 11) * 0x1.0p-53;
  };
  Passage passage;
  for (int i = 0; i < speed.directions; ++i) {
    const double side = i % 2 == 0 ? 1.0 : -1.0;
    const double azimuth = uniform(0.0, 2.0 * std::numbers::pi);
    const double steep = uniform(0.3, 0.5 * std::numbers::pi);  // from grazing to straight on
    const glm::dvec3 way(std::cos(azimuth) * std::cos(steep), std::sin(azimuth) * std::cos(steep),
                         -side * std::sin(steep));
    const glm::dquat turned =
        core::QuaternionFromRotationVector({uniform(-1.8, 1.8), uniform(-1.8, 1.8), uniform(-1.8, 1.8)});
    const double reach = Below_m(tool.mesh, {turned, {0, 0, 0}}, side);
    const double to_plate = (kStart_m + reach) / std::sin(steep);
    core::Pose X_WD{turned, {uniform(-0.02, 0.02), uniform(-0.02, 0.02), 0.0}};
    X_WD.translation -= to_plate * way;
    loop.LetGo(X_WD);
    const double step = 1e-3 * speed.m_per_s;
    const int num_steps = static_cast<int>(std::ceil((to_plate + kPast_m) / step));
    for (int k = 0; k < num_steps; ++k) {
      X_WD.translation += step * way;
      loop.Tick(X_WD);
      passage.deepest_m = std::max(passage.deepest_m, DepthInPlate_m(tool.mesh, loop.X_WC(), side));
    }
    if (side * loop.X_WC().translation.z < 0.0) ++passage.flips;
  }
  return passage;
}

Passage Push(const Variant& variant, const Tool& tool, bool is_open, const Speed& speed) {
  SceneKit kit(variant);
  const auto field = kit.AddFixed(Part(is_open), {}, kThinVoxel_m);
  if (is_open) kit.scenario.objects[field].sheet_thickness_m = kThickness_m;
  const auto hand = kit.AddHand(tool.mesh, kAway, kToolPoints);
  kit.AddPair(hand, field);
  Loop loop(kit.scenario);
  return PushThrough(loop, tool, speed);
}

Passage PushInPeer(const Peer& peer, const Tool& tool, bool is_open, const Speed& speed) {
  const auto loop = peer.make_loop(0.0);
  loop->AddFixed(Part(is_open), {});
  loop->AddTool(tool.mesh, kAway);
  return PushThrough(*loop, tool, speed);
}

Passage TryToPush(const Variant& variant, const Tool& tool, bool is_open, const Speed& speed) {
  try {
    return Push(variant, tool, is_open, speed);
  } catch (const std::runtime_error& refusal) {
    std::printf("%s\n", refusal.what());
    return {.is_refused = true};
  }
}

}  // namespace

void StudyThin(const Peers& peers, Report* report) {
  struct Case {
    bool is_open;
    const Speed* speed;
    const Variant* variant;  // null: of the peer
    const Peer* peer;
    const Tool* tool;
    Passage passage;
  };
  const std::vector<Tool> tools = Tools();
  std::vector<Case> cases;
  for (const bool is_open : {false, true}) {
    for (const Speed& speed : kSpeeds) {
      for (const Variant& variant : Variants()) {
        for (const Tool& tool : tools) cases.push_back({is_open, &speed, &variant, nullptr, &tool, {}});
      }
      for (const Peer& peer : peers) {
        if (is_open && !peer.takes_concave) continue;
        for (const Tool& tool : tools) cases.push_back({is_open, &speed, nullptr, &peer, &tool, {}});
      }
    }
  }
  ForAll(cases.size(), [&cases](std::size_t i) {
    Case& one = cases[i];
    one.passage = one.variant == nullptr ? PushInPeer(*one.peer, *one.tool, one.is_open, *one.speed)
                                         : TryToPush(*one.variant, *one.tool, one.is_open, *one.speed);
  });
  Table table{"thin", {"part", "speed_m_per_s", "contender", "tool", "flips", "deepest_voxels"}, {}};
  auto one = cases.begin();
  while (one != cases.end()) {
    const std::string what = one->is_open ? "open sheet, taken as 0.5 mm thick" : "plate of 0.5 mm";
    const Speed& speed = *one->speed;
    Row flips{"F1",
              "tunnelling",
              "ball, box, handle pushed 50 mm past a " + what + ", " + Short(speed.m_per_s) + " m/s, " +
                  std::to_string(speed.directions) + " directions each",
              "tools on the other side",
              "0",
              {},
              "a tool that is more than half through is pushed out on the far side"};
    Row depth = flips;
    depth.observable = "deepest penetration shown, in voxels of 0.5 mm";
    depth.bound = "<= " + Short(speed.bound);
    depth.why = "coupling `paper`: the proxy rests half a voxel inside, and a thin plate's inside is less than that";
    const bool is_open = one->is_open;
    while (one != cases.end() && one->is_open == is_open && one->speed == &speed) {
      const std::string name = one->variant == nullptr ? one->peer->name : one->variant->name;
      Passage worst;
      for (const Tool& tool : tools) {
        worst.is_refused = worst.is_refused || one->passage.is_refused;
        worst.flips += one->passage.flips;
        worst.deepest_m = std::max(worst.deepest_m, one->passage.deepest_m);
        table.Add({what, bench::Cell(speed.m_per_s), name, tool.name,
                   one->passage.is_refused ? "" : std::to_string(one->passage.flips),
                   one->passage.is_refused ? "" : bench::Cell(one->passage.deepest_m / kThinVoxel_m)});
        ++one;
      }
      if (worst.is_refused) {
        for (Row* row : {&flips, &depth}) row->readings.push_back({name, "refused: too thin", false});
        continue;
      }
      flips.readings.push_back({name, std::to_string(worst.flips), worst.flips == 0});
      depth.readings.push_back(
          {name, Short(worst.deepest_m / kThinVoxel_m), worst.deepest_m <= speed.bound * kThinVoxel_m});
    }
    AddRow(report, flips);
    AddRow(report, depth);
  }
  report->tables.push_back(table);
}

}  // namespace failures
