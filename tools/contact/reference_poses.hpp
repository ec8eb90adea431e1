#pragma once

#include <vector>

#include "vps/testing/reference_wrench.hpp"
#include "vps/testing/wrench_cases.hpp"

namespace contact {

// A pose of a case with the exact wrench.
struct ReferencePose {
  vps::ContactPose pose;
  std::size_t number = 0;  // within the case
  vps::oracle::ContactWrench reference;
};

// Those poses of a case at which the parts touch and whose reference has converged, on two threads. *num_without counts
// the poses without a reference.
std::vector<ReferencePose> WithReferences(const vps::WrenchCase& c, int* num_without);

}  // namespace contact
