/* Rodas5P, a linearly implicit method of order 5, with the step control, the bounds by the films
   left and the located contacts of clearance. Nothing is allocated.

   Source: G. Steinebach, Construction of Rosenbrock-Wanner method Rodas5P, BIT Numer. Math. 63, 27
   (2023). MIT licence. */
#include <math.h>
#include <string.h>
#include "machine.h"

#define PROBES 8
#define ALIGNMENTS 60
#define SHORTEST 1e-15 /* share of the time below which two events are one */
#define SETTLED 0.1
#define HALVINGS 6 /* of a step of the fixed variant, at most */

enum { NO_EVENT, CUT, AT_START, MISSED };

/* --- one step */
static void factorise(Machine *m, double g)
{
    for (int i = 0; i < RATES; i++) {
        const double *row = m->vector + (COORDINATES + i) * STATES;
        for (int j = 0; j < RATES; j++) m->lu[i][j] = -row[COORDINATES + j];
        for (int j = 0; j < COORDINATES; j++) m->lu[i][j] -= row[j] / g;
        m->lu[i][i] += g;
    }
    for (int k = 0; k < RATES; k++) {
        int best = k;
        for (int i = k + 1; i < RATES; i++)
            if (fabs(m->lu[i][k]) > fabs(m->lu[best][k])) best = i;
        m->pivots[k] = best;
        for (int j = 0; j < RATES && best != k; j++) {
            double kept = m->lu[k][j];
            m->lu[k][j] = m->lu[best][j];
            m->lu[best][j] = kept;
        }
        m->lu[k][k] = 1.0 / m->lu[k][k];
        for (int i = k + 1; i < RATES; i++) {
            m->lu[i][k] *= m->lu[k][k];
            for (int j = k + 1; j < RATES; j++) m->lu[i][j] -= m->lu[i][k] * m->lu[k][j];
        }
    }
}

/* right becomes x with (g - J) x = right */
static void solve(Machine *m, double *right, double g)
{
    double *b = m->slope;
    for (int i = 0; i < RATES; i++) {
        const double *row = m->vector + (COORDINATES + i) * STATES;
        b[i] = right[COORDINATES + i];
        for (int j = 0; j < COORDINATES; j++) b[i] += row[j] * right[j] / g;
    }
    for (int k = 0; k < RATES; k++) {
        double kept = b[k];
        b[k] = b[m->pivots[k]];
        b[m->pivots[k]] = kept;
    }
    for (int i = 1; i < RATES; i++)
        for (int j = 0; j < i; j++) b[i] -= m->lu[i][j] * b[j];
    for (int i = RATES - 1; i >= 0; i--) {
        for (int j = i + 1; j < RATES; j++) b[i] -= m->lu[i][j] * b[j];
        b[i] *= m->lu[i][i];
    }
    for (int i = 0; i < RATES; i++) right[COORDINATES + i] = b[i];
    for (int i = 0; i < COORDINATES; i++) right[i] = (right[i] + right[COORDINATES + i]) / g;
}

static void evaluate(Machine *m, double theta)
{
    for (int i = 0; i < LENGTH; i++) {
        double value = 0.0;
        for (int r = DENSE - 1; r > 0; r--) {
            value += m->dense[r][i];
            value *= r % 2 ? theta : 1.0 - theta;
        }
        m->trial[i] = m->dense[0][i] + value;
    }
}

static void take_dense(Machine *m)
{
    for (int i = 0; i < LENGTH; i++) {
        double sum[3] = {0.0, 0.0, 0.0};
        for (int r = 0; r < 3 && i < STATES; r++)
            for (int j = 0; j < STAGES; j++) sum[r] += rodas_h[r * STAGES + j] * m->stage[j][i];
        m->dense[0][i] = m->y[i];
        m->dense[1][i] = i < STATES ? m->y_new[i] - m->y[i] : 0.0;
        m->dense[2][i] = sum[0];
        m->dense[3][i] = sum[1] + sum[2];
        m->dense[4][i] = -sum[2];
    }
}

