/* The generator as an FMI 2.0 co-simulation slave: the steps of tmm/generator/transient in C.
 *
 * Implicit midpoint on the structure, discrete gradients on stops and magnetic field, so that
 * energy is kept to rounding.  model.h holds the numbers of one device. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "model.h"

#define API __attribute__((visibility("default")))
#define M_ 3 /* coordinates that stops and coil read: lift, lateral, tilt */
#define STEPS_MOST 40
#define APART (-60.0)
#define LARGEST 500.0

typedef struct { double w, linkage, force, inductance, motional, gradient; } Field;
typedef struct {
    double x[N], v[N], a[N], volts, amperes, time, asked_volts, asked_coil, step, imbalance, start;
    double inverse[N * N], made_for;
    Field field;
} Slave;

static Field field_at(double current, double gap) {
    double size = fabs(current), width = gap + GAP_OFFSET;
    double y = log(fmax(width, 1e-3 * GAP_OFFSET)), sign = current < 0.0 ? -1.0 : 1.0;
    int row = 0, col = 0;
    while (row < ROWS - 1 && size >= CURRENT_BREAKS[row + 1]) row++;
    while (col < COLS - 1 && y >= WIDTH_BREAKS[col + 1]) col++;
    double s = size - CURRENT_BREAKS[row], t = y - WIDTH_BREAKS[col];
    const double *c = COEFFICIENTS + 20 * (row * COLS + col);
    double v[5], d[5], e[5];
    for (int p = 0; p < 5; p++, c += 4) {
        v[p] = ((c[3] * t + c[2]) * t + c[1]) * t + c[0];
        d[p] = (3 * c[3] * t + 2 * c[2]) * t + c[1];
        e[p] = 6 * c[3] * t + 2 * c[2];
    }
    double dy = (((d[4] * s + d[3]) * s + d[2]) * s + d[1]) * s + d[0];
    double mixed = ((4 * d[4] * s + 3 * d[3]) * s + 2 * d[2]) * s + d[1];
    double dyy = (((e[4] * s + e[3]) * s + e[2]) * s + e[1]) * s + e[0];
    Field f;
    f.w = (((v[4] * s + v[3]) * s + v[2]) * s + v[1]) * s + v[0];
    f.linkage = sign * (((4 * v[4] * s + 3 * v[3]) * s + 2 * v[2]) * s + v[1]);
    f.force = -dy / width;
    f.inductance = (12 * v[4] * s + 6 * v[3]) * s + 2 * v[2];
    f.motional = sign * mixed / width;
    f.gradient = -(dyy - dy) / (width * width);
    return f;
}

static double rough(double exponent) {
    return exponent > APART ? RIM_LOAD * exp(fmin(exponent, LARGEST)) : 0.0;
}

static double deformation(const double *x, int stop, int j) {
    return stop ? -x[0] - STROKE + RIM[j] * x[2] : x[0] + RIM[j] * x[2];
}

typedef struct { double f[M_], k[M_ * M_], loss, pull, current, work; Field field; } Answer;

