#include "nodes/rt_worker/worker.hpp"

#include <algorithm>

#include "core/clock.hpp"

namespace rt_worker {
namespace {

// A list of jobs wakes the worker; a frame, being reliable, does not.
constexpr std::int64_t kWait_ns = 20'000'000, kWaitForFrame_ns = 300'000;

}  // namespace

Worker::Worker(const std::string& viewer, std::size_t seat, Drawer* drawer, bus::Node* node)
    : drawer_(drawer),
      node_(node),
      frames_(&node->ReadState<core::RayFrame>(bus::RayFrameTopic(viewer))),
      jobs_(&node->ReadLatest<core::RayJobs>(bus::RayJobsTopic(viewer, std::to_string(seat)))),
      tiles_(node->WriteState<core::RayTile>(bus::RayTileTopic(viewer, std::to_string(seat)))) {}

void Worker::Run(const std::atomic<bool>& stop) {
  tiles_.Set({}, "0");  // it is there
  bool is_busy = false;
  while (!stop.load(std::memory_order_relaxed)) {
    node_->Wait(is_busy ? 0 : core::MonotonicNow_ns() + (is_waiting_ ? kWaitForFrame_ns : kWait_ns));
    is_busy = Step();
  }
}

const core::RayJob* Worker::NextJob(const core::RayFrame** frame) {
  is_waiting_ = false;
  for (const core::RayJob& job : jobs_->value().jobs) {
    if (std::find(answered_.begin(), answered_.end(), job.id) != answered_.end()) continue;
    for (const auto& [key, candidate] : frames_->values()) {
      if (candidate.frame != job.frame) continue;
      *frame = &candidate;
      return &job;
    }
    is_waiting_ = true;
  }
  return nullptr;
}

bool Worker::Step() {
  const core::RayFrame* frame = nullptr;
  const core::RayJob* job = NextJob(&frame);
  if (job == nullptr) return false;
  const bool is_drawn = drawer_->Draw(*frame, *job, &answer_);
  Forget(job->id);
  if (is_drawn && tiles_.Set(answer_, std::to_string(num_tiles() % kKeys))) {
    num_tiles_.fetch_add(1, std::memory_order_relaxed);
  }
  return true;
}

}  // namespace rt_worker
