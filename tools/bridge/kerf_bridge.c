#include "kerf_bridge.h"

#include <math.h>
#include <string.h>

/* Byte offsets in a packet. */
enum {
  AT_MAGIC = 0,
  AT_VERSION = 4,
  AT_KIND = 6,
  AT_SESSION = 8,
  AT_SEQUENCE = 12,
  AT_TIME = 16,
  AT_FLAGS = 24,
  AT_ANSWER_TO = 28,
  AT_PAYLOAD = 32,
  AT_CRC = 124
};

#define MAGIC 0x4752424bu /* "KBRG" */
#define FLAG_ENGAGED 1u
#define FLAG_HOMED 1u
#define FLAG_READY 2u
#define MAX_VALUE 1e6f
#define MAX_VALID_MS 1000u
/* A client that is silent for longer than this is considered gone, and another may connect. */
#define CLIENT_GONE_NS 2000000000ull
/* Maximum time by which a servo loop that read the clock and then waited for the lock may be behind a command. */
#define BEHIND_NS 1000000000ull

static uint64_t get(const unsigned char* bytes, int count) {
  uint64_t value = 0;
  int i;
  for (i = 0; i < count; ++i) value |= (uint64_t)bytes[i] << (8 * i);
  return value;
}

static void put(unsigned char* bytes, int count, uint64_t value) {
  int i;
  for (i = 0; i < count; ++i) bytes[i] = (unsigned char)(value >> (8 * i) & 0xff);
}

static float get_real(const unsigned char* bytes) {
  const uint32_t bits = (uint32_t)get(bytes, 4);
  float value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

static void put_real(unsigned char* bytes, float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  put(bytes, 4, bits);
}

static int is_in_range(float x) { return x >= -MAX_VALUE && x <= MAX_VALUE; }

static int get_reals(const unsigned char* bytes, int count, float* values) {
  int good = 1;
  int i;
  for (i = 0; i < count; ++i) {
    values[i] = get_real(bytes + 4 * i);
    good = good && is_in_range(values[i]);
  }
  return good;
}

static void put_reals(unsigned char* bytes, int count, const float* values) {
  int i;
  for (i = 0; i < count; ++i) put_real(bytes + 4 * i, values[i]);
}

static void put_text(unsigned char* bytes, size_t count, const char* text) {
  size_t i;
  for (i = 0; i + 1 < count && text[i] != '\0'; ++i) {
    bytes[i] = (unsigned char)(text[i] >= 0x20 && text[i] < 0x7f ? text[i] : '?');
  }
}

uint32_t kerf_bridge_crc32(const unsigned char* bytes, size_t count) {
  uint32_t crc = 0xffffffffu;
  size_t i;
  int bit;
  for (i = 0; i < count; ++i) {
    crc ^= bytes[i];
    for (bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1u) != 0 ? 0xedb88320u : 0u);
  }
  return ~crc;
}

static void begin(unsigned char* bytes, const kerf_bridge_header* header, unsigned kind, uint32_t flags) {
  memset(bytes, 0, KERF_BRIDGE_BYTES);
  put(bytes + AT_MAGIC, 4, MAGIC);
  put(bytes + AT_VERSION, 2, header->version);
  put(bytes + AT_KIND, 2, kind);
  put(bytes + AT_SESSION, 4, header->session);
  put(bytes + AT_SEQUENCE, 4, header->sequence);
  put(bytes + AT_TIME, 8, header->time_ns);
  put(bytes + AT_FLAGS, 4, flags);
  put(bytes + AT_ANSWER_TO, 4, header->answer_to);
}

static void end(unsigned char* bytes) { put(bytes + AT_CRC, 4, kerf_bridge_crc32(bytes, AT_CRC)); }

