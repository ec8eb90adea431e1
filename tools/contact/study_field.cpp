#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "bus/rt/worker_pool.hpp"
#include "tools/contact/studies.hpp"
#include "vps/oracle/mesh_distance.hpp"
#include "vps/testing/case_random.hpp"

namespace contact {
namespace {

constexpr std::uint32_t kPoints = 16384;  // of A for depths, of B for directions; not derived
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Depth of P [VR-OOS, Eq. 1]: V(P) = v s + n . (c - P), v the layer's value, s the voxel size [m], c the voxel's centre
// [m], n the inward normal. NaN outside the grid.
double PaperDepth_m(const vps::Voxmap& map, const glm::dvec3& p, const glm::dvec3& n) {
  const glm::dvec3 v = (p - map.origin_m) / map.voxel_size_m;
  const glm::ivec3 c(glm::floor(v));
  if (!map.contains(c.x, c.y, c.z)) return kNaN;
  const glm::dvec3 centre = map.origin_m + map.voxel_size_m * (glm::dvec3(c) + 0.5);
  return map.voxel_size_m * map.at(c.x, c.y, c.z) + glm::dot(n, centre - p);
}

// -s d(P), d the field's signed distance [voxels].
double FastDepth_m(const vps::DistanceField& field, const glm::dvec3& p) {
  const glm::vec3 v((p - field.origin_m) / field.voxel_size_m);
  return -field.voxel_size_m * static_cast<double>(vps::SampleField(field, v).distance);
}

struct Comparison {
  const Parts* parts;
  const vps::oracle::MeshDistance* A;
  const vps::Voxmap* map;           // of `paper`; nullptr: the field is compared
  const vps::DistanceField* field;  // of `fast`
  [[nodiscard]] double Depth_m(const glm::dvec3& p, const glm::dvec3& n) const {
    return map != nullptr ? PaperDepth_m(*map, p, n) : FastDepth_m(*field, p);
  }
};

// Mean (as p50), 95th percentile and maximum of |depth + exact signed distance| / s, at points of A's surface moved by
// up to 1.5 voxels in random directions.
Errors DepthErrors(const Comparison& c, double voxel_size_m) {
  vps::CaseRandom random(7);
  const vps::SurfaceSamples samples = EvenSamples(c.parts->A, kPoints);
  std::vector<double> errors;
  double sum = 0.0;
  for (std::size_t i = 0; i < samples.points_m.size(); ++i) {
    const glm::dvec3& n = samples.inward_normals[i];
    const glm::dvec3 p = samples.points_m[i] + random.Uniform(-1.5, 1.5) * voxel_size_m * random.Direction();
    const double depth = c.Depth_m(p, n);
    if (!std::isfinite(depth)) continue;
    const double error = std::abs(depth + c.A->SignedDistance(p)) / voxel_size_m;
    errors.push_back(error);
    sum += error;
  }
  return {sum / static_cast<double>(errors.size()), Quantile(errors, 0.95), Quantile(errors, 1.0)};
}

// Angle between sum d a n with the field's depths and with exact depths, over samples of B with area a [m^2] and inward
// normal n.
double DirectionError_deg(const Comparison& c, const vps::SurfaceSamples& samples, const core::Pose& X_AB,
                          double voxel_size_m) {
  glm::dvec3 got(0.0), exact(0.0);
  for (std::size_t i = 0; i < samples.points_m.size(); ++i) {
    const glm::dvec3 p = X_AB * samples.points_m[i];
    const glm::dvec3 n = X_AB.rotate(samples.inward_normals[i]);
    const double depth = c.Depth_m(p, n);
    if (!(depth > -3.0 * voxel_size_m)) continue;  // outside exactly too: errors are below a voxel
    if (depth > 0.0) got += depth * samples.areas_m2[i] * n;
    const double d = c.A->SignedDistance(p);
    if (d < 0.0) exact -= d * samples.areas_m2[i] * n;
  }
  if (!(glm::length(exact) > 0.0) || !(glm::length(got) > 0.0)) return kNaN;
  return std::atan2(glm::length(glm::cross(got, exact)), glm::dot(got, exact)) * 180.0 / 3.14159265358979323846;
}

Errors DirectionErrors(const Comparison& c, const Workload& workload, double voxel_size_m) {
  struct Job {
    const Comparison* c;
    const Workload* workload;
    vps::SurfaceSamples samples;
    double voxel_size_m;
    std::vector<double> errors;
  } job{&c, &workload, EvenSamples(c.parts->B, kPoints), voxel_size_m,
        std::vector<double>(workload.independent.size())};
  bus::WorkerPool workers(2, "exact");
  workers.Run(
      job.errors.size(),
      [](void* context, std::size_t i) {
        Job& todo = *static_cast<Job*>(context);
        todo.errors[i] = DirectionError_deg(*todo.c, todo.samples, todo.workload->independent[i], todo.voxel_size_m);
      },
      &job);
  std::erase_if(job.errors, [](double e) { return !std::isfinite(e); });
  return {Quantile(job.errors, 0.5), Quantile(job.errors, 0.95), Quantile(job.errors, 1.0)};
}

// Share of samples of B with depth > 0, over all independent poses.
double WrongContacts(const Comparison& c, const Workload& workload) {
  const vps::SurfaceSamples samples = EvenSamples(c.parts->B, kPoints);
  std::size_t wrong = 0;
  for (const core::Pose& X_AB : workload.independent) {
    for (std::size_t i = 0; i < samples.points_m.size(); ++i) {
      wrong += c.Depth_m(X_AB * samples.points_m[i], X_AB.rotate(samples.inward_normals[i])) > 0.0;
    }
  }
  return static_cast<double>(wrong) / static_cast<double>(samples.points_m.size() * workload.independent.size());
}

}  // namespace

std::vector<FieldFigures> StudyField(const PartsAndWorkloads& made, Structures* structures) {
  const Parts& parts = *made.parts;
  const vps::oracle::MeshDistance exact(parts.A);
  // The goal for light contact is set at s = 1 mm.
  const double s = parts.name == "bunnies" ? 1e-3 : parts.voxel_size_m;
  std::vector<FieldFigures> rows;
  for (const vps::Method method : {vps::Method::kPaper, vps::Method::kFast}) {
    const auto A = structures->Get({false, method, s, 0});
    if (!A) continue;
    const bool is_fast = method == vps::Method::kFast;
    const Comparison c{&parts, &exact, is_fast ? nullptr : &*(*A)->voxmap, is_fast ? &*(*A)->field : nullptr};
    FieldFigures figures{parts.name, is_fast ? "fast" : "paper", s, DepthErrors(c, s), kNaN, {kNaN, kNaN, kNaN}};
    for (const Workload& workload : made.workloads) {
      if (workload.name == "peg_free") figures.wrong_contacts = WrongContacts(c, workload);
      if (&workload == &made.workloads.front()) figures.direction_deg = DirectionErrors(c, workload, s);
    }
    std::printf("%s, field of %s: depth error: mean %s, p95 %s, max %s voxels; direction error: %s / %s deg\n",
                parts.name.c_str(), figures.method.c_str(), Short(figures.depth_voxels.p50).c_str(),
                Short(figures.depth_voxels.p95).c_str(), Short(figures.depth_voxels.max).c_str(),
                Short(figures.direction_deg.p50).c_str(), Short(figures.direction_deg.p95).c_str());
    rows.push_back(figures);
  }
  return rows;
}

void ReportFields(const std::vector<FieldFigures>& rows, Report* report) {
  if (rows.empty()) return;
  Table table{"field_accuracy",
              {"parts", "method", "voxel_m", "depth_error_mean_voxels", "depth_error_p95_voxels",
               "depth_error_max_voxels", "direction_p50_deg", "direction_p95_deg", "wrong_contacts"},
              {}};
  Errors worst{0, 0, 0};
  for (const FieldFigures& f : rows) {
    table.Add({f.parts, f.method, Cell(f.voxel_size_m), Cell(f.depth_voxels.p50), Cell(f.depth_voxels.p95),
               Cell(f.depth_voxels.max), Cell(f.direction_deg.p50), Cell(f.direction_deg.p95), Cell(f.wrong_contacts)});
    if (f.method != "fast") continue;
    worst = {std::max(worst.p50, f.depth_voxels.p50), std::max(worst.p95, f.depth_voxels.p95),
             std::max(worst.max, f.depth_voxels.max)};
    const auto direction = [&](const char* what, double median, double p95) {
      report->AddGoal(std::string("force direction from the field alone: ") + what,
                      "<= " + Short(median) + " / " + Short(p95) + " deg",
                      Short(f.direction_deg.p50) + " / " + Short(f.direction_deg.p95) + " deg, median / p95",
                      f.direction_deg.p50 <= median && f.direction_deg.p95 <= p95);
    };
    if (f.parts == "bunnies") direction("bunny_light, s = 1 mm", 0.25, 1.5);
    if (f.parts == "peg") direction("peg_pressed, s = 0.25 mm", 0.1, 0.6);
    if (f.parts == "nut") direction("nut_pressed, s = 0.25 mm", 0.3, 1.5);
    if (std::isfinite(f.wrong_contacts)) {
      report->AddGoal("free peg in the tight hole, s = 0.25 mm: points that report contact", "<= 0.01 %",
                      Short(100.0 * f.wrong_contacts) + " %", f.wrong_contacts <= 1e-4);
    }
  }
  report->tables.push_back(table);
  report->AddGoal("depth error within 1.5 s of the surface, worst of all parts: mean / p95 / max",
                  "<= 0.02 / 0.1 / 0.3 s",
                  Short(worst.p50) + " / " + Short(worst.p95) + " / " + Short(worst.max) + " s",
                  worst.p50 <= 0.02 && worst.p95 <= 0.1 && worst.max <= 0.3);
}

}  // namespace contact
