/* The traversal and intersection units of the SaarCOR chip, speaking saarcor-kd over stdin and stdout (PROTOCOL.md). */

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MEMORY = 1 << 24, DEPTH = 64, NOTHING = -1 };

static uint8_t memory[MEMORY];
static float box[2][3];

typedef struct { float origin[3], direction[3], t_min, t_max; } Ray;
typedef struct { uint32_t triangle; float t, u, v; } Hit;
typedef struct { uint32_t node; float enter, leave; } Visit;

static uint32_t end, *touched, count, room; /* behind the last byte that was written; addresses that were read */

static uint32_t word(uint32_t address) {
    uint32_t value;
    memcpy(&value, memory + address, 4);
    return value;
}

static float number(uint32_t bits) { return ((union { uint32_t bits; float value; }){.bits = bits}).value; }
static uint32_t bits(float value) { return ((union { float value; uint32_t bits; }){.value = value}).bits; }

static void touch(uint32_t address) {
    if (count == room) touched = realloc(touched, (room = 2 * room + 64) * sizeof *touched);
    touched[count++] = address;
}

static float least(float a, float b) { return a < b ? a : b; }
static float greatest(float a, float b) { return a > b ? a : b; }
static float dot(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void cross(float *out, const float *a, const float *b) {
    for (int i = 0, p = 1, q = 2; i < 3; i++, p = q, q = (q + 1) % 3) out[i] = a[p] * b[q] - a[q] * b[p];
}

/* Least and greatest distance at which a plane may be met: wider by 2 gamma(3) and twice the least float. */
static void widen(float t, float *low, float *high) {
    const float width = 6 * (FLT_EPSILON / 2) / (1 - 3 * (FLT_EPSILON / 2)), underflow = number(2);
    float a = t * (1 - width), b = t * (1 + width);
    *low = least(a, b) - underflow;
    *high = greatest(a, b) + underflow;
}

/* 1 / direction; NaN, for both children, where distances have no bound. */
static float reciprocal(float direction, float reach) {
    float r = 1 / direction;
    return direction == 0 || (fabsf(r) >= FLT_MIN && reach * fabsf(r) < INFINITY) ? r : NAN;
}

/* Moller and Trumbore. */
static void intersect(const Ray *ray, uint32_t triangle, Hit *hit) {
    float to_b[3], to_c[3], from_a[3], p[3], q[3];
    touch(triangle);
    for (int i = 0; i < 3; i++) {
        float a = number(word(triangle + 4 * i));
        to_b[i] = number(word(triangle + 12 + 4 * i)) - a;
        to_c[i] = number(word(triangle + 24 + 4 * i)) - a;
        from_a[i] = ray->origin[i] - a;
    }
    cross(p, ray->direction, to_c);
    cross(q, from_a, to_b);
    float r = 1 / dot(to_b, p), t = dot(to_c, q) * r, u = dot(from_a, p) * r, v = dot(ray->direction, q) * r;
    int inside = u >= 0 && v >= 0 && u + v <= 1;
    int in_range = t >= ray->t_min && t < ray->t_max;
    int nearer = t < hit->t || (t == hit->t && triangle < hit->triangle);
    if (inside && in_range && nearer) *hit = (Hit){triangle, t, u, v};
}

static Hit trace(const Ray *ray) {
    Hit hit = {NOTHING, ray->t_max, 0, 0};
    Visit stack[DEPTH], at = {0, ray->t_min, ray->t_max};
    float r[3], low, high;
    int put_off = 0;
    count = 0;
    for (int i = 0; i < 3; i++) {
        float o = ray->origin[i];
        r[i] = reciprocal(ray->direction[i], greatest(fabsf(box[0][i] - o), fabsf(box[1][i] - o)));
        widen((box[r[i] < 0][i] - o) * r[i], &low, &high);
        at.enter = greatest(low, at.enter);
        widen((box[!(r[i] < 0)][i] - o) * r[i], &low, &high);
        at.leave = least(high, at.leave);
    }
    for (;; at = stack[--put_off]) {
        at.leave = least(hit.t, at.leave);
        while (at.enter <= at.leave) {
            uint32_t first = word(at.node), second = word(at.node + 4), axis = second & 3, below = second & ~3u;
            touch(at.node);
            if (axis == 3) {
                for (uint32_t entry = below; entry < below + 4 * first; entry += 4) {
                    touch(entry);
                    intersect(ray, word(entry) & ~3u, &hit);
                }
                break;
            }
            widen((number(first) - ray->origin[axis]) * r[axis], &low, &high);
            int down = r[axis] < 0;
            Visit near = {below + 8 * down, at.enter, least(high, at.leave)};
            Visit far = {below + 8 * !down, greatest(low, at.enter), at.leave};
            if (near.enter <= near.leave && far.enter <= far.leave) stack[put_off++] = far;
            at = near.enter <= near.leave ? near : far;
        }
        if (put_off == 0) return hit;
    }
}

static void answer(const Ray *ray, int any) {
    Hit hit = trace(ray);
    int is_hit = hit.triangle != (uint32_t)NOTHING;
    putchar(is_hit ? 'h' : 'm');
    if (is_hit && !any) printf(" %x %x %x %x", hit.triangle, bits(hit.t), bits(hit.u), bits(hit.v));
    for (uint32_t i = 0; i < count && !any; i++) printf("%c%x", i ? ',' : ' ', touched[i]);
    puts(count == 0 && !any ? " none" : "");
}

static void write_memory(char *text) {
    uint32_t address = strtoul(text, &text, 16);
    for (text++; text[0] > ' '; text += 2, end = address > end ? address : end) {
        char digits[3] = {text[0], text[1], 0};
        memory[address++] = strtoul(digits, NULL, 16);
    }
}

int main(void) {
    char *line = NULL;
    size_t size = 0;
    while (getline(&line, &size, stdin) > 0) {
        char *rest = line + 1;
        float n[8];
        for (int i = 0; strchr("abc", line[0]) && line[1] == ' ' && i < 8; i++) n[i] = number(strtoul(rest, &rest, 16));
        switch (line[0]) {
        case 'w': write_memory(rest); puts("ok"); break;
        case 'b': memcpy(box, n, sizeof box); puts("ok"); break;
        case 'f': memset(memory, 0, end); end = 0; puts("ok"); break;
        case 'e': puts("end"); return 0;
        case 's': puts("saarcor-kd 1"); break;
        case 'a': answer(&(Ray){{n[0], n[1], n[2]}, {n[3], n[4], n[5]}, n[6], n[7]}, 1); break;
        case 'c':
            if (line[1] == ' ') answer(&(Ray){{n[0], n[1], n[2]}, {n[3], n[4], n[5]}, n[6], n[7]}, 0);
            else puts(!strcmp(line, "config kernel=moller-trumbore\n") ? "ok observes=triangle,t,uv,touched" : "unsupported kernel");
        }
    }
}
