#include <sys/mman.h>

#include <cstdio>

#include "core/clock.hpp"
#include "tools/contact/studies.hpp"
#include "vps/testing/case_random.hpp"

namespace contact {
namespace {

constexpr std::size_t kReads = 1 << 18;  // 1 MB of indices; not derived

// Median time of one of kReads independent reads of 4 bytes at random places of a table.
double ReadTime_ns(std::size_t bytes, vps::CaseRandom* random) {
  const std::size_t count = bytes / 4;
  const std::size_t rounded = (bytes + (2U << 20) - 1) & ~std::size_t{(2U << 20) - 1};
  void* const memory = mmap(nullptr, rounded, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return 0.0;
  (void)madvise(memory, rounded, MADV_HUGEPAGE);
  auto* const table = static_cast<std::uint32_t*>(memory);
  for (std::size_t i = 0; i < count; ++i) table[i] = static_cast<std::uint32_t>(i);
  std::vector<std::uint32_t> places(kReads);
  for (std::uint32_t& place : places)
    place = static_cast<std::uint32_t>(random->Uniform(0.0, static_cast<double>(count)));
  std::vector<double> times;
  volatile std::uint32_t sink = 0;
  for (int pass = 0; pass < 7; ++pass) {
    const std::int64_t start_ns = core::MonotonicNow_ns();
    std::uint32_t sum[4] = {0, 0, 0, 0};
    for (std::size_t i = 0; i < kReads; i += 4) {
      for (std::size_t k = 0; k < 4; ++k) sum[k] += table[places[i + k]];
    }
    sink = sink + sum[0] + sum[1] + sum[2] + sum[3];
    if (pass > 0) times.push_back(static_cast<double>(core::MonotonicNow_ns() - start_ns) / kReads);
  }
  munmap(memory, rounded);
  return Quantile(times, 0.5);
}

}  // namespace

void StudyReads(Report* report) {
  const OneCore pinned;
  vps::CaseRandom random(1);
  Table table{"random_reads", {"table_bytes", "ns_per_read"}, {}};
  Panel panel;
  panel.title = "One random read of 4 bytes";
  panel.x_title = "size of the table [KB]";
  panel.y_title = "time per read [ns]";
  panel.series = {{"independent reads", {}, true}};
  std::printf("\nrandom reads:");
  for (std::size_t kb = 16; kb <= 256U << 10; kb *= 4) {
    const double ns = ReadTime_ns(kb << 10, &random);
    table.Add({std::to_string(kb << 10), Cell(ns)});
    panel.series[0].points.push_back({static_cast<double>(kb), ns, ""});
    std::printf(" %zu KB %s ns;", kb, Short(ns).c_str());
  }
  std::printf("\n");
  report->tables.push_back(table);
  report->charts.emplace_back("random_reads", Chart{"What the machine allows: random reads, one core",
                                                    "places known beforehand; 2 MB pages; the caches show as steps",
                                                    {panel}});
}

}  // namespace contact
