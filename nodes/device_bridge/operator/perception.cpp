#include "nodes/device_bridge/operator/perception.hpp"

#include <algorithm>
#include <cmath>

#include "core/clock.hpp"

namespace device_bridge {
namespace {

std::int64_t Nanoseconds(double seconds) {
  return static_cast<std::int64_t>(std::llround(seconds * 1e9));
}

// Twice the size that 1 kHz needs, so that a burst of late ticks does not overwrite samples within the delay.
std::size_t RingSize(std::int64_t delay_ns) {
  return static_cast<std::size_t>(2 * delay_ns / core::kTick_ns + 64);
}

}  // namespace

DelayedSight::DelayedSight(const scene::Scenario& scenario, double delay_s)
    : scenario_(scenario), delay_ns_(Nanoseconds(delay_s)), ring_(RingSize(delay_ns_)) {
  for (Sighting& sighting : ring_) {
    sighting.X_WO.resize(scenario.objects.size());
    sighting.is_visible.resize(scenario.objects.size());
    for (std::size_t i = 0; i < scenario.objects.size(); ++i) {
      sighting.X_WO[i] = scenario.objects[i].X_WO;
      sighting.is_visible[i] = scenario.objects[i].owner == scene::Owner::kFixed ? 1 : 0;
    }
    sighting.X_WHand.resize(scenario.devices.size());
    sighting.grasped.assign(scenario.devices.size(), core::kNoObject);
    sighting.mechanisms.resize(scenario.mechanisms.size());
  }
}

void DelayedSight::Record(const Inputs& inputs, const core::FixedVector<DeviceReading, kMaxRoles>& readings,
                          int step) noexcept {
  const Sighting& previous = ring_[newest_];
  newest_ = (newest_ + 1) % ring_.size();
  size_ = std::min(size_ + 1, ring_.size());
  Sighting& sighting = ring_[newest_];
  sighting.time_ns = inputs.now_ns;
  sighting.step = step;
  // Without a message everything keeps its last state.
  std::copy(previous.X_WO.begin(), previous.X_WO.end(), sighting.X_WO.begin());
  std::copy(previous.is_visible.begin(), previous.is_visible.end(), sighting.is_visible.begin());
  std::copy(previous.mechanisms.begin(), previous.mechanisms.end(), sighting.mechanisms.begin());
  std::copy(previous.grasped.begin(), previous.grasped.end(), sighting.grasped.begin());
  if (inputs.physics != nullptr && inputs.physics->header.sequence != 0) {
    for (const core::BodyState& body : inputs.physics->bodies) {
      if (body.object >= sighting.X_WO.size()) continue;
      sighting.X_WO[body.object] = body.X_WO;
      sighting.is_visible[body.object] = 1;
    }
    for (const core::MechanismState& mechanism : inputs.physics->mechanisms) {
      if (mechanism.mechanism < sighting.mechanisms.size()) sighting.mechanisms[mechanism.mechanism] = mechanism;
    }
  }
  for (std::size_t role = 0; role < sighting.X_WHand.size(); ++role) {
    double opening_m = 0.0;
    if (role < readings.size()) {
      sighting.X_WHand[role] = readings[role].X_WD;
      opening_m = readings[role].opening_m;
    }
    if (role < inputs.proxies.size() && inputs.proxies[role].header.sequence != 0) {
      sighting.X_WHand[role] = inputs.proxies[role].X_WC;
      opening_m = inputs.proxies[role].opening_m;
    }
    if (role < inputs.grasped_objects.size()) sighting.grasped[role] = inputs.grasped_objects[role];
    for (std::size_t i = 0; i < scenario_.objects.size(); ++i) {
      const scene::Object& object = scenario_.objects[i];
      if (object.owner != scene::Owner::kHand || object.role != static_cast<int>(role)) continue;
      sighting.X_WO[i] = scene::PartPose(object.part, sighting.X_WHand[role], opening_m);
      sighting.is_visible[i] = 1;
    }
  }
}

const Sighting* DelayedSight::At(std::int64_t now_ns) const noexcept {
  for (std::size_t age = 0; age < size_; ++age) {
    const Sighting& sighting = ring_[(newest_ + ring_.size() - age) % ring_.size()];
    if (sighting.time_ns <= now_ns - delay_ns_) return &sighting;
  }
  return nullptr;
}

DelayedTouch::DelayedTouch(double reaction_s) : delay_ns_(Nanoseconds(reaction_s)), ring_(RingSize(delay_ns_)) {}

void DelayedTouch::Record(std::int64_t now_ns, const FeltForce& felt) noexcept {
  newest_ = (newest_ + 1) % ring_.size();
  size_ = std::min(size_ + 1, ring_.size());
  ring_[newest_] = {now_ns, felt};
}

FeltForce DelayedTouch::At(std::int64_t now_ns) const noexcept {
  for (std::size_t age = 0; age < size_; ++age) {
    const Sample& sample = ring_[(newest_ + ring_.size() - age) % ring_.size()];
    if (sample.time_ns <= now_ns - delay_ns_) return sample.felt;
  }
  return {};
}

}  // namespace device_bridge
