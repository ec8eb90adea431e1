#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/contact/methods/method.hpp"
#include "tools/contact/report.hpp"
#include "tools/contact/stopwatch.hpp"
#include "tools/contact/workload.hpp"

namespace contact {

// A method at one resolution, as it takes part in the comparison.
struct Contender {
  std::string method;   // a series of the charts
  std::string setting;  // a point of the series
  std::string mark;     // short for charts; empty: at the middle resolution
  std::function<core::Result<std::unique_ptr<Method>>(const Parts&, Structures&)> make;
  bool has_magnitude = true;  // its force is the depth integral; false: only the direction of its force is compared
};

// Quantiles over poses of an absolute error.
struct Errors {
  double p50, p95, max;  // NaN: the method does not compute the quantity
};

// One contender on one workload. Times over all poses that it had time for; errors against the exact answers at the
// independent poses.
struct Measurement {
  std::string workload, method, setting, mark;
  Times consecutive, independent;
  Errors direction_deg, magnitude, torque, depth_m;  // | |F| / |F_ref| - 1 |; |M - M_ref| / (|F_ref| times B's radius)
  double missed = 0.0;                               // fraction of touching poses at which no contact was reported
  double points_tested = 0.0;                        // mean
  std::vector<double> forces;                        // at the independent poses
  std::vector<std::uint64_t> contacts;
};

// Compares a method with the exact answers at the independent poses. Sets the errors, `missed`, `points_tested`,
// `forces` and `contacts` of *m.
void Compare(const Parts& parts, const Workload& workload, const std::vector<Answer>& truth, bool has_magnitude,
             Method* method, Measurement* m);

// The contenders that could be built for these parts, each with its method. MakeTeam prints the ones that it leaves
// out.
struct Team {
  std::vector<const Contender*> contenders;
  std::vector<std::unique_ptr<Method>> methods;
};
Team MakeTeam(const Parts& parts, const std::vector<Contender>& contenders, Structures* structures);

// Computes the exact answers and the errors of every contender, then times all of them over the consecutive and over
// the independent poses. One row for each contender.
std::vector<Measurement> Contest(const Parts& parts, const Workload& workload, const Team& team);

Table ContestTable(const std::string& name, const std::vector<Measurement>& rows);
// x: time, y: error; one panel for each kind of error.
Chart ContestChart(const Workload& workload, const std::vector<Measurement>& rows);
void PrintContest(const Workload& workload, const std::vector<Measurement>& rows);

// The middle resolution, at which the goals are set.
constexpr std::uint32_t kMiddlePoints = 65536;
constexpr const char* kMiddle = "s; 65536 points";
constexpr const char* kMiddleAtTen = "s; 65536 points; 10 %";  // `fast`, with the accuracy of scenarios

// `paper` and `fast` at several voxel sizes and point counts.
std::vector<Contender> OwnContenders();

}  // namespace contact