/* integrals of energies, from powers at three places of the dense output */
static void add_energies(Machine *m, double t, double h)
{
    for (int s = 0; s < 3; s++) {
        evaluate(m, ledger_c[s]);
        rhs(t + ledger_c[s] * h, m->trial, m->par, m->work, m->stage[s]);
    }
    for (int i = STATES; i < LENGTH; i++) {
        double total[3] = {0.0, 0.0, 0.0};
        for (int s = 0; s < 3; s++)
            for (int j = 0; j < 3; j++) total[s] += ledger_a[3 * s + j] * m->stage[j][i];
        for (int r = 0; r < 3; r++)
            for (int s = 0; s < 3; s++)
                m->dense[1 + r][i] += ledger_basis[3 * r + s] * h * total[s];
        m->y_new[i] = m->y[i] + m->dense[1][i];
    }
}

/* from y with f = y' to y_new with f_new: MADE with an error over the tolerance, or NOT_FINITE */
static int attempt(Machine *m, double t, double h)
{
    const double g = 1.0 / (RODAS_GAMMA * h), later = DIFFERENCE * h;
    double total = 0.0;
    if (!m->fresh_jacobian) {
        jacobian(t, m->y, m->par, m->work, m->vector);
        m->fresh_jacobian = 1;
    }
    rhs(t + later, m->y, m->par, m->work, m->rate_of_time);
    for (int i = 0; i < STATES; i++)
        m->rate_of_time[i] = (m->rate_of_time[i] - m->f[i]) / later;
    factorise(m, g);
    memcpy(m->trial, m->y, sizeof m->trial);
    for (int s = 0; s < STAGES; s++) {
        double rate[ROOM(LENGTH)];
        for (int i = 0; i < STATES && s; i++) {
            m->trial[i] = m->y[i];
            for (int j = 0; j < s; j++) m->trial[i] += rodas_a[s * STAGES + j] * m->stage[j][i];
        }
        if (s) rhs(t + rodas_nodes[s] * h, m->trial, m->par, m->work, rate);
        else memcpy(rate, m->f, sizeof rate);
        for (int i = 0; i < STATES; i++) {
            double sum = 0.0;
            for (int j = 0; j < s; j++) sum += rodas_c[s * STAGES + j] * m->stage[j][i];
            m->stage[s][i] = rate[i] + sum / h + h * rodas_d[s] * m->rate_of_time[i];
        }
        solve(m, m->stage[s], g);
    }
    memcpy(m->y_new, m->y, sizeof m->y_new);
    for (int i = 0; i < STATES; i++) {
        double off = m->stage[STAGES - 1][i], weight;
        m->y_new[i] = m->trial[i] + off;
        weight = m->scale[i] + fmax(fabs(m->y[i]), fabs(m->y_new[i]));
        total += off / (m->rtol * weight) * (off / (m->rtol * weight));
    }
    m->error = sqrt(total / ROOM(STATES));
    if (!isfinite(m->error)) return NOT_FINITE;
    if (m->error > 1.0 && m->fixed_step == 0.0) return MADE;
    take_dense(m);
    if (LENGTH > STATES) add_energies(m, t, h);
    rhs(t + h, m->y_new, m->par, m->work, m->f_new);
    for (int i = 0; i < LENGTH; i++)
        if (!isfinite(m->y_new[i]) || !isfinite(m->f_new[i])) return NOT_FINITE;
    return MADE;
}

/* --- natural sizes */
static double larger(double a, double b) { return a > b ? a : b; }
static double smaller(double a, double b) { return a < b ? a : b; }

static int is_film(int j) { return spot_kind[j] == FILM && spot_place[j] >= 0; }

