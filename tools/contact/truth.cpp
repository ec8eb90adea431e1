#include "tools/contact/truth.hpp"

#include "bus/rt/worker_pool.hpp"
#include "vps/oracle/mesh_distance.hpp"

namespace contact {
namespace {

constexpr std::uint32_t kDensePoints = 200'000;  // not derived: time against the scatter of equal-area points
constexpr double kDeepest_m = 1e-3;              // conforming workloads are at most 0.3 mm deep (workload.cpp)

// F = sum d_i a_i n_i, M = sum (p_i - o_B) x d_i a_i n_i over dense samples i of B with d_i > 0: d_i exact depth in A
// [m], a_i area [m^2], n_i inward normal, p_i place and o_B B's origin in A's frame [m].
class DenseMethod : public Method {
 public:
  explicit DenseMethod(const Parts& parts)
      : A_(parts.A), box_(vps::BoundingBox(parts.A)), samples_(EvenSamples(parts.B, kDensePoints)) {}

  Answer Query(const core::Pose& X_AB) override {
    Answer answer;
    for (std::size_t i = 0; i < samples_.points_m.size(); ++i) {
      const glm::dvec3 p = X_AB * samples_.points_m[i];
      if (glm::any(glm::lessThan(p, box_.lower)) || glm::any(glm::greaterThan(p, box_.upper))) continue;
      if (!A_.FindNearest(p, kDeepest_m)) continue;
      const double depth_m = -A_.SignedDistance(p);
      if (depth_m <= 0.0) continue;
      const glm::dvec3 f = depth_m * samples_.areas_m2[i] * X_AB.rotate(samples_.inward_normals[i]);
      answer.force_A += f;
      answer.moment_A += glm::cross(p - X_AB.translation, f);
      answer.signed_distance_m = std::min(answer.signed_distance_m, -depth_m);
      ++answer.contacts;
    }
    answer.points_tested = samples_.points_m.size();
    return answer;
  }

 private:
  vps::oracle::MeshDistance A_;
  vps::Box box_;
  vps::SurfaceSamples samples_;
};

}  // namespace

std::vector<Answer> ExactAnswers(const Parts& parts, const Workload& workload) {
  struct Job {
    std::unique_ptr<Method> method;  // Query only reads
    const Workload* workload;
    std::vector<Answer> answers;
  } job{nullptr, &workload, std::vector<Answer>(workload.independent.size())};
  if (workload.fit == Fit::kConforming) {
    job.method = std::make_unique<DenseMethod>(parts);
  } else if (auto oracle = MakeOracleMethod(parts.A, parts.B, 1e-3)) {
    job.method = std::move(*oracle);
  }
  bus::WorkerPool workers(2, "exact");
  workers.Run(
      job.answers.size(),
      [](void* context, std::size_t i) {
        Job& todo = *static_cast<Job*>(context);
        todo.answers[i] = todo.method->Query(todo.workload->independent[i]);
      },
      &job);
  return job.answers;
}

}  // namespace contact
