/* Bridge between kerf and a haptic device with a vendor library: packets, session, and the force that the device must
 * output. C99; uses no library except libm, allocates no memory, and uses no sockets or clock, which the caller
 * provides (see example.c). The wire format is in docs/bridge.md.
 *
 * Frame D: right-handed, x to the user's right, y up, z towards the user, origin at the centre of the workspace.
 * Units: mm, N, N mm, s.
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
/* Maximum age of a state, ms. An older state is sent as not ready, and kerf then outputs no force. */
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
  float orientation_wxyz[4]; /* unit length; 1 0 0 0 if not sensed */
  uint32_t buttons;
  float made_force_n[3];
  int homed;
  int ready; /* motors are on; kerf outputs force only if homed and ready */
} kerf_bridge_state;

typedef struct {
  const char* name; /* 1 to 31 printable ASCII characters */
  float peak_force_n;       /* 0: no force and no torque */
  float continuous_force_n; /* 0: unknown, here and below, except for the peak torque */
  float peak_torque_nmm;    /* 0: no torque */
  float continuous_torque_nmm;
  float max_stiffness_n_per_mm;
  float max_damping_ns_per_mm;
  float workspace_radius_mm;
  float resolution_mm;
  float rate_hz; /* of the servo loop */
  int driven;    /* degrees of freedom with motors: 0, 3 or 6 */
  int senses_orientation;
  int homes;
  int buttons; /* 0 to 32 */
} kerf_bridge_description;

/* ---- packets; each writer fills 128 bytes, each reader returns 1 if the packet is valid and 0 otherwise */
/* Returns the CRC-32 of zip and Ethernet. */
uint32_t kerf_bridge_crc32(const unsigned char* bytes, size_t count);
/* Accepts any version and kind with correct length, magic number and checksum. */
int kerf_bridge_read_header(const unsigned char* bytes, size_t count, kerf_bridge_header* header);
/* Accepts this version, with values in their ranges. */
int kerf_bridge_read_command(const unsigned char* bytes, size_t count, kerf_bridge_command* command);
/* The header's kind and flags are ignored: they follow from the function called. Texts that are too long are cut.
 * kerf_bridge_take() writes these three packets itself. */
void kerf_bridge_write_state(unsigned char* bytes, const kerf_bridge_header* header, const kerf_bridge_state* state);
void kerf_bridge_write_description(unsigned char* bytes, const kerf_bridge_header* header,
                                   const kerf_bridge_description* description);
void kerf_bridge_write_refusal(unsigned char* bytes, const kerf_bridge_header* header, unsigned reason,
                               const char* text);
/* For tests and programs that replace kerf. */
void kerf_bridge_write_command(unsigned char* bytes, const kerf_bridge_header* header,
                               const kerf_bridge_command* command);
int kerf_bridge_read_state(const unsigned char* bytes, size_t count, kerf_bridge_state* state);

/* Computes the force of a command at a position and a velocity, limited to peak_n (0: unlimited). For a device call
 * kerf_bridge_force() instead: it checks that the command is still valid, and applies the device's peak. */
void kerf_bridge_field(const kerf_bridge_command* command, const float position_mm[3], const float velocity_mm_s[3],
                       float peak_n, float force_n[3]);

/* ---- the bridge's side of a session */
typedef struct {
  kerf_bridge_description description;
  /* Maintained by the functions below. */
  int has_session;
  uint32_t session;
  uint64_t client;        /* the caller's number for the sender of packets */
  uint32_t last_sequence; /* of the client's packets */
  uint64_t heard_ns;      /* time of the last valid packet */
  uint32_t sequence;      /* of the bridge's packets */
  int has_command;
  uint64_t command_ns;
  kerf_bridge_command command;
  kerf_bridge_state state;
  uint64_t state_ns;     /* time of the measurement; 0: never */
  unsigned long dropped; /* number of invalid, old or duplicate packets */
} kerf_bridge;

/* Initialises a bridge without client and state. description->name must live as long as the bridge. */
void kerf_bridge_begin(kerf_bridge* bridge, const kerf_bridge_description* description);
/* Sets the state of the device that the next answers contain. measured_ns: time when the device was read, by the clock
 * of kerf_bridge_take(); it is sent with the state. Call it each time the device is read, and nowhere else: a hanging
 * servo loop can be detected only by the age of its states. */
void kerf_bridge_set_state(kerf_bridge* bridge, const kerf_bridge_state* state, uint64_t measured_ns);
/* Processes a datagram. `client` identifies its sender (address and port as a number); now_ns: time of a monotonic
 * clock. Returns the number of bytes of `reply` to send back to that sender: 128, or 0 for no answer. A command is
 * answered with the last state, without `ready` if that is older than KERF_BRIDGE_STATE_MS or missing. now_ns may be
 * before the time of the state by less than a second, as with kerf_bridge_force(); the state then counts as new. */
size_t kerf_bridge_take(kerf_bridge* bridge, const unsigned char* bytes, size_t count, uint64_t client, uint64_t now_ns,
                        unsigned char reply[KERF_BRIDGE_BYTES]);
/* Computes the force and torque to output now, limited to the peaks in the description. Call it in every iteration of
 * the servo loop. Both are zero if there is no command, the command is not engaged, or it is older than valid_ms. Both
 * are also zero unless the peak force in the description is a number above 0 and at most 1e6; the same holds for the
 * torque and its peak. now_ns: time of the same clock as in kerf_bridge_take(). It may be before the time given there
 * by less than a second, if this thread read the clock and then waited for the lock; the command then counts as new. An
 * earlier now_ns gives zero. */
void kerf_bridge_force(const kerf_bridge* bridge, uint64_t now_ns, const float position_mm[3],
                       const float velocity_mm_s[3], float force_n[3], float torque_nmm[3]);

#ifdef __cplusplus
}
#endif

#endif
