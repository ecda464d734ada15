/* FMI 3.0 of a machine: model exchange and co-simulation. MIT licence. */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "machine.h"
#include "token.h"

#if defined _WIN32
#define EXPORT __declspec(dllexport)
#elif defined __GNUC__
#define EXPORT __attribute__((visibility("default")))
#else
#define EXPORT
#endif

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } Status;
typedef uint32_t Reference;
typedef void Log(void *environment, Status status, const char *category, const char *message);
typedef enum { INSTANTIATED, INITIALIZATION, EVENT, CONTINUOUS, STEP } Mode;

typedef struct {
    Machine machine;
    Mode mode;
    bool co_simulation, events_used, early_allowed;
    double start;
} State;

typedef struct {
    State state; /* all that a saved state has */
    void *environment;
    Log *log;
} Instance;

/* value references: time, states, rates, parameters, inputs, impact speeds, event indicators, the
   stepper, outputs */
#define CONTINUOUS_STATES (LENGTH + DRIVEN)
enum {
    TIME,
    OF_STATES,
    OF_RATES = OF_STATES + CONTINUOUS_STATES,
    OF_NUMBERS = OF_RATES + CONTINUOUS_STATES,
    OF_SPOTS = OF_NUMBERS + PARAMETERS + INPUTS,
    OF_INDICATORS = OF_SPOTS + SPOTS,
    OF_STEPPER = OF_INDICATORS + SPOTS,
    OF_OUTPUTS = OF_STEPPER + 5,
    END = OF_OUTPUTS + OUTPUTS
};
/* of the stepper */
enum { FIXED_STEP, STEPS, CUTS, HOLDS, WORST };

static Status failed(Instance *i, const char *message)
{
    if (i->log) i->log(i->environment, ERROR, "logStatusError", message);
    return ERROR;
}

static void *instantiated(const char *token, void *environment, Log *log, bool logging)
{
    Instance *i;
    if (token && strcmp(token, TOKEN) != 0) {
        if (log) log(environment, ERROR, "logStatusError", "the token is that of another model");
        return NULL;
    }
    i = calloc(1, sizeof *i);
    if (!i) return NULL;
    i->environment = environment;
    i->log = logging || log ? log : NULL;
    machine_begin(&i->state.machine);
    return i;
}

EXPORT const char *fmi3GetVersion(void)
{
    return "3.0";
}

EXPORT Status fmi3SetDebugLogging(Instance *i, bool on, size_t n, const char *const *categories)
{
    (void)i, (void)on, (void)n, (void)categories;
    return OK;
}

EXPORT void *fmi3InstantiateModelExchange(const char *name, const char *token, const char *path,
                                          bool visible, bool logging, void *environment, Log *log)
{
    (void)name, (void)path, (void)visible;
    return instantiated(token, environment, log, logging);
}

EXPORT void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *path,
                                         bool visible, bool logging, bool events_used,
                                         bool early_allowed, const Reference *required,
                                         size_t count, void *environment, Log *log,
                                         void (*update)(void))
{
    Instance *i = instantiated(token, environment, log, logging);
    (void)name, (void)path, (void)visible, (void)required, (void)count, (void)update;
    if (!i) return NULL;
    i->state.co_simulation = true;
    i->state.events_used = events_used;
    i->state.early_allowed = early_allowed;
    return i;
}

EXPORT void *fmi3InstantiateScheduledExecution(const char *name, const char *token,
                                               const char *path, bool visible, bool logging,
                                               void *environment, Log *log, void (*a)(void),
                                               void (*b)(void), void (*c)(void))
{
    (void)name, (void)token, (void)path, (void)visible, (void)logging, (void)environment;
    (void)log, (void)a, (void)b, (void)c;
    return NULL;
}

EXPORT void fmi3FreeInstance(Instance *i)
{
    free(i);
}

/* --- modes */
EXPORT Status fmi3EnterInitializationMode(Instance *i, bool has_tolerance, double tolerance,
                                          double start, bool has_stop, double stop)
{
    (void)has_stop, (void)stop;
    if (has_tolerance && tolerance > 0.0) i->state.machine.rtol = tolerance;
    i->state.machine.time = i->state.start = start;
    i->state.mode = INITIALIZATION;
    return OK;
}

EXPORT Status fmi3ExitInitializationMode(Instance *i)
{
    Machine *m = &i->state.machine;
    machine_place(m);
    machine_settle(m);
    m->moved = 1;
    i->state.mode = i->state.co_simulation && !i->state.events_used ? STEP : EVENT;
    return OK;
}

