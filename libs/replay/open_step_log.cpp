#include "replay/open_step_log.hpp"

#include <cstdio>
#include <fstream>
#include <iterator>
#include <set>

#include "core/hash.hpp"
#include "replay/platform.hpp"

namespace replay {
namespace {

std::string BytesOf(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

std::uint64_t DigestOf(const scene::Scenario& scenario) {
  std::set<std::filesystem::path> meshes;
  for (const scene::Object& object : scenario.objects) {
    meshes.insert(object.visual_mesh);
    meshes.insert(object.collision_mesh);
  }
  std::uint64_t digest = core::Hash64(BytesOf(scenario.file));
  digest = core::Hash64(BytesOf(scenario.procedure), digest);
  digest = core::Hash64(BytesOf(scenario.operator_script), digest);
  for (const std::filesystem::path& mesh : meshes) digest = core::Hash64(BytesOf(mesh), digest);
  return digest;
}

bus::log::TextMap DescribeRun(const scene::Scenario& scenario) {
  bus::log::TextMap about = DescribePlatform();
  const std::filesystem::path here = scenario.file.lexically_relative(std::filesystem::current_path());
  about["scenario"] = here.empty() || *here.begin() == ".." ? scenario.file.string() : here.string();
  char digest[20];
  std::snprintf(digest, sizeof digest, "%016llx", static_cast<unsigned long long>(DigestOf(scenario)));
  about["scenario_digest"] = digest;
  about["method"] = scenario.method;
  about["coupling"] = scenario.coupling.type;
  about["seed"] = std::to_string(scenario.seed);
  return about;
}

std::string CheckpointName(const std::string& node) {
  return node + ".checkpoint";
}

core::Result<std::unique_ptr<bus::log::StepLog>> OpenStepLog(const std::filesystem::path& file, const std::string& node,
                                                             const std::string& fields, const bus::log::TextMap& about,
                                                             const std::vector<std::uint8_t>& checkpoint) {
  auto opened = bus::log::StepFile::Create(file);
  if (!opened) return tl::unexpected(opened.error());
  const std::uint16_t channel = (*opened)->AddNode(node, fields, about);
  if (!checkpoint.empty()) {
    if (auto done = (*opened)->Attach(CheckpointName(node), checkpoint); !done) return tl::unexpected(done.error());
  }
  return std::make_unique<bus::log::StepLog>(std::move(*opened), node, channel);
}

}  // namespace replay
