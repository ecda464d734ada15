/* What a page calls: numbers, a start, and outputs at a time. MIT licence. */
#include <string.h>
#include "machine.h"

#define CALLED(name) __attribute__((export_name(#name))) name

static Machine machine;
static double values[ROOM(OUTPUTS)];

double *CALLED(numbers_at)(void)
{
    return machine.p;
}

double *CALLED(values_at)(void)
{
    return values;
}

void CALLED(reset)(void)
{
    machine_begin(&machine);
}

/* start with the numbers that were put in */
void CALLED(begin)(void)
{
    machine.changed = 1;
    machine_place(&machine);
    machine_settle(&machine);
    machine.moved = 1;
}

/* outputs at a time; 0 unless the run has failed */
int CALLED(go)(double time)
{
    int early, code = machine_advance(&machine, time, 0, &early);
    machine_place(&machine);
    observe(machine_clock(&machine), machine.y, machine.par, machine.work, values);
    return code;
}
