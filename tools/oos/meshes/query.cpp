#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "bus/rt/worker_pool.hpp"
#include "core/clock.hpp"
#include "tools/contact/methods/answer_table.hpp"
#include "tools/contact/methods/method.hpp"
#include "tools/contact/methods/pose_table.hpp"
#include "tools/oos/meshes/progress_line.hpp"
#include "tools/oos/meshes/verbs.hpp"
#include "vps/mesh/check_mesh.hpp"
#include "vps/mesh/load_mesh.hpp"
#include "vps/mesh/part_size.hpp"
#include "vps/mesh/thicken_sheet.hpp"

namespace oos {
namespace {

constexpr std::string_view kQueryDetails =
    R"(Poses: rows px,py,pz,qw,qx,qy,qz: pose of B's mesh frame in A's, metres, unit quaternion. A heading line, empty lines
and lines that begin with # are skipped.

Output: signed_distance_m,fx,fy,fz,mx,my,mz,contacts,points_tested,time_us,force_error, one row for each pose.
  signed_distance_m   of the two bodies; negative: deepest penetration
  fx,fy,fz            force on B per unit modulus, A's frame: integral over B's surface inside A of depth times B's
                      inward normal dA, m^3
  mx,my,mz            its moment about B's mesh origin, A's frame, m^4
  force_error         fast and oracle: estimate of the force's error, m^3

Methods:
  paper    voxelmap of A, points of B. Force and moment are its own sums, lambda(n,N) sum V n in m and
           lambda sum P x V n in m^2 [VR-OOS, Eq. 1-2]. Apart, the distance is a lower bound. --accuracy_m X takes
           voxels of 3 X; by default a voxel is 1/256 of A's longest side; points default to one voxel apart.
  fast     distance field of A; samples of B, and its surface, refined until the estimated error of the force is below
           --accuracy: the integral above. Resolution as for paper.
  oracle   exact distance, depth to 1e-3, the integral to 1e-4. Slow. Takes no resolution.)";

struct QueryRequest {
  std::string method;
  contact::Resolution resolution;
  double accuracy = contact::kAccuracy;  // of `fast`, relative
  double scale = 1.0;
  bool is_size_vouched = false;  // --scale was given: the user has checked the sizes
  double sheet_thickness_m = 0.0;
};

// A body of the query: a mesh that bounds a solid.
struct Body {
  vps::TriangleMesh mesh;
  vps::Box box;
};

core::Result<QueryRequest> ReadQueryRequest(const Arguments& arguments) {
  QueryRequest request;
  request.method = arguments.text("--method", "paper");
  if (request.method != "paper" && request.method != "fast" && request.method != "oracle") {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "--method " + request.method + ": no such method; known: paper fast oracle");
  }
  if (arguments.has("--accuracy") && request.method != "fast") {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "--accuracy: only --method fast takes a relative accuracy; --accuracy_m is that of a depth");
  }
  const auto positive = [&](std::string_view name, double fallback) -> core::Result<double> {
    const auto value = arguments.number(name);
    if (!value) return tl::unexpected(value.error());
    if (value->has_value() && !(**value > 0.0 && std::isfinite(**value))) {
      return core::Fail(core::ErrorCode::kInvalidInput, std::string(name) + " must be greater than 0");
    }
    return value->value_or(fallback);
  };
  const auto relative = positive("--accuracy", request.accuracy);
  const auto accuracy = positive("--accuracy_m", 0.0);
  const auto voxel = positive("--voxel_m", 0.0);
  const auto points = positive("--points", 0.0);
  const auto scale = positive("--scale", 1.0);
  const auto sheet = positive("--sheet_thickness_m", 0.0);
  for (const auto* value : {&relative, &accuracy, &voxel, &points, &scale, &sheet}) {
    if (!*value) return tl::unexpected(value->error());
  }
  if (*accuracy > 0.0 && (*voxel > 0.0 || *points > 0.0)) {
    return core::Fail(core::ErrorCode::kInvalidInput, "--accuracy_m chooses --voxel_m and --points: give it alone");
  }
  if (*points != std::floor(*points) || *points > 4e9) {
    return core::Fail(core::ErrorCode::kInvalidInput, "--points must be a whole number");
  }
  request.resolution = {*accuracy, *voxel, static_cast<std::uint32_t>(*points)};
  request.accuracy = *relative;
  request.scale = *scale;
  request.is_size_vouched = arguments.has("--scale");
  request.sheet_thickness_m = *sheet;
  return request;
}

