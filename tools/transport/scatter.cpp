#include "tools/transport/scatter.hpp"

#include <algorithm>
#include <cmath>

#include "tools/bench/one_core.hpp"
#include "tools/bench/table.hpp"

namespace transport {
namespace {

// Place of the bound, counted from either end of `count` sorted values: the true median lies beyond it with probability
// at most 1/40. 0 if there is no such place.
std::size_t PlaceOfBound(std::size_t count) {
  double probability = std::pow(0.5, static_cast<double>(count));  // that just `place` values lie below the median
  double sum = 0.0;
  for (std::size_t place = 0; place <= count / 2; ++place) {
    sum += probability;
    if (sum > 0.025) return place;
    probability *= static_cast<double>(count - place) / static_cast<double>(place + 1);
  }
  return count / 2;
}

}  // namespace

Scatter ScatterOf(std::vector<double> values) {
  values.erase(std::remove_if(values.begin(), values.end(), [](double value) { return std::isnan(value); }),
               values.end());
  std::sort(values.begin(), values.end());
  Scatter scatter;
  if (values.empty()) return scatter;
  scatter.median = bench::Quantile(values, 0.5);
  const std::size_t place = PlaceOfBound(values.size());
  if (place > 0) {
    scatter.low = values[place - 1];
    scatter.high = values[values.size() - place];
  }
  return scatter;
}

Scatter ScatterOfDifference(const std::vector<double>& one, const std::vector<double>& other) {
  std::vector<double> differences;
  for (std::size_t i = 0; i < std::min(one.size(), other.size()); ++i) differences.push_back(one[i] - other[i]);
  return ScatterOf(std::move(differences));
}

std::string DifferenceText(const Scatter& difference, const std::string& unit) {
  const std::string bounds = bench::Short(difference.low) + " to " + bench::Short(difference.high);
  if (difference.excludes_zero()) return bench::Short(difference.median) + " " + unit + " (" + bounds + ")";
  return "none beyond the scatter (" + bounds + " " + unit + ")";
}

}  // namespace transport
