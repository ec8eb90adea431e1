#include "nodes/device_bridge/force_log.hpp"

#include <fstream>

namespace device_bridge {

core::Result<void> ForceLog::Write(const std::filesystem::path& file) const {
  std::ofstream out(file);
  out << "time_ns,role,force_N,torque_Nm\n";
  for (const Sample& sample : samples_) {
    out << sample.time_ns << ',' << sample.role << ',' << sample.force_N << ',' << sample.torque_Nm << '\n';
  }
  out.flush();
  if (!out) return core::Fail(core::ErrorCode::kIo, "cannot write " + file.string() + "; is the disk full?");
  return {};
}

}  // namespace device_bridge
