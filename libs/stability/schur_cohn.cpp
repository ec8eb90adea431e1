#include "stability/schur_cohn.hpp"

#include <cmath>
#include <cstddef>

namespace stability {

bool AreRootsInsideUnitCircle(std::span<double> a) noexcept {
  for (std::size_t n = a.size() - 1; n >= 1; --n) {
    const double k = a[0] / a[n];
    if (!(std::abs(k) < 1.0)) return false;  // also when it is not a number
    // Pairs i, n - i of a(z) - k z^n a(1/z), then a division by z. In place: a[0] becomes zero and leaves.
    for (std::size_t i = 0, j = n; i <= j; ++i, --j) {
      const double low = a[i] - k * a[j];
      const double high = a[j] - k * a[i];
      a[i] = low;
      a[j] = high;
    }
    for (std::size_t i = 0; i < n; ++i) a[i] = a[i + 1];
  }
  return true;
}

}  // namespace stability
