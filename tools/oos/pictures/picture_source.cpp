#include "tools/oos/pictures/picture_source.hpp"

#include <algorithm>
#include <array>
#include <fstream>

#include "bus/log/mcap_indexed_reader.hpp"
#include "scene/load_scenario.hpp"
#include "tools/oos/verb/find_scenario.hpp"

namespace oos {
namespace {

bool IsRecording(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return false;
  std::array<std::uint8_t, bus::log::kMcapMagic.size()> begin{};
  std::ifstream in(file, std::ios::binary);
  in.read(reinterpret_cast<char*>(begin.data()), begin.size());
  return in && begin == bus::log::kMcapMagic;
}

core::Result<std::filesystem::path> ScenarioFile(const std::filesystem::path& given) {
  const auto scenario = scene::LoadScenario(given);
  if (scenario) return std::filesystem::absolute(scenario->file);
  std::string what;
  for (const scene::Diagnostic& diagnostic : scenario.error()) {
    what += (what.empty() ? "" : "\n") + scene::Format(diagnostic);
  }
  return core::Fail(core::ErrorCode::kInvalidInput, what);
}

}  // namespace

core::Result<std::filesystem::path> RecordedScenarioFile(const std::filesystem::path& recording) {
  auto reader = bus::log::McapIndexedReader::Open(recording);
  if (!reader) return tl::unexpected(reader.error());
  const auto records = reader->ReadMetadata("scenario");
  if (!records) return tl::unexpected(records.error());
  for (const bus::log::Metadata& record : *records) {
    const auto file = record.entries.find("file");
    if (file == record.entries.end() || file->second.empty()) continue;
    std::error_code error;
    const std::filesystem::path named = file->second, beside = recording.parent_path() / named;
    return std::filesystem::exists(named, error) || !std::filesystem::exists(beside, error) ? named : beside;
  }
  return std::filesystem::path();
}

core::Result<PictureSource> FindPictureSource(const std::string& given, const std::string& scenario) {
  const std::filesystem::path path = FindScenario(given);
  PictureSource source;
  std::filesystem::path wanted = path;
  if (IsRecording(path)) {
    source.recording = std::filesystem::absolute(path);
    wanted = FindScenario(scenario);
    if (wanted.empty()) {
      auto recorded = RecordedScenarioFile(path);
      if (!recorded) return tl::unexpected(recorded.error());
      wanted = std::move(*recorded);
    }
    if (wanted.empty()) {
      return core::Fail(core::ErrorCode::kNotFound,
                        path.string() + " does not name its scenario; give it with --scenario");
    }
  }
  auto file = ScenarioFile(wanted);
  if (!file) {
    const char* hint = source.recording.empty() ? "" : "; name the scenario of the recording with --scenario";
    return core::Fail(core::ErrorCode::kInvalidInput, file.error().detail + hint);
  }
  source.scenario = std::move(*file);
  return source;
}

}  // namespace oos