int kerf_bridge_read_header(const unsigned char* bytes, size_t count, kerf_bridge_header* header) {
  if (count != KERF_BRIDGE_BYTES || get(bytes + AT_MAGIC, 4) != MAGIC ||
      get(bytes + AT_CRC, 4) != kerf_bridge_crc32(bytes, AT_CRC)) {
    return 0;
  }
  header->version = (unsigned)get(bytes + AT_VERSION, 2);
  header->kind = (unsigned)get(bytes + AT_KIND, 2);
  header->session = (uint32_t)get(bytes + AT_SESSION, 4);
  header->sequence = (uint32_t)get(bytes + AT_SEQUENCE, 4);
  header->time_ns = get(bytes + AT_TIME, 8);
  header->flags = (uint32_t)get(bytes + AT_FLAGS, 4);
  header->answer_to = (uint32_t)get(bytes + AT_ANSWER_TO, 4);
  return header->kind >= KERF_BRIDGE_HELLO && header->kind <= KERF_BRIDGE_BYE;
}

int kerf_bridge_read_command(const unsigned char* bytes, size_t count, kerf_bridge_command* command) {
  kerf_bridge_header header;
  const unsigned char* p = bytes + AT_PAYLOAD;
  int good;
  if (!kerf_bridge_read_header(bytes, count, &header) || header.version != KERF_BRIDGE_VERSION ||
      header.kind != KERF_BRIDGE_COMMAND) {
    return 0;
  }
  good = get_reals(p, 3, command->force_n);
  good = get_reals(p + 12, 3, command->torque_nmm) && good;
  good = get_reals(p + 24, 3, command->anchor_mm) && good;
  good = get_reals(p + 36, 1, &command->stiffness_n_per_mm) && good;
  good = get_reals(p + 40, 1, &command->damping_ns_per_mm) && good;
  command->valid_ms = (uint32_t)get(p + 44, 4);
  command->engaged = (header.flags & FLAG_ENGAGED) != 0;
  return good && command->stiffness_n_per_mm >= 0 && command->damping_ns_per_mm >= 0 && command->valid_ms >= 1 &&
         command->valid_ms <= MAX_VALID_MS;
}

void kerf_bridge_write_command(unsigned char* bytes, const kerf_bridge_header* header,
                               const kerf_bridge_command* command) {
  unsigned char* p = bytes + AT_PAYLOAD;
  begin(bytes, header, KERF_BRIDGE_COMMAND, command->engaged ? FLAG_ENGAGED : 0);
  put_reals(p, 3, command->force_n);
  put_reals(p + 12, 3, command->torque_nmm);
  put_reals(p + 24, 3, command->anchor_mm);
  put_real(p + 36, command->stiffness_n_per_mm);
  put_real(p + 40, command->damping_ns_per_mm);
  put(p + 44, 4, command->valid_ms);
  end(bytes);
}

void kerf_bridge_write_state(unsigned char* bytes, const kerf_bridge_header* header, const kerf_bridge_state* state) {
  unsigned char* p = bytes + AT_PAYLOAD;
  begin(bytes, header, KERF_BRIDGE_STATE, (state->homed ? FLAG_HOMED : 0) | (state->ready ? FLAG_READY : 0));
  put_reals(p, 3, state->position_mm);
  put_reals(p + 12, 4, state->orientation_wxyz);
  put(p + 28, 4, state->buttons);
  put_reals(p + 32, 3, state->made_force_n);
  end(bytes);
}

int kerf_bridge_read_state(const unsigned char* bytes, size_t count, kerf_bridge_state* state) {
  kerf_bridge_header header;
  const unsigned char* p = bytes + AT_PAYLOAD;
  const float* q = state->orientation_wxyz;
  double length;
  int good;
  if (!kerf_bridge_read_header(bytes, count, &header) || header.version != KERF_BRIDGE_VERSION ||
      header.kind != KERF_BRIDGE_STATE) {
    return 0;
  }
  good = get_reals(p, 3, state->position_mm);
  good = get_reals(p + 12, 4, state->orientation_wxyz) && good;
  state->buttons = (uint32_t)get(p + 28, 4);
  good = get_reals(p + 32, 3, state->made_force_n) && good;
  state->homed = (header.flags & FLAG_HOMED) != 0;
  state->ready = (header.flags & FLAG_READY) != 0;
  length = sqrt((double)q[0] * q[0] + (double)q[1] * q[1] + (double)q[2] * q[2] + (double)q[3] * q[3]);
  return good && fabs(length - 1) <= 1e-3;
}

