#pragma once

#include "tools/failures/row.hpp"

namespace failures {

// Each study adds its rows, tables and charts to the report. The set-ups are those of the failure tests that the
// literature names; a study may not make one easier so that a bound is held.
void StudyThin(Report* report);       // F1
void StudySteps(Report* report);      // F2, F3, F4
void StudyPeg(Report* report);        // F5
void StudyEdges(Report* report);      // F6
void StudyBoundary(Report* report);   // F7
void StudyEnergy(Report* report);     // F8
void StudyImpact(Report* report);     // F9
void StudyBodies(Report* report);     // F10, F14, F18, and what is not measured yet
void StudyPenalty(Report* report);    // F12
void StudyFriction(Report* report);   // F13
void StudyLateness(Report* report);   // F16
void StudyDeepStart(Report* report);  // F17
void StudyRest(Report* report);       // F19
void StudyOverload(Report* report);   // F22

}  // namespace failures
