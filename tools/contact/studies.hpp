#pragma once

#include <functional>

#include "tools/contact/contest.hpp"
#include "tools/contact/report.hpp"
#include "tools/contact/workload.hpp"

// The measurements of `oos bench vps` besides the contests. Each prints its results and adds tables, charts and goals.
namespace contact {

// Time of a query against the number of points, 1k to 2M (`paper`: to 1M), over consecutive poses of one workload.
struct PointScaling {
  std::string workload;
  std::string method;
  std::uint32_t num_points;
  Times times;
};
std::vector<PointScaling> StudyPoints(const Workload& workload, const Parts& parts, Structures* structures);
void ReportPoints(const std::vector<PointScaling>& rows, Report* report);

// Time of the walk at the middle resolution, beside three others: a test of all points by the same kernel (flat), a
// gather of the words of the tested points alone, and the walk with each instruction set.
struct KernelFigures {
  std::string workload;
  Fit fit = Fit::kLight;
  double query_us, flat_us, worst_excess_us;  // medians over poses; max over poses of walk - flat
  double gather_us, tested_points;
  double portable_us, avx2_us, avx512_us;  // NaN: this machine does not have it
  double portable_relative_error;          // of the force, against the widest instruction set
};
KernelFigures StudyKernel(const Workload& workload, const Parts& parts, Structures* structures);
void ReportKernels(const std::vector<KernelFigures>& rows, Report* report);

// Errors of the field alone, in depth at points near A's surface, and in force direction: both sides sum d a n over the
// same points, areas and normals, one with the field's depths d, the other with exact ones.
struct FieldFigures {
  std::string parts, method;
  double voxel_size_m;
  Errors depth_voxels;    // p50 is the mean here
  double wrong_contacts;  // share of points with depth > 0 in a workload without contact; NaN: no such workload
  Errors direction_deg;   // over independent poses
};
std::vector<FieldFigures> StudyField(const PartsAndWorkloads& made, Structures* structures);
void ReportFields(const std::vector<FieldFigures>& rows, Report* report);

// Ripple of the force of a ball that slides at constant depth, 0.1 m/s at 1 kHz, on a plane and around a cylinder of
// radius 25 s, and the largest change of force for 1 um of approach.
void StudySlide(Report* report);

// MakeParts of a name, each made once.
using PartsSource = std::function<const core::Result<PartsAndWorkloads>&(const std::string&)>;

// Time of `fast` as `oos query` asks it, from meshes, where parts are near but apart, and how far its lower bound of
// the distance is below the exact one.
void StudyNear(const PartsSource& parts, Report* report);

// Steps of the force of `fast` between poses 1 um apart, where parts touch: approach, slide and turn, over the pairs of
// the workloads and the held-out families of vps/testing/wrench_cases, at 10 % as in scenarios and at 2 %.
void StudySteps(const PartsSource& parts, const Places& places, Report* report);

// Time of one query of `fast` and of `paper` while flat faces come together, 0.1 mm to 1 um apart.
void StudyFlat(Report* report);

// How many of 1,000 poses of a peg that is free in its hole report contact, at the resolution that `oos query` chooses.
void StudyFreePeg(Report* report);

// Time of a collision world's step: 10 objects with three pairs in contact, and 20 to 100 objects with ten.
void StudyScene(Report* report);

// Time of one random read [ns] against the size of the table.
void StudyReads(Report* report);

// Time of checking a mesh of about 1e5 triangles and building both roles of `fast`, with one and two threads.
void StudyCook(const Places& places, Report* report);

// Errors of the whole wrench of `fast`, sampling included: a row for each workload and point count.
void ReportWrenches(const std::vector<Measurement>& all, Report* report);

// Errors and times on the families of vps/testing/wrench_cases, training and held-out sets apart, against
// ReferenceWrench: every contender at the middle resolution and with a quarter of its points, and `fast` at several
// accuracies, with how often its error is within its own estimate. Voxels are 1/256 of the field's
// longest side. A contact that is not noticed counts with its whole force. Takes some minutes, most of them for the
// references.
void StudyHeldOut(const std::vector<Contender>& contenders, const Places& places, Report* report);

// Errors of `fast` at 2 % and 10 % on a few training parts alone, for cold and consecutive queries, and how much it
// read; of its planes and of a tool's gaps after a little motion (training_planes.hpp): seconds, once the references
// are in `folder` (TrainingCases). For choosing constants; not a part of the whole bench.
void StudyTraining(const std::filesystem::path& folder, Report* report);

// The same for pairs of the shipped scenarios at their own voxels and points, within the budget of scenarios: `paper`,
// and `fast` at several accuracies. Poses as of the held-out parts; a table `scene_pairs` and a chart.
void StudyScenePairs(const Places& places, Report* report);

// Adds the goals that the contests decide, each with what was measured.
void JudgeContests(const std::vector<Measurement>& all, Report* report);

}  // namespace contact