static Answer answer(const Slave *s, const double *y, double current, double from, double h) {
    Answer a;
    memset(&a, 0, sizeof a);
    for (int stop = 0; stop < 2; stop++) {
        double normal = 0.0, by[M_] = {0, 0, 0};
        for (int j = 0; j < POINTS; j++) {
            double row[M_] = {stop ? -1.0 : 1.0, 0.0, RIM[j]};
            double moved = row[0] * y[0] + row[2] * y[2], u0 = DECAY[stop];
            double before = deformation(s->x, stop, j) / u0, change = moved / u0;
            double begin = rough(before), end = rough(before + change);
            if (begin == 0.0 && end == 0.0) continue;
            double grown = begin > 0.0 ? begin * expm1(fmin(change, LARGEST)) : end;
            double elastic = change == 0.0 ? end : grown / change;
            double slope = fabs(change) > 1e-6 ? (end - elastic) / change : 0.5 * end;
            double force = elastic + RELAXATION[stop] / h * (end - begin);
            slope = (slope + RELAXATION[stop] / h * end) / u0;
            if (force <= 0.0) { force = 0.0; slope = 0.0; }
            a.loss += (force - elastic) * moved;
            normal += force;
            for (int p = 0; p < M_; p++) {
                a.f[p] -= force * row[p];
                by[p] += slope * row[p];
                for (int q = 0; q < M_; q++) a.k[p * M_ + q] += slope * row[p] * row[q];
            }
        }
        if (normal == 0.0) continue;
        double speed = y[1] / h, size = hypot(speed, CREEP), share = FRICTION * speed / size;
        a.f[1] -= share * normal;
        for (int q = 0; q < M_; q++) a.k[M_ + q] += share * by[q];
        a.k[M_ + 1] += FRICTION * normal * CREEP * CREEP / (size * size * size * h);
        a.loss += share * normal * y[1];
    }
    double g0 = GAP + s->x[0], dg = y[0];
    const Field *p0 = &s->field;
    Field p1 = a.field = field_at(current, g0 + dg);
    a.pull = 0.5 * (p0->force + p1.force);
    a.current = 0.5 * (from + current);
    double dl = p1.linkage - p0->linkage, cg = dg / WIDTH;
#if BY_VOLTAGE
    double size = fmax(fabs(p0->linkage), fabs(p1.linkage)), c = size > 0.0 ? dl / size : 0.0;
    double q = c * c + cg * cg;
    if (q > 1e-10) {
        double stored = current * p1.linkage - from * p0->linkage - (p1.w - p0->w);
        double rest = (stored - a.current * dl - a.pull * dg) / q;
        a.pull += rest * cg / WIDTH;
        if (size > 0.0) a.current += rest * c / size;
    }
    a.work = a.current * dl;
#else
    double size = fmax(fabs(from), fabs(current)), di = current - from;
    double c = size > 0.0 ? di / size : 0.0, q = c * c + cg * cg;
    a.work = a.current * dl;
    if (q > 1e-10) {
        double mean = 0.5 * (p0->linkage + p1.linkage);
        double rest = (p1.w - p0->w - mean * di + a.pull * dg) / q;
        a.pull -= rest * cg / WIDTH;
        a.work -= rest * c * c;
    }
#endif
    a.f[0] -= a.pull;
    a.k[0] += 0.5 * p1.gradient;
    return a;
}

/* Gauss elimination with pivots; b becomes the solution. */
static int solve(double *m, double *b, int n, int columns) {
    for (int k = 0; k < n; k++) {
        int best = k;
        for (int i = k + 1; i < n; i++)
            if (fabs(m[i * n + k]) > fabs(m[best * n + k])) best = i;
        if (m[best * n + k] == 0.0) return 1;
        for (int j = 0; j < n && best != k; j++) {
            double t = m[k * n + j]; m[k * n + j] = m[best * n + j]; m[best * n + j] = t;
        }
        for (int j = 0; j < columns && best != k; j++) {
            double t = b[k * columns + j];
            b[k * columns + j] = b[best * columns + j]; b[best * columns + j] = t;
        }
        for (int i = 0; i < n; i++) {
            if (i == k) continue;
            double r = m[i * n + k] / m[k * n + k];
            if (r == 0.0) continue;
            for (int j = k; j < n; j++) m[i * n + j] -= r * m[k * n + j];
            for (int j = 0; j < columns; j++) b[i * columns + j] -= r * b[k * columns + j];
        }
    }
    for (int k = 0; k < n; k++)
        for (int j = 0; j < columns; j++) b[k * columns + j] /= m[k * n + k];
    return 0;
}

static int prepare(Slave *s, double h) {
    static const double zero[N * N];
    double m[N * N], scale[N];
    if (s->made_for == h) return 0;
    memcpy(s->inverse, zero, sizeof zero);
    for (int i = 0; i < N * N; i++) m[i] = 2.0 / (h * h) * MASS[i] + DAMPING[i] / h + 0.5 * STIFFNESS[i];
    for (int i = 0; i < N; i++) { scale[i] = 1.0 / sqrt(m[i * N + i]); s->inverse[i * N + i] = 1.0; }
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++) m[i * N + j] *= scale[i] * scale[j];
    if (solve(m, s->inverse, N, N)) return 1;
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++) s->inverse[i * N + j] *= scale[i] * scale[j];
    s->made_for = h;
    return 0;
}