EXPORT Status fmi3EnterEventMode(Instance *i)
{
    i->state.mode = EVENT;
    return OK;
}

EXPORT Status fmi3EnterContinuousTimeMode(Instance *i)
{
    i->state.mode = CONTINUOUS;
    return OK;
}

EXPORT Status fmi3EnterStepMode(Instance *i)
{
    i->state.mode = STEP;
    return OK;
}

EXPORT Status fmi3EnterConfigurationMode(Instance *i)
{
    (void)i;
    return OK;
}

EXPORT Status fmi3ExitConfigurationMode(Instance *i)
{
    (void)i;
    return OK;
}

EXPORT Status fmi3Terminate(Instance *i)
{
    (void)i;
    return OK;
}

EXPORT Status fmi3Reset(Instance *i)
{
    machine_begin(&i->state.machine);
    i->state.mode = INSTANTIATED;
    return OK;
}

EXPORT Status fmi3EvaluateDiscreteStates(Instance *i)
{
    (void)i;
    return OK;
}

EXPORT Status fmi3UpdateDiscreteStates(Instance *i, bool *again, bool *terminate,
                                       bool *nominals_changed, bool *states_changed,
                                       bool *has_next, double *next)
{
    Machine *m = &i->state.machine;
    machine_place(m);
    if (!i->state.co_simulation) machine_update(m);
    machine_look_ahead(m);
    *again = *terminate = *nominals_changed = *states_changed = false;
    *has_next = !i->state.co_simulation && isfinite(m->horizon);
    if (*has_next) *next = m->horizon;
    return OK;
}

/* --- values */
static void states_of(const Machine *m, double *values)
{
    memcpy(values, m->y, LENGTH * sizeof(double));
    memcpy(values + LENGTH, m->angle, DRIVEN * sizeof(double));
}

static void rates_of(Machine *m, double *values)
{
    machine_place(m);
    rhs(machine_clock(m), m->y, m->par, m->work, values);
    for (int k = 0; k < DRIVEN; k++) values[LENGTH + k] = m->p[drive_speed[k]];
}

static double of_stepper(const Machine *m, int which)
{
    const double values[] = {m->fixed_step, (double)m->steps, (double)m->cuts, (double)m->holds,
                             m->worst};
    return values[which];
}

EXPORT Status fmi3GetFloat64(Instance *i, const Reference *references, size_t n, double *values,
                             size_t m_values)
{
    Machine *m = &i->state.machine;
    double outputs[ROOM(OUTPUTS)], rates[ROOM(CONTINUOUS_STATES)];
    bool observed = false, rated = false;
    (void)m_values;
    machine_refresh(m);
    for (size_t k = 0; k < n; k++) {
        const int r = (int)references[k];
        if (r >= END) return failed(i, "no variable has this value reference");
        if (r >= OF_OUTPUTS) {
            if (!observed) {
                machine_place(m);
                observe(machine_clock(m), m->y, m->par, m->work, outputs);
            }
            observed = true;
            values[k] = outputs[r - OF_OUTPUTS];
        } else if (r >= OF_STEPPER)
            values[k] = of_stepper(m, r - OF_STEPPER);
        else if (r >= OF_INDICATORS) {
            double z[ROOM(SPOTS)];
            machine_place(m);
            machine_indicators(m, z);
            values[k] = z[r - OF_INDICATORS];
        } else if (r >= OF_SPOTS)
            values[k] = m->work[r - OF_SPOTS];
        else if (r >= OF_NUMBERS)
            values[k] = m->p[r - OF_NUMBERS];
        else if (r >= OF_RATES) {
            if (!rated) rates_of(m, rates);
            rated = true;
            values[k] = rates[r - OF_RATES];
        } else if (r >= OF_STATES + LENGTH)
            values[k] = m->angle[r - OF_STATES - LENGTH];
        else
            values[k] = r == TIME ? m->time : m->y[r - OF_STATES];
    }
    return OK;
}

