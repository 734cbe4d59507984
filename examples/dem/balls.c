/* A small discrete-element code: beads fall into a box and come to rest under the contact law with memory.

       restitution export ../two_beads.toml --to contact_law.h
       cc -O2 -std=c99 -o balls balls.c -lm
       ./balls 1000 0.3

   The arguments are the number of beads and the time [s]. Central forces, no friction, SI units. The walls are rigid
   planes: a bead that meets one is the mirror image of a bead that meets its equal, so the law of two beads serves
   both, with twice the overlap.

   With -DMEMORYLESS the force is that of Kuwabara and Kono, calibrated by
   restitution calibrate ../two_beads.toml --target mercury-bshp --velocity 0.05 0.5 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "contact_law.h"

#define RADIUS 0.001   /* of a bead [m], as in the case file */
#define DENSITY 1100.0 /* [kg/m^3] */
#define GRAVITY 9.81   /* [m/s2] */
#define STEP 3e-6      /* [s]: some 50 steps in a contact */
#define MOST 24        /* contacts of a bead that it owns: with later beads, and with walls */

typedef struct {
    int partner; /* a later bead, or -1 to -5 for a wall */
    double depth, force, work;
    double state[CONTACT_LAW_SIZE];
} Contact;

typedef struct {
    double x[3], v[3], a[3];
    int contacts, next;
    Contact *contact[MOST];
} Bead;

static Bead *bead;
static int count, cells[3], *first;
static double box[3], mass, least_work = 0.0;
static long updates = 0;

/* Force at the end of a step; `speed` is that of the approach. */
static double force_at(double *state, double depth, double speed, double dt)
{
#ifdef MEMORYLESS
    const double stiffness = 4.0 / 3.0 * 8901152.5 * sqrt(0.5 * RADIUS), loss = 1.6317143e-5;
    (void)state, (void)dt;
    return depth > 0.0 ? fmax(stiffness * sqrt(depth) * (depth + 1.5 * loss * speed), 0.0) : 0.0;
#else
    (void)speed;
    return contact_law_step(state, depth, dt);
#endif
}

/* Force between bead i and a partner; the memory of a contact begins at first touch and ends with the contact. */
static double touch(int i, int partner, double depth, double speed)
{
    Bead *own = &bead[i];
    int n = 0;
    while (n < own->contacts && own->contact[n]->partner != partner)
        n++;
    if (n == own->contacts) {
        if (depth <= 0.0)
            return 0.0;
        if (n == MOST) {
            fprintf(stderr, "bead %d has more than %d contacts\n", i, MOST);
            exit(1);
        }
        own->contact[n] = calloc(1, sizeof(Contact));
        own->contact[n]->partner = partner;
        /* The gap of one step before. */
        contact_law_start(own->contact[n]->state, fmin(depth - speed * STEP, 0.0));
        own->contacts++;
    }
    Contact *one = own->contact[n];
    double force = force_at(one->state, depth, speed, STEP);
    updates++;
    /* A contact may return what it has stored, but no more. */
    one->work += 0.5 * (force + one->force) * (depth - one->depth);
    least_work = fmin(least_work, one->work);
    one->depth = depth;
    one->force = force;
    if (force == 0.0 && depth <= 0.0) {
        free(one);
        own->contact[n] = own->contact[--own->contacts];
    }
    return force;
}

static int cell_of(const double *x, int k)
{
    int n = (int)(x[k] / box[k] * cells[k]);
    return n < 0 ? 0 : n >= cells[k] ? cells[k] - 1 : n;
}

static int place(int p, int q, int r) { return (r * cells[1] + q) * cells[0] + p; }

static void pair_force(int i, int j)
{
    double d[3], square = 0.0, speed = 0.0;
    for (int k = 0; k < 3; k++) {
        d[k] = bead[j].x[k] - bead[i].x[k];
        square += d[k] * d[k];
    }
    if (square > 4.0 * RADIUS * RADIUS * 1.01)
        return;
    double distance = sqrt(square);
    for (int k = 0; k < 3; k++)
        speed += (bead[i].v[k] - bead[j].v[k]) * d[k] / distance;
    double force = touch(i, j, 2.0 * RADIUS - distance, speed);
    for (int k = 0; k < 3; k++) {
        bead[i].a[k] -= force / mass * d[k] / distance;
        bead[j].a[k] += force / mass * d[k] / distance;
    }
}

