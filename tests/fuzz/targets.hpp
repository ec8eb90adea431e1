#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace fuzz {

// One entry point for each parser that reads foreign data. For any bytes a target must return without a crash or a
// leak, within memory of a small multiple of the input. It aborts when a claim about the parser's result does not hold.
using Input = std::span<const std::uint8_t>;

void FuzzEnvelope(Input input);        // envelope.cpp
void FuzzLatestCodec(Input input);     // latest_codec.cpp
void FuzzControl(Input input);         // control.cpp
void FuzzSchema(Input input);          // schema.cpp
void FuzzMcap(Input input);            // mcap.cpp
void FuzzMcapChunk(Input input);       // mcap_chunk.cpp
void FuzzPayloadJson(Input input);     // payload_json.cpp
void FuzzScenario(Input input);        // scenario.cpp
void FuzzProcedure(Input input);       // procedure.cpp
void FuzzOperatorScript(Input input);  // operator_script.cpp
void FuzzCheckpoint(Input input);      // checkpoint.cpp
void FuzzSealed(Input input);          // sealed.cpp
void FuzzStep(Input input);            // step.cpp
void FuzzLab(Input input);             // lab.cpp
void FuzzKeys(Input input);            // keys.cpp
void FuzzTolerance(Input input);       // tolerance.cpp
void FuzzBulk(Input input);            // bulk.cpp
void FuzzDeviceFrame(Input input);     // device_frame.cpp
void FuzzSerialLine(Input input);      // device_frame.cpp
void FuzzWebSocket(Input input);       // haply.cpp
void FuzzHaplyMessage(Input input);    // haply.cpp
void FuzzDtrack(Input input);          // dtrack.cpp
void FuzzPinch(Input input);           // dtrack.cpp
void FuzzGlove(Input input);           // dtrack.cpp
void FuzzUsbFrame(Input input);        // usb_frame.cpp

struct NamedTarget {
  const char* name;  // of its folder in corpus/
  void (*run)(Input);
};

// tests/fuzz/CMakeLists.txt has the same names.
inline constexpr std::array kTargets = {
    NamedTarget{"envelope", FuzzEnvelope},
    NamedTarget{"latest_codec", FuzzLatestCodec},
    NamedTarget{"control", FuzzControl},
    NamedTarget{"schema", FuzzSchema},
    NamedTarget{"mcap", FuzzMcap},
    NamedTarget{"mcap_chunk", FuzzMcapChunk},
    NamedTarget{"payload_json", FuzzPayloadJson},
    NamedTarget{"scenario", FuzzScenario},
    NamedTarget{"procedure", FuzzProcedure},
    NamedTarget{"operator_script", FuzzOperatorScript},
    NamedTarget{"checkpoint", FuzzCheckpoint},
    NamedTarget{"sealed", FuzzSealed},
    NamedTarget{"step", FuzzStep},
    NamedTarget{"lab", FuzzLab},
    NamedTarget{"keys", FuzzKeys},
    NamedTarget{"tolerance", FuzzTolerance},
    NamedTarget{"bulk", FuzzBulk},
    NamedTarget{"device_frame", FuzzDeviceFrame},
    NamedTarget{"serial_line", FuzzSerialLine},
    NamedTarget{"web_socket", FuzzWebSocket},
    NamedTarget{"haply_message", FuzzHaplyMessage},
    NamedTarget{"dtrack", FuzzDtrack},
    NamedTarget{"pinch", FuzzPinch},
    NamedTarget{"glove", FuzzGlove},
    NamedTarget{"usb_frame", FuzzUsbFrame},
};

}  // namespace fuzz
