/* Made by varcontact $version: vc_forces as an FMU of FMI 2.0 and 3.0, without states: outputs follow from the inputs.
 * The types are those of the headers of the standard, which are not needed to compile this file.
 */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "vc_forces.h"

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#elif defined __GNUC__
#define EXPORT __attribute__((visibility("default")))
#else
#define EXPORT
#endif
#ifndef FMI2_FUNCTION_PREFIX
#define FMI2_FUNCTION_PREFIX
#endif
#ifndef FMI3_FUNCTION_PREFIX
#define FMI3_FUNCTION_PREFIX
#endif
#define JOINED(prefix, name) prefix##name
#define NAMED(prefix, name) JOINED(prefix, name)
#define FMI2(type, name) EXPORT type NAMED(FMI2_FUNCTION_PREFIX, fmi2##name)
#define FMI3(type, name) EXPORT type NAMED(FMI3_FUNCTION_PREFIX, fmi3##name)

enum { OK, WARNING, DISCARD, ERROR };
enum { INPUTS = 9, OUTPUTS = 12, TIME = INPUTS + OUTPUTS, VALUES };

typedef void (*Log2)(void *environment, const char *instance, int status, const char *category, const char *text, ...);
typedef void (*Log3)(void *environment, int status, const char *category, const char *text);

typedef struct {
    Log2 log;
    void *allocate, *release, *finished, *environment;
} Callbacks2;

typedef struct {
    int new_states, terminate, nominals, values, next_defined;
    double next;
} Events2;

typedef struct {
    double value[VALUES]; /* by value reference */
    bool known;           /* outputs belong to the inputs */
    int status;           /* FMI's */
    Log2 log2;
    Log3 log3;
    void *environment;
    char name[64];
} Instance;

static int reset(Instance *m)
{
    static const double start[INPUTS] = {6e-3, 4e-3, 82e9, VC_NU, 1e5, 0.3, 0, 0, 0};
    memset(m->value, 0, sizeof m->value);
    memcpy(m->value, start, sizeof start);
    m->known = false;
    m->status = OK;
    return OK;
}

static Instance *instance(const char *name, const char *token, Log2 log2, Log3 log3, void *environment)
{
    Instance *m = token && strcmp(token, VC_BOOK) == 0 ? calloc(1, sizeof *m) : NULL;
    if (m) {
        reset(m);
        m->log2 = log2;
        m->log3 = log3;
        m->environment = environment;
        strncpy(m->name, name ? name : "", sizeof m->name - 1);
    } else if (log2)
        log2(environment, name, ERROR, "logStatusError", "the token is not that of this FMU, or memory is full");
    else if (log3)
        log3(environment, ERROR, "logStatusError", "the token is not that of this FMU, or memory is full");
    return m;
}

static int set(Instance *m, const uint32_t *references, size_t n, const double *values)
{
    for (size_t k = 0; k < n; k++) {
        if (references[k] >= INPUTS) return ERROR;
        m->value[references[k]] = values[k];
        m->known = false;
    }
    return OK;
}

static int get(Instance *m, const uint32_t *references, size_t n, double *values)
{
    int worst = OK;
    for (size_t k = 0; k < n; k++) {
        uint32_t at = references[k];
        if (at >= VALUES) return ERROR;
        if (at >= INPUTS && at < TIME) {
            if (!m->known) {
                int before = m->status, found = vc_forces_gradient(m->value, m->value + INPUTS);
                m->known = true;
                m->status = found < 0 ? ERROR : found > 0 ? WARNING : OK;
                if (m->status != before && m->status != OK) {
                    if (m->log2) m->log2(m->environment, m->name, m->status, "logStatusError", vc_message(found));
                    if (m->log3) m->log3(m->environment, m->status, "logStatusError", vc_message(found));
                }
            }
            worst = m->status;
        }
        values[k] = m->value[at];
    }
    return worst;
}

static int set_time(Instance *m, double time)
{
    m->value[TIME] = time;
    return OK;
}

/* Variables of other types, states, event indicators: there are none. */
static int none(size_t n)
{
    return n ? ERROR : OK;
}

