#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/result.hpp"
#include "core/wrench.hpp"

namespace device_bridge {

// The filtered force at every tick, to verify forces and the time at which they fell to zero. Memory is allocated at
// construction; samples beyond it are counted but not kept.
class ForceLog {
 public:
  explicit ForceLog(std::size_t num_samples) { samples_.reserve(num_samples); }

  void Add(std::uint32_t role, std::int64_t now_ns, const core::Wrench& applied) noexcept {
    if (samples_.size() == samples_.capacity()) {
      ++num_not_kept_;
      return;
    }
    samples_.push_back({now_ns, static_cast<float>(glm::length(applied.force_N)),
                        static_cast<float>(glm::length(applied.torque_Nm)), role});
  }

  // CSV with one row per tick and role: time_ns (CLOCK_MONOTONIC), role, force_N, torque_Nm. Error: kIo.
  core::Result<void> Write(const std::filesystem::path& file) const;
  [[nodiscard]] std::uint64_t num_not_kept() const { return num_not_kept_; }

 private:
  struct Sample {
    std::int64_t time_ns = 0;
    float force_N = 0.0f;
    float torque_Nm = 0.0f;
    std::uint32_t role = 0;
  };
  std::vector<Sample> samples_;
  std::uint64_t num_not_kept_ = 0;
};

}  // namespace device_bridge
