/* The sweep as a plain C loop: one trial after the other, its own normals for every leg (xoshiro256+, polar method).
   Compiled and called by sweep.py. Gives the mean cost of each cell and the number of legs run. */

#include <math.h>
#include <stdint.h>

static uint64_t state[4];

static uint64_t rotated(uint64_t x, int k) { return (x << k) | (x >> (64 - k)); }

static double uniform(void) {
    const uint64_t sum = state[0] + state[3], shifted = state[1] << 17;
    state[2] ^= state[0];
    state[3] ^= state[1];
    state[1] ^= state[2];
    state[0] ^= state[3];
    state[2] ^= shifted;
    state[3] = rotated(state[3], 45);
    return (double)(sum >> 11) * 0x1.0p-53;
}

static void seed_with(uint64_t seed) {
    for (int i = 0; i < 4; i++) { /* splitmix64 */
        uint64_t z = (seed += 0x9e3779b97f4a7c15u);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        state[i] = z ^ (z >> 31);
    }
}

static void normal_pair(double *first, double *second) {
    double u, v, s;
    do {
        u = 2.0 * uniform() - 1.0;
        v = 2.0 * uniform() - 1.0;
        s = u * u + v * v;
    } while (s >= 1.0 || s == 0.0);
    const double factor = sqrt(-2.0 * log(s) / s);
    *first = u * factor;
    *second = v * factor;
}

int64_t sweep(const double *d_max, int cells, const double *sigma, int sigmas, int trials, double distance, double speed,
              double radius, double surfacing_time, int max_legs, uint64_t seed, double *cost) {
    int64_t legs = 0;
    seed_with(seed);
    for (int j = 0; j < sigmas; j++) {
        for (int i = 0; i < cells; i++) {
            double total = 0.0;
            for (int trial = 0; trial < trials; trial++) {
                double x = -distance, y = 0.0, run = 0.0, left = distance;
                int surfacings = 0;
                while (left >= radius && surfacings < max_legs) {
                    const double length = left < d_max[i] ? left : d_max[i];
                    const double kept = 1.0 - length / left, scale = sigma[j] * length / speed;
                    double east, north;
                    normal_pair(&east, &north);
                    x = x * kept + scale * east;
                    y = y * kept + scale * north;
                    left = sqrt(x * x + y * y);
                    run += length;
                    surfacings++;
                }
                legs += surfacings;
                total += run / speed + surfacing_time * (surfacings - 1);
            }
            cost[j * cells + i] = total / trials / (distance / speed) - 1.0;
        }
    }
    return legs;
}
