#include <map>
#include <utility>

#include "core/names.hpp"
#include "scene/read_scenario.hpp"

namespace scene {
namespace {

bool CanSample(const Object& sampled, const Object& field) {
  return (sampled.num_points > 0 || sampled.is_resolution_chosen) &&
         (field.voxel_size_m > 0.0 || field.is_resolution_chosen);
}

// When both objects of a pair could be sampled, the one of lower rank is: a hand's part (the paper's haptic object)
// before an object that physics moves, before a fixed one. Equal rank: the one that comes first in the file. Where the
// resolution of both is chosen, this holds until collision::ChooseResolutions knows which has the smaller feature.
int SampledRank(const Object& object) {
  if (object.owner == Owner::kHand || object.finger_link) return 0;
  return object.owner == Owner::kPhysics ? 1 : 2;
}

// What a finger touches, physics_node tests: its links are moved there.
void SetPad(const FingerLink& link, Pair* pair) {
  pair->owner = PairOwner::kPhysics;
  pair->friction = link.friction;
  pair->stiffness_N_per_m = link.stiffness_N_per_m;
  pair->damping_N_s_per_m = link.damping_N_s_per_m;
}

class Generator {
 public:
  Generator(Scenario* scenario, std::vector<Diagnostic>* diagnostics)
      : scenario_(*scenario), diagnostics_(diagnostics) {}

  void Run(const std::vector<PairElement>& elements) {
    for (const PairElement& element : elements) Resolve(element);
    const std::vector<Object>& objects = scenario_.objects;
    const auto num_objects = static_cast<std::uint16_t>(objects.size());
    for (std::uint16_t i = 0; i < num_objects; ++i) {
      for (std::uint16_t j = i + 1; j < num_objects; ++j) AddPair(i, j);
    }
  }

 private:
  using Key = std::pair<int, int>;  // object indices, the lower first

  void Report(const PairElement& element, const std::string& what, std::string why, std::string fix) {
    diagnostics_->push_back({element.figures.location, "pair " + element.a + "/" + element.b + ": " + what,
                             std::move(why), std::move(fix)});
  }

  int ObjectOf(const PairElement& element, const std::string& name) {
    const int index = scenario_.FindObject(name);
    if (index < 0 && !name.empty()) {
      std::vector<std::string> names;
      for (const Object& object : scenario_.objects) names.push_back(object.name);
      Report(element, "unknown object '" + name + "'", "a and b must name an <object> of this file",
             core::SuggestName(name, names));
    }
    return index;
  }

  void Resolve(const PairElement& element) {
    const int a = ObjectOf(element, element.a);
    const int b = ObjectOf(element, element.b);
    if (a < 0 || b < 0) return;
    if (a == b) {
      Report(element, "an object with itself", "a pair is of two objects", "name another object");
      return;
    }
    if (!elements_.emplace(Key{std::min(a, b), std::max(a, b)}, &element).second) {
      Report(element, "named twice", "one <pair> element holds all settings of two objects", "merge the two elements");
      return;
    }
    if (!element.is_collide) return;
    const Object& object_a = scenario_.objects[static_cast<std::size_t>(a)];
    const Object& object_b = scenario_.objects[static_cast<std::size_t>(b)];
    if (object_a.group == object_b.group) {
      Report(element, "both are in group '" + object_a.group + "'", "members of a group are never tested",
             "change a group, or remove the pair");
    } else if (object_a.owner == Owner::kFixed && object_b.owner == Owner::kFixed) {
      Report(element, "both are fixed", "neither can move into contact", "remove the pair");
    } else if (!CanSample(object_a, object_b) && !CanSample(object_b, object_a)) {
      Report(element, "no pointshell against a voxelmap",
             "one of them needs <collision points=\"...\">, the other <collision voxel_size_m=\"...\">",
             "add points to one and voxel_size_m to the other, or give neither and let them be chosen, or remove the "
             "pair");
    } else if (element.figures.owner == PairOwner::kPhysics &&
               (object_a.owner == Owner::kHand || object_b.owner == Owner::kHand)) {
      Report(element, "owner=\"physics\" on a pair of a hand",
             "a hand's contact is felt, so haptic_node computes it in its own cycle", "remove the attribute");
    }
  }

  void AddPair(std::uint16_t i, std::uint16_t j) {
    const Object& a = scenario_.objects[i];
    const Object& b = scenario_.objects[j];
    if (a.group == b.group || (a.owner == Owner::kFixed && b.owner == Owner::kFixed)) return;
    const bool can_sample_a = CanSample(a, b);
    const bool can_sample_b = CanSample(b, a);
    if (!can_sample_a && !can_sample_b) return;
    Pair pair;
    pair.location = a.location;
    const bool is_of_hand = a.owner == Owner::kHand || b.owner == Owner::kHand;
    const bool is_of_finger = (a.finger_link || b.finger_link) && !is_of_hand;
    if (is_of_finger) SetPad(a.finger_link ? *a.finger_link : *b.finger_link, &pair);
    const PairElement* own = nullptr;
    bool is_a_sampled = can_sample_a && (!can_sample_b || SampledRank(a) <= SampledRank(b));
    if (const auto it = elements_.find({i, j}); it != elements_.end()) {
      const PairElement& element = *it->second;
      if (!element.is_collide) return;
      pair = element.figures;
      if (is_of_finger) pair.owner = PairOwner::kPhysics;
      own = &element;
      if (can_sample_a && can_sample_b) is_a_sampled = element.a == a.name;  // the file's choice overrides the rank
    }
    pair.accuracy = own != nullptr ? own->accuracy.value_or(scenario_.accuracy) : scenario_.accuracy;
    pair.budget_us = own != nullptr ? own->budget_us.value_or(scenario_.budget_us) : scenario_.budget_us;
    pair.sampled = is_a_sampled ? i : j;
    pair.field = is_a_sampled ? j : i;
    scenario_.pairs.push_back(pair);
  }

  Scenario& scenario_;
  std::vector<Diagnostic>* diagnostics_;
  std::map<Key, const PairElement*> elements_;
};

}  // namespace

void GeneratePairs(const std::vector<PairElement>& elements, Scenario* scenario, std::vector<Diagnostic>* diagnostics) {
  Generator(scenario, diagnostics).Run(elements);
}

}  // namespace scene
