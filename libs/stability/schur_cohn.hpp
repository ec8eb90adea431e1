#pragma once

#include <span>

namespace stability {

// Whether all roots of sum_i a[i] z^i lie inside the unit circle, by the Schur-Cohn (Jury) recursion: with
// k = a[0] / a[n], |k| < 1 is necessary, and (a(z) - k z^n a(1/z)) / z has the remaining n - 1 roots to test.
// `a` is working memory. Real-time: no allocation.
bool AreRootsInsideUnitCircle(std::span<double> a) noexcept;

}  // namespace stability
