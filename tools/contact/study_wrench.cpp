#include <cmath>

#include "tools/contact/studies.hpp"

namespace contact {

void ReportWrenches(const std::vector<Measurement>& all, Report* report) {
  Table table{"wrench_accuracy",
              {"workload", "setting", "magnitude_p50", "magnitude_p95", "magnitude_max", "direction_p50_deg",
               "direction_p95_deg", "torque_p50", "torque_max", "depth_error_m_p50", "missed"},
              {}};
  for (const Measurement& m : all) {
    if (m.method != "fast" || !std::isfinite(m.missed)) continue;
    table.Add({m.workload, m.setting, Cell(m.magnitude.p50), Cell(m.magnitude.p95), Cell(m.magnitude.max),
               Cell(m.direction_deg.p50), Cell(m.direction_deg.p95), Cell(m.torque.p50), Cell(m.torque.max),
               Cell(m.depth_m.p50), Cell(m.missed)});
  }
  if (!table.rows.empty()) report->tables.push_back(table);
}

}  // namespace contact
