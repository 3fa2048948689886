/* The paper's crossing in C, eight scenarios in one 512-bit vector: the peer that scripts/benchmark.py compares with.
 *
 * The same mathematics as tbi_cli/integrator/kernel.py, written as a C programmer would: sizes are constants, the
 * matrix is a table of (row, column), every channel is reduced at every step.  terms.h is written by peers/c.py.
 */
#if defined(STRICT) && defined(__AVX512F__)
#include <immintrin.h>
#endif
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "terms.h" /* ND, NV, N, AXLES, WHEELS, TERMS, G_TERMS, SUMS, SUM_TERMS, CHANNELS and the index tables */

typedef double v8 __attribute__((vector_size(64)));
typedef int64_t m8 __attribute__((vector_size(64)));

static inline v8 all(double x) { return (v8){x, x, x, x, x, x, x, x}; }
/* With STRICT only what is written as fma8 is one operation, as in our kernel; else the compiler may contract more. */
static inline v8 fma8(v8 a, v8 b, v8 c) {
#if defined(STRICT) && defined(__AVX512F__)
    return (v8)_mm512_fmadd_pd((__m512d)a, (__m512d)b, (__m512d)c);
#elif defined(STRICT)
    v8 sum;
    for (int l = 0; l < 8; l++) sum[l] = __builtin_fma(a[l], b[l], c[l]);
    return sum;
#else
    return a * b + c;
#endif
}
static inline v8 pick(m8 where, v8 a, v8 b) { return (v8)((where & (m8)a) | (~where & (m8)b)); }
static inline int any(m8 m) {
    return (m[0] | m[1] | m[2] | m[3] | m[4] | m[5] | m[6] | m[7]) != 0;
}

typedef struct {
    v8 scale[5], wave[N], term[TERMS], axle[4 * AXLES], wheel[4 * WHEELS], g[G_TERMS], gm[G_TERMS];
    v8 offset[SUMS], coef[SUM_TERMS];
} Crossing;

typedef struct {
    v8 state[2 * ND], signal[3 * ND + 4 * WHEELS + SUMS], later[3 * ND], sine[3 * AXLES * N], cosine[3 * AXLES * N];
    v8 on[AXLES], reduced[5 * CHANNELS];
} Work;

static void shapes(const Crossing *c, Work *w, const int *active, v8 j, int instant) {
    v8 angle = all(3.14159265358979323846) * c->scale[4] * (j * c->scale[0]), s0, c0;
    for (int l = 0; l < 8; l++) { s0[l] = sin(angle[l]); c0[l] = cos(angle[l]); }
    for (int k = 0; k < AXLES; k++) {
        if (!active[k]) continue;
        v8 cb = c->axle[4 * k], sb = c->axle[4 * k + 1];
        v8 s = s0 * cb - c0 * sb, co = c0 * cb + s0 * sb, twice = co + co, sp = all(0), cp = all(1);
        for (int i = 0; i < N; i++) {
            w->sine[(instant * AXLES + k) * N + i] = s;
            w->cosine[(instant * AXLES + k) * N + i] = co;
            v8 sn = twice * s - sp, cn = twice * co - cp;
            sp = s; cp = co; s = sn; co = cn;
        }
    }
}

static inline v8 tension_of(const Crossing *c, const v8 *x, int wheel) {
    v8 s = all(0), r = all(0);
    for (int t = g_begin[wheel]; t < g_begin[wheel + 1]; t++) {
        s = fma8(c->g[t], x[g_col[t]], s);
        r = fma8(c->g[t], x[ND + g_col[t]], r);
    }
    return fma8(c->wheel[4 * wheel], s, c->wheel[4 * wheel + 1] * r);
}

