/* A plugin in C11 against the bare ABI. Each fixture defines one of the macros below to make one thing wrong. */
#define _POSIX_C_SOURCE 200809L
#include <stdlib.h>

#include <springnet/sdk/plugin.h>

#ifndef MAGIC
#define MAGIC SPRINGNET_MAGIC
#endif
#ifndef ABI_MAJOR
#define ABI_MAJOR SPRINGNET_ABI_MAJOR
#endif
#ifndef ABI_MINOR
#define ABI_MINOR SPRINGNET_ABI_MINOR
#endif
#ifndef DEFAULT_STIFFNESS
#define DEFAULT_STIFFNESS 1
#endif
#ifndef COMPONENT_ID
#define COMPONENT_ID "fixture"
#endif
#ifdef RUDE /* clears the screen, renames the window, and is no UTF-8 */
#define COMPONENT_SUMMARY "\033[2J\033]0;owned\007 \377\376"
#else
#define COMPONENT_SUMMARY "tension is length"
#endif
#ifndef PLUGIN_ID
#define PLUGIN_ID "org.example.fixture"
#endif

#ifdef CALLS_NOWHERE
double springnet_fixture_nowhere(double);
#endif

#ifndef VERSION
#define VERSION "1.2.3"
#endif

#if defined(OTHER_NOTE) /* longer than that of 2.0, as that of a later minor version */
#ifndef NOTE_NAME
#define NOTE_NAME SPRINGNET_NOTE_NAME
#endif
#ifndef NOTE_NAME_SIZE
#define NOTE_NAME_SIZE sizeof NOTE_NAME
#endif
#ifndef NOTE_MAJOR
#define NOTE_MAJOR ABI_MAJOR
#endif
#ifndef NOTE_NEEDS
#define NOTE_NEEDS 0
#endif
struct long_note {
  springnet_note note;
  uint32_t tail[2];
};
static const struct long_note note __attribute__((used, section(".note.springnet"), aligned(4))) = {
    {NOTE_NAME_SIZE, 24, SPRINGNET_NOTE_TYPE, NOTE_NAME, NOTE_MAJOR, ABI_MINOR, NOTE_NEEDS, 0}, {1, 2}};
#elif !defined(NO_NOTE)
SPRINGNET_PLUGIN_NOTE(0);
#endif

#ifdef CONSTRUCTOR /* leaves a trace of its own if the file is opened */
__attribute__((constructor)) static void constructed(void) { setenv("SPRINGNET_FIXTURE_CONSTRUCTED", "yes", 1); }
#endif

static springnet_status evaluate(void* context, const springnet_law_batch* batch) {
  (void)context;
  for (uint32_t i = 0; i < batch->count; ++i) {
    batch->force[i] = batch->q[i];
#ifdef CALLS_NOWHERE
    batch->force[i] = springnet_fixture_nowhere(batch->q[i]);
#endif
  }
  return SPRINGNET_OK;
}

static const springnet_parameter stiffness = {.struct_size = sizeof(springnet_parameter),
                                              .type = SPRINGNET_NUMBER,
                                              .name = "stiffness",
                                              .unit = "N/m",
                                              .summary = "tension per length",
                                              .default_value = DEFAULT_STIFFNESS,
                                              .smallest = 0,
                                              .largest = 1e9,
                                              .scale = 1};
static const springnet_parameter* const parameters[] = {&stiffness};
static const springnet_law law = {.struct_size = sizeof(springnet_law),
                                  .invariant = SPRINGNET_LENGTH,
                                  .update_order = 1,
                                  .largest_stretch = 1e9,
                                  .evaluate = evaluate};
static const springnet_component component = {.struct_size = sizeof(springnet_component),
                                              .kind = SPRINGNET_SPRING_FUNCTION,
                                              .id = COMPONENT_ID,
                                              .summary = COMPONENT_SUMMARY,
                                              .reference = "",
                                              .parameter_count = 1,
                                              .parameters = parameters,
                                              .implementation = &law};
static const springnet_component* const components[] = {&component};

#ifdef NO_ENTRY
SPRINGNET_EXPORT const void* const another_symbol = components;
#else
/* A struct of a later minor version is longer. */
typedef struct entry {
  springnet_plugin plugin;
#ifdef PLUGIN_TAIL
  const char* tail[4];
#endif
} entry;
#ifndef PLUGIN_SIZE
#define PLUGIN_SIZE sizeof(entry)
#endif
SPRINGNET_EXPORT extern const entry springnet_plugin_entry;
const entry springnet_plugin_entry = {.plugin = {.magic = MAGIC,
                                                 .struct_size = PLUGIN_SIZE,
                                                 .abi_major = ABI_MAJOR,
                                                 .abi_minor = ABI_MINOR,
                                                 .component_count = 1,
                                                 .id = PLUGIN_ID,
                                                 .version = VERSION,
                                                 .author = "tests",
                                                 .licence = "MIT",
                                                 .components = components}};
#endif
