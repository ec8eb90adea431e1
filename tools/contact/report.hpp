#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tools/contact/chart.hpp"
#include "tools/contact/table.hpp"

namespace contact {

enum class Verdict { kMet, kPartly, kMissed, kNotMeasured };

// One line of what the contact engine must hold.
struct Goal {
  std::string what;
  std::string wanted;
  std::string measured;
  Verdict verdict = Verdict::kNotMeasured;
};

struct Report {
  std::vector<Goal> goals;
  std::vector<Table> tables;
  std::vector<std::pair<std::string, Chart>> charts;  // by file name
  std::vector<std::string> skipped;                   // what and why

  void AddGoal(std::string what, std::string wanted, std::string measured, bool is_met) {
    goals.push_back(
        {std::move(what), std::move(wanted), std::move(measured), is_met ? Verdict::kMet : Verdict::kMissed});
  }
};

const char* ToText(Verdict verdict);
Table GoalTable(const std::vector<Goal>& goals);
// A page of Markdown: the machine and the table.
std::string GoalPage(const std::vector<Goal>& goals);
// Processor, compiler, instruction set of the walk.
std::string MachineText();
void PrintGoals(const std::vector<Goal>& goals);

}  // namespace contact
