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
  bool has_magnitude = true;  // its force is the depth integral; else only its direction means something
};

// Over poses.
struct Errors {
  double p50, p95, max;  // NaN: the method does not say
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

// The errors of a method against the exact answers at the independent poses, into *m.
void Compare(const Parts& parts, const Workload& workload, const std::vector<Answer>& truth, bool has_magnitude,
             Method* method, Measurement* m);

// Contenders that could be made, with the method that each has made of these parts.
struct Team {
  std::vector<const Contender*> contenders;
  std::vector<std::unique_ptr<Method>> methods;
};
Team MakeTeam(const Parts& parts, const std::vector<Contender>& contenders, Structures* structures);

// Exact answers, errors, and a race over consecutive, then over independent poses.
std::vector<Measurement> Contest(const Parts& parts, const Workload& workload, const Team& team);

Table ContestTable(const std::string& name, const std::vector<Measurement>& rows);
// Time to the right, error upwards, one panel for each kind of error.
Chart ContestChart(const Workload& workload, const std::vector<Measurement>& rows);
void PrintContest(const Workload& workload, const std::vector<Measurement>& rows);

constexpr std::uint32_t kMiddlePoints = 65536;
constexpr const char* kMiddle = "s; 65536 points";

// `paper` and `fast` at several voxel sizes and point counts.
std::vector<Contender> OwnContenders();

}  // namespace contact