/* the rate at which a film gives way to the accelerations of the mechanism */
static void take_sizes(Machine *m)
{
    double rest[ROOM(LENGTH)], before[ROOM(LENGTH)], after[ROOM(LENGTH)];
    memcpy(rest, m->y, sizeof rest);
    for (int i = 0; i < STATES; i++) m->scale[i] = m->size[i];
    for (int i = STATES; i < LENGTH; i++) m->scale[i] = ENERGY;
    for (int j = 0; j < SPOTS; j++)
        for (int k = 0; spot_place[j] >= 0 && k < spot_places[j]; k++) {
            rest[spot_place[j] + k] = 0.0;
            rest[COORDINATES + spot_place[j] + k] = 0.0;
        }
    rhs(m->time, rest, m->par, m->work, before);
    for (int j = 0; j < SPOTS; j++)
        for (int k = 0; spot_place[j] >= 0 && k < spot_places[j]; k++) {
            int i = COORDINATES + spot_place[j] + k;
            double share = m->size[i] / m->size[COORDINATES + spot_place[j]], damping;
            rest[i] = m->size[i];
            rhs(m->time, rest, m->par, m->work, after);
            rest[i] = 0.0;
            damping = fabs(after[i] - before[i]) / m->size[i];
            if (damping * m->size[i] > ACCELERATION * share)
                m->scale[i] = ACCELERATION * share / damping;
        }
    memcpy(m->usual, m->scale, STATES * sizeof(double));
    memset(m->damping, 0, sizeof m->damping);
}

/* errors stay below a part of the film left, and of the rate at which it gives way */
static void weigh_films(Machine *m, const double *values)
{
    for (int j = 0; j < SPOTS; j++) {
        double gap = larger(-DEPTH(values, j), 1e-15 * m->reach[j]);
        if (!is_film(j)) continue;
        m->damping[j] *= FORGET;
        for (int k = 0; k < spot_places[j]; k++) {
            int i = spot_place[j] + k, rate = COORDINATES + i;
            double size = fabs(m->y[i]);
            m->scale[i] = smaller(m->usual[i] + size, FILM_ERROR * gap / m->rtol) - size;
            m->damping[j] = larger(m->damping[j], fabs(m->vector[rate * STATES + rate]));
        }
        for (int k = 0; k < spot_places[j]; k++) {
            int rate = COORDINATES + spot_place[j] + k;
            double size = fabs(m->y[rate]);
            double bound = FILM_ERROR * ACCELERATION / (larger(m->damping[j], 1e-300) * m->rtol);
            bound = larger(bound, RESOLVED * size / m->rtol);
            m->scale[rate] = smaller(m->usual[rate] + size, bound) - size;
        }
    }
}

/* Hairer, Norsett, Wanner 1993, section II.4 */
static double first_step(Machine *m, double longest)
{
    double size = 0.0, rate = 0.0, bend = 0.0, h = longest, most;
    for (int i = 0; i < STATES; i++) {
        double weight = m->rtol * (m->scale[i] + fabs(m->y[i]));
        size += m->scale[i] / weight * (m->scale[i] / weight);
        rate += m->f[i] / weight * (m->f[i] / weight);
    }
    if (rate > 0.0) h = smaller(h, 0.01 * sqrt(size / rate));
    for (int i = 0; i < LENGTH; i++) m->trial[i] = m->y[i] + h * m->f[i];
    rhs(m->time + h, m->trial, m->par, m->work, m->f_new);
    for (int i = 0; i < STATES; i++) {
        double part = (m->f_new[i] - m->f[i]) / (m->rtol * (m->scale[i] + fabs(m->y[i])));
        bend += part * part;
    }
    most = larger(sqrt(rate / ROOM(STATES)), sqrt(bend / ROOM(STATES)) / h);
    if (most > 0.0 && isfinite(most))
        return smaller(smaller(100.0 * h, pow(0.01 / most, 1.0 / 6.0)), longest);
    return 1e-3 * h;
}

static double resolution(const Machine *m, double until)
{
    return SMALLEST * larger(fabs(m->time), EARLIEST * until);
}

