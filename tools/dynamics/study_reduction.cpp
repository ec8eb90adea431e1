// Contact reduction: error of the wrench when few contacts stand for 10,000.
#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "physics/testing/contact_points.hpp"
#include "physics/testing/trials/reference.hpp"
#include "tools/dynamics/studies.hpp"
#include "tools/dynamics/turns.hpp"

namespace dynamics {
namespace {

using physics::ContactPoint;
using Points = std::vector<ContactPoint>;

constexpr double kHalf_m = 0.05;
constexpr int kSide = 100;

struct Scene {
  const char* name;
  Points points;
};

// 100 x 100 points on a square of 0.1 m; `depth` over x and y.
template <typename Depth>
Points Press(Depth depth) {
  Points points;
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      const double x = (i - 49.5) * 1e-3;
      const double y = (j - 49.5) * 1e-3;
      points.push_back({{x, y, 0.0}, {0, 0, 1}, -depth(x, y), 5.0});
    }
  }
  return points;
}

// A peg of 20 mm radius, pressed aside and tilted in its hole.
Points PegInHole() {
  Points points;
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      const double angle = 2.0 * 3.14159265358979 * j / kSide;
      const glm::dvec3 r(std::cos(angle), std::sin(angle), 0.0);
      const double z = 1e-3 * (i - 49.5);
      points.push_back({0.02 * r + glm::dvec3(0, 0, z), -r, 1e-4 - 4e-4 * r.x * (z + 0.03) / kHalf_m, 5.0});
    }
  }
  return points;
}

std::vector<Scene> Scenes() {
  return {{"flat", Press([](double, double) { return 2e-4; })},
          {"wavy", Press([](double x, double y) { return 2e-4 + 5e-5 * std::sin(200 * x) * std::cos(150 * y); })},
          {"one edge", Press([](double x, double) { return 0.02 * (x - 0.02); })},
          {"peg in its hole", PegInHole()}};
}

// Contacts after a small motion of the body; gaps change to first order.
struct Motion {
  glm::dvec3 way_m{0.0};
  glm::dvec3 turn_rad{0.0};
};

struct Sum {
  glm::dvec3 force_N{0.0};
  glm::dvec3 torque_Nm{0.0};
};

Sum WrenchOf(const Points& points, const Motion& motion) {
  Sum sum;
  for (const ContactPoint& p : points) {
    const double gap_m = p.gap_m + glm::dot(p.n_W, motion.way_m + glm::cross(motion.turn_rad, p.p_W));
    const glm::dvec3 force_N = p.stiffness_N_per_m * std::max(0.0, -gap_m) * p.n_W;
    sum.force_N += force_N;
    sum.torque_Nm += glm::cross(p.p_W, force_N);
  }
  return sum;
}

double Error(const Points& all, const Points& few, const Motion& motion) {
  const Sum exact = WrenchOf(all, motion);
  const Sum found = WrenchOf(few, motion);
  const double force_N = glm::length(exact.force_N);
  return std::max(glm::length(found.force_N - exact.force_N),
                  glm::length(found.torque_Nm - exact.torque_Nm) / kHalf_m) /
         force_N;
}

// Motions of up to 50 um and 1 mrad, those of a body until the next contacts arrive.
double ErrorOnTheMove(const Points& all, const Points& few) {
  double worst = 0.0;
  for (const double z : {-5e-5, 0.0, 5e-5}) {
    for (const double x : {-1e-3, 0.0, 1e-3}) {
      for (const double y : {-1e-3, 0.0, 1e-3}) {
        worst = std::max(worst, Error(all, few, {{0, 0, z}, {x, y, 0}}));
      }
    }
  }
  return worst;
}

void Ours(const Points& all, Points* few) {
  core::FixedVector<core::ContactPlane, core::kMaxContactPlanes> planes;
  physics::ReduceContactPoints(all, {}, {}, &planes);
  few->clear();
  for (const core::ContactPlane& plane : planes) {
    const glm::dvec3 n_W(plane.n_G);
    const glm::dvec3 p_W(plane.p_S);
    few->push_back({p_W, n_W, glm::dot(n_W, p_W - glm::dvec3(plane.q_G)), plane.stiffness_N_per_m});
  }
}

// Keeps the deepest contacts, which share the stiffness of all penetrating ones.
void Deepest(const Points& all, std::size_t count, Points* few) {
  few->assign(all.begin(), all.end());
  double stiffness = 0.0;
  for (const ContactPoint& p : all) stiffness += p.gap_m < 0.0 ? p.stiffness_N_per_m : 0.0;
  std::nth_element(few->begin(), few->begin() + static_cast<std::ptrdiff_t>(count - 1), few->end(),
                   [](const ContactPoint& a, const ContactPoint& b) { return a.gap_m < b.gap_m; });
  few->resize(count);
  for (ContactPoint& p : *few) p.stiffness_N_per_m = stiffness / static_cast<double>(count);
}

// Keeps an even subset; each contact stands for those left out.
void Thinned(const Points& all, std::size_t count, Points* few) {
  few->clear();
  const int side = static_cast<int>(std::lround(std::sqrt(static_cast<double>(count))));
  const double stride = static_cast<double>(kSide) / side;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      const int at = static_cast<int>((i + 0.5) * stride) * kSide + static_cast<int>((j + 0.5) * stride);
      few->push_back(all[static_cast<std::size_t>(at)]);
      few->back().stiffness_N_per_m *= stride * stride;
    }
  }
}

