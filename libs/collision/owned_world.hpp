#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/parallel_for.hpp"
#include "core/result.hpp"
#include "scene/scenario.hpp"
#include "vps/multibody/collision_world.hpp"

namespace collision {

struct Options {
  std::filesystem::path cache;                            // of cooked structures; empty: the default folder
  std::function<void(const std::string& line)> progress;  // while cooking
};

// The contact of a scenario that one node computes. The world's objects are the scenario's, its pairs only that node's.
struct OwnedWorld {
  std::unique_ptr<vps::CollisionWorld> world;
  std::vector<std::uint16_t> scenario_pair;                    // of each of the world's pairs, ascending
  std::vector<std::shared_ptr<const vps::CookedObject>> data;  // per object; null: in no pair of this node
};

// Cooks (or takes from the cache) the structures that the owner's pairs ask for, and nothing else.
// A hand's pairs have the stiffness k_f of the coupling: physics_node evaluates a hand's planes at the device pose D,
// and with k_f there it pushes the object by what the spring from D to C makes the hand feel.
core::Result<OwnedWorld> BuildOwnedWorld(const scene::Scenario& scenario, scene::PairOwner owner,
                                         core::ParallelFor& workers, const Options& options);

// Whether there is something to tell about a pair of the world in this cycle; then `set` is filled but for its cycle.
// A contact that has ended is told a few times as an empty set: datagrams get lost. `empty_sets_left` belongs to the
// pair and starts at 0.
bool TellContact(const vps::CollisionWorld& world, std::size_t pair, std::uint16_t scenario_pair, int* empty_sets_left,
                 core::ContactSet* set);

}  // namespace collision
