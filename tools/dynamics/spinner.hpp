#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <memory>
#include <string>
#include <vector>

namespace dynamics {

// Equal free bodies that tumble, far apart. The accessors return the state of the first one.
class Spinner {
 public:
  virtual ~Spinner() = default;
  virtual void Step() = 0;
  [[nodiscard]] virtual glm::dquat R_WB() const = 0;  // B: principal axes
  [[nodiscard]] virtual glm::dvec3 w_B_rad_per_s() const = 0;
};

struct SpinnerParams {
  glm::dvec3 moments_kg_m2{1.0, 2.0, 3.0};
  glm::dvec3 w_B_rad_per_s{0.01, 2.0, 0.01};  // about the middle axis, nearly: it flips (Dzhanibekov)
  double dt_s = 1e-3;
  int num_bodies = 1;
};

struct SpinnerMaker {
  std::string name;
  std::function<std::unique_ptr<Spinner>(const SpinnerParams&)> make;
};

// This project's world, then Bullet's with its default and its other modes of rotation.
std::vector<SpinnerMaker> OwnSpinners();

}  // namespace dynamics
