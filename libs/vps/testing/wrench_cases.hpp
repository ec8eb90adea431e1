#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "vps/mesh/triangle_mesh.hpp"
#include "vps/testing/contact_poses.hpp"

namespace vps {

// Constants of a method may be chosen on the training set. The held-out set is only reported: a figure of it that is
// bad says that the method is, and nothing may be changed until that one figure is good.
enum class CaseSet { kTraining, kHeldOut };
constexpr CaseSet kCaseSets[] = {CaseSet::kTraining, CaseSet::kHeldOut};
std::string_view ToText(CaseSet set);

// Two parts and how they touch. A is the field's side, B the sampled one; both have their origin inside or in the
// middle.
struct WrenchCase {
  std::string family;
  CaseSet set = CaseSet::kTraining;
  std::string name;  // within the family and the set
  TriangleMesh A, B;
  std::vector<ContactPose> poses;
};

// Generated: bevelled, threaded, thin_walled, sharp, sheets, needles, long_edges, pegs, scanned, remeshed. From files:
// public.
const std::vector<std::string>& WrenchFamilies();

// A family's cases of a set, each with `poses_each` poses of every kind. The two sets of a generated family are
// different draws from the same ranges of sizes; in every second case the roles of the parts are exchanged. Public
// meshes are split by file: those that the older benchmarks have (bunny, fandisk, gear, nut and bolt) are for training,
// the Factory pegs and holes are held out. The same cases at every call. Errors: an unknown family, a mesh file that is
// missing or refused.
core::Result<std::vector<WrenchCase>> MakeWrenchCases(const std::string& family, CaseSet set, int poses_each,
                                                      const std::filesystem::path& public_meshes);

}  // namespace vps
