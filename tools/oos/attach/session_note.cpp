#include "tools/oos/attach/session_note.hpp"

#include <nlohmann/json.hpp>

#include "tools/oos/attach/places.hpp"

namespace oos {

std::string ToJson(const SessionNote& note) {
  const nlohmann::json json = {{"registry", note.registry}, {"session", note.session}, {"pid", note.pid},
                               {"out", note.out},           {"keys", note.keys},       {"scenario", note.scenario}};
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

core::Result<SessionNote> ParseSessionNote(const std::string& json) {
  const nlohmann::json note = nlohmann::json::parse(json, nullptr, false);
  const auto text = [&note](const char* name) {
    const auto found = note.is_object() ? note.find(name) : note.end();
    return found != note.end() && found->is_string() ? found->get<std::string>() : std::string();
  };
  SessionNote read{text("registry"), text("session"), 0, text("out"), text("keys"), text("scenario")};
  if (read.registry.empty() || read.session.empty()) {
    return core::Fail(core::ErrorCode::kNotFound, "the note names no registry and session");
  }
  if (note.contains("pid") && note["pid"].is_number_integer()) read.pid = note["pid"].get<pid_t>();
  return read;
}

core::Result<SessionNote> FindSessionNote() {
  const auto text = ReadSessionNote();
  if (!text) return tl::unexpected(text.error());
  return ParseSessionNote(*text);
}

}  // namespace oos
