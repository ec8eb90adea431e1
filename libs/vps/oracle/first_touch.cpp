#include "vps/oracle/first_touch.hpp"

#include "vps/oracle/body_distance.hpp"

namespace vps::oracle {

std::optional<FirstTouch> FindFirstTouch(const MeshDistance& A, const Box& box_A, const MeshDistance& B,
                                         const Box& box_B, const glm::dquat& R_AB, const glm::dvec3& from_A) {
  constexpr double kTouching_m = 1e-7;  // not derived; a thousandth of the smallest depths measured
  const glm::dvec3 centre_A = 0.5 * (box_A.lower + box_A.upper);
  const glm::dvec3 centre_B = 0.5 * (box_B.lower + box_B.upper);
  double travel = glm::length(box_A.upper - box_A.lower) + glm::length(box_B.upper - box_B.lower);
  FirstTouch touch{{R_AB, {}}, from_A};
  while (travel > 0.0) {
    touch.X_AB.translation = centre_A + travel * from_A - R_AB * centre_B;
    const double distance = SurfaceDistance(A, B, touch.X_AB);
    if (distance <= kTouching_m) return touch;
    travel -= distance;
  }
  return std::nullopt;
}

}  // namespace vps::oracle
