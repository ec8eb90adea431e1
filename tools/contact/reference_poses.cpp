#include "tools/contact/reference_poses.hpp"

#include "bus/rt/worker_pool.hpp"

namespace contact {

std::vector<ReferencePose> WithReferences(const vps::WrenchCase& c, int* num_without) {
  struct Job {
    vps::oracle::MeshDistance A, B;
    const std::vector<vps::ContactPose>* poses;
    std::vector<vps::oracle::ContactWrench> wrenches;
  } job{vps::oracle::MeshDistance(c.A), vps::oracle::MeshDistance(c.B), &c.poses, {}};
  job.wrenches.resize(c.poses.size());
  bus::WorkerPool workers(2, "exact");
  workers.Run(
      c.poses.size(),
      [](void* context, std::size_t i) {
        Job& todo = *static_cast<Job*>(context);
        todo.wrenches[i] = vps::ReferenceWrench(todo.A, todo.B, (*todo.poses)[i].X_AB);
      },
      &job);
  std::vector<ReferencePose> posed;
  for (std::size_t i = 0; i < c.poses.size(); ++i) {
    if (!job.wrenches[i].has_converged) {
      ++*num_without;
    } else if (job.wrenches[i].depth_integral_m3 > 0.0) {
      posed.push_back({c.poses[i], i, job.wrenches[i]});
    }
  }
  return posed;
}

}  // namespace contact