// Bullet's cache of four points, filled point by point as by its collision detection.
void BulletCache(const Points& all, Points* few) {
  btPersistentManifold manifold(nullptr, nullptr, 0, 0.02, 1e30);
  double stiffness = 0.0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const ContactPoint& p = all[i];
    if (p.gap_m >= 0.0) continue;
    stiffness += p.stiffness_N_per_m;
    const btVector3 at(p.p_W.x, p.p_W.y, p.p_W.z);
    btManifoldPoint point(at, at, {p.n_W.x, p.n_W.y, p.n_W.z}, p.gap_m);
    point.m_index0 = static_cast<int>(i);
    const int entry = manifold.getCacheEntry(point);
    if (entry >= 0)
      manifold.replaceContactPoint(point, entry);
    else
      manifold.addManifoldPoint(point);
  }
  few->clear();
  for (int i = 0; i < manifold.getNumContacts(); ++i) {
    few->push_back(all[static_cast<std::size_t>(manifold.getContactPoint(i).m_index0)]);
  }
  for (ContactPoint& p : *few) p.stiffness_N_per_m = stiffness / static_cast<double>(few->size());
}

struct Way {
  std::string name;
  std::function<void(const Points&, Points*)> reduce;
};

std::vector<Way> Ways() {
  std::vector<Way> ways = {{"ours", Ours}, {"Bullet's cache", BulletCache}};
  for (const std::size_t count : {4, 16, 64, 256, 1024}) {
    ways.push_back({"deepest", [count](const Points& all, Points* few) { Deepest(all, count, few); }});
    ways.push_back({"thinned", [count](const Points& all, Points* few) { Thinned(all, count, few); }});
  }
  return ways;
}

void AddTo(Panel* panel, const std::string& name, double x, double y, const std::string& mark = "") {
  auto at = std::find_if(panel->series.begin(), panel->series.end(), [&](auto& s) { return s.name == name; });
  if (at == panel->series.end()) at = panel->series.insert(at, Series{name, {}, mark.empty()});
  at->points.push_back({x, y, mark});
}

}  // namespace

void StudyReduction(const Peers& /*peers*/, Report* report) {
  const std::vector<Scene> scenes = Scenes();
  const std::vector<Way> ways = Ways();
  std::vector<std::shared_ptr<Points>> scratch;
  std::vector<std::function<void()>> pieces;
  for (const Way& way : ways) {
    scratch.push_back(std::make_shared<Points>());
    pieces.emplace_back([&, few = scratch.back(), reduce = way.reduce] { reduce(scenes[1].points, few.get()); });
  }
  const std::vector<double> us = TakeTurns(pieces, 3, 15);

  Table table{"reduction", {"way", "scene", "contacts", "us_wavy", "error", "error_moved"}, {}};
  Panel still{"where they are, worst scene", "contacts", "force or torque off, of the force", {}, true, true, {}};
  Panel moved{"moved by up to 50 um and 1 mrad", "contacts", "force or torque off, of the force", {}, true, true, {}};
  Panel time{"error against time, where they are", "us", "force or torque off, of the force", {}, true, true, {}};
  Panel each{"ours, moved, by scene", "", "", {}, false, false, {}};
  std::size_t most_contacts = 0;
  double worst_ours = 0.0;
  for (std::size_t w = 0; w < ways.size(); ++w) {
    double of_still = 0.0;
    double of_moved = 0.0;
    std::size_t contacts = 0;
    for (const Scene& scene : scenes) {
      Points few;
      ways[w].reduce(scene.points, &few);
      const double error = Error(scene.points, few, {});
      const double on_the_move = ErrorOnTheMove(scene.points, few);
      table.Add({ways[w].name, scene.name, std::to_string(few.size()), Cell(us[w]), Cell(error), Cell(on_the_move)});
      std::printf("%-16s %-16s %5zu contacts  %8.1f us  off by %.3g, moved %.3g\n", ways[w].name.c_str(), scene.name,
                  few.size(), us[w], error, on_the_move);
      if (w == 0) each.bars.push_back({scene.name, 100.0 * on_the_move, Short(100.0 * on_the_move) + " %", "ours"});
      of_still = std::max(of_still, error);
      of_moved = std::max(of_moved, on_the_move);
      contacts = std::max(contacts, few.size());
    }
    if (w == 0) {
      most_contacts = contacts;
      worst_ours = of_still;
    }
    AddTo(&still, ways[w].name, static_cast<double>(contacts), of_still);
    AddTo(&moved, ways[w].name, static_cast<double>(contacts), of_moved);
    AddTo(&time, ways[w].name, us[w], of_still, std::to_string(contacts));
  }
  each.x_title = "% of the force";
  report->tables.push_back(table);
  report->charts.emplace_back("reduction", Chart{"Ten thousand contact points as few",
                                                 "flat, wavy and tilted press of 0.1 m, a peg in its hole; torque over "
                                                 "50 mm counts as force",
                                                 {still, moved, time, each}});
  report->AddGoal("10,000 contact points: reduced to", "<= 24", std::to_string(most_contacts), most_contacts <= 24);
  report->AddGoal("10,000 contact points: force and torque", "within 1 %", Short(100.0 * worst_ours) + " % off",
                  worst_ours <= 0.01);
  const double rocking_um = 1e6 * physics::trials::RockingOfAPress_m(2.0);
  report->AddGoal("10,000 contact points: a flat press never rocks by more (2 s)", "<= 5 um", Short(rocking_um) + " um",
                  rocking_um <= 5.0);
}

}  // namespace dynamics