/* --- contacts inside a step */
static double wanted(const Machine *m, int j)
{
    double depth = DEPTH(m->before, j), band = dead_band(m, j);
    int within = depth > band || (depth >= -band && CLOSING(m->before, j) > 0.0);
    return (spot_kind[j] == CONTACT ? m->side[j] : within) ? -1.0 : 1.0;
}

static void probe(Machine *m, double t, double h, double theta)
{
    evaluate(m, theta);
    events(t + theta * h, m->trial, m->par, m->work, m->inside);
}

static int near_contact(const Machine *m, double h)
{
    for (int j = 0; j < SPOTS; j++) {
        double sign = wanted(m, j), before = CLOSING(m->before, j), after = CLOSING(m->after, j);
        double deepest = larger(sign * DEPTH(m->before, j), sign * DEPTH(m->after, j));
        int turns = sign * before > 0.0 && sign * after < 0.0;
        if (spot_kind[j] == FILM) continue;
        if (spot_kind[j] == CONTACT || turns) deepest += h * larger(fabs(before), fabs(after));
        if (deepest > dead_band(m, j)) return 1;
    }
    return 0;
}

static double summit(Machine *m, double t, double h, int j, double low, double high)
{
    for (int k = 0; k < 50; k++) {
        double middle = 0.5 * (low + high);
        probe(m, t, h, middle);
        if (CLOSING(m->inside, j) * wanted(m, j) > 0.0) low = middle;
        else high = middle;
    }
    return 0.5 * (low + high);
}

/* by the Illinois method; intervals that begin with no depth are halved */
static double crossing(Machine *m, double t, double h, int j, double low, double high,
                       double at_low, double at_high)
{
    double sign = wanted(m, j), side = 0.0, band = dead_band(m, j);
    for (int k = 0; k < 60 && high - low >= 1e-15; k++) {
        double theta = 0.5 * (low + high), value;
        if (at_low < -band)
            theta = (low * at_high - high * at_low) / (at_high - at_low);
        probe(m, t, h, theta);
        value = DEPTH(m->inside, j) * sign;
        if (fabs(value) < SETTLED * band) return theta;
        if (value > 0.0) {
            high = theta, at_high = value;
            if (side > 0.0) at_low *= 0.5;
        } else {
            low = theta, at_low = value;
            if (side < 0.0) at_high *= 0.5;
        }
        side = value;
    }
    return high;
}

static double event_of(Machine *m, double t, double h, int j, double low, double high)
{
    double sign = wanted(m, j), value = DEPTH(m->ahead, j) * sign, end = high;
    if (value <= dead_band(m, j) && CLOSING(m->probed, j) * sign > 0.0
        && CLOSING(m->ahead, j) * sign < 0.0) {
        end = summit(m, t, h, j, low, high);
        probe(m, t, h, end);
        value = DEPTH(m->inside, j) * sign;
    }
    if (value <= dead_band(m, j)) return 2.0;
    return crossing(m, t, h, j, low, end, DEPTH(m->probed, j) * sign, value);
}

static int first_event(Machine *m, double t, double h, double *theta)
{
    memcpy(m->probed, m->before, sizeof m->probed);
    for (int p = 0; p < PROBES; p++) {
        int best = -1;
        probe(m, t, h, (p + 1.0) / PROBES);
        memcpy(m->ahead, m->inside, sizeof m->ahead);
        *theta = 2.0;
        for (int j = 0; j < SPOTS; j++) {
            double place = 2.0;
            if (spot_kind[j] != FILM)
                place = event_of(m, t, h, j, (double)p / PROBES, (p + 1.0) / PROBES);
            if (place < *theta) best = j, *theta = place;
        }
        if (best >= 0) return best;
        memcpy(m->probed, m->ahead, sizeof m->probed);
    }
    return -1;
}

/* the step made again so that it ends on the event: Newton's method on the penetration at its end,
   or bisection where that leaves the bracket */
