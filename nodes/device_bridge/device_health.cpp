#include "nodes/device_bridge/device_health.hpp"

namespace device_bridge {

const char* NameOf(DeviceStatus status) {
  switch (status) {
    case DeviceStatus::kWaiting:
      return "waiting";
    case DeviceStatus::kAlive:
      return "alive";
    case DeviceStatus::kSilent:
      return "silent";
    case DeviceStatus::kGone:
      return "gone";
    case DeviceStatus::kHung:
      return "hung";
    case DeviceStatus::kBroken:
      return "broken";
  }
  return "";
}

LinkQuality QualityOf(const LinkFigures& figures) {
  if (figures.rate_hz <= 0.0) return LinkQuality::kOff;
  if (figures.loss > 0.05 || figures.jitter_s > 0.02) return LinkQuality::kPoor;
  if (figures.loss > 0.01 || figures.jitter_s > 0.005) return LinkQuality::kFair;
  if (figures.loss > 0.001 || figures.jitter_s > 0.001) return LinkQuality::kGood;
  return LinkQuality::kExcellent;
}

const char* NameOf(LinkQuality quality) {
  switch (quality) {
    case LinkQuality::kOff:
      return "off";
    case LinkQuality::kPoor:
      return "poor";
    case LinkQuality::kFair:
      return "fair";
    case LinkQuality::kGood:
      return "good";
    case LinkQuality::kExcellent:
      return "excellent";
  }
  return "";
}

}  // namespace device_bridge
