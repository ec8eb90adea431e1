#pragma once

#include <string>

namespace scene {

// Why a run ended before its procedure did, e.g. "limit of 0.5 s reached in step 'approach'". `step` may be empty.
std::string LimitReached(double limit_s, const std::string& step);

}  // namespace scene