static int aligned(Machine *m, double t, double h, int j, double theta, int *reached)
{
    double sign = wanted(m, j), size = theta * h, low = 0.0, high = h, last = 0.0, value = 0.0;
    int passed = 0;
    *reached = 1;
    for (int k = 0; k < ALIGNMENTS; k++) {
        double rate, shift;
        m->made = size;
        if (size <= SHORTEST * larger(fabs(t), h)) return AT_START;
        if (attempt(m, t, size) != MADE || m->error > 1.0) return MISSED;
        last = size;
        events(t + size, m->y_new, m->par, m->work, m->after);
        value = sign * DEPTH(m->after, j), rate = sign * CLOSING(m->after, j);
        if (fabs(value) <= 1e-2 * dead_band(m, j)) return CUT;
        if (value > 0.0) high = size, passed = 1;
        else low = size;
        shift = rate > 0.0 ? -value / rate : INFINITY;
        if (fabs(shift) < smaller(1e-6, 1e-3 * m->rtol) * size) {
            for (int i = 0; i < LENGTH; i++) m->y_new[i] += shift * m->f_new[i];
            rhs(t + size, m->y_new, m->par, m->work, m->f_new);
            events(t + size, m->y_new, m->par, m->work, m->after);
            m->made = size + shift;
            return CUT;
        }
        if (!(low < size + shift && size + shift < high)) {
            if (!passed || high - low <= SHORTEST * larger(fabs(t), h)) {
                *reached = value > 0.0;
                return CUT;
            }
            shift = 0.5 * (low + high) - size;
        }
        size += shift;
    }
    m->made = last;
    *reached = value > 0.0;
    return CUT;
}

static int meet(Machine *m, double t, double h)
{
    double theta;
    int j, outcome, reached, touches;
    m->met = -1;
    if (!near_contact(m, h)) return NO_EVENT;
    j = first_event(m, t, h, &theta);
    touches = j >= 0 && spot_kind[j] == CONTACT;
    if (j < 0 || (!touches && theta * h <= SHORTEST * larger(fabs(t), h))) return NO_EVENT;
    outcome = aligned(m, t, h, j, theta, &reached);
    if (reached && touches) m->met = j;
    if (outcome == AT_START && !touches) {
        m->made = theta * h;
        return MISSED;
    }
    return outcome;
}

static void turn_over(Machine *m, int j)
{
    m->side[j] = !m->side[j];
    m->work[j] = m->side[j] ? larger(CLOSING(m->after, j), 0.0) : FREE;
}

static void swap(Machine *m)
{
    turn_over(m, m->met);
    for (int j = 0; j < SPOTS; j++) {
        double rate = CLOSING(m->after, j);
        int here = spot_kind[j] == CONTACT && fabs(DEPTH(m->after, j)) <= dead_band(m, j);
        if (j != m->met && here && (m->side[j] ? rate < 0.0 : rate > 0.0)) turn_over(m, j);
    }
}

/* --- the loop */
static int in_contact(const Machine *m)
{
    for (int j = 0; j < SPOTS; j++)
        if (spot_kind[j] == CONTACT && m->side[j]) return 1;
    return 0;
}

static void begin_phase(Machine *m, double until)
{
    double last = in_contact(m) ? m->contact_step : m->free_step, least = resolution(m, until);
    rhs(m->time, m->y, m->par, m->work, m->f);
    m->fresh_jacobian = 0;
    m->step = last > least ? last : larger(first_step(m, until - m->time), CLEARLY * least);
    m->last_step = 0.0;
}

static void begin(Machine *m, double until)
{
    if (SPOTS) events(m->time, m->y, m->par, m->work, m->before);
    take_sizes(m);
    jacobian(m->time, m->y, m->par, m->work, m->vector);
    weigh_films(m, m->before);
    m->contact_step = m->free_step = 0.0;
    m->refused = m->refusals = 0;
    begin_phase(m, until);
    m->begun = 1;
}

