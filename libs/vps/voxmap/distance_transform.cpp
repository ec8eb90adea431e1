#include "vps/voxmap/distance_transform.hpp"

#include <algorithm>

namespace vps {
namespace {

constexpr int kFar = kDistanceLimit * kDistanceLimit;

// Columns are copied a block of neighbours at a time, so that memory is read along x on every axis. 32 distances of 16
// bits are one cache line.
constexpr int kBlock = 32;

class Envelope {
 public:
  explicit Envelope(int length) : seeds_(length), starts_(length) {}

  // g[i] <- min over j of g[j] + (i - j)^2.
  void Run(int* g, int n) {
    // Seeds are kept whose parabola is lowest somewhere; starts_[k] is the first i at which seed k is. Parabolas a < b
    // meet at i = (b^2 - a^2 + g(b) - g(a)) / (2 (b - a)); b is lower from the next whole i on.
    int last = -1;
    for (int b = 0; b < n; ++b) {
      if (g[b] >= kFar) continue;
      int start = 0;
      while (last >= 0) {
        const int a = seeds_[last];
        const int numerator = b * b - a * a + g[b] - g[a];
        start = numerator < 0 ? 0 : numerator / (2 * (b - a)) + 1;
        if (start > starts_[last]) break;
        --last;
        start = 0;
      }
      if (start >= n) continue;
      ++last;
      seeds_[last] = b;
      starts_[last] = start;
    }
    if (last < 0) return;
    copy_.assign(g, g + n);
    int end = n;
    for (int k = last; k >= 0; --k) {
      const int seed = seeds_[k];
      for (int i = starts_[k]; i < end; ++i) {
        const int d = i - seed;
        g[i] = std::min(copy_[seed] + d * d, kFar);
      }
      end = std::min(end, starts_[k]);
    }
  }

 private:
  std::vector<int> seeds_, starts_, copy_;
};

// Transforms `count` neighbouring columns that start at `first` and step by `stride`, n long.
void TransformColumns(std::uint16_t* first, int count, std::size_t stride, int n, std::vector<int>* buffer,
                      Envelope* envelope) {
  bool is_near[kBlock] = {};
  for (int i = 0; i < n; ++i) {
    const std::uint16_t* row = first + static_cast<std::size_t>(i) * stride;
    for (int c = 0; c < count; ++c) {
      (*buffer)[static_cast<std::size_t>(c) * n + i] = row[c];
      is_near[c] |= row[c] < kFar;
    }
  }
  bool any = false;
  for (int c = 0; c < count; ++c) {
    if (is_near[c]) envelope->Run(buffer->data() + static_cast<std::size_t>(c) * n, n);
    any |= is_near[c];
  }
  if (!any) return;
  for (int i = 0; i < n; ++i) {
    std::uint16_t* row = first + static_cast<std::size_t>(i) * stride;
    for (int c = 0; c < count; ++c) row[c] = static_cast<std::uint16_t>((*buffer)[static_cast<std::size_t>(c) * n + i]);
  }
}

}  // namespace

std::vector<std::uint16_t> SquaredDistances(const std::vector<std::uint8_t>& state, std::uint8_t mark, int nx, int ny,
                                            int nz, const std::function<void(double)>& progress) {
  std::vector<std::uint16_t> squared(state.size());
  const std::size_t slice = static_cast<std::size_t>(nx) * ny;
  for (std::size_t row = 0; row < static_cast<std::size_t>(ny) * nz; ++row) {
    const std::uint8_t* s = state.data() + row * nx;
    std::uint16_t* out = squared.data() + row * nx;
    int d = kDistanceLimit;
    for (int x = 0; x < nx; ++x) {
      d = s[x] == mark ? 0 : std::min(d + 1, kDistanceLimit);
      out[x] = static_cast<std::uint16_t>(d);
    }
    d = kDistanceLimit;
    for (int x = nx - 1; x >= 0; --x) {
      d = s[x] == mark ? 0 : std::min(d + 1, kDistanceLimit);
      const int nearest = std::min<int>(d, out[x]);
      out[x] = static_cast<std::uint16_t>(nearest * nearest);
    }
  }
  Envelope envelope(std::max(ny, nz));
  std::vector<int> buffer(static_cast<std::size_t>(kBlock) * std::max(ny, nz));
  for (int z = 0; z < nz; ++z) {
    for (int x = 0; x < nx; x += kBlock) {
      TransformColumns(squared.data() + z * slice + x, std::min(kBlock, nx - x), nx, ny, &buffer, &envelope);
    }
    if (z % 16 == 0) progress(0.5 * z / nz);
  }
  for (int y = 0; y < ny; ++y) {
    for (int x = 0; x < nx; x += kBlock) {
      TransformColumns(squared.data() + static_cast<std::size_t>(y) * nx + x, std::min(kBlock, nx - x), slice, nz,
                       &buffer, &envelope);
    }
    if (y % 16 == 0) progress(0.5 + 0.5 * y / ny);
  }
  return squared;
}

}  // namespace vps
