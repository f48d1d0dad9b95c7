/* Example of a bridge, with a simulated device: a point mass on the spring of a hand. Copy it and insert your device's
 * calls at the places marked DEVICE; nothing else needs to change. POSIX.
 *
 *   cc -std=c99 -O2 example.c kerf_bridge.c -lm -o example
 *   ./example [PORT [circle]]
 *
 * PORT: 47810 by default; 0: any free port. The hand does not move; with "circle" it moves on a circle of 20 mm radius
 * through the centre, with a period of 6.3 s. Ends with Ctrl-C.
 */
#define _POSIX_C_SOURCE 200809L /* NOLINT(bugprone-reserved-identifier): defined by POSIX */

#include <arpa/inet.h>
#include <errno.h>
#include <math.h>
#include <netinet/in.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "kerf_bridge.h"

enum { MAX_PACKETS = 64 }; /* processed between two reads of the device */

static volatile sig_atomic_t stop_asked = 0;

static void on_signal(int number) {
  (void)number;
  stop_asked = 1;
}

static uint64_t now_ns(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (uint64_t)t.tv_sec * 1000000000u + (uint64_t)t.tv_nsec;
}

/* ---- the device: here a mass on the spring of a hand */
typedef struct {
  double position_mm[3];
  double velocity_mm_s[3];
  double time_s;
  int circle; /* 1: the hand moves on the circle */
} device;

static const kerf_bridge_description kDescription = {
    /* DEVICE: properties of your device (volumes/device_profiles.csv has the values of many). */
    "example", 3.3f, 0.88f, 0, 0, 0.4f, 0.004f, 75, 0.055f, 1000, 3, 0, 0, 2};

static int device_open(device* d, int circle) {
  /* DEVICE: OpenHaptics: hdInitDevice, hdEnable(HD_FORCE_OUTPUT), hdStartScheduler, and calibration. Force Dimension:
   * dhdOpen, dhdEnableForce. Return 0 on failure. */
  memset(d, 0, sizeof *d);
  d->circle = circle;
  return 1;
}

/* Simulates a step of the servo loop with this force on the hand. */
static void device_step(device* d, double dt_s, const float force_n[3]) {
  /* DEVICE: remove the simulation. Output the force instead: hdSetDoublev(HD_CURRENT_FORCE, ...) between hdBeginFrame
   * and hdEndFrame, or dhdSetForce; convert it from frame D first. */
  const double mass_kg = 0.15, spring_n_per_mm = 0.2, damper_ns_per_mm = 0.004;
  int i;
  d->time_s += dt_s;
  for (i = 0; i < 3; ++i) {
    const double round_mm = i == 0 ? 20 * sin(d->time_s) : i == 1 ? 20 - 20 * cos(d->time_s) : 0;
    const double wanted_mm = d->circle ? round_mm : 0;
    const double f_n =
        force_n[i] + spring_n_per_mm * (wanted_mm - d->position_mm[i]) - damper_ns_per_mm * d->velocity_mm_s[i];
    d->velocity_mm_s[i] += dt_s * 1000 * f_n / mass_kg;
    d->position_mm[i] += dt_s * d->velocity_mm_s[i];
  }
}

static void device_read(const device* d, kerf_bridge_state* state, float velocity_mm_s[3]) {
  /* DEVICE: hdGetDoublev(HD_CURRENT_POSITION / HD_CURRENT_TRANSFORM / HD_CURRENT_VELOCITY), hdGetIntegerv(
   * HD_CURRENT_BUTTONS); dhdGetPosition, dhdGetOrientationFrame, dhdGetLinearVelocity, dhdGetButtonMask. Metres to mm;
   * OpenHaptics has frame D's axes, DHD has x towards the user, y to the right, z up: D = (y, z, x). */
  int i;
  memset(state, 0, sizeof *state);
  state->orientation_wxyz[0] = 1;
  for (i = 0; i < 3; ++i) {
    state->position_mm[i] = (float)d->position_mm[i];
    velocity_mm_s[i] = (float)d->velocity_mm_s[i];
  }
  state->homed = 1;
  state->ready = 1;
}

