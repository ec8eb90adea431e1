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

// The collision world of one node. Its objects are those of the scenario, its pairs only those that the node computes.
struct OwnedWorld {
  std::unique_ptr<vps::CollisionWorld> world;
  std::vector<std::uint16_t> scenario_pair;                    // of each of the world's pairs, ascending
  std::vector<std::shared_ptr<const vps::CookedObject>> data;  // per object; null: in no pair of this node
};

// Cooks (or takes from the cache) the structures that the owner's pairs require, and nothing else. Errors: those of
// Cook and CollisionWorld::Create, with the object's name. A hand's pairs have the stiffness k_f of the coupling:
// physics_node evaluates a hand's planes at the device pose D, so that with k_f it pushes the object with the force of
// the spring from D to C on the hand.
core::Result<OwnedWorld> BuildOwnedWorld(const scene::Scenario& scenario, scene::PairOwner owner,
                                         core::ParallelFor& workers, const Options& options);

// Fills `set`, but for its header, with the contact of a pair of the world, and returns whether it is to be published
// in this cycle. A contact that has ended is published a few times as an empty set, because datagrams get lost.
// `empty_sets_left` belongs to the pair and starts at 0.
bool FillContactUpdate(const vps::CollisionWorld& world, std::size_t pair, std::uint16_t scenario_pair,
                       int* empty_sets_left, core::ContactSet* set);

}  // namespace collision
