#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "space/stars/star_field.hpp"

namespace space {
namespace {

// Stars spread evenly over the sky; the argument is how many.
void BM_Splat(benchmark::State& state) {
  std::vector<Star> stars;
  const auto count = static_cast<double>(state.range(0));
  for (double i = 0.5; i < count; i += 1.0) {
    const double z = 1.0 - 2.0 * i / count, angle = 2.399963229728653 * i, ring = std::sqrt(1.0 - z * z);
    stars.push_back({{ring * std::cos(angle), ring * std::sin(angle), z}, 10.0, 0.7});
  }
  const StarField field(stars);
  const int width = static_cast<int>(state.range(1)), height = width * 9 / 16;
  const StarCamera camera{glm::dmat3(1.0), 0.5 * height / std::tan(0.4), width, height};
  std::vector<glm::vec4> image(static_cast<std::size_t>(width * height));
  std::size_t num_drawn = 0;
  for (auto _ : state) {
    std::fill(image.begin(), image.end(), glm::vec4(0.0f));
    num_drawn = field.AddTo(camera, image);
    benchmark::ClobberMemory();
  }
  state.counters["drawn"] = static_cast<double>(num_drawn);
}
BENCHMARK(BM_Splat)
    ->Args({1'060'000, 640})
    ->Args({1'060'000, 1280})
    ->Args({1'870'000, 1280})
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace space