static void accelerations(void)
{
    memset(first, -1, sizeof(int) * cells[0] * cells[1] * cells[2]);
    for (int i = 0; i < count; i++) {
        int home = place(cell_of(bead[i].x, 0), cell_of(bead[i].x, 1), cell_of(bead[i].x, 2));
        bead[i].next = first[home];
        first[home] = i;
        bead[i].a[0] = bead[i].a[1] = 0.0;
        bead[i].a[2] = -GRAVITY;
    }
    for (int i = 0; i < count; i++) {
        const double *x = bead[i].x, *v = bead[i].v;
        /* Four sides and the floor. */
        for (int k = 0; k < 3; k++) {
            bead[i].a[k] += touch(i, -1 - k, 2.0 * (RADIUS - x[k]), -2.0 * v[k]) / mass;
            if (k < 2)
                bead[i].a[k] -= touch(i, -4 - k, 2.0 * (RADIUS - box[k] + x[k]), 2.0 * v[k]) / mass;
        }
        int p = cell_of(x, 0), q = cell_of(x, 1), r = cell_of(x, 2);
        for (int c = r - (r > 0); c <= r + (r < cells[2] - 1); c++)
            for (int b = q - (q > 0); b <= q + (q < cells[1] - 1); b++)
                for (int a = p - (p > 0); a <= p + (p < cells[0] - 1); a++)
                    for (int j = first[place(a, b, c)]; j >= 0; j = bead[j].next)
                        if (j > i)
                            pair_force(i, j);
    }
}

/* Kinetic and potential energy [J]. */
static void energies(double *kinetic, double *potential)
{
    *kinetic = *potential = 0.0;
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < 3; k++)
            *kinetic += 0.5 * mass * bead[i].v[k] * bead[i].v[k];
        *potential += mass * GRAVITY * (bead[i].x[2] - RADIUS);
    }
}

/* Time [ns] of one update of a contact, with the contacts as they are. */
static double time_of_update(void)
{
    static double state[CONTACT_LAW_SIZE];
    const int repeats = 50;
    long done = 0;
    double sum = 0.0;
    clock_t start = clock();
    for (int i = 0; i < count; i++)
        for (int n = 0; n < bead[i].contacts; n++) {
            const Contact *one = bead[i].contact[n];
            memcpy(state, one->state, sizeof state);
            for (int r = 0; r < repeats; r++, done++)
                sum += force_at(state, one->depth * (1.0 + 1e-3 * (r % 5)), 0.0, STEP);
        }
    double seconds = (double)(clock() - start) / CLOCKS_PER_SEC;
    return done && sum >= 0.0 ? 1e9 * seconds / done : NAN;
}

int main(int arguments, char **argument)
{
    count = arguments > 1 ? atoi(argument[1]) : 1000;
    double duration = arguments > 2 ? atof(argument[2]) : 0.3;
    if (count < 1 || !(duration > 0.0)) {
        fprintf(stderr, "usage: balls NUMBER TIME, both > 0\n");
        return 2;
    }
    int side = (int)ceil(cbrt(count));
    mass = DENSITY * 4.0 / 3.0 * 3.14159265358979 * RADIUS * RADIUS * RADIUS;
    for (int k = 0; k < 3; k++) {
        box[k] = (k < 2 ? 1.0 : 2.0) * side * 2.4 * RADIUS;
        cells[k] = (int)(box[k] / (2.05 * RADIUS));
    }
    bead = calloc(count, sizeof(Bead));
    first = malloc(sizeof(int) * cells[0] * cells[1] * cells[2]);
    unsigned long random = 11;
    for (int i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) {
            int n = k == 0 ? i % side : k == 1 ? i / side % side : i / (side * side);
            random = (random * 1103515245UL + 12345UL) & 0x7fffffffUL;
            bead[i].x[k] = (n + 0.5) * 2.4 * RADIUS + 0.3 * RADIUS * (random / 2147483648.0 - 0.5) + (k == 2) * RADIUS;
        }
    double kinetic, potential, start, highest = -INFINITY;
    accelerations();
    energies(&kinetic, &potential);
    start = kinetic + potential;
    long steps = (long)(duration / STEP);
    clock_t begin = clock();
    printf("time [s]  kinetic [J]  potential [J]  contacts\n");
    for (long n = 1; n <= steps; n++) {
        for (int i = 0; i < count; i++)
            for (int k = 0; k < 3; k++) {
                bead[i].v[k] += 0.5 * STEP * bead[i].a[k];
                bead[i].x[k] += STEP * bead[i].v[k];
            }
        accelerations();
        for (int i = 0; i < count; i++)
            for (int k = 0; k < 3; k++)
                bead[i].v[k] += 0.5 * STEP * bead[i].a[k];
        energies(&kinetic, &potential);
        highest = fmax(highest, kinetic + potential);
        if (n % (steps / 10 + 1) == 0 || n == steps) {
            int touching = 0;
            for (int i = 0; i < count; i++)
                touching += bead[i].contacts;
            printf("%8.4f  %11.4e  %13.6e  %8d\n", n * STEP, kinetic, potential, touching);
        }
    }
    double seconds = (double)(clock() - begin) / CLOCKS_PER_SEC;
    printf("highest energy - first energy = %.2e of the first\n", highest / start - 1.0);
    printf("least work of a contact = %.2e of the first energy\n", least_work / start);
    printf("kinetic energy at the end = %.2e of the first energy\n", kinetic / start);
    printf("%ld steps, %ld updates of contacts, %.3g s\n", steps, updates, seconds);
    printf("one update of a contact = %.0f ns\n", time_of_update());
    return highest <= start * (1.0 + 1e-6) ? 0 : 1;
}