// Checks and repairs the mesh; prints the repairs to stderr. An open mesh becomes a sheet if a thickness was given.
core::Result<Body> ReadBody(const std::string& file, const QueryRequest& request, core::ParallelFor* workers) {
  const auto triangles = vps::LoadTriangles(file, request.scale);
  if (!triangles) return tl::unexpected(triangles.error());
  auto checked = vps::CheckMesh(*triangles, false, workers);
  const bool is_sheet = !checked && request.sheet_thickness_m > 0.0;
  if (is_sheet) checked = vps::CheckMesh(*triangles, true, workers);
  if (!checked) return core::Fail(checked.error().code, file + ": the mesh " + checked.error().detail);
  if (const auto good = vps::CheckPartSize(file, checked->report.box); !good && !request.is_size_vouched) {
    return tl::unexpected(good.error());
  }
  for (const std::string& defect : vps::DescribeDefects(checked->report)) {
    std::fprintf(stderr, "oos query: note: %s: %s\n", file.c_str(), defect.c_str());
  }
  if (!is_sheet) return Body{std::move(checked->mesh), checked->report.box};
  return Body{vps::ThickenSheet(checked->mesh, request.sheet_thickness_m), checked->report.box};
}

core::Result<std::unique_ptr<contact::Method>> MakeMethod(const vps::TriangleMesh& A, const vps::TriangleMesh& B,
                                                          const QueryRequest& request, core::ParallelFor* workers) {
  if (request.method == "oracle") return contact::MakeOracleMethod(A, B);
  ProgressLine line_A("A", stderr, false);
  ProgressLine line_B("B", stderr, false);
  const contact::Cooking cooking{line_A.AsProgress(), line_B.AsProgress(), workers};
  if (request.method == "paper") return contact::MakePaperMethod(A, B, request.resolution, cooking);
  return contact::MakeFastMethod(A, B, request.resolution, {request.accuracy}, cooking);
}

int RunQuery(const Arguments& arguments) {
  const auto fail = [](const core::Error& error) { return Complain("query", error.detail, kBadUsage); };
  if (!arguments.has("--poses")) return Complain("query", "--poses FILE is missing", kBadUsage);
  if (!arguments.has("--out")) return Complain("query", "--out FILE is missing", kBadUsage);
  const auto request = ReadQueryRequest(arguments);
  if (!request) return fail(request.error());
  const auto poses = contact::ReadPoseTable(arguments.text("--poses"));
  if (!poses) return fail(poses.error());
  const std::string& file_A = arguments.positional()[0];
  const std::string& file_B = arguments.positional()[1];
  bus::WorkerPool workers(NumCookWorkers(), "cook");
  const auto A = ReadBody(file_A, *request, &workers);
  if (!A) return fail(A.error());
  const auto B = ReadBody(file_B, *request, &workers);
  if (!B) return fail(B.error());
  if (const auto good = vps::CheckSameUnit(file_A, A->box, file_B, B->box); !good && !request->is_size_vouched) {
    return fail(good.error());
  }
  auto table = contact::AnswerTable::Create(arguments.text("--out"));
  if (!table) return fail(table.error());

  const std::int64_t begin_ns = core::MonotonicNow_ns();
  auto method = MakeMethod(A->mesh, B->mesh, *request, &workers);
  if (!method) return fail(method.error());
  const std::int64_t built_ns = core::MonotonicNow_ns();
  for (const core::Pose& X_AB : *poses) {
    const std::int64_t start_ns = core::MonotonicNow_ns();
    const contact::Answer answer = (*method)->Query(X_AB);
    table->Add(answer, 1e-3 * static_cast<double>(core::MonotonicNow_ns() - start_ns));
  }
  if (const auto done = table->Commit(); !done) return fail(done.error());
  std::printf("%zu poses by %s: built in %.2f s, queried in %.2f s, written to %s\n", poses->size(),
              request->method.c_str(), 1e-9 * static_cast<double>(built_ns - begin_ns),
              1e-9 * static_cast<double>(core::MonotonicNow_ns() - built_ns), arguments.text("--out").c_str());
  return kHolds;
}

}  // namespace

Verb QueryVerb() {
  return {"query",
          "computes distance and contact wrench of two meshes at given poses",
          "A B --poses POSES.csv --out OUT.csv",
          2,
          2,
          {{"--poses", "FILE", "poses of B in A's frame"},
           {"--out", "FILE", "file for the results"},
           {"--method", "NAME", "paper (default), fast or oracle"},
           {"--accuracy", "X", "of fast: wanted error of the force over the integral of depth; default 0.02"},
           {"--accuracy_m", "X", "wanted error of a depth, m"},
           {"--voxel_m", "SIZE", "edge of a voxel of A's field, m"},
           {"--points", "N", "points on B's surface"},
           {"--scale", "S", "factor of both meshes' coordinates, 0.001 for millimetres; default 1"},
           {"--sheet_thickness_m", "T", "takes an open mesh as a sheet with two sides, T thick"}},
          RunQuery,
          kQueryDetails};
}

}  // namespace oos
