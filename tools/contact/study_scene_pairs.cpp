#include <algorithm>
#include <cstdio>
#include <string>

#include "core/clock.hpp"
#include "scene/load_scenario.hpp"
#include "tools/contact/accuracy_race.hpp"
#include "tools/contact/studies.hpp"
#include "vps/mesh/check_mesh.hpp"
#include "vps/mesh/load_mesh.hpp"

namespace contact {
namespace {

// Of what the shipped scenarios press together: fits, round on flat, flat on flat.
struct ScenePair {
  const char* file;
  const char* sampled;
  const char* field;
};
constexpr ScenePair kPairs[] = {
    {"peg_in_hole/scenario.xml", "peg", "hole"},
    {"peg_in_hole/tight.xml", "peg", "hole"},
    {"module_replacement/scenario.xml", "module_new", "cavity_a"},
    {"module_replacement/scenario.xml", "handle", "module_new"},
    {"touch/scenario.xml", "ball", "plate"},
    {"touch/scenario.xml", "block", "plate"},
};
constexpr double kAccuracies[] = {0.1, 0.05, 0.02, 0.01};
// Not derived, as for the held-out parts.
constexpr int kPosesOfEachKind = 3;
constexpr std::uint64_t kSeed = 28;
// A pair that has been in contact for some cycles.
constexpr int kQueries = 8;
// Ten times the error that does not count in a scenario (PairDescription::negligible_N): with less, 10 % of the force
// are below what a hand feels.
constexpr double kFelt_N = 0.1;

// By the force of a pair with the default stiffness k and rho: k V / max(A_c, rho A), with the touching area for A_c,
// which is not smaller.
bool IsFelt(const ReferencePose& pose, double area_B_m2) {
  const double carrying_m2 = std::max(pose.reference.area_m2, vps::WorldDescription{}.rho * area_B_m2);
  return vps::PairDescription{}.stiffness_N_per_m * pose.reference.depth_integral_m3 > kFelt_N * carrying_m2;
}

std::vector<Entrant> EntrantsOf() {
  const auto make_paper = [](const Parts& parts, const Resolution& resolution,
                             Structures* structures) -> core::Result<std::unique_ptr<Method>> {
    const auto A = structures->Get({false, vps::Method::kPaper, parts.voxel_size_m, 0});
    if (!A) return tl::unexpected(A.error());
    const auto B = structures->Get({true, vps::Method::kPaper, 0.0, resolution.num_points});
    if (!B) return tl::unexpected(B.error());
    return MakePaperMethod(*A, *B, vps::SurfaceArea_m2(parts.B), true);
  };
  std::vector<Entrant> entrants = {{"paper", "the scene's points", "", make_paper}};
  for (const double accuracy : kAccuracies) {
    entrants.push_back(FastEntrant(AsInScenarios(accuracy)));
    entrants.back().queries = kQueries;
  }
  return entrants;
}

core::Result<vps::TriangleMesh> LoadChecked(const std::filesystem::path& file) {
  auto triangles = vps::LoadTriangles(file);
  if (!triangles) return tl::unexpected(triangles.error());
  auto checked = vps::CheckMesh(*triangles);
  if (!checked) return core::Fail(checked.error().code, file.string() + ": the mesh " + checked.error().detail);
  return std::move(checked->mesh);
}

struct CaseOfScene {
  vps::WrenchCase parts;
  Resolution resolution;
};

core::Result<CaseOfScene> MakeCase(const ScenePair& pair, const std::filesystem::path& scenarios) {
  const auto scenario = scene::LoadScenario(scenarios / pair.file);
  if (!scenario) return core::Fail(core::ErrorCode::kInvalidInput, scene::Format(scenario.error().front()));
  const int s = scenario->FindObject(pair.sampled);
  const int g = scenario->FindObject(pair.field);
  if (s < 0 || g < 0) {
    return core::Fail(core::ErrorCode::kInvalidInput,
                      std::string(pair.file) + " has no object " + (s < 0 ? pair.sampled : pair.field));
  }
  const scene::Object& S = scenario->objects[static_cast<std::size_t>(s)];
  const scene::Object& G = scenario->objects[static_cast<std::size_t>(g)];
  auto A = LoadChecked(G.collision_mesh);
  if (!A) return tl::unexpected(A.error());
  auto B = LoadChecked(S.collision_mesh);
  if (!B) return tl::unexpected(B.error());
  CaseOfScene made;
  const std::string file(pair.file);
  const std::string scene = file.substr(0, file.find('/'));
  const std::string variant = file.substr(scene.size() + 1);
  made.parts.family = scene + (variant == "scenario.xml" ? "" : " " + variant.substr(0, variant.find('.')));
  made.parts.name = std::string(pair.sampled) + " on " + pair.field;
  made.parts.A = std::move(*A);
  made.parts.B = std::move(*B);
  made.resolution.voxel_size_m = G.voxel_size_m;
  made.resolution.num_points = S.num_points;
  vps::CaseRandom random(kSeed);
  made.parts.poses = vps::MakeContactPoses(made.parts.A, made.parts.B, kPosesOfEachKind, &random);
  return made;
}

Chart ChartOf(const std::vector<Row>& rows, const std::vector<Entrant>& entrants) {
  Chart chart{
      "What an accuracy costs in the shipped scenes",
      "contacts that may be felt, at the scenes' own voxels and points, within their budget; marks: the accuracy",
      {}};
  for (const int share : {0, 1}) {
    chart.panels.push_back(ErrorPanel("All pairs", share, "felt", vps::CaseSet::kTraining, rows, entrants));
  }
  return chart;
}

}  // namespace

void StudyScenePairs(const Places& places, Report* report) {
  const std::vector<Entrant> entrants = EntrantsOf();
  std::vector<Sample> samples;
  std::vector<std::string> names;
  int num_without = 0;
  for (const ScenePair& pair : kPairs) {
    const auto made = MakeCase(pair, places.scenarios);
    if (!made) {
      report->skipped.push_back("scenes: " + made.error().detail);
      std::printf("skipped %s\n", report->skipped.back().c_str());
      continue;
    }
    vps::WrenchCase c = made->parts;
    c.family += ": " + c.name;
    names.push_back(c.family);
    std::vector<Structures::Key> keys;
    for (const vps::Method method : {vps::Method::kPaper, vps::Method::kFast}) {
      keys.push_back({false, method, made->resolution.voxel_size_m, 0});
      keys.push_back({true, method, 0.0, made->resolution.num_points});
    }
    const double area_B_m2 = vps::SurfaceArea_m2(c.B);
    const auto is_felt = [&](const ReferencePose& pose) { return IsFelt(pose, area_B_m2); };
    Measure(c, made->resolution, WithReferences(c, &num_without), entrants, keys, is_felt, &samples);
  }
  names.emplace_back("felt");
  std::vector<Row> rows;
  for (const std::string& name : names) {
    for (std::size_t k = 0; k < entrants.size(); ++k) {
      rows.push_back(Summarize(name, vps::CaseSet::kTraining, k, samples,
                               [&](const Sample& s) { return s.is_felt && (name == "felt" || s.family == name); }));
    }
  }
  std::printf("\nscenes: %d poses without a reference\n", num_without);
  Print(rows, entrants);
  const Row* ten = nullptr;
  const Row* two = nullptr;
  for (const Row& r : rows) {
    if (r.what != "felt") continue;
    if (entrants[r.entrant].accuracy == 0.1) ten = &r;
    if (entrants[r.entrant].accuracy == 0.02) two = &r;
  }
  if (ten != nullptr && two != nullptr && two->p50_us > 0.0) {
    report->AddGoal("the scenes' contacts: median time at 10 % over that at 2 %", "<= 0.5",
                    Short(ten->p50_us / two->p50_us), ten->p50_us <= 0.5 * two->p50_us);
  }
  report->tables.push_back(TableOf("scene_pairs", "pair", rows, entrants));
  report->charts.emplace_back("scene_pairs", ChartOf(rows, entrants));
}

}  // namespace contact