void kerf_bridge_write_description(unsigned char* bytes, const kerf_bridge_header* header,
                                   const kerf_bridge_description* d) {
  unsigned char* p = bytes + AT_PAYLOAD;
  begin(bytes, header, KERF_BRIDGE_DESCRIPTION, 0);
  put_text(p, 32, d->name);
  put_real(p + 32, d->peak_force_n);
  put_real(p + 36, d->continuous_force_n);
  put_real(p + 40, d->peak_torque_nmm);
  put_real(p + 44, d->continuous_torque_nmm);
  put_real(p + 48, d->max_stiffness_n_per_mm);
  put_real(p + 52, d->max_damping_ns_per_mm);
  put_real(p + 56, d->workspace_radius_mm);
  put_real(p + 60, d->resolution_mm);
  put_real(p + 64, d->rate_hz);
  p[68] = (unsigned char)d->driven;
  p[69] = (unsigned char)(d->senses_orientation != 0);
  p[70] = (unsigned char)(d->homes != 0);
  p[71] = (unsigned char)d->buttons;
  end(bytes);
}

void kerf_bridge_write_refusal(unsigned char* bytes, const kerf_bridge_header* header, unsigned reason,
                               const char* text) {
  unsigned char* p = bytes + AT_PAYLOAD;
  begin(bytes, header, KERF_BRIDGE_REFUSAL, 0);
  put(p, 4, reason);
  put(p + 4, 4, KERF_BRIDGE_VERSION);
  put_text(p + 8, 80, text);
  end(bytes);
}

void kerf_bridge_field(const kerf_bridge_command* command, const float position_mm[3], const float velocity_mm_s[3],
                       float peak_n, float force_n[3]) {
  const float* f = command->force_n;
  const double size = sqrt((double)f[0] * f[0] + (double)f[1] * f[1] + (double)f[2] * f[2]);
  double made[3];
  double sum;
  int i;
  for (i = 0; i < 3; ++i) made[i] = -(double)command->damping_ns_per_mm * velocity_mm_s[i];
  if (size > 0) {
    double moved_mm = 0;
    double along;
    for (i = 0; i < 3; ++i) moved_mm += ((double)position_mm[i] - command->anchor_mm[i]) * f[i] / size;
    along = size - (double)command->stiffness_n_per_mm * moved_mm;
    if (along < 0) along = 0;
    for (i = 0; i < 3; ++i) made[i] += along * f[i] / size;
  }
  sum = sqrt(made[0] * made[0] + made[1] * made[1] + made[2] * made[2]);
  for (i = 0; i < 3; ++i) {
    if (!(sum <= 1e12)) {
      made[i] = 0; /* not a number, or infinite */
    } else if (peak_n > 0 && sum > peak_n) {
      made[i] *= peak_n / sum;
    }
    force_n[i] = (float)made[i];
  }
}

void kerf_bridge_begin(kerf_bridge* bridge, const kerf_bridge_description* description) {
  memset(bridge, 0, sizeof *bridge);
  bridge->description = *description;
  bridge->state.orientation_wxyz[0] = 1;
}

void kerf_bridge_set_state(kerf_bridge* bridge, const kerf_bridge_state* state, uint64_t measured_ns) {
  bridge->state = *state;
  bridge->state_ns = measured_ns;
}

/* Returns 1 if since_ns is at most max_age_ms before now_ns. */
static int is_fresh(uint64_t since_ns, uint64_t now_ns, uint32_t max_age_ms) {
  if (now_ns < since_ns) return since_ns - now_ns < BEHIND_NS;
  return now_ns - since_ns <= (uint64_t)max_age_ms * 1000000u;
}

/* Writes the last state, marked as not ready if it is too old. */
static void write_last_state(const kerf_bridge* bridge, uint64_t now_ns, kerf_bridge_header header,
                             unsigned char* reply) {
  kerf_bridge_state state = bridge->state;
  /* If the servo loop hangs, the pose no longer changes, and it must not cause a force. */
  if (!is_fresh(bridge->state_ns, now_ns, KERF_BRIDGE_STATE_MS)) state.ready = 0;
  header.time_ns = bridge->state_ns;
  kerf_bridge_write_state(reply, &header, &state);
}

static size_t refuse(unsigned char* reply, kerf_bridge_header header, unsigned reason, const char* text) {
  kerf_bridge_write_refusal(reply, &header, reason, text);
  return KERF_BRIDGE_BYTES;
}

