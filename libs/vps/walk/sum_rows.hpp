// SumRows of walk_lanes.hpp for registers of four and eight lanes; included by their kernels.

// Four lanes.
typedef float Quad __attribute__((vector_size(16)));

inline Quad SumOfQuarters(const F* row) {
  Quad sum{};
  for (std::uint32_t k = 0; k < kBlock; k += 4) {
    Quad quarter;
    __builtin_memcpy(&quarter, reinterpret_cast<const char*>(row) + k * sizeof(float), sizeof quarter);
    sum = k == 0 ? quarter : sum + quarter;
  }
  return sum;
}
inline void SumRows(const F* a, const F* b, const F* c, const F* d, float* sums) {
  const Quad sum_a = SumOfQuarters(a);
  const Quad sum_b = SumOfQuarters(b);
  const Quad sum_c = SumOfQuarters(c);
  const Quad sum_d = SumOfQuarters(d);
  const Quad ab01 = __builtin_shufflevector(sum_a, sum_b, 0, 4, 1, 5);
  const Quad ab23 = __builtin_shufflevector(sum_a, sum_b, 2, 6, 3, 7);
  const Quad cd01 = __builtin_shufflevector(sum_c, sum_d, 0, 4, 1, 5);
  const Quad cd23 = __builtin_shufflevector(sum_c, sum_d, 2, 6, 3, 7);
  const Quad lane0 = __builtin_shufflevector(ab01, cd01, 0, 1, 4, 5);
  const Quad lane1 = __builtin_shufflevector(ab01, cd01, 2, 3, 6, 7);
  const Quad lane2 = __builtin_shufflevector(ab23, cd23, 0, 1, 4, 5);
  const Quad lane3 = __builtin_shufflevector(ab23, cd23, 2, 3, 6, 7);
  const Quad all = (lane0 + lane1) + (lane2 + lane3);
  __builtin_memcpy(sums, &all, sizeof all);
}