void advance(const Crossing *restrict c, Work *restrict w, double first, long steps) {
    v8 h = c->scale[0], half = c->scale[1], sixth = c->scale[2], square = c->scale[3], j = all(first);
    v8 *x = w->signal;
    memcpy(x, w->state, sizeof w->state);
    for (long step = 0; step < steps; step++) {
        int active[AXLES], found = 0;
        for (int k = 0; k < AXLES; k++) {
            m8 on = (j + 0.5 >= c->axle[4 * k + 2]) & (j + 0.5 <= c->axle[4 * k + 3]);
            active[k] = any(on);
            found |= active[k];
            w->on[k] = pick(on, all(1), all(0));
        }
        if (found) {
            shapes(c, w, active, j, 0);
            shapes(c, w, active, j + 0.5, 1);
            shapes(c, w, active, j + 1.0, 2);
        }
        for (int stage = 0; stage < 4; stage++) {
            v8 *a = stage == 0 ? x + 2 * ND : w->later + (stage - 1) * ND;
            for (int row = 0, t = 0; row < ND; row++) {
                v8 total = all(0);
                for (; t < term_begin[row + 1]; t++) total = fma8(c->term[term_value[t]], x[term_col[t]], total);
                a[row] = total;
            }
            int instant = (stage + 1) / 2;
            for (int k = 0; found && k < AXLES; k++) {
                if (!active[k]) continue;
                const v8 *s = w->sine + (instant * AXLES + k) * N;
                for (int wheel = 2 * k; wheel < 2 * k + 2; wheel++) {
                    int mode = NV + N * (wheel % 2);
                    v8 d = all(0), r = all(0);
                    for (int i = 0; i < N; i++) {
                        d = fma8(s[i], x[mode + i], d);
                        r = fma8(s[i], x[ND + mode + i], r);
                    }
                    v8 pull = w->on[k] * fma8(c->wheel[4 * wheel], d, c->wheel[4 * wheel + 1] * r);
                    v8 p = tension_of(c, x, wheel) - pull;
                    for (int t = g_begin[wheel]; t < g_begin[wheel + 1]; t++)
                        a[g_col[t]] = fma8(c->gm[t], pull, a[g_col[t]]);
                    v8 force = w->on[k] * c->wheel[4 * wheel + 3] * (p - c->wheel[4 * wheel + 2]);
                    for (int i = 0; i < N; i++) a[mode + i] = fma8(s[i], force, a[mode + i]);
                }
            }
            if (stage == 0) {
                v8 *out = x + 3 * ND;
                for (int wheel = 0; wheel < WHEELS; wheel++) {
                    int k = wheel / 2, mode = NV + N * (wheel % 2);
                    v8 d = all(0), local = all(0), rate = all(0), dd = all(0), p = tension_of(c, x, wheel);
                    if (active[k]) {
                        const v8 *s = w->sine + k * N, *co = w->cosine + k * N;
                        for (int i = 0; i < N; i++) {
                            v8 q = x[mode + i], dq = x[ND + mode + i], ddq = x[2 * ND + mode + i];
                            v8 slope = c->wave[i] * co[i];
                            d += s[i] * q; local += s[i] * dq; rate += slope * q;
                            dd += s[i] * ddq + 2 * slope * dq - c->wave[i] * c->wave[i] * s[i] * q;
                        }
                        p -= w->on[k] * (c->wheel[4 * wheel] * d + c->wheel[4 * wheel + 1] * local);
                    }
                    out[wheel] = p;
                    out[WHEELS + wheel] = w->on[k] * d;
                    out[2 * WHEELS + wheel] = w->on[k] * (local + rate);
                    out[3 * WHEELS + wheel] = w->on[k] * dd;
                }
                for (int row = 0, t = 0; row < SUMS; row++) {
                    v8 total = c->offset[row];
                    for (; t < sum_begin[row + 1]; t++) total = fma8(c->coef[t], x[sum_col[t]], total);
                    x[3 * ND + 4 * WHEELS + row] = total;
                }
                for (int n = 0; n < CHANNELS; n++) {
                    v8 y = x[channel[n]], *red = w->reduced + 5 * n;
                    red[0] = fma8(y, y, red[0]);
                    m8 above = y > red[1], below = y < red[2];
                    if (any(above | below)) {
                        red[1] = pick(above, y, red[1]);
                        red[2] = pick(below, y, red[2]);
                        red[3] = pick(above, j, red[3]);
                        red[4] = pick(below, j, red[4]);
                    }
                }
            }
            if (stage < 3) {
                v8 f = stage < 2 ? half : h;
                for (int i = 0; i < ND; i++) {
                    v8 v = x[ND + i];
                    x[i] = fma8(f, v, w->state[i]);
                    x[ND + i] = fma8(f, a[i], w->state[ND + i]);
                }
            }
        }
        for (int i = 0; i < ND; i++) {
            v8 a1 = x[2 * ND + i], inner = w->later[i] + w->later[ND + i], a4 = w->later[2 * ND + i];
            v8 v = w->state[ND + i];
            w->state[i] = x[i] = fma8(square, a1 + inner, fma8(h, v, w->state[i]));
            w->state[ND + i] = x[ND + i] = fma8(sixth, (a1 + a4) + (inner + inner), v);
        }
        j += 1.0;
    }
}
