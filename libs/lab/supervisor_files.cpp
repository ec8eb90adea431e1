#include "lab/unit_files.hpp"

namespace lab {
namespace {

// supervisor expands %(name)s in every value.
std::string Escape(const std::string& text) {
  std::string escaped;
  for (const char c : text) escaped += c == '%' ? "%%" : std::string(1, c);
  return escaped;
}

// supervisor splits a command into words as a shell does.
std::string QuoteForSupervisor(const std::string& word) {
  return word.find_first_of(" ;\t\"") == std::string::npos && !word.empty() ? word : "'" + word + "'";
}

std::string CommandOf(const Unit& unit) {
  std::string command;
  if (!unit.cores.empty()) command += "taskset -c " + unit.cores + " ";
  std::string blank;
  for (const std::string& word : WordsOf(unit)) {
    command += blank + QuoteForSupervisor(word);
    blank = " ";
  }
  return Escape(command);
}

std::string ProgramSection(const Unit& unit, const HostPlan& plan, int priority) {
  std::string environment;
  for (const auto& [name, value] : unit.environment) {
    environment += (environment.empty() ? "" : ",") + name + "=\"" + Escape(value) + "\"";
  }
  // A node that exits with 0 is finished; any other exit restarts it at once.
  return "\n[program:" + unit.name + "]\ncommand=" + CommandOf(unit) + "\ndirectory=" + plan.run_folder +
         "\nenvironment=" + environment + "\npriority=" + std::to_string(priority) +
         "\nautostart=true\nautorestart=unexpected\nexitcodes=0\nstartsecs=1\nstartretries=5\nstopsignal=TERM\n"
         "stopwaitsecs=" +
         std::to_string(unit.stop_patience_s) +
         "\nstopasgroup=true\nkillasgroup=true\nredirect_stderr=true\nstdout_logfile=" + unit.log +
         "\nstdout_logfile_maxbytes=0\n";
}

}  // namespace

UnitFiles SupervisorFiles(const HostPlan& plan) {
  const std::string socket = plan.facts.root + "/supervisor.sock";
  const std::string pid_file = plan.facts.root + "/supervisord.pid";
  const std::string config = plan.run_folder + "/supervisord.conf";
  std::string text = "; The processes of run " + plan.run_folder.substr(plan.run_folder.rfind('/') + 1) + " on " +
                     plan.host.name + ".\n[unix_http_server]\nfile=" + socket +
                     "\nchmod=0700\n\n[supervisord]\nlogfile=" + plan.run_folder + "/supervisord-" + plan.host.name +
                     ".log\nlogfile_maxbytes=0\npidfile=" + pid_file + "\ndirectory=" + plan.run_folder +
                     "\nnodaemon=false\numask=077\n\n[rpcinterface:supervisor]\nsupervisor.rpcinterface_factory = "
                     "supervisor.rpcinterface:make_main_rpcinterface\n\n[supervisorctl]\nserverurl=unix://" +
                     socket + "\n";
  int priority = 10;
  for (const Unit& unit : plan.units) text += ProgramSection(unit, plan, priority++);
  UnitFiles result;
  result.files["supervisord.conf"] = text;
  const std::string control = "supervisorctl -c " + config;
  result.start = "supervisord -c " + config + "\n";
  // supervisord itself removes a stale socket and pid file after a power failure.
  result.resume = control + " pid >/dev/null 2>&1 || " + result.start;
  result.stop = "if [ -S " + socket + " ]; then\n  pid=$(cat " + pid_file + ")\n  " + control + " shutdown\n" +
                "  timeout 60 tail -s 0.05 --pid=\"$pid\" -f /dev/null\nfi\n";
  result.status = control +
                  " status | sed -e 's/RUNNING/running/;s/STARTING/starting/;s/BACKOFF/starting/;s/STOPPING/stopped/;"
                  "s/FATAL/failed/;s/EXITED/stopped/;s/STOPPED/stopped/'\n";
  return result;
}

std::vector<std::string> WordsOf(const Unit& unit) {
  std::vector<std::string> words;
  if (!unit.socket.empty()) {
    words = {"/bin/sh", "-c", "until [ -S " + unit.socket + " ]; do sleep 0.05; done; exec \"$0\" \"$@\""};
  }
  words.push_back(unit.program);
  words.insert(words.end(), unit.arguments.begin(), unit.arguments.end());
  return words;
}

UnitFiles FilesFor(const HostPlan& plan) {
  return plan.host.supervisor == SupervisorKind::kSystemd ? SystemdFiles(plan) : SupervisorFiles(plan);
}

}  // namespace lab