static void device_close(device* d) {
  /* DEVICE: switch the force off, stop the scheduler, close the device. */
  (void)d;
}

/* Receives one of kerf's packets and answers it. Returns 0 if none is waiting or it cannot be answered. */
static int take_packet(int s, kerf_bridge* bridge) {
  unsigned char packet[2 * KERF_BRIDGE_BYTES], reply[KERF_BRIDGE_BYTES];
  struct sockaddr_in from;
  socklen_t from_size = sizeof from;
  uint64_t client;
  size_t count;
  const ssize_t got = recvfrom(s, packet, sizeof packet, MSG_DONTWAIT, (struct sockaddr*)&from, &from_size);
  if (got < 0) return 0;
  client = (uint64_t)from.sin_addr.s_addr << 16 | from.sin_port;
  count = kerf_bridge_take(bridge, packet, (size_t)got, client, now_ns(), reply);
  return count == 0 || sendto(s, reply, count, 0, (struct sockaddr*)&from, from_size) >= 0;
}

int main(int argc, char** argv) {
  struct sockaddr_in at;
  socklen_t size = sizeof at;
  kerf_bridge bridge;
  device d;
  long port = KERF_BRIDGE_PORT;
  uint64_t last_ns;
  float force_n[3] = {0, 0, 0}; /* output of the device */
  struct sigaction action;
  int s;

  if (argc > 1) {
    char* tail = NULL;
    errno = 0;
    port = strtol(argv[1], &tail, 10);
    if (argc > 3 || (argc == 3 && strcmp(argv[2], "circle") != 0) || errno != 0 || *argv[1] == '\0' || *tail != '\0' || port < 0 || port > 65535) {
      fprintf(stderr, "usage: %s [PORT [circle]]\n", argv[0]);
      return 2;
    }
  }
  memset(&action, 0, sizeof action);
  action.sa_handler = on_signal;
  sigaction(SIGINT, &action, NULL);
  sigaction(SIGTERM, &action, NULL);

  s = socket(AF_INET, SOCK_DGRAM, 0);
  memset(&at, 0, sizeof at);
  at.sin_family = AF_INET;
  at.sin_port = htons((uint16_t)port);
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK); /* this machine only: any sender can move the device */
  if (s < 0 || bind(s, (struct sockaddr*)&at, sizeof at) != 0 || getsockname(s, (struct sockaddr*)&at, &size) != 0) {
    fprintf(stderr, "%s: no socket at port %ld: %s\n", argv[0], port, strerror(errno));
    return 1;
  }
  if (!device_open(&d, argc == 3)) {
    fprintf(stderr, "%s: no device\n", argv[0]);
    return 1;
  }
  kerf_bridge_begin(&bridge, &kDescription);
  printf("listening at 127.0.0.1:%d\n", (int)ntohs(at.sin_port));
  fflush(stdout);

  last_ns = now_ns();
  while (!stop_asked) {
    /* The servo loop. A thread of your library (a scheduler callback) may do the device's part instead: reading it,
     * kerf_bridge_set_state, kerf_bridge_force. Then protect the bridge by a lock. */
    kerf_bridge_state state;
    float velocity_mm_s[3], torque_nmm[3];
    struct pollfd waiting;
    uint64_t t;
    double dt_s;
    int left;

    waiting.fd = s;
    waiting.events = POLLIN;
    poll(&waiting, 1, 1); /* at most 1 ms: the device is served even if no packets arrive */
    t = now_ns();
    dt_s = 1e-9 * (double)(t - last_ns);
    if (dt_s > 0.02) dt_s = 0.02; /* the program was suspended */
    last_ns = t;
    device_read(&d, &state, velocity_mm_s);
    memcpy(state.made_force_n, force_n, sizeof force_n);
    kerf_bridge_set_state(&bridge, &state, t);
    /* Limited number of packets, so that the device is served however many arrive. */
    for (left = MAX_PACKETS; left > 0 && take_packet(s, &bridge); --left) {
    }
    kerf_bridge_force(&bridge, now_ns(), state.position_mm, velocity_mm_s, force_n, torque_nmm);
    device_step(&d, dt_s, force_n);
  }
  device_close(&d);
  close(s);
  return 0;
}
