/* A hand device as a shared library: what a laboratory's own plug-in starts from (docs/howto/own-device.md).
 *
 *   cc -O2 -shared -fPIC -I libs examples/device/own_device.c -o own_device.so -lm
 *   oos device check plugin:$PWD/own_device.so
 *
 * In place of motors and sensors it has a mass of 0.5 kg that a spring pulls round a circle. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "device/plugin.h"

typedef struct {
  double place[3], speed[3], force[3], brake;
  int64_t time_ns, command_ns;
  uint64_t sample, command;
} Arm;

static int Open(const oos_device_setting* setting, void** device) {
  (void)setting; /* here you open your hardware; setting->options has what the scenario says */
  *device = calloc(1, sizeof(Arm));
  return *device != NULL ? OOS_DEVICE_OK : OOS_DEVICE_GONE;
}

static int Describe(void* device, oos_device_description* description) {
  (void)device;
  strncpy(description->name, "own device", sizeof description->name - 1);
  strncpy(description->serial, "1", sizeof description->serial - 1);
  description->flags = OOS_DEVICE_TELLS_APPLIED | OOS_DEVICE_TELLS_VELOCITY;
  description->sensed = description->actuated = OOS_DEVICE_TRANSLATION;
  description->rate_hz = 1000.0;
  description->max_force_N = 10.0;
  description->max_torque_Nm = 1.0;
  description->max_grip_force_N = 1.0;
  description->mass_kg = 0.5;
  description->reach_m = 0.3;
  return OOS_DEVICE_OK;
}

static int Step(void* device, int64_t now_ns, const oos_device_command* command, const oos_device_hand* hand,
                oos_device_state* state) {
  Arm* arm = (Arm*)device;
  const double step_s = arm->time_ns == 0 ? 0.0 : fmin(1e-9 * (double)(now_ns - arm->time_ns), 0.002);
  const double angle = 1e-9 * (double)(now_ns % 4000000000) * 1.5707963267948966; /* a turn in 4 s */
  const double target[3] = {0.05 * cos(angle), 0.05 * sin(angle), 0.0};
  (void)hand;
  arm->time_ns = now_ns;
  if (command != NULL) {
    for (int i = 0; i < 3; ++i) arm->force[i] = command->F_Do_B[i]; /* here you set your motors */
    arm->brake = command->brake_N_s_per_m;
    arm->command = command->sequence;
    arm->command_ns = now_ns;
  } else if (now_ns - arm->command_ns > 60000000) { /* the device's own watchdog */
    memset(arm->force, 0, sizeof arm->force);
    arm->brake = 400.0;
  }
  for (int i = 0; i < 3; ++i) { /* here you read your sensors */
    const double pull = 300.0 * (target[i] - arm->place[i]) - (20.0 + arm->brake) * arm->speed[i];
    arm->speed[i] += (arm->force[i] + pull) / 0.5 * step_s;
    arm->place[i] += arm->speed[i] * step_s;
  }
  state->flags = OOS_DEVICE_IS_ENGAGED;
  state->sequence = ++arm->sample;
  state->reflected = arm->command;
  state->device_time_ns = now_ns;
  state->X_BD[0] = 1.0;
  for (int i = 0; i < 3; ++i) {
    state->X_BD[4 + i] = arm->place[i];
    state->V_BD[3 + i] = arm->speed[i];
    state->applied[i] = arm->force[i];
  }
  return OOS_DEVICE_OK;
}

static void Close(void* device) { free(device); }

#ifdef __cplusplus
extern "C"
#endif
__attribute__((visibility("default"))) const oos_device_plugin* oos_device_plugin_get(void);

#ifdef __cplusplus
extern "C"
#endif
__attribute__((visibility("default"))) const oos_device_plugin* oos_device_plugin_get(void) {
  static const oos_device_plugin plugin = {OOS_DEVICE_ABI_VERSION, sizeof plugin, Open, Describe, Step, Close, NULL, NULL, NULL};
  return &plugin;
}