static void refuse(Machine *m, double h, double share)
{
    m->rejected++;
    m->refusals++;
    m->refused = 1;
    m->step = h * share;
}

static int outside(const Machine *m)
{
    for (int j = 0; j < SPOTS; j++)
        if (spot_kind[j] == FILM && DEPTH(m->after, j) >= SQUEEZE * DEPTH(m->before, j)) return 1;
    return 0;
}

static void accept(Machine *m, double t, double h, double until)
{
    m->time = h >= until - t || t + h >= until ? until : t + h;
    memcpy(m->y, m->y_new, sizeof m->y);
    memcpy(m->f, m->f_new, sizeof m->f);
    weigh_films(m, m->after);
    m->fresh_jacobian = 0;
    m->steps++;
    m->flips = 0;
    if (COMMITS) {
        double carried[ROOM(COMMITS)];
        commit(m->time, m->y, m->par, m->work, carried);
        memcpy(m->work + SPOTS, carried, COMMITS * sizeof(double));
    }
}

static void grow(Machine *m, double h, double until)
{
    double error = larger(m->error, 1e-10), value = SAFETY * pow(error, -0.2);
    if (m->last_step > 0.0) {
        double grown = m->last_error / (error * error);
        value = smaller(value, SAFETY * h / m->last_step * pow(grown, 0.2));
    }
    value = smaller(GROW, larger(SHRINK, value));
    if (m->refused) value = smaller(value, 1.0);
    m->step = larger(value >= 1.0 && value <= 1.2 ? h : h * value, CLEARLY * resolution(m, until));
    m->refused = m->refusals = 0;
    m->last_step = h;
    m->last_error = larger(error, 1e-2);
}

/* after an error that is too large; where a contact ends inside the step, about there */
static double reduction(Machine *m, double t, double h)
{
    double share = larger(SHRINK, SAFETY * pow(m->error, m->refusals ? -DOUBTED : -0.2));
    if (!in_contact(m)) return share;
    events(t, m->y, m->par, m->work, m->before);
    events(t + h, m->y_new, m->par, m->work, m->after);
    for (int j = 0; j < SPOTS; j++) {
        double before = DEPTH(m->before, j), after = DEPTH(m->after, j);
        if (m->side[j] && after < 0.0 && before > 0.0)
            share = smaller(larger(share, NEARLY * before / (before - after)), NEARLY);
    }
    return share;
}

/* up to a time that lies before the next kink */
static int advance(Machine *m, double until, int stop_at_events, int *early)
{
    while (m->time < until) {
        double t = m->time, left = until - t, h = smaller(m->step, left), proposal;
        int code, met = NO_EVENT, trimmed = h < m->step;
        if (h < left && 1.9 * h >= left) h = 0.5 * left, trimmed = 1;
        if (1.0001 * h >= left) h = left;
        if (left <= resolution(m, until)) {
            m->time = until;
            break;
        }
        if (h <= resolution(m, until) && h < left) return m->refused > 1 ? m->refused : TOO_SMALL;
        proposal = m->step;
        code = attempt(m, t, h);
        if (code != MADE) {
            refuse(m, h, NEWTON_FAILED);
            m->refused = NOT_FINITE;
            continue;
        }
        if (m->error > 1.0) {
            refuse(m, h, reduction(m, t, h));
            continue;
        }
        if (SPOTS) {
            events(t, m->y, m->par, m->work, m->before);
            events(t + h, m->y_new, m->par, m->work, m->after);
            if (outside(m)) {
                refuse(m, h, SHRINK);
                m->refused = FILM_LEFT;
                continue;
            }
            met = meet(m, t, h);
        }
        if (met == MISSED) {
            refuse(m, m->made, 0.5);
            continue;
        }
        if (met == AT_START) {
            events(t, m->y, m->par, m->work, m->after);
            swap(m);
            begin_phase(m, until);
            if (++m->flips > FLIP_LIMIT) return TOO_SMALL;
            continue;
        }
        if (met == CUT) h = m->made;
        if (m->last_step == 0.0 && met != CUT && !trimmed)
            *(in_contact(m) ? &m->contact_step : &m->free_step) = h;
        accept(m, t, h, until);
        if (trimmed && met != CUT) { /* the end of a call is no reason for short steps behind it */
            grow(m, h, until);
            m->step = larger(m->step, proposal);
        } else
            grow(m, h, until);
        if (met == CUT && m->met >= 0) {
            swap(m);
            begin_phase(m, until);
            if (stop_at_events) {
                *early = 1;
                return MADE;
            }
        } else if (met == CUT)
            m->step = larger(ONSET * proposal, CLEARLY * resolution(m, until));
    }
    return MADE;
}

