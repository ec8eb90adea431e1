#include "nodes/logic_node/signals.hpp"

#include "core/names.hpp"
#include "scene/diagnostic.hpp"

namespace logic_node {

Signals::Signals(const scene::Scenario& scenario)
    : scenario_(scenario),
      states_(scenario.mechanisms.size(), 0),
      positions_(scenario.mechanisms.size(), 0.0),
      grasped_(scenario.devices.size(), -1) {
  for (const scene::Object& object : scenario.objects) p_WO_.push_back(object.X_WO.translation);
}

// Logic knows the poses of objects from physics/state, which does not contain hand parts.
int Signals::MovedObject(const std::string& name) const {
  const int object = scenario_.FindObject(name);
  if (object < 0 || scenario_.objects[static_cast<std::size_t>(object)].owner == scene::Owner::kHand) return -1;
  return object;
}

std::optional<Signals::Signal> Signals::Parse(const std::string& name) const {
  // Names may contain dots, so every dot is tried as the separator between name and property.
  for (std::size_t dot = name.find('.'); dot != std::string::npos; dot = name.find('.', dot + 1)) {
    const std::string owner = name.substr(0, dot);
    const std::string property = name.substr(dot + 1);
    if (const int mechanism = scenario_.FindMechanism(owner); mechanism >= 0) {
      if (property == "state") return Signal{name, Kind::kState, mechanism, 0};
      if (property == "position") return Signal{name, Kind::kPosition, mechanism, 0};
    }
    constexpr std::string_view kGrasped = "grasped.";
    if (const int role = scenario_.FindRole(owner); role >= 0 && property.starts_with(kGrasped)) {
      const int object = MovedObject(property.substr(kGrasped.size()));
      if (object >= 0) return Signal{name, Kind::kGrasped, role, object};
    }
    if (const int object = MovedObject(owner); object >= 0) {
      if (property == "x") return Signal{name, Kind::kCoordinate, object, 0};
      if (property == "y") return Signal{name, Kind::kCoordinate, object, 1};
      if (property == "z") return Signal{name, Kind::kCoordinate, object, 2};
      constexpr std::string_view kDistance = "distance.";
      if (property.starts_with(kDistance)) {
        const int other = MovedObject(property.substr(kDistance.size()));
        if (other >= 0) return Signal{name, Kind::kDistance, object, other};
      }
    }
  }
  return std::nullopt;
}

std::optional<scxml::Symbol> Signals::Find(const std::string& name) {
  for (std::size_t slot = 0; slot < signals_.size(); ++slot) {
    if (signals_[slot].name != name) continue;
    const bool is_flag = signals_[slot].kind == Kind::kGrasped;
    return scxml::Symbol{scxml::SymbolKind::kSignal, is_flag ? scxml::Type::kFlag : scxml::Type::kNumber,
                         static_cast<int>(slot)};
  }
  const auto signal = Parse(name);
  if (!signal) return std::nullopt;
  signals_.push_back(*signal);
  values_.push_back(Value(*signal));
  return Find(name);
}

std::string Signals::Suggest(const std::string& name) const {
  std::vector<std::string> names;
  for (const scene::Mechanism& mechanism : scenario_.mechanisms) {
    names.push_back(mechanism.name + ".state");
    names.push_back(mechanism.name + ".position");
  }
  for (const scene::Device& device : scenario_.devices) {
    for (const scene::Object& object : scenario_.objects) {
      if (object.owner == scene::Owner::kPhysics) names.push_back(device.role + ".grasped." + object.name);
    }
  }
  for (const scene::Object& object : scenario_.objects) {
    if (object.owner != scene::Owner::kPhysics) continue;
    for (const char* axis : {".x", ".y", ".z"}) names.push_back(object.name + axis);
    for (const scene::Object& other : scenario_.objects) {
      if (&other != &object) names.push_back(object.name + ".distance." + other.name);
    }
  }
  const std::string nearest = core::NearestName(name, names);
  const std::string forms =
      "signals are MECHANISM.state, MECHANISM.position, ROLE.grasped.OBJECT, OBJECT.x, .y, .z and "
      "OBJECT.distance.OBJECT";
  return nearest.empty() ? forms : "did you mean '" + nearest + "'? (" + forms + ")";
}

void Signals::Update(const Inputs& inputs) {
  if (inputs.physics != nullptr) {
    for (const core::BodyState& body : inputs.physics->bodies) {
      if (body.object < p_WO_.size()) p_WO_[body.object] = body.X_WO.translation;
    }
    for (const core::MechanismState& mechanism : inputs.physics->mechanisms) {
      if (mechanism.mechanism >= states_.size()) continue;
      states_[mechanism.mechanism] = mechanism.state;
      positions_[mechanism.mechanism] = mechanism.position;
    }
  }
  for (std::size_t role = 0; role < grasped_.size() && role < inputs.grasped_objects.size(); ++role) {
    const std::uint16_t object = inputs.grasped_objects[role];
    grasped_[role] = object == core::kNoObject ? -1 : object;
  }
  for (std::size_t slot = 0; slot < signals_.size(); ++slot) values_[slot] = Value(signals_[slot]);
}

double Signals::Value(const Signal& signal) const {
  const auto first = static_cast<std::size_t>(signal.first);
  const auto second = static_cast<std::size_t>(signal.second);
  switch (signal.kind) {
    case Kind::kState:
      return states_[first];
    case Kind::kPosition:
      return positions_[first];
    case Kind::kGrasped:
      return grasped_[first] == signal.second ? 1.0 : 0.0;
    case Kind::kCoordinate:
      return p_WO_[first][signal.second];
    case Kind::kDistance:
      return glm::distance(p_WO_[first], p_WO_[second]);
  }
  return 0.0;
}

}  // namespace logic_node