/* FMI 2.0 */
typedef const uint32_t *References;
FMI2(const char *, GetTypesPlatform)(void) { return "default"; }
FMI2(const char *, GetVersion)(void) { return "2.0"; }
FMI2(int, SetDebugLogging)(void *m, int on, size_t n, const char *const *categories) { return OK; }
FMI2(void *, Instantiate)(const char *name, int type, const char *guid, const char *resources,
                          const Callbacks2 *callbacks, int visible, int logging)
{
    return instance(name, guid, callbacks ? callbacks->log : NULL, NULL, callbacks ? callbacks->environment : NULL);
}
FMI2(void, FreeInstance)(void *m) { free(m); }
FMI2(int, SetupExperiment)(void *m, int tolerance_defined, double tolerance, double start, int stop_defined, double stop)
{
    return set_time(m, start);
}
FMI2(int, EnterInitializationMode)(void *m) { return OK; }
FMI2(int, ExitInitializationMode)(void *m) { return OK; }
FMI2(int, Terminate)(void *m) { return OK; }
FMI2(int, Reset)(void *m) { return reset(m); }
FMI2(int, GetReal)(void *m, References at, size_t n, double *values) { return get(m, at, n, values); }
FMI2(int, SetReal)(void *m, References at, size_t n, const double *values) { return set(m, at, n, values); }
FMI2(int, GetInteger)(void *m, References at, size_t n, int *values) { return none(n); }
FMI2(int, SetInteger)(void *m, References at, size_t n, const int *values) { return none(n); }
FMI2(int, GetBoolean)(void *m, References at, size_t n, int *values) { return none(n); }
FMI2(int, SetBoolean)(void *m, References at, size_t n, const int *values) { return none(n); }
FMI2(int, GetString)(void *m, References at, size_t n, const char **values) { return none(n); }
FMI2(int, SetString)(void *m, References at, size_t n, const char *const *values) { return none(n); }
FMI2(int, GetFMUstate)(void *m, void **state) { return ERROR; }
FMI2(int, SetFMUstate)(void *m, void *state) { return ERROR; }
FMI2(int, FreeFMUstate)(void *m, void **state) { return ERROR; }
FMI2(int, SerializedFMUstateSize)(void *m, void *state, size_t *size) { return ERROR; }
FMI2(int, SerializeFMUstate)(void *m, void *state, char *bytes, size_t size) { return ERROR; }
FMI2(int, DeSerializeFMUstate)(void *m, const char *bytes, size_t size, void **state) { return ERROR; }
FMI2(int, GetDirectionalDerivative)(void *m, References unknowns, size_t n, References knowns, size_t known,
                                    const double *seed, double *values)
{
    return ERROR;
}
FMI2(int, EnterEventMode)(void *m) { return OK; }
FMI2(int, NewDiscreteStates)(void *m, Events2 *events)
{
    memset(events, 0, sizeof *events);
    return OK;
}
FMI2(int, EnterContinuousTimeMode)(void *m) { return OK; }
FMI2(int, CompletedIntegratorStep)(void *m, int no_set, int *event_mode, int *terminate)
{
    *event_mode = *terminate = 0;
    return OK;
}
FMI2(int, SetTime)(void *m, double time) { return set_time(m, time); }
FMI2(int, SetContinuousStates)(void *m, const double *states, size_t n) { return none(n); }
FMI2(int, GetDerivatives)(void *m, double *values, size_t n) { return none(n); }
FMI2(int, GetEventIndicators)(void *m, double *values, size_t n) { return none(n); }
FMI2(int, GetContinuousStates)(void *m, double *values, size_t n) { return none(n); }
FMI2(int, GetNominalsOfContinuousStates)(void *m, double *values, size_t n) { return none(n); }
FMI2(int, SetRealInputDerivatives)(void *m, References at, size_t n, const int *orders, const double *values)
{
    return none(n);
}
FMI2(int, GetRealOutputDerivatives)(void *m, References at, size_t n, const int *orders, double *values)
{
    return none(n);
}
FMI2(int, DoStep)(void *m, double time, double step, int no_set) { return set_time(m, time + step); }
FMI2(int, CancelStep)(void *m) { return ERROR; }
FMI2(int, GetStatus)(void *m, int kind, int *value) { return DISCARD; }
FMI2(int, GetRealStatus)(void *m, int kind, double *value) { return DISCARD; }
FMI2(int, GetIntegerStatus)(void *m, int kind, int *value) { return DISCARD; }
FMI2(int, GetBooleanStatus)(void *m, int kind, int *value) { return DISCARD; }
FMI2(int, GetStringStatus)(void *m, int kind, const char **value) { return DISCARD; }

