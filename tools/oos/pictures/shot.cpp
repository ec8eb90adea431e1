#include "tools/oos/pictures/shot.hpp"

#include <algorithm>

#include "tools/oos/attach/places.hpp"
#include "tools/oos/pictures/picture_source.hpp"
#include "tools/process/spawn.hpp"

namespace oos {
namespace {

constexpr std::string_view kFiles[] = {"--shot", "--depth", "--ids", "--hdr"};

}  // namespace

const std::vector<Option>& ShotOptions() {
  static const std::vector<Option> kOptions = {
      {"--shot", "FILE.png", "write one picture instead, without a session"},
      {"--depth", "FILE", "the same picture's depths: .png of 16 bits in mm, or .pfm in m; 0: nothing there"},
      {"--ids", "FILE.png", "the objects in it: 16 bits, 0: nothing; FILE.json names them"},
      {"--hdr", "FILE.pfm", "its light before exposure and tone curve: linear RGB; 1: a white wall that faces the sun"},
      {"--camera", "NAME", "of the picture; default: the one named after the procedure step, else the first"},
      {"--at", "S", "of a recording, from its first message; default: its end"},
      {"--scenario", "FILE", "of a recording; default: the one that it names"}};
  return kOptions;
}

bool IsShotWanted(const Arguments& arguments) {
  return std::any_of(std::begin(kFiles), std::end(kFiles),
                     [&](std::string_view option) { return arguments.has(option); });
}

int MakeShot(const Arguments& arguments) {
  if (arguments.positional().empty()) {
    return Complain("view", "a picture needs a scenario or a recording: oos view SCENARIO|FILE.mcap --shot FILE.png",
                    kBadUsage);
  }
  const auto source = FindPictureSource(arguments.positional()[0], arguments.text("--scenario"));
  if (!source) return Complain("view", source.error().detail, kBadUsage);
  process::Command command;
  command.name = "visual_node";
  command.program = ProgramFolder() / "visual_node";
  command.arguments = {"--scenario", source->scenario.string()};
  const auto pass_on = [&](std::string_view option, const char* as) {
    if (arguments.has(option)) command.arguments.insert(command.arguments.end(), {as, arguments.text(option)});
  };
  for (const std::string_view option : kFiles) pass_on(option, option.data());
  pass_on("--camera", "--view");
  pass_on("--at", "--at");
  pass_on("--show", "--show");
  for (const char* option : {"--size", "--layout", "--stereo", "--eye_distance_mm"}) pass_on(option, option);
  if (!source->recording.empty()) {
    command.arguments.insert(command.arguments.end(), {"--recording", source->recording.string()});
  }
  return Complain("view", process::Replace(command).value().detail, kDoesNotHold);
}

}  // namespace oos
