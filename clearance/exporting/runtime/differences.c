/* Derivatives along a direction where friction of coupled joints is solved for by iteration: those
   of states by states from the Jacobian, all others by central differences. MIT licence. */
#include <math.h>
#include <string.h>
#include "model.h"

#define WIDTH 6e-6 /* of a difference, over natural sizes */
#define ALL (LENGTH + DRIVEN + INPUTS)

static void values_at(double t, const double *y, const double *par, const double *work,
                      const double *dy, double along, double *out)
{
    double moved[ROOM(LENGTH)], numbers_there[ROOM(NUMBERS)];
    for (int i = 0; i < LENGTH; i++) moved[i] = y[i] + along * dy[i];
    memcpy(numbers_there, par, NUMBERS * sizeof(double));
    for (int k = 0; k < DRIVEN; k++) {
        double faster = dy[LENGTH + DRIVEN + k];
        numbers_there[drive_start[k]] += along * (dy[LENGTH + k] - t * faster);
    }
    for (int k = 0; k < INPUTS; k++)
        numbers_there[input_place[k]] += along * dy[LENGTH + DRIVEN + k];
    derive(numbers_there);
    rhs(t, moved, numbers_there, work, out);
    observe(t, moved, numbers_there, work, out + LENGTH);
}

void direction(double t, const double *y, const double *par, const double *work, const double *dy,
               double *out)
{
    double before[ROOM(LENGTH + OUTPUTS)], after[ROOM(LENGTH + OUTPUTS)], h, most = 0.0;
    double vector[ROOM(STATES *STATES)], rest[ROOM(ALL)];
    memcpy(rest, dy, ALL * sizeof(double));
    for (int i = 0; i < ALL; i++) most = fmax(most, fabs(dy[i]) / direction_size[i]);
    for (int i = 0; i < LENGTH + OUTPUTS; i++) out[i] = 0.0;
    if (most == 0.0) return;
    h = WIDTH / most;
    values_at(t, y, par, work, dy, h, after);
    values_at(t, y, par, work, dy, -h, before);
    for (int i = 0; i < LENGTH + OUTPUTS; i++) out[i] = 0.5 * (after[i] - before[i]) / h;
    for (int i = 0; i < STATES; i++) rest[i] = 0.0;
    for (int i = 0; i < ALL; i++)
        if (rest[i] != 0.0) return; /* inputs and angles move, too */
    jacobian(t, y, par, work, vector);
    for (int i = 0; i < STATES; i++) {
        out[i] = 0.0;
        for (int j = 0; j < STATES; j++) out[i] += vector[i * STATES + j] * dy[j];
    }
}
