/* Hand devices for device_bridge, in C. A device is a shared library that exports oos_device_plugin_get(), or code that
 * is compiled in and gives the same table. docs/howto/own-device.md is the way to one; this file is the whole contract.
 *
 * SI units and radians. W is the world, B the device's base, D its hand frame. Poses are 7 doubles: unit quaternion
 * w, x, y, z of R_BD, then p_BD [m]. Twists are 6: angular velocity [rad/s], then velocity [m/s], in B. Times are
 * CLOCK_MONOTONIC [ns] of the bridge.
 *
 * A device of its own thread is called by that thread alone: open, then step again and again, then close. A function
 * may wait a few milliseconds; one that does not return within 60 ms loses its force, and the device is off until it
 * returns. No exception may leave a function (one that does switches the device off). Commands have passed the safety
 * filter; they are the only force that a plug-in is ever given.
 */
#ifndef OOS_DEVICE_PLUGIN_H
#define OOS_DEVICE_PLUGIN_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Grows when a struct changes other than at its end. A table of another version is refused. */
#define OOS_DEVICE_ABI_VERSION 1u

/* What a function returns. */
enum {
  OOS_DEVICE_OK = 0,
  OOS_DEVICE_GONE = 1,       /* not there (now): the bridge closes it and opens it again, four times a second */
  OOS_DEVICE_BAD_SETTING = 2 /* will not work with this setting: the run does not begin */
};

/* One name and value of the scenario, e.g. "serial" and "A12". */
typedef struct oos_device_option {
  const char* name;
  const char* value;
} oos_device_option;

typedef struct oos_device_setting {
  uint32_t size; /* of this struct */
  uint32_t num_options;
  const char* role;
  const char* address; /* what the scenario says, e.g. "127.0.0.1:7460" or "/dev/ttyUSB0" */
  const oos_device_option* options;
  char* why;         /* for a sentence about what failed and how to repair it, ended by 0 */
  uint32_t why_size; /* bytes */
} oos_device_setting;

/* oos_device_description::flags */
enum {
  OOS_DEVICE_IS_SIMULATED = 1,
  OOS_DEVICE_TAKES_HAND = 2,    /* its operator is simulated, too: steps get an oos_device_hand */
  OOS_DEVICE_IS_IMMEDIATE = 4,  /* never waits, allocates or locks, and its time is now_ns, however fast that passes */
  OOS_DEVICE_TELLS_APPLIED = 8, /* its states say which force its motors apply */
  OOS_DEVICE_TELLS_VELOCITY = 16,
  OOS_DEVICE_LEADS = 32 /* leads the hand to a goal by its own motors, see lead() */
};

/* Axes as bits, for what is sensed and what has a motor. An axis without a motor gets no force. */
enum { OOS_DEVICE_TRANSLATION = 1, OOS_DEVICE_ROTATION = 2, OOS_DEVICE_GRIP = 4 };

/* Of the device that is there now. 0: not known, for numbers that are not counts. */
typedef struct oos_device_description {
  uint32_t size;
  uint32_t flags;
  char name[48];   /* of the model, as people call it */
  char serial[32]; /* of this specimen: its calibration is kept under it */
  uint32_t sensed;
  uint32_t actuated;
  double rate_hz;
  double max_force_N; /* the bridge never commands more than the smaller of these and the scenario's limits */
  double max_torque_Nm;
  double max_grip_force_N;
  double mass_kg; /* apparent, with the hand's frame; for the limits of stability */
  double inertia_kg_m2;
  double damping_N_s_per_m;
  double damping_Nm_s_per_rad;
  double reach_m; /* radius of the workspace */
  double opening_max_m;
} oos_device_description;

/* oos_device_state::flags */
enum {
  OOS_DEVICE_IS_ENGAGED = 1, /* the dead-man is held: without it there is no force */
  OOS_DEVICE_IS_OFF = 2      /* motors are off, whatever is commanded; its own watchdog, a fault, an emergency stop */
};

enum { OOS_DEVICE_FINGER_JOINTS = 15 };