EXPORT Status fmi3SetFloat64(Instance *i, const Reference *references, size_t n,
                             const double *values, size_t m_values)
{
    Machine *m = &i->state.machine;
    (void)m_values;
    for (size_t k = 0; k < n; k++) {
        const int r = (int)references[k];
        if (!isfinite(values[k])) return failed(i, "a value is not finite");
        if (r >= OF_NUMBERS && r < OF_SPOTS) {
            if (m->p[r - OF_NUMBERS] == values[k]) continue;
            m->p[r - OF_NUMBERS] = values[k];
            m->changed = 1;
            if (r < OF_NUMBERS + PARAMETERS) m->begun = 0;
        } else if (r == OF_STEPPER + FIXED_STEP && values[k] >= 0.0)
            m->fixed_step = values[k];
        else if (r >= OF_STATES + LENGTH && r < OF_RATES) {
            m->angle[r - OF_STATES - LENGTH] = values[k];
            m->moved = 1;
        } else if (r >= OF_STATES && r < OF_STATES + LENGTH) {
            m->y[r - OF_STATES] = values[k];
            m->begun = 0;
        } else
            return failed(i, "a value that nothing can set, or that is out of its range");
    }
    return OK;
}

#define NO_VALUES(kind, type)                                                                    \
    EXPORT Status fmi3Get##kind(Instance *i, const Reference *r, size_t n, type *v, size_t m)    \
    {                                                                                            \
        (void)r, (void)v, (void)m;                                                               \
        return n ? failed(i, "all variables are Float64") : OK;                                  \
    }                                                                                            \
    EXPORT Status fmi3Set##kind(Instance *i, const Reference *r, size_t n, const type *v,        \
                                size_t m)                                                        \
    {                                                                                            \
        (void)r, (void)v, (void)m;                                                               \
        return n ? failed(i, "all variables are Float64") : OK;                                  \
    }

NO_VALUES(Float32, float)
NO_VALUES(Int8, int8_t)
NO_VALUES(UInt8, uint8_t)
NO_VALUES(Int16, int16_t)
NO_VALUES(UInt16, uint16_t)
NO_VALUES(Int32, int32_t)
NO_VALUES(UInt32, uint32_t)
NO_VALUES(Int64, int64_t)
NO_VALUES(UInt64, uint64_t)
NO_VALUES(Boolean, bool)
NO_VALUES(String, char *)

EXPORT Status fmi3GetBinary(Instance *i, const Reference *r, size_t n, size_t *sizes, void *v,
                            size_t m)
{
    (void)r, (void)sizes, (void)v, (void)m;
    return n ? failed(i, "all variables are Float64") : OK;
}

EXPORT Status fmi3SetBinary(Instance *i, const Reference *r, size_t n, const size_t *sizes,
                            const void *v, size_t m)
{
    (void)r, (void)sizes, (void)v, (void)m;
    return n ? failed(i, "all variables are Float64") : OK;
}

/* --- states */
EXPORT Status fmi3GetFMUState(Instance *i, State **saved)
{
    if (!*saved) *saved = malloc(sizeof **saved);
    if (!*saved) return failed(i, "no memory");
    **saved = i->state;
    return OK;
}

EXPORT Status fmi3SetFMUState(Instance *i, const State *saved)
{
    i->state = *saved;
    return OK;
}

EXPORT Status fmi3FreeFMUState(Instance *i, State **saved)
{
    (void)i;
    free(*saved);
    *saved = NULL;
    return OK;
}

EXPORT Status fmi3SerializedFMUStateSize(Instance *i, const State *saved, size_t *size)
{
    (void)i, (void)saved;
    *size = sizeof *saved;
    return OK;
}

EXPORT Status fmi3SerializeFMUState(Instance *i, const State *saved, uint8_t *bytes, size_t size)
{
    if (size < sizeof *saved) return failed(i, "too few bytes for the state");
    memcpy(bytes, saved, sizeof *saved);
    return OK;
}

EXPORT Status fmi3DeserializeFMUState(Instance *i, const uint8_t *bytes, size_t size,
                                      State **saved)
{
    if (size != sizeof **saved) return failed(i, "the bytes are not those of a state");
    if (!*saved) *saved = malloc(sizeof **saved);
    if (!*saved) return failed(i, "no memory");
    memcpy(*saved, bytes, size);
    return OK;
}

/* --- derivatives */
/* the place of a known among dy, -1: none; of an unknown among what `direction` returns */
static int place_of_known(int r)
{
    const int first = OF_NUMBERS + PARAMETERS;
    if (r >= OF_STATES && r < OF_RATES) return r - OF_STATES;
    if (r >= first && r < first + INPUTS) return CONTINUOUS_STATES + input_order[r - first];
    return -1;
}

