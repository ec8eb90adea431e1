#pragma once

#include <vector>

#include "tools/contact/methods/method.hpp"
#include "tools/contact/workload.hpp"

namespace contact {

// Exact answers at the independent poses, computed on two threads. Conforming contact: exact distances at 200,000 even
// points of B's surface, at most 1 mm deep, since refining the integral of a whole pressed side takes half a minute a
// pose; its depth is that of B's points. Else vps/oracle's refined integral to 1e-3 and the depth of both surfaces.
std::vector<Answer> ExactAnswers(const Parts& parts, const Workload& workload);

}  // namespace contact
