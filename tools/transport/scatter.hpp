#pragma once

#include <limits>
#include <string>
#include <vector>

namespace transport {

// A sample median and the 95 % confidence interval of the true median, by order statistics as in the sign test. Assumes
// that the values are independent, and nothing else of their distribution.
struct Scatter {
  double median = std::numeric_limits<double>::quiet_NaN();
  double low = std::numeric_limits<double>::quiet_NaN();  // NaN: fewer than six values bound nothing
  double high = std::numeric_limits<double>::quiet_NaN();

  [[nodiscard]] bool excludes_zero() const { return low > 0.0 || high < 0.0; }
};

// Ignores NaN.
Scatter ScatterOf(std::vector<double> values);
// Scatter of one[i] - other[i]. Both were measured in round i, so disturbances common to the round cancel.
Scatter ScatterOfDifference(const std::vector<double>& one, const std::vector<double>& other);
// "0.81 us (0.42 to 1.3)", or "none beyond the scatter (-0.9 to 1.2 us)" if the interval contains zero.
std::string DifferenceText(const Scatter& difference, const std::string& unit);

}  // namespace transport
