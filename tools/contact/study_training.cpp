#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tools/contact/accuracy_race.hpp"
#include "tools/contact/studies.hpp"
#include "tools/contact/training_planes.hpp"
#include "tools/contact/training_poses.hpp"
#include "vps/testing/case_random.hpp"

namespace contact {
namespace {

// How a pose is come to. Cold: nothing is remembered. Consecutive: by a hand that moves 0.1 mm a query; the same with
// no more places than in a scenario. Every error counts, those that no hand feels as well.
struct Way {
  std::string name;
  int queries;  // of which the last counts
  std::uint32_t most_places;
};
const Way kWays[] = {{"cold", 1, FastGoal{}.most_places},
                     {"consecutive", 4, FastGoal{}.most_places},
                     {"few places", 4, vps::PairDescription{}.most_places}};
constexpr double kStep_m = 1e-4;
constexpr double kTurn_rad = 1e-3;
constexpr double kAccuracies[] = {0.02, 0.1};
constexpr double kFelt_m3 = 1e-12;  // as in study_held_out.cpp

// Half as fine as UsualResolution, and few samples: most of the study is building.
constexpr std::uint32_t kNumPoints = 16'384;
Resolution CoarseResolution(const vps::TriangleMesh& A, const vps::TriangleMesh& B) {
  return {2.0 * UsualResolution(A, B).voxel_size_m, kNumPoints};
}

// Straight to the pose, turning a little, the same at every call.
std::vector<core::Pose> WayTo(const core::Pose& X_AB, int queries, std::uint64_t seed) {
  vps::CaseRandom random(seed);
  const glm::dvec3 direction = random.Direction();
  const glm::dvec3 axis = random.Direction();
  std::vector<core::Pose> poses;
  for (int left = queries - 1; left >= 0; --left) {
    core::Pose pose = X_AB;
    pose.translation -= left * kStep_m * direction;
    pose.rotation = pose.rotation * core::QuaternionFromRotationVector(-left * kTurn_rad * axis);
    poses.push_back(pose);
  }
  return poses;
}

struct Figures {
  std::vector<double> force, moment, places;
  double within_twice = 0.0;
  double worst = -1.0;
  std::string worst_at;