static double energy(const Slave *s) {
    double e = s->amperes * s->field.linkage - s->field.w + 0.5 * CAPACITANCE * s->volts * s->volts;
    for (int i = 0; i < N; i++) {
        e -= LOAD[i] * s->x[i];
        for (int j = 0; j < N; j++)
            e += 0.5 * (s->v[i] * MASS[i * N + j] * s->v[j] + s->x[i] * STIFFNESS[i * N + j] * s->x[j]);
    }
    for (int stop = 0; stop < 2; stop++)
        for (int j = 0; j < POINTS; j++) 
            e += DECAY[stop] * rough(deformation(s->x, stop, j) / DECAY[stop]);
    return e;
}

static double charge(const Slave *s) {
    double q = CAPACITANCE * s->volts;
    for (int i = 0; i < N; i++) q += COUPLING[i] * s->x[i];
    return q;
}

/* One step at constant voltage and coil source; 0 if it settled. */
static int advance(Slave *s, double h, double coil) {
    double right[N], guess[M_] = {0, 0, 0}, size[M_ + 1], y[M_ + 1], last[M_ + 1] = {0, 0, 0, 0};
    int count = M_ + BY_VOLTAGE, halvings = 0;
    double before = INFINITY, from = BY_VOLTAGE ? s->amperes : coil;
    if (prepare(s, h)) return 1;
    for (int i = 0; i < N; i++) {
        right[i] = LOAD[i] + COUPLING[i] * s->volts;
        for (int j = 0; j < N; j++)
            right[i] += MASS[i * N + j] * (2.0 / h) * s->v[j] - STIFFNESS[i * N + j] * s->x[j];
    }
    for (int p = 0; p < M_; p++) {
        for (int j = 0; j < N; j++) guess[p] += s->inverse[p * N + j] * right[j];
        y[p] = h * (s->v[p] + 0.5 * h * s->a[p]);
    }
    y[M_] = s->amperes;
    Answer a = answer(s, y, BY_VOLTAGE ? y[M_] : coil, from, h);
    for (int p = 0; p < M_; p++) {
        size[p] = fabs(guess[p]) + fabs(s->x[p]) + fabs(h * s->v[p]);
        for (int q = 0; q < M_; q++) size[p] += fabs(s->inverse[p * N + q] * a.f[q]);
    }
    size[M_] = fabs(s->field.linkage) + h * fabs(coil);
    int settled = 0;
    for (int turn = 0; turn < STEPS_MOST && !settled; turn++) {
        double r[M_ + 1], m[(M_ + 1) * (M_ + 1)], off = 0.0;
        for (int p = 0; p < M_; p++) {
            const double *row = s->inverse + p * N;
            r[p] = y[p] - guess[p];
            for (int q = 0; q < M_; q++) {
                r[p] -= row[q] * a.f[q];
                m[p * count + q] = p == q;
                for (int k = 0; k < M_; k++) m[p * count + q] += row[k] * a.k[k * M_ + q];
            }
#if BY_VOLTAGE
            m[p * count + M_] = -0.5 * a.field.motional * row[0];
#endif
        }
#if BY_VOLTAGE
        r[M_] = a.field.linkage - s->field.linkage - h * (coil - RESISTANCE * a.current);
        for (int q = 0; q < M_; q++) m[M_ * count + q] = q == 0 ? a.field.motional : 0.0;
        m[M_ * count + M_] = a.field.inductance + 0.5 * h * RESISTANCE;
#endif
        for (int p = 0; p < count; p++) if (size[p] > 0.0) off = fmax(off, fabs(r[p]) / size[p]);
        if (off > 4.0 * before && halvings < 8) {
            halvings++;
            for (int p = 0; p < count; p++) { last[p] *= 0.5; y[p] -= last[p]; }
        } else {
            before = off; halvings = 0; settled = 1;
            if (solve(m, r, count, 1)) return 1;
            for (int p = 0; p < count; p++) {
                double still = p < M_ ? fabs(h * s->v[p]) : size[M_] / s->field.inductance;
                double noise = 2e-15 * size[p] / (p < M_ ? 1.0 : s->field.inductance);
                last[p] = -r[p];
                y[p] += last[p];
                if (fabs(last[p]) > fmax(1e-9 * fmax(fabs(y[p]), still), noise)) settled = 0;
            }
        }
        a = answer(s, y, BY_VOLTAGE ? y[M_] : coil, from, h);
    }
    if (!settled) return 1;
    double start = energy(s), q0 = charge(s), lost = a.loss;
    double work = a.work;
    for (int p = 0; p < M_; p++) right[p] += a.f[p];
    double change[N];
    for (int i = 0; i < N; i++) {
        change[i] = 0.0;
        for (int j = 0; j < N; j++) change[i] += s->inverse[i * N + j] * right[j];
    }
    for (int i = 0; i < N; i++) {
        double v = 2.0 / h * change[i] - s->v[i];
        for (int j = 0; j < N; j++) lost += change[i] * DAMPING[i * N + j] * change[j] / h;
        s->a[i] = (v - s->v[i]) / h;
        s->x[i] += change[i];
        s->v[i] = v;
    }
    s->field = a.field;
    s->amperes = BY_VOLTAGE ? y[M_] : coil;
    s->imbalance += energy(s) - start - work - s->volts * (charge(s) - q0) + lost;
    return 0;
}

