#pragma once

#include <array>
#include <cstddef>

namespace muscle {

// Eight electrode pairs, evenly round the upper forearm [VR-OOS, section 4], a thousand samples a second.
constexpr std::size_t kNumChannels = 8;
constexpr double kSample_s = 0.001;
constexpr double kFullScale_V = 5e-3;  // of the amplifier: beyond, it saturates. A usual range; no device was there

using EmgFrame = std::array<double, kNumChannels>;  // [V], of one instant

}  // namespace muscle
