#pragma once

#include <vector>

#include "tools/contact/methods/method.hpp"
#include "tools/contact/workload.hpp"

namespace contact {

// Reference answers at the independent poses, computed on two threads. Conforming contact: quadrature over 200,000 even
// points of B's surface with exact depths up to 1 mm, because adaptive refinement over a whole pressed side takes half
// a minute a pose; the depth is the greatest of B's points. Other contact: vps/oracle's adaptive integral, to a
// relative 1e-3, and the greatest depth of both surfaces.
std::vector<Answer> ExactAnswers(const Parts& parts, const Workload& workload);

}  // namespace contact
