#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "core/clock.hpp"
#include "tools/contact/answer_table.hpp"
#include "tools/contact/method.hpp"
#include "tools/contact/pose_table.hpp"
#include "tools/oos/verb.hpp"
#include "vps/mesh/load_mesh.hpp"

namespace oos {
namespace {

constexpr std::string_view kDetails =
    R"(Poses: rows px,py,pz,qw,qx,qy,qz: pose of B's mesh frame in A's, metres, unit quaternion. A heading line, empty lines
and lines that begin with # are skipped.

Output: signed_distance_m,fx,fy,fz,mx,my,mz,contacts,points_tested,time_us, one row for each pose.
  signed_distance_m   of the two bodies; negative: deepest penetration
  fx,fy,fz            force on B per unit modulus, A's frame: integral over B's surface inside A of depth times B's
                      inward normal dA, m^3
  mx,my,mz            its moment about B's mesh origin, A's frame, m^4

Methods:
  paper    voxelmap of A, points of B. Force and moment are its own sums, lambda(n,N) sum V n in m and
           lambda sum P x V n in m^2 [VR-OOS, Eq. 1-2]. Apart, the distance is a lower bound. --accuracy_m X takes
           voxels of 3 X; by default a voxel is 1/256 of A's longest side; points default to one voxel apart.
  fast     distance field of A, area-weighted samples of B: the integral above. Resolution as for paper.
  oracle   exact distance, depth to 1e-3, the integral to 1e-4. Slow. Takes no resolution.)";

struct Request {
  std::string method;
  contact::Resolution resolution;
  double scale = 1.0;
};

core::Result<Request> ReadRequest(const Arguments& arguments) {
  Request request;
  request.method = arguments.text("--method", "paper");
  if (request.method != "paper" && request.method != "fast" && request.method != "oracle") {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      "--method " + request.method + ": no such method; known: paper fast oracle");
  }
  const auto positive = [&](std::string_view name, double fallback) -> core::Result<double> {
    const auto value = arguments.number(name);
    if (!value) return tl::unexpected(value.error());
    if (value->has_value() && !(**value > 0.0 && std::isfinite(**value))) {
      return core::Fail(core::ErrorCode::kInvalidInput, std::string(name) + " must be greater than 0");
    }
    return value->value_or(fallback);
  };
  const auto accuracy = positive("--accuracy_m", 0.0);
  const auto voxel = positive("--voxel_m", 0.0);
  const auto points = positive("--points", 0.0);
  const auto scale = positive("--scale", 1.0);
  for (const auto* value : {&accuracy, &voxel, &points, &scale}) {
    if (!*value) return tl::unexpected(value->error());
  }
  if (*accuracy > 0.0 && (*voxel > 0.0 || *points > 0.0)) {
    return core::Fail(core::ErrorCode::kInvalidInput, "--accuracy_m chooses --voxel_m and --points: give it alone");
  }
  if (*points != std::floor(*points) || *points > 4e9) {
    return core::Fail(core::ErrorCode::kInvalidInput, "--points must be a whole number");
  }
  request.resolution = {*accuracy, *voxel, static_cast<std::uint32_t>(*points)};
  request.scale = *scale;
  return request;
}

int Run(const Arguments& arguments) {
  const auto fail = [](const core::Error& error) { return Complain("query", error.detail, kBadUsage); };
  if (!arguments.has("--poses")) return Complain("query", "--poses FILE is missing", kBadUsage);
  if (!arguments.has("--out")) return Complain("query", "--out FILE is missing", kBadUsage);
  const auto request = ReadRequest(arguments);
  if (!request) return fail(request.error());
  const auto poses = contact::ReadPoseTable(arguments.text("--poses"));
  if (!poses) return fail(poses.error());
  const auto A = vps::LoadMesh(arguments.positional()[0], request->scale);
  if (!A) return fail(A.error());
  const auto B = vps::LoadMesh(arguments.positional()[1], request->scale);
  if (!B) return fail(B.error());
  auto table = contact::AnswerTable::Create(arguments.text("--out"));
  if (!table) return fail(table.error());

  const std::int64_t begin_ns = core::MonotonicNow_ns();
  auto method = request->method == "oracle" ? contact::MakeOracleMethod(*A, *B)
                : request->method == "fast" ? contact::MakeFastMethod(*A, *B, request->resolution)
                                            : contact::MakePaperMethod(*A, *B, request->resolution);
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
          "distance and contact wrench of two meshes at given poses",
          "A B --poses POSES.csv --out OUT.csv",
          2,
          2,
          {{"--poses", "FILE", "poses of B in A's frame"},
           {"--out", "FILE", "where the answers go"},
           {"--method", "NAME", "paper (default), fast or oracle"},
           {"--accuracy_m", "X", "wanted error of a depth, m"},
           {"--voxel_m", "SIZE", "edge of a voxel of A's field, m"},
           {"--points", "N", "points on B's surface"},
           {"--scale", "S", "factor of both meshes' coordinates, 0.001 for millimetres; default 1"}},
          Run,
          kDetails};
}

}  // namespace oos
