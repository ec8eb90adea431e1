#pragma once

#include <limits>
#include <string>
#include <vector>

namespace transport {

// A median, and the bounds between which the true one lies 19 times of 20: order statistics, as in the sign test, which
// ask nothing of the distribution but that one value tells nothing of the next.
struct Scatter {
  double median = std::numeric_limits<double>::quiet_NaN();
  double low = std::numeric_limits<double>::quiet_NaN();  // NaN: fewer than six values bound nothing
  double high = std::numeric_limits<double>::quiet_NaN();

  [[nodiscard]] bool excludes_zero() const { return low > 0.0 || high < 0.0; }
};

// NaN is passed over.
Scatter ScatterOf(std::vector<double> values);
// Of one[i] - other[i], which were measured in the same round: what both share in it cancels.
Scatter ScatterOfDifference(const std::vector<double>& one, const std::vector<double>& other);
// "0.81 us (0.42 to 1.3)"; a difference within its scatter is none: "none beyond the scatter (-0.9 to 1.2 us)".
std::string DifferenceText(const Scatter& difference, const std::string& unit);

}  // namespace transport
