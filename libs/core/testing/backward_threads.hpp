#pragma once

#include <cstddef>
#include <thread>
#include <vector>

#include "core/parallel_for.hpp"

namespace core::test {

// Runs the bodies of a range backwards on `count` threads.
class BackwardThreads final : public core::ParallelFor {
 public:
  explicit BackwardThreads(std::size_t count) : count_(count) {}
  void Run(std::size_t count, Body body, void* context) override {
    std::vector<std::thread> threads;
    for (std::size_t k = 0; k < count_; ++k) {
      threads.emplace_back([=, this] {
        for (std::size_t i = count; i-- > 0;) {
          if (i % count_ == k) body(context, i);
        }
      });
    }
    for (std::thread& thread : threads) thread.join();
  }

 private:
  std::size_t count_;
};

}  // namespace core::test
