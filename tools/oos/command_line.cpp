#include "tools/oos/command_line.hpp"

#include <cstdio>

#include "bus/log/source_version.hpp"
#include "tools/oos/bench/verbs.hpp"
#include "tools/oos/check/verbs.hpp"
#include "tools/oos/device/verbs.hpp"
#include "tools/oos/doctor/verbs.hpp"
#include "tools/oos/launch/verbs.hpp"
#include "tools/oos/live/verbs.hpp"
#include "tools/oos/meshes/verbs.hpp"
#include "tools/oos/record/verbs.hpp"
#include "tools/oos/replay/verbs.hpp"
#include "tools/oos/run/verbs.hpp"
#include "tools/oos/stars/verbs.hpp"
#include "tools/oos/sweep/verbs.hpp"

namespace oos {
namespace {

int PrintVersion() {
  std::printf("oos %s (%s)\n", VR_OOS_VERSION, bus::log::SourceVersion().c_str());
  return kHolds;
}

}  // namespace

std::vector<Verb> AllVerbs() {
  return {RunVerb(),    CheckVerb(),  CookVerb(),   DoctorVerb(),    DeviceVerb(),  TopicVerb(),    TopVerb(),
          ViewVerb(),   SweepVerb(),  SetVerb(),    LatencyVerb(),   ReportVerb(),  InspectVerb(),  QueryVerb(),
          BenchVerb(),  RecordVerb(), InfoVerb(),   CatVerb(),       RecoverVerb(), MergeVerb(),    DiffVerb(),
          ExportVerb(), LaunchVerb(), StatusVerb(), AttachVerb(),    StopVerb(),    RegistryVerb(), ClockVerb(),
          ReplayVerb(), FetchVerb(),  StarsVerb(),  AtmosphereVerb()};
}

int RunCommandLine(const std::vector<std::string>& words) {
  if (words.size() == 1 && words[0] == "--version") return PrintVersion();
  return RunVerbs(AllVerbs(), words);
}

}  // namespace oos
