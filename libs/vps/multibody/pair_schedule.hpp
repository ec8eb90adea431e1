#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "core/pose.hpp"
#include "vps/multibody/pair_bits.hpp"

namespace vps {

// Broad phase by temporal coherence: selects the pairs of moving objects that have to be tested in a cycle, without
// touching the others.
//
// Every object has an odometer: the path length of its fastest point, rotation included. A pair that was found apart by
// d [m] cannot touch before the two odometers have together advanced by d. That free distance is shared: each of the
// two objects gets a reading up to which it may run, and keeps the least of all its pairs' readings. So a cycle
// compares one number per object; only when an odometer passes its least reading are that object's pairs visited. Pairs
// whose reading is passed share the rest of their free distance anew, or, when none is left, are selected. The faster
// object gets the larger share. Only real displacements count, no speed or acceleration is assumed: an object that is
// thrown, jumps or turns faster than before passes its readings in that very cycle.
//
// Proof, with odometers a and b that stood at a0 and b0: they only grow, so while a < a0 + x and b < b0 + y with
// x + y <= d, the distance of no two points has shrunk by d.
class PairSchedule {
 public:
  // Adds an object whose points lie within `radius_m` around `centre_m` (object frame).
  void AddObject(const core::Pose& X_WO, const glm::dvec3& centre_m, double radius_m);
  // Adds a pair; contact reaches `zone_m` beyond the surface of `b`. It is selected in its first cycle.
  void AddPair(std::uint32_t a, std::uint32_t b, double zone_m);
  // Once, after the last pair.
  void Finish();

  void SetPose(std::size_t object, const core::Pose& X_WO);
  [[nodiscard]] const core::Pose& X_WO(std::size_t object) const { return objects_[object].X_WO; }

  // The pairs to test, ascending; valid until the next call. One call a cycle, after the poses are set.
  const std::vector<std::uint32_t>& Collect();
  // Sets the state of a pair, which holds until the next of these calls for it. The pair is selected ...
  void Rest(std::size_t pair, double free_m);        // when its objects have used up `free_m` > 0
  void Hold(std::size_t pair);                       // in every cycle
  void Wake(std::size_t pair) { woken_.Set(pair); }  // in the next cycle and until Rest, Hold or Stop
  void Stop(std::size_t pair);                       // never

  // Free distance left to a resting pair [m]; of a held one minus the travel since Hold.
  [[nodiscard]] double FreeDistance_m(std::size_t pair) const {
    const Pair& p = pairs_[pair];
    return p.free_m - (objects_[p.a].travel_m + objects_[p.b].travel_m - p.travel_m);
  }
  // Distance of the two balls less the zone: how far the objects can move before they can touch. Negative: unknown.
  [[nodiscard]] double BallGap(std::size_t pair) const;
  // Whether one of the two objects has moved between the last two calls of Collect.
  [[nodiscard]] bool HasMoved(std::size_t pair) const {
    return objects_[pairs_[pair].a].has_moved || objects_[pairs_[pair].b].has_moved;
  }
  // Path length of the object's fastest point in the last cycle, rotation included.
  [[nodiscard]] double Pace_m(std::size_t object) const {
    return objects_[object].has_moved ? objects_[object].pace_m : 0.0;
  }
  [[nodiscard]] std::uint32_t a(std::size_t pair) const { return pairs_[pair].a; }
  [[nodiscard]] std::uint32_t b(std::size_t pair) const { return pairs_[pair].b; }

 private:
  static constexpr double kNever = std::numeric_limits<double>::infinity();

  struct Object {
    core::Pose X_WO;
    glm::dvec3 centre_m{0.0};    // object frame
    glm::dvec3 centre_W{0.0};    // m
    double radius_m = 0.0;       // holds the object
    double reach_m = 0.0;        // holds its zones too
    double travel_m = 0.0;       // odometer
    double travel_then_m = 0.0;  // at the last Collect
    double pace_m = 0.0;         // of the last cycle in which it moved
    double least_reading_m = kNever;
    bool has_moved = false;
    std::vector<double> readings_m{};  // one for each of its pairs
    std::vector<std::uint32_t> pairs{};
  };
  struct Pair {
    std::uint32_t a = 0;
    std::uint32_t b = 0;
    std::uint32_t slot_a = 0;  // in the objects' lists
    std::uint32_t slot_b = 0;
    double zone_m = 0.0;
    double free_m = 0.0;
    double travel_m = 0.0;  // sum of both odometers when `free_m` was found
  };

  void FindPassed(Object* object);
  void SetReadings(const Pair& pair, double a_m, double b_m);
  void ShareOut(std::size_t pair, double free_distance_m);

  std::vector<Object> objects_;
  std::vector<Pair> pairs_;
  PairBits passed_;  // a reading of theirs was passed in this cycle
  PairBits woken_;   // free distance used up, or woken
  PairBits held_;
  PairBits selected_;
  std::vector<std::uint32_t> due_;
};

}  // namespace vps
