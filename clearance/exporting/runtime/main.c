/* Prints a run as CSV: main [end in s] [rows]. MIT licence. */
#include <stdio.h>
#include <stdlib.h>
#include "machine.h"

static Machine machine;

static void print_row(Machine *m)
{
    double out[ROOM(OUTPUTS)];
    machine_place(m);
    observe(machine_clock(m), m->y, m->par, m->work, out);
    printf("%.17g", m->time);
    for (int i = 0; i < OUTPUTS; i++) printf(",%.17g", out[i]);
    printf("\n");
}

int main(int count, char **words)
{
    const double end = count > 1 ? atof(words[1]) : TURN > 0.0 ? 2.0 * TURN : 1.0;
    const int rows = count > 2 ? atoi(words[2]) : 201;
    int early, code;
    machine_begin(&machine);
    machine_settle(&machine);
    printf("time");
    for (int i = 0; i < OUTPUTS; i++) printf(",%s", output_names[i]);
    printf("\n");
    print_row(&machine);
    for (int i = 1; i < rows; i++) {
        code = machine_advance(&machine, end * i / (rows - 1), 0, &early);
        if (code != MADE) {
            fprintf(stderr, "%s: the run ends at %.9g s, code %d\n", model_name, machine.time, code);
            return 1;
        }
        print_row(&machine);
    }
    return 0;
}
