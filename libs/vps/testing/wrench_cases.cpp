#include "vps/testing/wrench_cases.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "vps/mesh/check_mesh.hpp"
#include "vps/testing/part_shapes.hpp"
#include "vps/testing/shapes.hpp"

namespace vps {
namespace {

// Not derived: more cases take longer and show more. An even number, so that both roles occur equally often.
constexpr int kDraws = 2;

struct Pair {
  std::string name;
  TriangleMesh A, B;
};

// The sizes below are those of parts that a hand holds; they are not derived further.
glm::dvec3 BlockSize(double low_m, double high_m, CaseRandom* r) {
  return {r->Uniform(low_m, high_m), r->Uniform(low_m, high_m), r->Uniform(low_m, high_m)};
}

TriangleMesh Block(CaseRandom* r) {
  return MakeBevelledBlock(BlockSize(0.03, 0.08, r), r->Uniform(2e-4, 3e-3));
}

TriangleMesh Rod(CaseRandom* r) {
  Thread thread;
  thread.radius_m = r->Uniform(4e-3, 0.012);
  thread.pitch_m = thread.radius_m * r->Uniform(0.15, 0.35);
  thread.depth_m = thread.pitch_m * r->Uniform(0.3, 0.6);
  thread.num_turns = static_cast<int>(r->Uniform(6.0, 12.0));
  thread.num_segments = 4 * static_cast<int>(r->Uniform(6.0, 10.0));
  return MakeThreadedRod(thread);
}

TriangleMesh ThinWalled(int draw, CaseRandom* r) {
  const double wall_m = r->Uniform(4e-4, 2e-3);
  if (draw % 2 == 0) return MakeTray(BlockSize(0.03, 0.07, r), wall_m);
  const double radius_m = r->Uniform(0.01, 0.03);
  return MakeTube(radius_m, radius_m - wall_m, r->Uniform(0.02, 0.06), static_cast<int>(r->Uniform(32.0, 96.0)));
}

TriangleMesh Wedge(int draw, CaseRandom* r) {
  const double height_m = r->Uniform(0.015, 0.04);
  const double width_m = height_m * r->Uniform(0.2, 1.0);
  return MakeWedge(r->Uniform(0.02, 0.06), width_m, height_m, draw % 2 == 0 ? 0.0 : r->Uniform(5e-5, 5e-4));
}

TriangleMesh Sheet(int draw, CaseRandom* r) {
  const double length_m = r->Uniform(0.03, 0.08);
  return MakeBentSheet(length_m, r->Uniform(0.02, 0.06), r->Uniform(3e-4, 1.2e-3),
                       draw % 2 == 0 ? 0.0 : length_m * r->Uniform(0.01, 0.08), 48);
}

TriangleMesh Needle(CaseRandom* r) {
  const double radius_m = r->Uniform(5e-4, 2e-3);
  return MakeNeedle(radius_m, r->Uniform(0.03, 0.06), radius_m * r->Uniform(3.0, 12.0),
                    radius_m * r->Uniform(0.03, 0.2), 24);
}

TriangleMesh Corrugated(CaseRandom* r) {
  return MakeCorrugatedPlate({r->Uniform(0.03, 0.07), r->Uniform(0.03, 0.07), r->Uniform(4e-3, 0.01)},
                             r->Uniform(2e-5, 6e-5), static_cast<int>(r->Uniform(4.0, 16.0)));
}

TriangleMesh Lumpy(CaseRandom* r) {
  const double radius_m = r->Uniform(0.015, 0.04);
  const int num_segments = 2 * static_cast<int>(r->Uniform(48.0, 90.0));
  const double facet_m = 6.28 * radius_m / num_segments;
  return MakeLumpyBall(radius_m, radius_m * r->Uniform(0.05, 0.3), facet_m * r->Uniform(0.02, 0.1), num_segments,
                       static_cast<std::uint64_t>(r->Uniform(0.0, 1e9)));
}

TriangleMesh Split(TriangleMesh mesh, int times, double fraction) {
  for (int i = 0; i < times; ++i) mesh = SplitTriangles(mesh, fraction);
  return mesh;
}

// One part meshed coarsely, finely and with slivers, on the same other part.
std::vector<Pair> Remeshed(int draw, CaseRandom* r) {
  const TriangleMesh part = Block(r);
  const TriangleMesh other = draw % 2 == 0 ? Block(r) : Wedge(1, r);
  std::vector<Pair> pairs;
  for (const auto& [name, mesh] : {std::pair{"coarse", part}, std::pair{"fine", Split(part, 5, 0.5)},
                                   std::pair{"slivers", Split(part, 3, 0.01)}}) {
    pairs.push_back({name, other, mesh});
  }
  return pairs;
}

std::vector<Pair> Draw(const std::string& family, int draw, CaseRandom* r) {
  if (family == "remeshed") return Remeshed(draw, r);
  Pair pair;
  pair.A = family == "scanned" ? Lumpy(r) : Block(r);
  if (family == "bevelled") pair.B = Block(r);
  if (family == "threaded") pair.B = Rod(r);
  if (family == "thin_walled") pair.B = ThinWalled(draw / 2, r);
  if (family == "sharp") pair.B = Wedge(draw / 2, r);
  if (family == "sheets") pair.B = Sheet(draw / 2, r);
  if (family == "needles") pair.B = Needle(r);
  if (family == "long_edges") pair.B = Corrugated(r);
  if (family == "scanned") pair.B = Lumpy(r);
  return {pair};
}

std::uint64_t Seed(const std::string& family, CaseSet set, int draw) {
  const auto& all = WrenchFamilies();
  const auto number = static_cast<std::uint64_t>(std::find(all.begin(), all.end(), family) - all.begin());
  return 1000 * (number + 1) + 100 * static_cast<std::uint64_t>(set) + static_cast<std::uint64_t>(draw);
}

std::vector<WrenchCase> Generate(const std::string& family, CaseSet set, int poses_each) {
  std::vector<WrenchCase> cases;
  for (int draw = 0; draw < kDraws; ++draw) {
    CaseRandom random(Seed(family, set, draw));
    std::vector<ContactPose> poses;  // the same for all meshes of one part
    for (Pair& pair : Draw(family, draw, &random)) {
      WrenchCase c{family,
                   set,
                   std::to_string(draw) + (pair.name.empty() ? "" : "_" + pair.name),
                   std::move(pair.A),
                   std::move(pair.B),
                   {}};
      if (draw % 2 == 1) std::swap(c.A, c.B);
      if (poses.empty()) poses = MakeContactPoses(c.A, c.B, poses_each, &random);
      c.poses = poses;
      cases.push_back(std::move(c));
    }
  }
  return cases;
}

// A peg in a block with a hole, pressed aside along whole lines or faces, and both from outside.
std::vector<WrenchCase> Pegs(CaseSet set, int poses_each) {
  std::vector<WrenchCase> cases;
  for (int draw = 0; draw < kDraws; ++draw) {
    CaseRandom r(Seed("pegs", set, draw));
    const double radius_m = r.Uniform(4e-3, 0.012);
    const double clearance_m = radius_m * r.Uniform(2e-3, 0.05);
    const double height_m = radius_m * r.Uniform(1.5, 3.0);
    const int num_segments = 8 * static_cast<int>(r.Uniform(6.0, 16.0));
    WrenchCase c{"pegs",
                 set,
                 std::to_string(draw),
                 MakeBlockWithHole(radius_m * r.Uniform(3.0, 5.0), height_m, radius_m + clearance_m, num_segments),
                 MakeCylinder(radius_m, radius_m * r.Uniform(3.0, 5.0), num_segments),
                 {}};
    c.poses = MakeContactPoses(c.A, c.B, poses_each, &r);
    const PegFit fit{{}, clearance_m, 0.4 * height_m};
    for (const ContactPose& pose : MakePressedPoses(c.A, c.B, fit, 2 * poses_each, &r)) c.poses.push_back(pose);
    cases.push_back(std::move(c));
  }
  return cases;
}

struct PublicPair {
  const char* name;
  const char* A;
  const char* B;
  double largest_side_A_m, largest_side_B_m;  // 0: as the file has it
  double clearance_m;                         // radial, measured in the files; 0: not a round peg in a hole
};

const std::vector<PublicPair>& PublicPairs(CaseSet set) {
  static const std::vector<PublicPair> training = {
      {"fandisk_on_bunny", "stanford_bunny.obj", "fandisk.obj", 0.1, 0.1, 0.0},
      {"gears", "factory_gear_base_loose_space_5e-4_subdiv_4x.obj", "factory_gear_small_space_5e-4.obj", 0, 0, 0},
      {"nut_on_bolt", "factory_bolt_m16_tight.obj", "factory_nut_m16_tight_subdiv_3x.obj", 0.0, 0.0, 0.0}};
  static const std::vector<PublicPair> held_out = {
      {"round_16mm", "factory_round_hole_16mm_subdiv_3x.obj", "factory_round_peg_16mm_loose.obj", 0.0, 0.0, 2.5e-4},
      {"round_8mm", "factory_round_hole_8mm_subdiv_3x.obj", "factory_round_peg_8mm_tight.obj", 0.0, 0.0, 5e-5},
      {"rectangular", "factory_rectangular_hole_8mm_subdiv_3x.obj", "factory_rectangular_peg_8mm_loose_subdiv_3x.obj",
       0.0, 0.0, 0.0}};
  return set == CaseSet::kTraining ? training : held_out;
}

// Mended, its box's middle in the origin.
core::Result<TriangleMesh> LoadPublic(const std::filesystem::path& file, double largest_side_m) {
  auto checked = LoadCheckedMesh(file);
  if (!checked) return tl::unexpected(checked.error());
  TriangleMesh mesh = std::move(checked->mesh);
  const Box box = BoundingBox(mesh);
  const glm::dvec3 size = box.upper - box.lower;
  const double scale = largest_side_m > 0.0 ? largest_side_m / std::max({size.x, size.y, size.z}) : 1.0;
  for (glm::dvec3& v : mesh.vertices) v = scale * (v - 0.5 * (box.lower + box.upper));
  return mesh;
}

core::Result<std::vector<WrenchCase>> LoadCases(CaseSet set, int poses_each, const std::filesystem::path& folder) {
  std::vector<WrenchCase> cases;
  int draw = 0;
  for (const PublicPair& pair : PublicPairs(set)) {
    auto A = LoadPublic(folder / pair.A, pair.largest_side_A_m);
    if (!A) return tl::unexpected(A.error());
    auto B = LoadPublic(folder / pair.B, pair.largest_side_B_m);
    if (!B) return tl::unexpected(B.error());
    CaseRandom random(Seed("public", set, draw++));
    WrenchCase c{"public", set, pair.name, std::move(*A), std::move(*B), {}};
    c.poses = MakeContactPoses(c.A, c.B, poses_each, &random);
    if (pair.clearance_m > 0.0) {
      const PegFit fit{{}, pair.clearance_m, 0.02};
      for (const ContactPose& pose : MakePressedPoses(c.A, c.B, fit, poses_each, &random)) c.poses.push_back(pose);
    }
    cases.push_back(std::move(c));
  }
  return cases;
}

}  // namespace

std::string_view ToText(CaseSet set) {
  return set == CaseSet::kTraining ? "training" : "held_out";
}

const std::vector<std::string>& WrenchFamilies() {
  static const std::vector<std::string> names = {"bevelled", "threaded", "thin_walled", "sharp",
                                                 "sheets",   "needles",  "long_edges",  "pegs",
                                                 "scanned",  "remeshed", "public"};
  return names;
}

core::Result<std::vector<WrenchCase>> MakeWrenchCases(const std::string& family, CaseSet set, int poses_each,
                                                      const std::filesystem::path& public_meshes) {
  const auto& known = WrenchFamilies();
  if (std::find(known.begin(), known.end(), family) == known.end()) {
    return core::Fail(core::ErrorCode::kInvalidInput, "no family '" + family + "' of contact cases");
  }
  if (family == "public") return LoadCases(set, poses_each, public_meshes);
  return family == "pegs" ? Pegs(set, poses_each) : Generate(family, set, poses_each);
}

}  // namespace vps