/* Halve a step that does not settle. */
static int surely(Slave *s, double h, double coil, int depth) {
    if (!advance(s, h, coil)) return 0;
    return depth == 12 || surely(s, 0.5 * h, coil, depth + 1) || surely(s, 0.5 * h, coil, depth + 1);
}

/* FMI 2.0; the types are those of the standard's headers. */
typedef void *Component;
typedef unsigned int Reference;
typedef enum { OK, WARNING, DISCARD, ERROR } Status;

static void reset(Slave *s) {
    memset(s, 0, sizeof *s);
    memcpy(s->x, REST, sizeof REST);
    s->step = STEP;
    s->field = field_at(0.0, GAP + s->x[0]);
}

API const char *fmi2GetTypesPlatform(void) { return "default"; }
API const char *fmi2GetVersion(void) { return "2.0"; }
API Component fmi2Instantiate(const char *name, int type, const char *guid, const char *where,
                              const void *callbacks, int visible, int logging) {
    (void)name; (void)where; (void)callbacks; (void)visible; (void)logging;
    if (type != 1 || strcmp(guid, GUID)) return NULL;
    Slave *s = malloc(sizeof(Slave));
    if (s) reset(s);
    return s;
}
API void fmi2FreeInstance(Component c) { free(c); }
API Status fmi2Reset(Component c) { reset(c); return OK; }
API Status fmi2SetDebugLogging(Component c, int on, size_t n, const char *const list[]) {
    (void)c; (void)on; (void)n; (void)list; return OK;
}
API Status fmi2SetupExperiment(Component c, int tolerant, double tolerance, double start, int ends, double stop) {
    (void)tolerant; (void)tolerance; (void)ends; (void)stop;
    ((Slave *)c)->time = start;
    return OK;
}
API Status fmi2EnterInitializationMode(Component c) { (void)c; return OK; }
API Status fmi2ExitInitializationMode(Component c) { (void)c; return OK; }
API Status fmi2Terminate(Component c) { (void)c; return OK; }

