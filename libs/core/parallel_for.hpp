#pragma once

#include <cstddef>
#include <type_traits>

namespace core {

// Runs body(context, i) for i in [0, count). Libraries take a ParallelFor from their caller and create no threads.
// Bodies may run in any order and concurrently, so a body writes only to data of its own index.
class ParallelFor {
 public:
  using Body = void (*)(void* context, std::size_t index);
  virtual ~ParallelFor() = default;
  virtual void Run(std::size_t count, Body body, void* context) = 0;
};

// Runs every body on the calling thread, in order.
class SerialFor final : public ParallelFor {
 public:
  void Run(std::size_t count, Body body, void* context) override {
    for (std::size_t i = 0; i < count; ++i) body(context, i);
  }
};

// Runs callable(i) for i in [0, count). A null `workers` runs everything on the calling thread.
template <class Callable>
void ForEach(ParallelFor* workers, std::size_t count, Callable&& callable) {
  const auto body = [](void* context, std::size_t index) {
    (*static_cast<std::remove_reference_t<Callable>*>(context))(index);
  };
  SerialFor serial;
  (workers != nullptr ? *workers : serial).Run(count, body, &callable);
}

}  // namespace core
