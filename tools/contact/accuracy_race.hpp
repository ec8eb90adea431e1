#pragma once

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "tools/contact/methods/method.hpp"
#include "tools/contact/reference_poses.hpp"
#include "tools/contact/report.hpp"
#include "tools/contact/structures.hpp"

// Errors and times of several methods at poses with exact wrenches, as rows of a table.
namespace contact {

// For generated parts, the same for thin ones and stout ones, so that a row compares shapes: voxels of 1/256 of A's
// longest side, and points on B one voxel apart.
Resolution UsualResolution(const vps::TriangleMesh& A, const vps::TriangleMesh& B);

// What is measured: a method with a setting, built for two parts at a resolution.
struct Entrant {
  std::string method, setting;
  std::string mark;  // short for charts
  std::function<core::Result<std::unique_ptr<Method>>(const Parts&, const Resolution&, Structures*)> make;
  double accuracy = 0.0;  // that it is asked for; 0: it is none of a series of accuracies
  int queries = 1;        // at each pose, of which the last counts: a pair remembers what sufficed
};
// `fast` for such a goal, with A's field and B's points at the given resolution.
Entrant FastEntrant(const FastGoal& goal);

// One pose of one entrant.
struct Sample {
  std::string family, kind, place;
  vps::CaseSet set = vps::CaseSet::kTraining;
  std::size_t entrant = 0;
  bool is_felt = false;
  vps::WrenchError error;
  bool is_missed = false;
  double estimate = std::numeric_limits<double>::quiet_NaN();  // of error.force; NaN: the method makes none
  bool is_reached = false;
  double places = 0.0;
  double time_us = 0.0;
};

// Appends a sample for each entrant that can be built for these parts and each pose; prints those that cannot. `keys`
// are built side by side first.
void Measure(const vps::WrenchCase& c, const Resolution& resolution, const std::vector<ReferencePose>& posed,
             const std::vector<Entrant>& entrants, const std::vector<Structures::Key>& keys,
             const std::function<bool(const ReferencePose&)>& is_felt, std::vector<Sample>* samples);

// What a row is about, and its figures.
struct Row {
  std::string what;
  vps::CaseSet set = vps::CaseSet::kTraining;
  std::size_t entrant = 0;
  std::size_t num_poses = 0;
  double missed = 0.0;
  double force[3], moment[3], direction_deg[3];  // median, 99th percentile, worst
  std::string worst_at;
  double p50_us = 0.0, p99_us = 0.0;
  // Shares of poses at which the error of the force was within the estimate, and the estimate within what was asked
  // for; and the places that were read. NaN: the method makes no estimate.
  double within = 0.0, within_twice = 0.0, reached = 0.0, places = 0.0;
};

// Over the samples of a set and an entrant that are wanted.
Row Summarize(const std::string& what, vps::CaseSet set, std::size_t entrant, const std::vector<Sample>& samples,
              const std::function<bool(const Sample&)>& is_wanted);

Table TableOf(const std::string& name, const std::string& what, const std::vector<Row>& rows,
              const std::vector<Entrant>& entrants);
void Print(const std::vector<Row>& rows, const std::vector<Entrant>& entrants);

// Error of the force against time, of the rows about `what`: the median (share 0) or the 99th percentile (1). Along a
// line: the accuracy asked for, or the number of points.
Panel ErrorPanel(const std::string& title, int share, const std::string& what, vps::CaseSet set,
                 const std::vector<Row>& rows, const std::vector<Entrant>& entrants);

}  // namespace contact