size_t kerf_bridge_take(kerf_bridge* bridge, const unsigned char* bytes, size_t count, uint64_t client, uint64_t now_ns,
                        unsigned char reply[KERF_BRIDGE_BYTES]) {
  kerf_bridge_header header;
  kerf_bridge_header answer;
  int same;
  if (!kerf_bridge_read_header(bytes, count, &header)) {
    ++bridge->dropped;
    return 0;
  }
  memset(&answer, 0, sizeof answer);
  answer.version = KERF_BRIDGE_VERSION;
  answer.session = header.session;
  answer.sequence = ++bridge->sequence;
  answer.time_ns = now_ns;
  answer.answer_to = header.sequence;
  if (header.version != KERF_BRIDGE_VERSION) {
    return refuse(reply, answer, KERF_BRIDGE_OTHER_VERSION, "this bridge speaks version 1");
  }
  same = bridge->has_session && client == bridge->client && header.session == bridge->session;
  if (header.kind == KERF_BRIDGE_HELLO) {
    if (!same) {
      if (bridge->has_session && client != bridge->client && now_ns - bridge->heard_ns < CLIENT_GONE_NS) {
        return refuse(reply, answer, KERF_BRIDGE_BUSY, "another client has the device");
      }
      bridge->has_session = 1;
      bridge->session = header.session;
      bridge->client = client;
      bridge->has_command = 0;
      bridge->last_sequence = header.sequence;
    } else if ((int32_t)(header.sequence - bridge->last_sequence) > 0) {
      bridge->last_sequence = header.sequence;
    }
    bridge->heard_ns = now_ns;
    kerf_bridge_write_description(reply, &answer, &bridge->description);
    return KERF_BRIDGE_BYTES;
  }
  if (!same) {
    if (header.kind != KERF_BRIDGE_COMMAND) return 0;
    return refuse(reply, answer, KERF_BRIDGE_NO_SESSION, "begin with a hello");
  }
  if ((int32_t)(header.sequence - bridge->last_sequence) <= 0) {
    ++bridge->dropped; /* old or duplicate */
    return 0;
  }
  if (header.kind == KERF_BRIDGE_BYE) {
    bridge->has_session = 0;
    bridge->has_command = 0;
    return 0;
  }
  {
    kerf_bridge_command command;
    if (!kerf_bridge_read_command(bytes, count, &command)) {
      ++bridge->dropped;
      return 0;
    }
    bridge->command = command;
  }
  bridge->has_command = 1;
  bridge->command_ns = now_ns;
  bridge->heard_ns = now_ns;
  bridge->last_sequence = header.sequence;
  write_last_state(bridge, now_ns, answer, reply);
  return KERF_BRIDGE_BYTES;
}

static int is_peak(float x) { return is_in_range(x) && x > 0; }

void kerf_bridge_force(const kerf_bridge* bridge, uint64_t now_ns, const float position_mm[3],
                       const float velocity_mm_s[3], float force_n[3], float torque_nmm[3]) {
  const kerf_bridge_command* command = &bridge->command;
  const kerf_bridge_description* device = &bridge->description;
  double size = 0;
  int i;
  for (i = 0; i < 3; ++i) force_n[i] = torque_nmm[i] = 0;
  if (!bridge->has_command || !command->engaged || !is_fresh(bridge->command_ns, now_ns, command->valid_ms)) {
    return;
  }
  /* For kerf_bridge_field() a peak of 0 means unlimited; here it means a device without force. */
  if (device->driven < 3 || !is_peak(device->peak_force_n)) return;
  kerf_bridge_field(command, position_mm, velocity_mm_s, device->peak_force_n, force_n);
  if (device->driven < 6 || !is_peak(device->peak_torque_nmm)) return;
  for (i = 0; i < 3; ++i) size += (double)command->torque_nmm[i] * command->torque_nmm[i];
  size = sqrt(size);
  for (i = 0; i < 3; ++i) {
    const double most = device->peak_torque_nmm;
    torque_nmm[i] = (float)(command->torque_nmm[i] * (size > most ? most / size : 1.0));
  }
}