/* FMI 3.0 */
FMI3(const char *, GetVersion)(void) { return "3.0"; }
FMI3(int, SetDebugLogging)(void *m, bool on, size_t n, const char *const *categories) { return OK; }
FMI3(void *, InstantiateModelExchange)(const char *name, const char *token, const char *resources, bool visible,
                                       bool logging, void *environment, Log3 log)
{
    return instance(name, token, NULL, log, environment);
}
FMI3(void *, InstantiateCoSimulation)(const char *name, const char *token, const char *resources, bool visible,
                                      bool logging, bool events, bool early, References intermediate, size_t n,
                                      void *environment, Log3 log, void (*update)(void))
{
    return instance(name, token, NULL, log, environment);
}
FMI3(void *, InstantiateScheduledExecution)(const char *name, const char *token, const char *resources, bool visible,
                                            bool logging, void *environment, Log3 log, void (*update)(void),
                                            void (*lock)(void), void (*unlock)(void))
{
    return NULL;
}
FMI3(void, FreeInstance)(void *m) { free(m); }
FMI3(int, EnterInitializationMode)(void *m, bool tolerance_defined, double tolerance, double start, bool stop_defined,
                                   double stop)
{
    return set_time(m, start);
}
FMI3(int, ExitInitializationMode)(void *m) { return OK; }
FMI3(int, EnterEventMode)(void *m) { return OK; }
FMI3(int, Terminate)(void *m) { return OK; }
FMI3(int, Reset)(void *m) { return reset(m); }
FMI3(int, GetFloat64)(void *m, References at, size_t n, double *values, size_t count)
{
    return count == n ? get(m, at, n, values) : ERROR;
}
FMI3(int, SetFloat64)(void *m, References at, size_t n, const double *values, size_t count)
{
    return count == n ? set(m, at, n, values) : ERROR;
}
#define WITHOUT(name, type)                                                                                           \
    FMI3(int, Get##name)(void *m, References at, size_t n, type *values, size_t count) { return none(n); }           \
    FMI3(int, Set##name)(void *m, References at, size_t n, const type *values, size_t count) { return none(n); }
WITHOUT(Float32, float)
WITHOUT(Int8, int8_t)
WITHOUT(UInt8, uint8_t)
WITHOUT(Int16, int16_t)
WITHOUT(UInt16, uint16_t)
WITHOUT(Int32, int32_t)
WITHOUT(UInt32, uint32_t)
WITHOUT(Int64, int64_t)
WITHOUT(UInt64, uint64_t)
WITHOUT(Boolean, bool)
typedef const char *String;
WITHOUT(String, String)
FMI3(int, GetBinary)(void *m, References at, size_t n, size_t *sizes, const uint8_t **values, size_t count)
{
    return none(n);
}
FMI3(int, SetBinary)(void *m, References at, size_t n, const size_t *sizes, const uint8_t *const *values, size_t count)
{
    return none(n);
}
FMI3(int, GetClock)(void *m, References at, size_t n, bool *values) { return none(n); }
FMI3(int, SetClock)(void *m, References at, size_t n, const bool *values) { return none(n); }
FMI3(int, GetNumberOfVariableDependencies)(void *m, uint32_t at, size_t *n) { return ERROR; }
FMI3(int, GetVariableDependencies)(void *m, uint32_t at, size_t *elements, uint32_t *independents,
                                   size_t *independent_elements, int *kinds, size_t n)
{
    return ERROR;
}
FMI3(int, GetFMUState)(void *m, void **state) { return ERROR; }
FMI3(int, SetFMUState)(void *m, void *state) { return ERROR; }
FMI3(int, FreeFMUState)(void *m, void **state) { return ERROR; }
FMI3(int, SerializedFMUStateSize)(void *m, void *state, size_t *size) { return ERROR; }
FMI3(int, SerializeFMUState)(void *m, void *state, uint8_t *bytes, size_t size) { return ERROR; }
FMI3(int, DeserializeFMUState)(void *m, const uint8_t *bytes, size_t size, void **state) { return ERROR; }
FMI3(int, GetDirectionalDerivative)(void *m, References unknowns, size_t n, References knowns, size_t known,
                                    const double *seed, size_t seeds, double *values, size_t count)
{
    return ERROR;
}
FMI3(int, GetAdjointDerivative)(void *m, References unknowns, size_t n, References knowns, size_t known,
                                const double *seed, size_t seeds, double *values, size_t count)
{
    return ERROR;
}
FMI3(int, EnterConfigurationMode)(void *m) { return OK; }
FMI3(int, ExitConfigurationMode)(void *m) { return OK; }
FMI3(int, GetIntervalDecimal)(void *m, References at, size_t n, double *values, int *kinds) { return none(n); }
FMI3(int, GetIntervalFraction)(void *m, References at, size_t n, uint64_t *counters, uint64_t *resolutions, int *kinds)
{
    return none(n);
}
FMI3(int, GetShiftDecimal)(void *m, References at, size_t n, double *values) { return none(n); }
FMI3(int, GetShiftFraction)(void *m, References at, size_t n, uint64_t *counters, uint64_t *resolutions)
{
    return none(n);
}
FMI3(int, SetIntervalDecimal)(void *m, References at, size_t n, const double *values) { return none(n); }
FMI3(int, SetIntervalFraction)(void *m, References at, size_t n, const uint64_t *counters, const uint64_t *resolutions)
{
    return none(n);
}
FMI3(int, SetShiftDecimal)(void *m, References at, size_t n, const double *values) { return none(n); }
FMI3(int, SetShiftFraction)(void *m, References at, size_t n, const uint64_t *counters, const uint64_t *resolutions)
{
    return none(n);
}
FMI3(int, EvaluateDiscreteStates)(void *m) { return OK; }
FMI3(int, UpdateDiscreteStates)(void *m, bool *update, bool *terminate, bool *nominals, bool *values, bool *next_defined,
                                double *next)
{
    *update = *terminate = *nominals = *values = *next_defined = false;
    return OK;
}
FMI3(int, EnterContinuousTimeMode)(void *m) { return OK; }
FMI3(int, CompletedIntegratorStep)(void *m, bool no_set, bool *event_mode, bool *terminate)
{
    *event_mode = *terminate = false;
    return OK;
}
FMI3(int, SetTime)(void *m, double time) { return set_time(m, time); }
FMI3(int, SetContinuousStates)(void *m, const double *states, size_t n) { return none(n); }
FMI3(int, GetContinuousStateDerivatives)(void *m, double *values, size_t n) { return none(n); }
FMI3(int, GetEventIndicators)(void *m, double *values, size_t n) { return none(n); }
FMI3(int, GetContinuousStates)(void *m, double *values, size_t n) { return none(n); }
FMI3(int, GetNominalsOfContinuousStates)(void *m, double *values, size_t n) { return none(n); }
FMI3(int, GetNumberOfEventIndicators)(void *m, size_t *n)
{
    *n = 0;
    return OK;
}
FMI3(int, GetNumberOfContinuousStates)(void *m, size_t *n)
{
    *n = 0;
    return OK;
}
FMI3(int, EnterStepMode)(void *m) { return OK; }
FMI3(int, GetOutputDerivatives)(void *m, References at, size_t n, const int32_t *orders, double *values, size_t count)
{
    return none(n);
}
FMI3(int, DoStep)(void *m, double time, double step, bool no_set, bool *events, bool *terminate, bool *early,
                  double *last)
{
    *events = *terminate = *early = false;
    *last = time + step;
    return set_time(m, time + step);
}
FMI3(int, ActivateModelPartition)(void *m, uint32_t clock, double time) { return ERROR; }
