#include "tools/contact/training_poses.hpp"

#include <cstdio>
#include <fstream>
#include <sstream>

namespace contact {
namespace {

// Not derived: a third of a second each for their references.
constexpr int kPosesOfEachKind = 2;

// Public parts come from files that need not be here, and remeshed ones are the same part three times.
std::vector<std::string> Families() {
  std::vector<std::string> families = vps::WrenchFamilies();
  std::erase_if(families, [](const std::string& family) { return family == "public" || family == "remeshed"; });
  return families;
}

// Of every second family the case in which the roles of the parts are exchanged.
std::vector<vps::WrenchCase> MakeCases(int poses_each) {
  std::vector<vps::WrenchCase> cases;
  const std::vector<std::string> families = Families();
  for (std::size_t i = 0; i < families.size(); ++i) {
    auto made = vps::MakeWrenchCases(families[i], vps::CaseSet::kTraining, poses_each, {});
    if (made) cases.push_back(std::move((*made)[i % made->size()]));  // an error could only be of a file
  }
  return cases;
}

std::filesystem::path FileIn(const std::filesystem::path& folder) {
  return folder / "training_references_" VR_OOS_SOURCE_OF_REFERENCES ".txt";
}

// A line: number of the case, kind and number of the pose, then its pose and its reference.
constexpr std::size_t kNumbers = 17;

void Write(const std::vector<TrainingCase>& cases, const std::filesystem::path& path) {
  std::ofstream file(path);
  file.precision(17);
  for (std::size_t i = 0; i < cases.size(); ++i) {
    for (const ReferencePose& p : cases[i].posed) {
      const auto& [q, t] = p.pose.X_AB;
      const vps::oracle::ContactWrench& w = p.reference;
      file << i << ' ' << static_cast<int>(p.pose.kind) << ' ' << p.number;
      for (const double value : {q.w, q.x, q.y, q.z, t.x, t.y, t.z, w.force_A_m3.x, w.force_A_m3.y, w.force_A_m3.z,
                                 w.moment_A_m4.x, w.moment_A_m4.y, w.moment_A_m4.z, w.depth_integral_m3}) {
        file << ' ' << value;
      }
      file << '\n';
    }
  }
}

// False: there is no such file, or it was not written to its end.
bool Read(const std::filesystem::path& path, std::vector<TrainingCase>* cases) {
  std::ifstream file(path);
  std::string line;
  std::size_t count = 0;
  while (std::getline(file, line)) {
    std::istringstream text(line);
    std::vector<double> v(kNumbers);
    for (double& value : v) text >> value;
    if (!text || v[0] >= static_cast<double>(cases->size())) return false;
    ReferencePose p;
    p.pose.kind = static_cast<vps::PoseKind>(static_cast<int>(v[1]));
    p.number = static_cast<std::size_t>(v[2]);
    p.pose.X_AB = {{v[3], v[4], v[5], v[6]}, {v[7], v[8], v[9]}};
    p.reference.force_A_m3 = {v[10], v[11], v[12]};
    p.reference.moment_A_m4 = {v[13], v[14], v[15]};
    p.reference.depth_integral_m3 = v[16];
    (*cases)[static_cast<std::size_t>(v[0])].posed.push_back(p);
    ++count;
  }
  return count > 0;
}

std::vector<TrainingCase> WithoutPoses() {
  std::vector<TrainingCase> cases;
  for (vps::WrenchCase& c : MakeCases(0)) cases.push_back({std::move(c), {}});
  return cases;
}

}  // namespace

std::vector<TrainingCase> TrainingCases(const std::filesystem::path& folder) {
  std::vector<TrainingCase> cases = WithoutPoses();
  if (!folder.empty() && Read(FileIn(folder), &cases)) return cases;
  std::printf("training: exact wrenches are made, which takes some minutes\n");
  cases.clear();
  int num_without = 0;
  for (vps::WrenchCase& c : MakeCases(kPosesOfEachKind)) {
    std::vector<ReferencePose> posed = WithReferences(c, &num_without);
    std::printf("  %s %s: %zu poses\n", c.family.c_str(), c.name.c_str(), posed.size());
    c.poses.clear();
    cases.push_back({std::move(c), std::move(posed)});
  }
  std::printf("training: %d poses without a reference\n", num_without);
  if (!folder.empty()) {
    // Whole or not at all.
    const std::filesystem::path unfinished = FileIn(folder).replace_extension(".part");
    Write(cases, unfinished);
    std::filesystem::rename(unfinished, FileIn(folder));
  }
  return cases;
}

}  // namespace contact
