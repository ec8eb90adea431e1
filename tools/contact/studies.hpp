#pragma once

#include "tools/contact/contest.hpp"
#include "tools/contact/report.hpp"
#include "tools/contact/workload.hpp"

// What `oos bench vps` measures besides the contests. Each prints what it found and adds tables, charts and goals.
namespace contact {

// Time against number of points, 1k to 2M (`paper`: to 1M), consecutive poses of one workload.
struct PointScaling {
  std::string workload;
  std::string method;
  std::uint32_t num_points;
  Times times;
};
std::vector<PointScaling> StudyPoints(const Workload& workload, const Parts& parts, Structures* structures);
void ReportPoints(const std::vector<PointScaling>& rows, Report* report);

// The query against a scan of all points, against an ideal gather of the words of the points that it tests, and by
// instruction sets; at the middle resolution.
struct KernelFigures {
  std::string workload;
  Fit fit = Fit::kLight;
  double query_us, flat_us, worst_excess_us;  // medians; worst of the query beyond the flat scan, over poses
  double gather_us, tested_points;
  double portable_us, avx2_us, avx512_us;  // NaN: not on this machine
  double portable_relative_error;          // of the force, against the widest
};
KernelFigures StudyKernel(const Workload& workload, const Parts& parts, Structures* structures);
void ReportKernels(const std::vector<KernelFigures>& rows, Report* report);

// Depth against the exact distance at points near A's surface, and force direction from the field alone: the same
// points, areas and normals, exact distances on the one side.
struct FieldFigures {
  std::string parts, method;
  double voxel_size_m;
  Errors depth_voxels;    // p50 is the mean here
  double wrong_contacts;  // share of the points that touch in a workload that touches nowhere; NaN: no such workload
  Errors direction_deg;   // over independent poses
};
std::vector<FieldFigures> StudyField(const PartsAndWorkloads& made, Structures* structures);
void ReportFields(const std::vector<FieldFigures>& rows, Report* report);

// Force while a body slides at constant depth, 0.1 m/s at 1 kHz, on a plane and around a cylinder of radius 25 s; steps
// of the force at 1 um of approach.
void StudySlide(Report* report);

// Cycle of a collision world: 10 objects with three couples in contact, and 10 to 100 objects with ten couples.
void StudyScene(Report* report);

// Nanoseconds of one random read from tables of many sizes.
void StudyReads(Report* report);

// Errors of the whole wrench of `fast`, sampling included: a row for each workload and point count.
void ReportWrenches(const std::vector<Measurement>& all, Report* report);

// What the contests say of the goals.
void JudgeContests(const std::vector<Measurement>& all, Report* report);

}  // namespace contact
