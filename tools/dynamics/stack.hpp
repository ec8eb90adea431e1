#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace dynamics {

// A heavy block on a light one on the ground: physics::trials::HeavyOnLight, or the same scene in another library with
// that library's own box contacts.
class Stack {
 public:
  virtual ~Stack() = default;
  virtual void Step() = 0;  // of 1 ms
  [[nodiscard]] virtual double deepest_m() const = 0;
};

struct StackMaker {
  std::string name;
  std::function<std::unique_ptr<Stack>(double ratio)> make;
};

// This project's hard and compliant contact, then Bullet's solvers.
std::vector<StackMaker> OwnStacks();

}  // namespace dynamics