static void cross(Machine *m, double kink)
{
    for (int i = 0; i < LENGTH; i++) m->y[i] += (kink - m->time) * m->f[i];
    m->time = kink;
    machine_look_ahead(m);
    m->contact_step = m->free_step = 0.0;
}

int machine_advance(Machine *m, double until, int stop_at_events, int *early)
{
    int code = MADE;
    *early = 0;
    if (!(until > m->time)) return MADE;
    machine_depart(m);
    machine_look_ahead(m);
    if (!m->begun) begin(m, until);
    else if (!m->fresh_jacobian) rhs(m->time, m->y, m->par, m->work, m->f);
    while (m->time < until && code == MADE && !*early) {
        double kink = m->horizon;
        if (kink > until) code = advance(m, until, stop_at_events, early);
        else {
            code = advance(m, kink * (1.0 - BEFORE), stop_at_events, early);
            if (code != MADE || *early) break;
            cross(m, kink);
            begin_phase(m, until);
        }
    }
    machine_arrive(m);
    return code;
}

/* --- steps of one size, without failure */
static int passes_wall(Machine *m, double t, double h)
{
    if (attempt(m, t, h) != MADE) return 1;
    if (!SPOTS) return 0;
    events(t, m->y, m->par, m->work, m->before);
    events(t + h, m->y_new, m->par, m->work, m->after);
    return outside(m);
}

static void fixed_step(Machine *m, double t, double h, int halvings)
{
    if (passes_wall(m, t, h)) {
        m->cuts++;
        if (halvings > 0) {
            fixed_step(m, t, 0.5 * h, halvings - 1);
            fixed_step(m, t + 0.5 * h, 0.5 * h, halvings - 1);
            return;
        }
        m->holds++; /* the state stays where it is for this part */
        memcpy(m->y_new, m->y, sizeof m->y);
        memcpy(m->after, m->before, sizeof m->after);
        for (int i = COORDINATES; i < 2 * COORDINATES; i++) m->y_new[i] = 0.0;
        rhs(t + h, m->y_new, m->par, m->work, m->f_new);
    } else
        m->worst = larger(m->worst, m->error);
    accept(m, t, h, t + h);
    for (int j = 0; j < SPOTS; j++) {
        int within = DEPTH(m->after, j) > 0.0;
        if (spot_kind[j] != CONTACT || within == m->side[j]) continue;
        turn_over(m, j);
        rhs(m->time, m->y, m->par, m->work, m->f);
    }
}

void machine_advance_fixed(Machine *m, double until)
{
    double from = m->time;
    int count = (int)ceil((until - from) / m->fixed_step - 1e-9);
    machine_depart(m);
    if (!m->begun) begin(m, until);
    rhs(m->time, m->y, m->par, m->work, m->f);
    m->fresh_jacobian = 0;
    for (int k = 0; k < count; k++) {
        double h = (until - from) / count;
        fixed_step(m, from + k * h, h, HALVINGS);
        m->time = k + 1 < count ? from + (k + 1) * h : until;
    }
    machine_arrive(m);
}
