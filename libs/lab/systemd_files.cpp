#include "lab/unit_files.hpp"

namespace lab {
namespace {

std::string QuoteForSystemd(const std::string& word) {
  std::string escaped;
  for (const char c : word) escaped += c == '%' ? "%%" : c == '$' ? "$$" : std::string(1, c);
  return escaped.find_first_of(" ;\t\"") == std::string::npos && !escaped.empty() ? escaped : "'" + escaped + "'";
}

std::string UnitName(const Unit& unit) {
  return "oos-" + unit.name + ".service";
}

std::string UnitText(const Unit& unit, const HostPlan& plan) {
  std::string text = "[Unit]\nDescription=" + unit.name + " of " + plan.run_folder;
  if (!unit.socket.empty()) text += "\nAfter=oos-display.service";
  text += "\nStartLimitIntervalSec=10\nStartLimitBurst=4\n\n[Service]\nType=exec\nExecStart=";
  std::string blank;
  for (const std::string& word : WordsOf(unit)) {
    text += blank + QuoteForSystemd(word);
    blank = " ";
  }
  text += "\nWorkingDirectory=" + plan.run_folder + "\n";
  for (const auto& [name, value] : unit.environment)
    text += "Environment=" + QuoteForSystemd(name + "=" + value) + "\n";
  // A page's address with the session's key stands in its log.
  text += "UMask=0077\nStandardOutput=append:" + unit.log + "\nStandardError=append:" + unit.log + "\n";
  // A node that exits with 0 is finished; any other exit restarts it at once.
  text +=
      "Restart=on-failure\nRestartSec=0\nKillSignal=SIGTERM\nTimeoutStopSec=" + std::to_string(unit.stop_patience_s) +
      "\nKillMode=control-group\n";
  // Effective up to the user's own limits (limits.d, or user@.service.d), which systemd does not raise.
  text += "LimitRTPRIO=95\nLimitMEMLOCK=infinity\n";
  if (!unit.cores.empty()) text += "CPUAffinity=" + unit.cores + "\n";
  return text;
}

}  // namespace

UnitFiles SystemdFiles(const HostPlan& plan) {
  UnitFiles result;
  std::string names;
  for (const Unit& unit : plan.units) {
    result.files[UnitName(unit)] = UnitText(unit, plan);
    names += " " + UnitName(unit);
  }
  const std::string folder = plan.facts.home + "/.config/systemd/user";
  const std::string bus = "export XDG_RUNTIME_DIR=${XDG_RUNTIME_DIR:-/run/user/$(id -u)}\n";
  result.start = bus + "mkdir -p " + folder + "\ncd " + plan.run_folder + " && cp" + names + " " + folder +
                 "\nsystemctl --user daemon-reload && systemctl --user start" + names + "\n";
  result.resume = bus + "systemctl --user start" + names + "\n";  // no effect on units that are running
  result.stop = bus + "systemctl --user stop" + names + "\nsystemctl --user reset-failed" + names +
                " 2>/dev/null\ncd " + folder + " && rm -f" + names + "\nsystemctl --user daemon-reload\n";
  result.status =
      bus + "for unit in" + names +
      "; do name=${unit#oos-}; echo \"${name%.service} $(systemctl --user is-active $unit)\"; done | sed -e "
      "'s/ active/ running/;s/ activating/ starting/;s/ inactive/ stopped/;s/ deactivating/ stopped/'\n";
  return result;
}

}  // namespace lab
