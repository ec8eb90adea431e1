#pragma once

#include <optional>
#include <string>

#include "tools/contact/methods/method.hpp"

namespace contact {

// Which of two bodies is sampled, and how finely. Where a contact is not wide against its depth, the wrench depends on
// the former, so every method makes the same choice.
struct Setup {
  bool is_A_sampled = false;  // A's surface in B's field; else B's in A's
  Resolution resolution;
  std::string text;  // one line: what was chosen, and what chose it
};

// What the caller has decided; the rest is chosen from the meshes: the sampled body by vps::IsFirstSampled, the
// resolution by vps::ChooseVoxel and ChoosePoints, within the sizes that a scenario may have.
struct SetupWish {
  std::optional<vps::Method> method = vps::Method::kFast;  // none: the oracle, which takes no resolution
  double accuracy = kAccuracy;
  Resolution given;  // zero: chosen
  std::optional<bool> is_A_sampled;
};
Setup ChooseSetup(const vps::TriangleMesh& A, const vps::TriangleMesh& B, const SetupWish& wish);

// The method for A and B made of one for B and A, which samples A: its wrench on A in B's frame about A's mesh origin
// becomes that on B in A's frame about B's.
std::unique_ptr<Method> Turned(std::unique_ptr<Method> of_B_and_A);

}  // namespace contact
