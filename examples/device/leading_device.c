/* A hand device that leads the hand to a goal when a person asks for guidance (lead() of device/plugin.h). Start with
 * own_device.c; what is more here is Lead, Pull and one flag.
 *
 *   cc -O2 -shared -fPIC -I libs examples/device/leading_device.c -o leading_device.so -lm
 *   oos device check plugin:$PWD/leading_device.so
 *
 * In place of motors and sensors it has a mass of 0.5 kg with the drag of a hand that goes along. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "device/plugin.h"

typedef struct {
  double place[3], speed[3], force[3], brake;
  double way[3]; /* where the path to the goal is now */
  oos_device_goal goal;
  int leads;
  int64_t time_ns, command_ns;
  uint64_t sample, command;
} Arm;

static int Open(const oos_device_setting* setting, void** device) {
  (void)setting;
  *device = calloc(1, sizeof(Arm));
  return *device != NULL ? OOS_DEVICE_OK : OOS_DEVICE_GONE;
}

static int Describe(void* device, oos_device_description* description) {
  (void)device;
  strncpy(description->name, "leading device", sizeof description->name - 1);
  strncpy(description->serial, "1", sizeof description->serial - 1);
  description->flags = OOS_DEVICE_TELLS_APPLIED | OOS_DEVICE_TELLS_VELOCITY | OOS_DEVICE_LEADS;
  description->sensed = description->actuated = OOS_DEVICE_TRANSLATION;
  description->rate_hz = 1000.0;
  description->max_force_N = 10.0;
  description->max_torque_Nm = 1.0;
  description->max_grip_force_N = 1.0;
  description->mass_kg = 0.5;
  description->damping_N_s_per_m = 10.0;
  description->reach_m = 0.5;
  return OOS_DEVICE_OK;
}

static double Length(const double v[3]) { return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }
static void Shorten(double v[3], double length) {
  const double now = Length(v);
  for (int i = 0; i < 3 && now > length; ++i) v[i] *= length / now;
}

/* Called after each step. A goal that is new begins a path where the hand is. */
static int Lead(void* device, const oos_device_goal* goal) {
  Arm* arm = (Arm*)device;
  if (goal != NULL && !arm->leads) memcpy(arm->way, arm->place, sizeof arm->way);
  arm->leads = goal != NULL;
  if (goal != NULL) arm->goal = *goal;
  return OOS_DEVICE_OK;
}

/* A point runs to the goal with 0.15 m/s and pulls by a spring of 200 N/m with 4 N at most, so that a hand can leave it;
 * it waits for a hand that is 5 cm behind. Command and pull are together within the goal's limit. */
static void Pull(Arm* arm, double step_s, double applied[3]) {
  double ahead[3], total[3];
  memcpy(applied, arm->force, 3 * sizeof *applied);
  if (!arm->leads) return;
  for (int i = 0; i < 3; ++i) ahead[i] = arm->way[i] - arm->place[i];
  if (Length(ahead) < 0.05) {
    double left[3];
    for (int i = 0; i < 3; ++i) left[i] = arm->goal.X_BG[4 + i] - arm->way[i];
    Shorten(left, 0.15 * step_s);
    for (int i = 0; i < 3; ++i) arm->way[i] += left[i];
  }
  for (int i = 0; i < 3; ++i) ahead[i] *= 200.0;
  Shorten(ahead, 4.0);
  for (int i = 0; i < 3; ++i) total[i] = arm->force[i] + ahead[i];
  Shorten(total, arm->goal.max_force_N);
  memcpy(applied, total, sizeof total);
}

static int Step(void* device, int64_t now_ns, const oos_device_command* command, const oos_device_hand* hand,
                oos_device_state* state) {
  Arm* arm = (Arm*)device;
  const double step_s = arm->time_ns == 0 ? 0.0 : fmin(1e-9 * (double)(now_ns - arm->time_ns), 0.002);
  double applied[3];
  (void)hand;
  arm->time_ns = now_ns;
  if (command != NULL) {
    for (int i = 0; i < 3; ++i) arm->force[i] = command->F_Do_B[i];
    arm->brake = command->brake_N_s_per_m;
    arm->command = command->sequence;
    arm->command_ns = now_ns;
  } else if (now_ns - arm->command_ns > 60000000) {
    memset(arm->force, 0, sizeof arm->force);
    arm->brake = 400.0;
    arm->leads = 0;
  }
  Pull(arm, step_s, applied);
  for (int i = 0; i < 3; ++i) {
    const double drag = 10.0 + arm->brake;
    arm->speed[i] = (arm->speed[i] + applied[i] / 0.5 * step_s) / (1.0 + drag / 0.5 * step_s);
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
    state->applied[i] = applied[i];
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
  static const oos_device_plugin plugin = {OOS_DEVICE_ABI_VERSION, sizeof plugin, Open, Describe, Step, Close, NULL, NULL, Lead};
  return &plugin;
}
