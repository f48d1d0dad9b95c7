/* The bridge between kerf and a haptic device whose maker has a library of its own: packets, session, and the force
 * that the device is to make. C99, no library but libm, no memory, no sockets, no clock: those are the caller's, see
 * example.c. The wire format is in docs/bridge.md.
 *
 * Frame D: right-handed, x to the user's right, y up, z towards the user, origin in the middle of the workspace. mm, N,
 * N mm, s.
 */
#ifndef KERF_BRIDGE_H
#define KERF_BRIDGE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define KERF_BRIDGE_BYTES 128
#define KERF_BRIDGE_VERSION 1
#define KERF_BRIDGE_PORT 47810
/* A state that was measured longer ago than this is answered as not ready: kerf then makes no force. ms */
#define KERF_BRIDGE_STATE_MS 50

enum kerf_bridge_kind {
  KERF_BRIDGE_HELLO = 1,
  KERF_BRIDGE_DESCRIPTION = 2,
  KERF_BRIDGE_COMMAND = 3,
  KERF_BRIDGE_STATE = 4,
  KERF_BRIDGE_REFUSAL = 5,
  KERF_BRIDGE_BYE = 6
};

enum kerf_bridge_reason {
  KERF_BRIDGE_OTHER_VERSION = 1,
  KERF_BRIDGE_BUSY = 2,
  KERF_BRIDGE_NO_DEVICE = 3,
  KERF_BRIDGE_NO_SESSION = 4
};

typedef struct {
  unsigned version;
  unsigned kind; /* enum kerf_bridge_kind */
  uint32_t session;
  uint32_t sequence;
  uint64_t time_ns;
  uint32_t flags;
  uint32_t answer_to;
} kerf_bridge_header;

typedef struct {
  float force_n[3];
  float torque_nmm[3];
  float anchor_mm[3];
  float stiffness_n_per_mm;
  float damping_ns_per_mm;
  uint32_t valid_ms;
  int engaged;
} kerf_bridge_command;

typedef struct {
  float position_mm[3];
  float orientation_wxyz[4]; /* unit length; 1 0 0 0 when it is not sensed */
  uint32_t buttons;
  float made_force_n[3];
  int homed;
  int ready; /* its motors are on; kerf makes force only when it is homed and ready */
} kerf_bridge_state;

typedef struct {
  const char* name; /* 1 to 31 printable ASCII characters */
  float peak_force_n;       /* 0: it makes none, and no torque either */
  float continuous_force_n; /* 0: not known, here and below, but for the peak torque */
  float peak_torque_nmm;    /* 0: it makes none */
  float continuous_torque_nmm;
  float max_stiffness_n_per_mm;
  float max_damping_ns_per_mm;
  float workspace_radius_mm;
  float resolution_mm;
  float rate_hz; /* of your servo loop */
  int driven;    /* degrees of freedom with motors: 0, 3 or 6 */
  int senses_orientation;
  int homes;
  int buttons; /* 0 to 32 */
} kerf_bridge_description;

/* ---- packets; each writer fills 128 bytes, each reader gives 1 when all is right and 0 when not */
/* That of zip and Ethernet. */
uint32_t kerf_bridge_crc32(const unsigned char* bytes, size_t count);
/* Of any version and kind: length, magic and sum are right. */
int kerf_bridge_read_header(const unsigned char* bytes, size_t count, kerf_bridge_header* header);
/* Of this version, with figures that are within their ranges. */
int kerf_bridge_read_command(const unsigned char* bytes, size_t count, kerf_bridge_command* command);
/* The header's kind and flags are not looked at: they follow from what is written. Texts are cut where they are too
 * long. kerf_bridge_take() writes these three by itself. */
void kerf_bridge_write_state(unsigned char* bytes, const kerf_bridge_header* header, const kerf_bridge_state* state);
void kerf_bridge_write_description(unsigned char* bytes, const kerf_bridge_header* header,
                                   const kerf_bridge_description* description);
void kerf_bridge_write_refusal(unsigned char* bytes, const kerf_bridge_header* header, unsigned reason,
                               const char* text);
/* For a program that plays kerf's part, and tests. */
void kerf_bridge_write_command(unsigned char* bytes, const kerf_bridge_header* header,
                               const kerf_bridge_command* command);
int kerf_bridge_read_state(const unsigned char* bytes, size_t count, kerf_bridge_state* state);

/* The force of a command at a place and a speed; not above peak_n (0: as it is). kerf_bridge_force() is the one to call
 * for a device: it looks whether the command is still good, and knows the device's peak. */
void kerf_bridge_field(const kerf_bridge_command* command, const float position_mm[3], const float velocity_mm_s[3],
                       float peak_n, float force_n[3]);

/* ---- the bridge's side of a session */
typedef struct {
  kerf_bridge_description description;
  /* What follows is kept by the functions below. */
  int has_session;
  uint32_t session;
  uint64_t client;        /* the caller's own number for where packets come from */
  uint32_t last_sequence; /* of the client's packets */
  uint64_t heard_ns;      /* when the last good one came */
  uint32_t sequence;      /* of our own packets */
  int has_command;
  uint64_t command_ns;
  kerf_bridge_command command;
  kerf_bridge_state state;
  uint64_t state_ns;     /* when it was measured; 0: never */
  unsigned long dropped; /* packets that were not right, old or doubled */
} kerf_bridge;

/* A bridge without a client and without a state. description->name must live as long as the bridge. */
void kerf_bridge_begin(kerf_bridge* bridge, const kerf_bridge_description* description);
/* Where the device is: what the next answers tell. measured_ns: when you read the device, of the clock of
 * kerf_bridge_take(); it goes out with the state. Call it where the device is read, each time, and nowhere else: that a
 * servo loop hangs can be seen only by its states growing old. */
void kerf_bridge_set_state(kerf_bridge* bridge, const kerf_bridge_state* state, uint64_t measured_ns);
/* Takes a datagram. `client` stands for its sender (address and port made to a number); now_ns is of a clock that only
 * goes forward. Gives the bytes of `reply` to send back to that sender: 128, or 0 for no answer. A command is answered
 * by the last state; without `ready` when that is older than KERF_BRIDGE_STATE_MS, or when there is none. now_ns may be
 * before its time by less than a second, as with kerf_bridge_force(): the state is new then. */
size_t kerf_bridge_take(kerf_bridge* bridge, const unsigned char* bytes, size_t count, uint64_t client, uint64_t now_ns,
                        unsigned char reply[KERF_BRIDGE_BYTES]);
/* Force and torque to make now, never above the peaks described: call it from your servo loop, as fast as that runs.
 * Zero when there is no command, it is not engaged, or it is older than it says that it is good for. Both are zero when
 * the peak force described is not above 0 (or not a number up to 1e6), the torque when the peak torque is not. now_ns is
 * of the clock of kerf_bridge_take(); it may be before the time given there by less than a second, where this thread
 * looked at the clock and then waited for the lock: the command is new then. A clock that is further back gives zero. */
void kerf_bridge_force(const kerf_bridge* bridge, uint64_t now_ns, const float position_mm[3],
                       const float velocity_mm_s[3], float force_n[3], float torque_nmm[3]);

#ifdef __cplusplus
}
#endif

#endif