  void Add(const Answer& answer, const vps::WrenchError& error, double integral_m3, const std::string& at) {
    force.push_back(error.force);
    moment.push_back(error.moment);
    places.push_back(static_cast<double>(answer.points_tested));
    within_twice += error.force <= 2.0 * *answer.force_error / integral_m3 ? 1.0 : 0.0;
    if (error.force <= worst) return;
    worst = error.force;
    worst_at = at;
  }
};

void Measure(const TrainingCase& c, Method* method, const Way& way, Figures* all, Figures* felt) {
  const double radius_B_m = vps::RadiusAboutOrigin_m(c.parts.B);
  for (const ReferencePose& p : c.posed) {
    method->Forget();
    Answer answer;
    for (const core::Pose& pose : WayTo(p.pose.X_AB, way.queries, p.number)) answer = method->Query(pose);
    const vps::WrenchError error = vps::CompareWrench(answer.force_A, answer.moment_A, p.reference, radius_B_m);
    const std::string at = c.parts.family + " " + std::string(ToText(p.pose.kind)) + " " + std::to_string(p.number);
    all->Add(answer, error, p.reference.depth_integral_m3, at);
    if (p.reference.depth_integral_m3 > kFelt_m3) felt->Add(answer, error, p.reference.depth_integral_m3, at);
  }
}

std::vector<std::string> RowOf(const Way& way, double accuracy, const std::string& contacts, const Figures& f) {
  const auto count = static_cast<double>(std::max<std::size_t>(f.force.size(), 1));
  double places = 0.0;
  for (const double value : f.places) places += value / count;
  std::vector<std::string> row = {way.name, Short(100.0 * accuracy) + " %", contacts, std::to_string(f.force.size())};
  for (const double share : {0.5, 0.99, 1.0}) row.push_back(Cell(Quantile(f.force, share)));
  row.push_back(f.worst_at);
  for (const double share : {0.5, 0.99, 1.0}) row.push_back(Cell(Quantile(f.moment, share)));
  row.insert(row.end(), {Cell(f.within_twice / count), Cell(Quantile(f.places, 0.5)), Cell(places)});
  return row;
}

// As a row of the table: in the place of errors of forces those of planes, in that of places how many there are.
std::vector<std::string> PlanesRow(const std::string& queries, const std::vector<double>& force,
                                   const std::vector<double>& moment, const std::vector<double>& num_planes) {
  double mean = 0.0;
  for (const double value : num_planes)
    mean += value / static_cast<double>(std::max<std::size_t>(num_planes.size(), 1));
  std::vector<std::string> row = {queries, "10 %", "felt", std::to_string(force.size())};
  for (const double share : {0.5, 0.99, 1.0}) row.push_back(Cell(Quantile(force, share)));
  row.emplace_back("-");
  for (const double share : {0.5, 0.99, 1.0}) row.push_back(Cell(Quantile(moment, share)));
  row.insert(row.end(), {Cell(1.0), Cell(Quantile(num_planes, 0.5)), Cell(mean)});
  return row;
}

}  // namespace

void StudyTraining(const std::filesystem::path& folder, Report* report) {
  std::map<std::pair<std::string, double>, std::array<Figures, 2>> figures;
  PlaneFigures planes;
  for (const TrainingCase& c : TrainingCases(folder)) {
    const Resolution resolution = CoarseResolution(c.parts.A, c.parts.B);
    const Parts parts{c.parts.family, c.parts.A, c.parts.B, resolution.voxel_size_m};
    Structures structures(parts);
    const Structures::Key key_A{false, vps::Method::kFast, resolution.voxel_size_m, 0};
    const Structures::Key key_B{true, vps::Method::kFast, 0.0, resolution.num_points};
    structures.Prepare({key_A, key_B});
    const auto A = structures.Get(key_A);
    const auto B = structures.Get(key_B);
    if (!A || !B) {
      report->skipped.push_back("training " + c.parts.family + ": " + (A ? B : A).error().detail);
      std::printf("skipped %s\n", report->skipped.back().c_str());
      continue;
    }
    for (const Way& way : kWays) {
      for (const double accuracy : kAccuracies) {
        const auto method = MakeFastMethod(*A, *B, {accuracy, 0.0, way.most_places});
        auto& [all, felt] = figures[{way.name, accuracy}];
        Measure(c, method.get(), way, &all, &felt);
      }
    }
    std::vector<std::vector<core::Pose>> ways;
    for (const ReferencePose& p : c.posed) ways.push_back(WayTo(p.pose.X_AB, kWays[1].queries, p.number));
    MeasurePlanes(*A, *B, vps::RadiusAboutOrigin_m(c.parts.B), ways, &planes);
  }
  Table table{"training",
              {"queries", "accuracy", "contacts", "poses", "force_p50", "force_p99", "force_max", "worst_at",
               "moment_p50", "moment_p99", "moment_max", "within_twice", "places_p50", "places_mean"},
              {}};
  for (const Way& way : kWays) {
    for (const double accuracy : kAccuracies) {
      const auto& [all, felt] = figures[{way.name, accuracy}];
      table.Add(RowOf(way, accuracy, "all", all));
      table.Add(RowOf(way, accuracy, "felt", felt));
    }
  }
  table.Add(PlanesRow("planes", planes.force, planes.moment, planes.num_planes));
  table.Add(PlanesRow("gaps", planes.gap, {0.0}, planes.num_gap_planes));
  for (const auto& row : table.rows) {
    std::printf("training, %s, %s, %s: force off %s, %s, %s worst (%s), within twice %s, places %s\n", row[0].c_str(),
                row[1].c_str(), row[2].c_str(), row[4].c_str(), row[5].c_str(), row[6].c_str(), row[7].c_str(),
                row[11].c_str(), row[13].c_str());
  }
  report->tables.push_back(table);
}

}  // namespace contact