static bool along(Machine *m, const double *dy, const Reference *unknowns, size_t n,
                  double *slopes)
{
    double out[ROOM(LENGTH + OUTPUTS)];
    direction(machine_clock(m), m->y, m->par, m->work, dy, out);
    for (size_t k = 0; k < n; k++) {
        const int r = (int)unknowns[k], rate = r - OF_RATES;
        if (r >= OF_OUTPUTS && r < END) slopes[k] = out[LENGTH + r - OF_OUTPUTS];
        else if (r >= OF_STATES && r < OF_RATES) slopes[k] = dy[r - OF_STATES];
        else if (r >= OF_RATES && rate < LENGTH) slopes[k] = out[rate];
        else if (r >= OF_RATES && r < OF_NUMBERS)
            slopes[k] = dy[CONTINUOUS_STATES + rate - LENGTH];
        else return false;
    }
    return true;
}

EXPORT Status fmi3GetDirectionalDerivative(Instance *i, const Reference *unknowns, size_t n,
                                           const Reference *knowns, size_t n_knowns,
                                           const double *seed, size_t n_seed, double *slopes,
                                           size_t n_slopes)
{
    double dy[ROOM(CONTINUOUS_STATES + INPUTS)] = {0.0};
    (void)n_seed, (void)n_slopes;
    for (size_t k = 0; k < n_knowns; k++) {
        const int place = place_of_known((int)knowns[k]);
        if (place < 0) return failed(i, "derivatives are by states and inputs");
        dy[place] += seed[k];
    }
    machine_place(&i->state.machine);
    if (along(&i->state.machine, dy, unknowns, n, slopes)) return OK;
    return failed(i, "derivatives are of rates and outputs");
}

EXPORT Status fmi3GetAdjointDerivative(Instance *i, const Reference *unknowns, size_t n,
                                       const Reference *knowns, size_t n_knowns,
                                       const double *seed, size_t n_seed, double *slopes,
                                       size_t n_slopes)
{
    (void)n_seed, (void)n_slopes;
    machine_place(&i->state.machine);
    for (size_t k = 0; k < n_knowns; k++) {
        const int place = place_of_known((int)knowns[k]);
        double dy[ROOM(CONTINUOUS_STATES + INPUTS)] = {0.0};
        if (place < 0) return failed(i, "derivatives are by states and inputs");
        dy[place] = 1.0;
        slopes[k] = 0.0;
        for (size_t u = 0; u < n; u++) {
            double slope;
            if (!along(&i->state.machine, dy, unknowns + u, 1, &slope))
                return failed(i, "derivatives are of rates and outputs");
            slopes[k] += seed[u] * slope;
        }
    }
    return OK;
}

/* --- model exchange */
EXPORT Status fmi3CompletedIntegratorStep(Instance *i, bool final, bool *event, bool *terminate)
{
    (void)final;
    machine_place(&i->state.machine);
    machine_commit(&i->state.machine);
    *event = *terminate = false;
    return OK;
}

EXPORT Status fmi3SetTime(Instance *i, double time)
{
    i->state.machine.time = time;
    return OK;
}

EXPORT Status fmi3SetContinuousStates(Instance *i, const double *states, size_t n)
{
    (void)n;
    memcpy(i->state.machine.y, states, LENGTH * sizeof(double));
    memcpy(i->state.machine.angle, states + LENGTH, DRIVEN * sizeof(double));
    return OK;
}

EXPORT Status fmi3GetContinuousStates(Instance *i, double *states, size_t n)
{
    (void)n;
    states_of(&i->state.machine, states);
    return OK;
}

EXPORT Status fmi3GetContinuousStateDerivatives(Instance *i, double *rates, size_t n)
{
    (void)n;
    rates_of(&i->state.machine, rates);
    for (int k = 0; k < CONTINUOUS_STATES; k++)
        if (!isfinite(rates[k])) return DISCARD;
    return OK;
}

EXPORT Status fmi3GetEventIndicators(Instance *i, double *z, size_t n)
{
    (void)n;
    machine_place(&i->state.machine);
    machine_indicators(&i->state.machine, z);
    return OK;
}

EXPORT Status fmi3GetNominalsOfContinuousStates(Instance *i, double *nominals, size_t n)
{
    (void)n;
    machine_refresh(&i->state.machine);
    memcpy(nominals, i->state.machine.size, STATES * sizeof(double));
    for (int k = STATES; k < LENGTH; k++) nominals[k] = ENERGY;
    for (int k = LENGTH; k < CONTINUOUS_STATES; k++) nominals[k] = 1.0;
    return OK;
}

