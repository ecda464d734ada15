/* A mechanism: its numbers, its state, and a stepper. All of it is one struct without pointers, so
   a copy of the struct is a copy of the state. MIT licence. */
#ifndef MACHINE_H
#define MACHINE_H

#include "model.h"

#define STAGES 8
#define DENSE 5 /* rows of the dense output */
#define RATES (STATES - COORDINATES)
#define EVENTS (SPOT_VALUES * SPOTS)
#define DEPTH(values, j) (values)[SPOT_VALUES * (j)]
#define CLOSING(values, j) (values)[SPOT_VALUES * (j) + 1]
#define FREE (-1.0) /* in place of an impact speed */
#define BEFORE 1e-15 /* share of the time of a kink by which a moment lies before it */

enum { MADE, TOO_SMALL, NOT_FINITE, FILM_LEFT };

typedef struct {
    double time, rtol, fixed_step;
    double p[ROOM(PARAMETERS + INPUTS)]; /* parameters, then inputs */
    double par[ROOM(NUMBERS)];
    double y[ROOM(LENGTH)];
    double work[ROOM(WORK)]; /* impact speeds, then what steps carry on */
    double angle[ROOM(DRIVEN)], origin[ROOM(DRIVEN)]; /* of drives; where lines over time start */
    double size[ROOM(STATES)], reach[ROOM(SPOTS)], typical[ROOM(SPOTS)], kink[ROOM(KINKS)];
    double horizon;        /* next kink of a law of time, behind which kernels do not look */
    int side[ROOM(SPOTS)]; /* 1: beyond the threshold */
    int changed;           /* numbers have changed since they were last derived */
    int moved;             /* angles or speeds of drives have */

    /* of the stepper */
    double scale[ROOM(LENGTH)], usual[ROOM(STATES)], damping[ROOM(SPOTS)];
    double f[ROOM(LENGTH)], y_new[ROOM(LENGTH)], f_new[ROOM(LENGTH)], trial[ROOM(LENGTH)];
    double dense[DENSE][ROOM(LENGTH)], stage[STAGES][ROOM(LENGTH)], slope[ROOM(LENGTH)];
    double rate_of_time[ROOM(LENGTH)], vector[ROOM(STATES *STATES)];
    double lu[ROOM(RATES)][ROOM(RATES)];
    int pivots[ROOM(RATES)];
    double before[ROOM(EVENTS)], after[ROOM(EVENTS)], inside[ROOM(EVENTS)];
    double probed[ROOM(EVENTS)], ahead[ROOM(EVENTS)];
    double step, last_step, error, last_error, contact_step, free_step, made;
    int begun, fresh_jacobian, refusals, refused, met, flips;
    long steps, rejected, cuts, holds;
    double worst; /* of the steps of the fixed variant: error over tolerance */
} Machine;

void machine_begin(Machine *m);             /* the scene's own numbers and start */
void machine_refresh(Machine *m);           /* derive what follows from changed numbers */
void machine_settle(Machine *m);            /* which spots touch where a run starts */
void machine_place(Machine *m);             /* have drives stand at `angle` */
void machine_depart(Machine *m);            /* have them turn from there on as time passes */
void machine_arrive(Machine *m);            /* `angle` at the time that was reached */
double machine_clock(const Machine *m);     /* time as kernels take it */
double dead_band(const Machine *m, int j);   /* of a spot, wider for a kink of wound-up coordinates */
void machine_indicators(const Machine *m, double *z);
int machine_update(Machine *m);             /* begin and end contacts; 1: there was one */
void machine_commit(Machine *m);            /* what a finished step carries on */
void machine_look_ahead(Machine *m);        /* for the next kink of a law of time, from here on */

/* up to a time; ends early where a contact begins or ends, if asked to: *early is 1 then */
int machine_advance(Machine *m, double until, int stop_at_events, int *early);
/* the same in steps of `fixed_step`, which never fails */
void machine_advance_fixed(Machine *m, double until);

#endif
