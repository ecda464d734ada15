/* Numbers, contacts and start of a mechanism. MIT licence. */
#include <math.h>
#include <string.h>
#include "machine.h"

#define WARNING 1e-3 /* of the clearance: film left at which a film's indicator crosses zero */

void machine_begin(Machine *m)
{
    memset(m, 0, sizeof *m);
    m->rtol = 1e-8;
    memcpy(m->p, number_start, (PARAMETERS + INPUTS) * sizeof(double));
    memcpy(m->y, state_start, LENGTH * sizeof(double));
    memcpy(m->work, work_start, WORK * sizeof(double));
    m->changed = 1;
    machine_refresh(m);
    machine_look_ahead(m);
    for (int k = 0; k < DRIVEN; k++) m->angle[k] = m->par[drive_start[k]];
    machine_place(m);
}

void machine_refresh(Machine *m)
{
    if (!m->changed) return;
    numbers(m->p, m->par, m->size, m->reach, m->typical, m->kink);
    for (int j = 0; j < SPOTS; j++)
        if (spot_kind[j] == BLENDED) m->work[j] = m->typical[j];
    derive(m->par);
    m->changed = 0;
    m->moved = 1;
}

double machine_clock(const Machine *m)
{
    if (!NEEDS_CLOCK) return 0.0;
    return m->time < m->horizon ? m->time : m->horizon * (1.0 - BEFORE);
}

void machine_look_ahead(Machine *m)
{
    m->horizon = INFINITY;
    for (int i = 0; i < KINKS; i++)
        if (m->kink[i] * (1.0 - BEFORE) > m->time && m->kink[i] < m->horizon)
            m->horizon = m->kink[i];
}

static void stand(Machine *m, const double *start)
{
    for (int k = 0; k < DRIVEN; k++) m->par[drive_start[k]] = start[k];
    if (START_DERIVED) derive(m->par);
}

void machine_place(Machine *m)
{
    double start[ROOM(DRIVEN)], time = machine_clock(m);
    machine_refresh(m);
    for (int k = 0; k < DRIVEN; k++) start[k] = m->angle[k] - m->p[drive_speed[k]] * time;
    stand(m, start);
}

void machine_depart(Machine *m)
{
    machine_refresh(m);
    for (int k = 0; k < DRIVEN && m->moved; k++)
        m->origin[k] = m->angle[k] - m->p[drive_speed[k]] * m->time;
    m->fresh_jacobian = m->fresh_jacobian && !m->moved;
    m->moved = 0;
    stand(m, m->origin);
}

void machine_arrive(Machine *m)
{
    for (int k = 0; k < DRIVEN; k++)
        m->angle[k] = m->origin[k] + m->p[drive_speed[k]] * m->time;
}

static double beyond(const Machine *m, const double *values, int j)
{
    return DEPTH(values, j) + (spot_kind[j] == FILM ? WARNING * m->reach[j] : 0.0);
}

void machine_settle(Machine *m)
{
    double values[ROOM(EVENTS)];
    for (int j = 0; j < SPOTS; j++)
        if (spot_kind[j] == CONTACT) m->work[j] = FREE;
    if (SPOTS) events(machine_clock(m), m->y, m->par, m->work, values);
    for (int j = 0; j < SPOTS; j++) {
        m->side[j] = beyond(m, values, j) > 0.0;
        if (m->side[j] && spot_kind[j] == CONTACT) m->work[j] = fmax(CLOSING(values, j), 0.0);
    }
}

double dead_band(const Machine *m, int j)
{
    double wound = 1.0;
    for (int i = 0; i < COORDINATES && spot_kind[j] != CONTACT; i++)
        wound = fmax(wound, fabs(m->y[i]) / (WOUND * m->size[i]));
    return spot_band[j] * wound;
}

void machine_indicators(const Machine *m, double *z)
{
    double values[ROOM(EVENTS)];
    if (SPOTS) events(machine_clock(m), m->y, m->par, m->work, values);
    for (int j = 0; j < SPOTS; j++)
        z[j] = beyond(m, values, j) + (m->side[j] ? dead_band(m, j) : -dead_band(m, j));
}

int machine_update(Machine *m)
{
    double values[ROOM(EVENTS)];
    int changes = 0;
    /* the rates are those before the contact: nothing of it has begun */
    if (SPOTS) events(machine_clock(m), m->y, m->par, m->work, values);
    for (int j = 0; j < SPOTS; j++) {
        double depth = beyond(m, values, j), rate = CLOSING(values, j), band = dead_band(m, j);
        int begins = !m->side[j] && (depth > band || (depth >= -band && rate > 0.0));
        int ends = m->side[j] && (depth < -band || (depth <= band && rate < 0.0));
        if (!begins && !ends) continue;
        m->side[j] = begins;
        changes = 1;
        if (spot_kind[j] == CONTACT) m->work[j] = begins ? fmax(rate, 0.0) : FREE;
    }
    return changes;
}

void machine_commit(Machine *m)
{
    double carried[ROOM(COMMITS)];
    if (!COMMITS) return;
    commit(machine_clock(m), m->y, m->par, m->work, carried);
    memcpy(m->work + SPOTS, carried, COMMITS * sizeof(double));
}