EXPORT Status fmi3GetNumberOfEventIndicators(Instance *i, size_t *n)
{
    (void)i;
    *n = SPOTS;
    return OK;
}

EXPORT Status fmi3GetNumberOfContinuousStates(Instance *i, size_t *n)
{
    (void)i;
    *n = CONTINUOUS_STATES;
    return OK;
}

/* --- co-simulation */
EXPORT Status fmi3GetOutputDerivatives(Instance *i, const Reference *r, size_t n,
                                       const int32_t *orders, double *values, size_t m)
{
    (void)r, (void)orders, (void)values, (void)m;
    return n ? failed(i, "no derivatives of outputs over time") : OK;
}

EXPORT Status fmi3DoStep(Instance *i, double point, double size, bool final, bool *event,
                         bool *terminate, bool *early, double *last)
{
    static const char *const reasons[] = {
        "", "the step size fell below what the clock resolves",
        "no trial step gives finite numbers",
        "the journal reached the wall and the joint has no contact to carry it"};
    Machine *m = &i->state.machine;
    int ended = 0, code = MADE;
    (void)final;
    *event = *terminate = *early = false;
    if (m->time != point && fabs(m->time - point) > 1e-9 * fabs(size)) {
        m->time = point;
        m->moved = 1;
    }
    if (m->fixed_step > 0.0) machine_advance_fixed(m, point + size);
    else code = machine_advance(m, point + size, i->state.events_used && i->state.early_allowed,
                                &ended);
    *last = m->time;
    *event = *early = ended;
    return code == MADE ? OK : failed(i, reasons[code]);
}

/* --- clocks: there are none */
#define NO_CLOCKS(name, parameters)                                                              \
    EXPORT Status name parameters                                                                \
    {                                                                                            \
        (void)r, (void)a;                                                                        \
        return n ? failed(i, "there are no clocks") : OK;                                        \
    }
#define NO_CLOCKS_2(name, parameters)                                                            \
    EXPORT Status name parameters                                                                \
    {                                                                                            \
        (void)r, (void)a, (void)b;                                                               \
        return n ? failed(i, "there are no clocks") : OK;                                        \
    }

NO_CLOCKS(fmi3GetClock, (Instance *i, const Reference *r, size_t n, bool *a))
NO_CLOCKS(fmi3SetClock, (Instance *i, const Reference *r, size_t n, const bool *a))
NO_CLOCKS_2(fmi3GetIntervalDecimal, (Instance *i, const Reference *r, size_t n, double *a, int *b))
NO_CLOCKS(fmi3GetShiftDecimal, (Instance *i, const Reference *r, size_t n, double *a))
NO_CLOCKS_2(fmi3GetShiftFraction,
            (Instance *i, const Reference *r, size_t n, uint64_t *a, uint64_t *b))
NO_CLOCKS(fmi3SetIntervalDecimal, (Instance *i, const Reference *r, size_t n, const double *a))
NO_CLOCKS_2(fmi3SetIntervalFraction,
            (Instance *i, const Reference *r, size_t n, const uint64_t *a, const uint64_t *b))
NO_CLOCKS(fmi3SetShiftDecimal, (Instance *i, const Reference *r, size_t n, const double *a))
NO_CLOCKS_2(fmi3SetShiftFraction,
            (Instance *i, const Reference *r, size_t n, const uint64_t *a, const uint64_t *b))

EXPORT Status fmi3GetIntervalFraction(Instance *i, const Reference *r, size_t n, uint64_t *a,
                                      uint64_t *b, int *c)
{
    (void)r, (void)a, (void)b, (void)c;
    return n ? failed(i, "there are no clocks") : OK;
}

EXPORT Status fmi3ActivateModelPartition(Instance *i, Reference clock, double time)
{
    (void)clock, (void)time;
    return failed(i, "there are no clocks");
}

EXPORT Status fmi3GetNumberOfVariableDependencies(Instance *i, Reference r, size_t *n)
{
    (void)r, (void)n;
    return failed(i, "dependencies do not change: the model description has them");
}

EXPORT Status fmi3GetVariableDependencies(Instance *i, Reference r, size_t *a, Reference *b,
                                          size_t *c, int *kinds, size_t n)
{
    (void)r, (void)a, (void)b, (void)c, (void)kinds, (void)n;
    return failed(i, "dependencies do not change: the model description has them");
}
