#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "bus/rt/worker_pool.hpp"
#include "core/clock.hpp"
#include "tools/contact/methods/answer_table.hpp"
#include "tools/contact/methods/method.hpp"
#include "tools/contact/methods/pose_table.hpp"
#include "tools/contact/methods/setup.hpp"
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
  fx,fy,fz            force on B per unit modulus, A's frame: integral over the sampled surface inside the other body
                      of depth times inward normal dA, of A's surface its opposite, m^3
  mx,my,mz            its moment about B's mesh origin, A's frame, m^4
  force_error         fast and oracle: estimate of the force's error, m^3

Sampled is the body with the smaller feature (thinnest wall, narrowest gap), B where they are alike, whatever the
method. Voxels and points follow from both bodies' features and the accuracy. What was chosen, and why, is printed.

Methods:
  paper    voxelmap of one body, points of the other. Force and moment are its own sums, lambda(n,N) sum V n in m and
           lambda sum P x V n in m^2 [VR-OOS, Eq. 1-2]. Apart, the distance is a lower bound.
  fast     distance field of one body; samples of the other, and its surface, refined until the estimated error of the
           force is below --accuracy: the integral above.
  oracle   exact distance, depth to 1e-3, the integral to 1e-4. Slow. Takes no resolution.)";

struct QueryRequest {
  std::string method;
  contact::SetupWish setup;
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
                      "--accuracy: only --method fast takes one; of paper choose --voxel_m and --points");
  }
  const auto positive = [&](std::string_view name, double fallback) -> core::Result<double> {
    const auto value = arguments.number(name);
    if (!value) return tl::unexpected(value.error());
    if (value->has_value() && !(**value > 0.0 && std::isfinite(**value))) {
      return core::Fail(core::ErrorCode::kInvalidInput, std::string(name) + " must be greater than 0");
    }
    return value->value_or(fallback);
  };
  const auto accuracy = positive("--accuracy", request.setup.accuracy);
  if (accuracy && *accuracy >= 1.0) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "--accuracy must be below 1: it is a share of the integral of depth, such as 0.02");
  }
  const auto voxel = positive("--voxel_m", 0.0);
  const auto points = positive("--points", 0.0);
  const auto scale = positive("--scale", 1.0);
  const auto sheet = positive("--sheet_thickness_m", 0.0);
  for (const auto* value : {&accuracy, &voxel, &points, &scale, &sheet}) {
    if (!*value) return tl::unexpected(value->error());
  }
  if (*points != std::floor(*points) || *points > 4e9) {
    return core::Fail(core::ErrorCode::kInvalidInput, "--points must be a whole number");
  }
  const std::string sampled = arguments.text("--sampled", "");
  if (!sampled.empty() && sampled != "A" && sampled != "B") {
    return core::Fail(core::ErrorCode::kInvalidInput, "--sampled is A or B, not '" + sampled + "'");
  }
  if (!sampled.empty()) request.setup.is_A_sampled = sampled == "A";
  request.setup.method = vps::MethodFromName(request.method);
  request.setup.given = {*voxel, static_cast<std::uint32_t>(*points)};
  request.setup.accuracy = *accuracy;
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

// S is sampled, G is the field.
core::Result<std::unique_ptr<contact::Method>> MakeMethod(const vps::TriangleMesh& G, const vps::TriangleMesh& S,
                                                          const QueryRequest& request, const contact::Setup& setup,
                                                          core::ParallelFor* workers) {
  if (request.method == "oracle") return contact::MakeOracleMethod(G, S);
  ProgressLine line_G(setup.is_A_sampled ? "B" : "A", stderr, false);
  ProgressLine line_S(setup.is_A_sampled ? "A" : "B", stderr, false);
  const contact::Cooking cooking{line_G.AsProgress(), line_S.AsProgress(), workers};
  if (request.method == "paper") return contact::MakePaperMethod(G, S, setup.resolution, cooking);
  return contact::MakeFastMethod(G, S, setup.resolution, {request.setup.accuracy}, cooking);
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
  const contact::Setup setup = contact::ChooseSetup(A->mesh, B->mesh, request->setup);
  std::printf("%s\n", setup.text.c_str());
  auto method = setup.is_A_sampled ? MakeMethod(B->mesh, A->mesh, *request, setup, &workers)
                                   : MakeMethod(A->mesh, B->mesh, *request, setup, &workers);
  if (!method) return fail(method.error());
  if (setup.is_A_sampled) method = contact::Turned(std::move(*method));
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
           {"--voxel_m", "SIZE", "edge of a voxel, m; default: chosen by the bodies' features and the accuracy"},
           {"--points", "N", "points on the sampled surface; default: one voxel apart, 1,000 to 100,000"},
           {"--sampled", "A|B", "whose surface is integrated; default: the one with the smaller feature"},
           {"--scale", "S", "factor of both meshes' coordinates, 0.001 for millimetres; default 1"},
           {"--sheet_thickness_m", "T", "takes an open mesh as a sheet with two sides, T thick"}},
          RunQuery,
          kQueryDetails};
}

}  // namespace oos
