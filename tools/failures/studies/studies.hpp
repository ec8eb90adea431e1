#pragma once

#include "tools/failures/peer_loop.hpp"
#include "tools/failures/row.hpp"

namespace failures {

// Each study adds its rows, tables and charts to the report. The set-ups are those of the failure tests that the
// literature names; a study may not make one easier so that a bound is held.
void StudyThin(const Peers& peers, Report* report);       // F1
void StudySteps(Report* report);                          // F2, F3, F4
void StudyPeg(Report* report);                            // F5
void StudyEdges(Report* report);                          // F6
void StudyBoundary(Report* report);                       // F7
void StudyField(Report* report);                          // F7
void StudyEnergy(Report* report);                         // F8
void StudyImpact(const Peers& peers, Report* report);     // F9
void StudyBodies(const Peers& peers, Report* report);     // F10, F14, F18
void StudyLightBodies(Report* report);                    // F11
void StudyPenalty(Report* report);                        // F12
void StudyFriction(const Peers& peers, Report* report);   // F13
void StudyPairs(Report* report);                          // F15
void StudyLateness(Report* report);                       // F16
void StudyDeepStart(const Peers& peers, Report* report);  // F17
void StudyRest(Report* report);                           // F19
void StudyThreads(Report* report);                        // F20
void StudyLongRun(Report* report);                        // F21
void StudyOverload(Report* report);                       // F22
void StudyMeshes(Report* report);                         // F23
// What the jaws hold: rows of their own, then those of F5, and of F10, F14, F19 and F20.
void StudyHeld(Report* report);
void StudyHeldPeg(Report* report);
void StudyHeldBodies(Report* report);

// Of StudyPeg: how a peg trembles at rest in one of its attitudes, by the default method. Rms.
double PegJitter_m(double clearance_m, double friction, int seed);

}  // namespace failures