API Status fmi2SetReal(Component c, const Reference *r, size_t n, const double *value) {
    Slave *s = c;
    for (size_t i = 0; i < n; i++) {
        if (!isfinite(value[i])) return ERROR;
        if (r[i] == 0) s->asked_volts = value[i];
        else if (r[i] == 1) s->asked_coil = value[i];
        else if (r[i] == 2 && value[i] > 0.0) s->step = value[i];
        else return ERROR;
    }
    return OK;
}
API Status fmi2GetReal(Component c, const Reference *r, size_t n, double *value) {
    Slave *s = c;
    for (size_t i = 0; i < n; i++) {
        double sum = 0.0;
        switch (r[i]) {
        case 0: sum = s->asked_volts; break;
        case 1: sum = s->asked_coil; break;
        case 2: sum = s->step; break;
        case 3: sum = s->x[0]; break;
        case 4: for (int k = 0; k < N; k++) sum += TIP[k] * s->x[k]; break;
        case 5: sum = s->x[2]; break;
        case 6: sum = s->amperes; break;
        case 7: sum = s->field.linkage; break;
        case 8: sum = s->field.force; break;
        case 9: sum = charge(s); break;
        case 10: sum = energy(s); break;
        case 11: sum = s->imbalance; break;
        default: return ERROR;
        }
        value[i] = sum;
    }
    return OK;
}
API Status fmi2DoStep(Component c, double time, double size, int keep) {
    Slave *s = c;
    (void)keep;
    if (!(size > 0.0) || !isfinite(size)) return ERROR;
    s->volts = s->asked_volts;
#if !BY_VOLTAGE
    s->amperes = s->asked_coil;
    s->field = field_at(s->amperes, GAP + s->x[0]);
#endif
    double pieces = ceil(size / s->step - 1e-9);
    for (long k = 0; k < (long)pieces; k++)
        if (surely(s, size / pieces, s->asked_coil, 0)) return ERROR;
    s->time = time + size;
    return OK;
}
#define NONE { return ERROR; }
API Status fmi2GetInteger(Component c, const Reference *r, size_t n, int *v) { (void)c; (void)r; (void)v; return n ? ERROR : OK; }
API Status fmi2GetBoolean(Component c, const Reference *r, size_t n, int *v) { (void)c; (void)r; (void)v; return n ? ERROR : OK; }
API Status fmi2GetString(Component c, const Reference *r, size_t n, const char **v) { (void)c; (void)r; (void)v; return n ? ERROR : OK; }
API Status fmi2SetInteger(Component c, const Reference *r, size_t n, const int *v) { (void)c; (void)r; (void)v; return n ? ERROR : OK; }
API Status fmi2SetBoolean(Component c, const Reference *r, size_t n, const int *v) { (void)c; (void)r; (void)v; return n ? ERROR : OK; }
API Status fmi2SetString(Component c, const Reference *r, size_t n, const char *const *v) { (void)c; (void)r; (void)v; return n ? ERROR : OK; }
API Status fmi2GetFMUstate(Component c, void **state) {
    if (!*state) *state = malloc(sizeof(Slave));
    if (!*state) return ERROR;
    memcpy(*state, c, sizeof(Slave));
    return OK;
}
API Status fmi2SetFMUstate(Component c, void *state) { memcpy(c, state, sizeof(Slave)); return OK; }
API Status fmi2FreeFMUstate(Component c, void **state) { (void)c; free(*state); *state = NULL; return OK; }
API Status fmi2SerializedFMUstateSize(Component c, void *s, size_t *n) { (void)c; (void)s; (void)n; NONE }
API Status fmi2SerializeFMUstate(Component c, void *s, char *b, size_t n) { (void)c; (void)s; (void)b; (void)n; NONE }
API Status fmi2DeSerializeFMUstate(Component c, const char *b, size_t n, void **s) { (void)c; (void)b; (void)n; (void)s; NONE }
API Status fmi2GetDirectionalDerivative(Component c, const Reference *u, size_t n, const Reference *k, size_t m, const double *d, double *v) {
    (void)c; (void)u; (void)n; (void)k; (void)m; (void)d; (void)v; NONE
}
API Status fmi2SetRealInputDerivatives(Component c, const Reference *r, size_t n, const int *o, const double *v) {
    (void)c; (void)r; (void)n; (void)o; (void)v; NONE
}
API Status fmi2GetRealOutputDerivatives(Component c, const Reference *r, size_t n, const int *o, double *v) {
    (void)c; (void)r; (void)n; (void)o; (void)v; NONE
}
API Status fmi2CancelStep(Component c) { (void)c; NONE }
API Status fmi2GetStatus(Component c, int k, int *v) { (void)c; (void)k; (void)v; return DISCARD; }
API Status fmi2GetRealStatus(Component c, int k, double *v) {
    if (k != 2) return DISCARD;
    *v = ((Slave *)c)->time;
    return OK;
}
API Status fmi2GetIntegerStatus(Component c, int k, int *v) { (void)c; (void)k; (void)v; return DISCARD; }
API Status fmi2GetBooleanStatus(Component c, int k, int *v) { (void)c; (void)k; (void)v; return DISCARD; }
API Status fmi2GetStringStatus(Component c, int k, const char **v) { (void)c; (void)k; (void)v; return DISCARD; }