typedef struct oos_device_state {
  uint32_t size;
  uint32_t flags;
  uint64_t sequence;      /* number of the sample, from 1; the same as before: no new sample */
  uint64_t reflected;     /* number of the newest command that the device had when it took the sample; 0: not known */
  int64_t device_time_ns; /* its own clock */
  double X_BD[7];
  double V_BD[6]; /* without OOS_DEVICE_TELLS_VELOCITY the bridge differentiates the poses */
  double opening_m;
  double opening_velocity_m_per_s;
  double applied[7]; /* by the motors: force [N] and torque about Do [Nm] in B, grip force [N] */
  uint64_t buttons;  /* bit 0: the first */
  uint64_t lost;     /* samples that never arrived, since open */
  /* With OOS_DEVICE_TAKES_HAND: what the simulated operator feels. */
  double hand_F_Do_B[6]; /* the hand's own spring and damper on the arm: force, torque */
  double finger_force_N; /* of the fingers on the jaws, positive opens */
  /* Angles of a person's fingers: three for each, thumb first, from the palm outwards, 0 for a straight finger
   * (scenarios/parts/README.md). num_finger_joints 0: the device does not know. */
  uint32_t num_finger_joints;
  uint32_t reserved;
  double finger_rad[OOS_DEVICE_FINGER_JOINTS];
} oos_device_state;

/* What the motors shall apply until the next command, or for 60 ms if none comes: after that without force, and braked.
 */
typedef struct oos_device_command {
  uint32_t size;
  uint32_t reserved;
  uint64_t sequence;
  double F_Do_B[6];       /* force [N], torque about Do [Nm], in B */
  double grip_force_N;    /* positive opens the jaws */
  double brake_N_s_per_m; /* viscous damping, in the device's own loop */
  double brake_Nm_s_per_rad;
} oos_device_command;

/* Target of the springs and dampers of a simulated operator's arm and fingers. */
typedef struct oos_device_hand {
  uint32_t size;
  uint32_t holds_dead_man;
  double X_BT[7];
  double V_BT[6]; /* of the target, which moves on with it */
  double opening_m;
  double opening_velocity_m_per_s;
  double grip_strength_N;
} oos_device_hand;

/* Where the operator wants to be led. The force that leads and that of the command are together never larger than these
 * limits, which are the safety filter's. */
typedef struct oos_device_goal {
  uint32_t size;
  uint32_t reserved;
  double X_BG[7]; /* of the hand frame */
  double max_force_N;
  double max_torque_Nm;
} oos_device_goal;

/* For people who watch a device that is a robot. L is a joint's link, its frame at the joint, z along the axis. */
typedef struct oos_device_joint {
  double X_BL[7];
  double X_BL_target[7]; /* where a motion interpolator wants it */
  double position_rad;
  double speed_rad_per_s;
  double measured_Nm;
  double commanded_Nm;
  double temperature_degC;
  double radius_m; /* of the link, as a round bar to the next joint */
} oos_device_joint;

enum { OOS_DEVICE_MAX_JOINTS = 16 };

typedef struct oos_device_joints {
  uint32_t size;
  uint32_t num_joints;
  uint32_t has_target;
  uint32_t state;       /* 0 off, 1 idle, 2 ready, 3 engaging, 4 force, 5 degraded, 6 brake, 7 fault */
  uint32_t first_cause; /* as in DeviceJoints of device.proto */
  uint32_t reserved;
  double X_BD_target[7];
  oos_device_joint joints[OOS_DEVICE_MAX_JOINTS];
} oos_device_joints;

typedef struct oos_device_plugin {
  uint32_t abi_version; /* OOS_DEVICE_ABI_VERSION */
  uint32_t size;        /* of this struct */
  /* Opens the device of that setting. On success *device is what the other functions get. */
  int (*open)(const oos_device_setting* setting, void** device);
  /* What is open. May be called after any step, because another device may have been plugged in. */
  int (*describe)(void* device, oos_device_description* description);
  /* Comes to now_ns, takes over command and hand (null: the ones before stay), and gives the newest state. */
  int (*step)(void* device, int64_t now_ns, const oos_device_command* command, const oos_device_hand* hand,
              oos_device_state* state);
  void (*close)(void* device);
  /* A file descriptor that can be read when a sample is there; -1: none, the device is asked once a millisecond. May be
   * null. */
  int (*wait_fd)(void* device);
  /* The joints as of the latest step. Null, or missing at the end of a table that is older: the device is no robot.
   * Asked after a step, 62 times a second, by the thread that makes the steps. */
  int (*joints)(void* device, oos_device_joints* joints);
  /* With OOS_DEVICE_LEADS: leads the hand to the goal from now on, on a path of its own and softly, so that the hand
   * can leave it; null: no longer, which is also told when the bridge has been silent for 60 ms. Told after a step,
   * each millisecond, by the thread that makes the steps. Null, or missing at the end of a table that is older: the
   * device leads nowhere. */
  int (*lead)(void* device, const oos_device_goal* goal);
} oos_device_plugin;

/* The one symbol of a shared library. The table lives as long as the library. */
typedef const oos_device_plugin* (*oos_device_plugin_function)(void);
#define OOS_DEVICE_PLUGIN_SYMBOL "oos_device_plugin_get"

#ifdef __cplusplus
}
#endif

#endif
