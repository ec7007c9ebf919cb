/* Compensation in a controller, in C: load a fit from memory, predict, command, and time the commands.
 *
 *   controller FIT.json [COMMANDS]
 */
#define _POSIX_C_SOURCE 199309L
#include "truepose.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

/* The whole file in memory: a controller without files has the fit in its flash. */
static char *contents(const char *path, size_t *length) {
    FILE *file = fopen(path, "rb");
    if (!file) return NULL;
    char *text = NULL;
    size_t room = 0, used = 0;
    for (;;) {
        if (used == room) {
            room = room ? 2 * room : 65536;
            char *more = realloc(text, room);
            if (!more) { free(text); fclose(file); return NULL; }
            text = more;
        }
        size_t got = fread(text + used, 1, room - used, file);
        used += got;
        if (!got) break;
    }
    fclose(file);
    *length = used;
    return text;
}

static int refused(const char *what, int32_t code) {
    fprintf(stderr, "%s: %s (%s)\n", what, truepose_message(code), truepose_last_error());
    return 1;
}

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

int main(int count, char **words) {
    if (count < 2) {
        fprintf(stderr, "usage: controller FIT.json [COMMANDS]\n");
        return 2;
    }
    if (truepose_abi() != TRUEPOSE_ABI) {
        fprintf(stderr, "the library has another interface than this program\n");
        return 1;
    }
    size_t length = 0;
    char *text = contents(words[1], &length);
    if (!text) {
        fprintf(stderr, "%s cannot be read\n", words[1]);
        return 1;
    }
    truepose_fit *fit = NULL;
    int32_t code = truepose_fit_parse(text, length, &fit);
    free(text);
    if (code != TRUEPOSE_OK) return refused(words[1], code);
    truepose_arm *arm = NULL;
    code = truepose_arm_new(fit, NULL, &arm);
    if (code != TRUEPOSE_OK) return refused("arm", code);

    size_t joints = truepose_fit_joints(fit), channels = truepose_fit_channels(fit);
    printf("truepose %s: %zu joints, %zu channels, %zu targets\n", truepose_version(), joints, channels,
           truepose_fit_targets(fit));
    if (channels > 0) {
        fprintf(stderr, "this program has no values for channel %s\n", truepose_fit_channel(fit, 0));
        return 1;
    }

    truepose_conditions conditions = {0};
    conditions.load = TRUEPOSE_LOAD_PAYLOAD;
    conditions.payload_mass = 5.0;
    conditions.payload_com[2] = 0.1;

    size_t commands = count > 2 ? (size_t)strtoul(words[2], NULL, 10) : 1000, reached = 0;
    double *q = calloc(3 * joints, sizeof *q), *seed = q + joints, *found = q + 2 * joints;
    double *times = calloc(commands, sizeof *times);
    if (!q || !times) return 1;
    double worst = 0.0;
    for (size_t n = 0; n < commands; n++) {
        for (size_t k = 0; k < joints; k++) {
            q[k] = 0.4 * sin(0.7 * (double)n + 1.9 * (double)k) + (k == 1 ? -1.0 : k == 2 ? 0.9 : 0.3);
            seed[k] = q[k] + 0.005;
        }
        /* Where the real robot is at these joint values is desired; the command has to lead back there. */
        truepose_pose pose;
        code = truepose_predict(arm, q, joints, &conditions, TRUEPOSE_TOOL, &pose);
        if (code != TRUEPOSE_OK) return refused("predict", code);
        truepose_target desired = {0};
        for (int k = 0; k < 3; k++) desired.position[k] = pose.position[k];
        for (int k = 0; k < 4; k++) desired.quaternion[k] = pose.quaternion[k];
        desired.has_orientation = 1;
        desired.target = TRUEPOSE_TOOL;
        truepose_answer answer;
        double begun = now();
        code = truepose_command(arm, &desired, &conditions, seed, found, joints, &answer);
        times[n] = now() - begun;
        if (code < 0) return refused("command", code);
        if (code != TRUEPOSE_OK) continue;
        reached++;
        if (answer.position_error > worst) worst = answer.position_error;
    }
    qsort(times, commands, sizeof *times, ascending);
    double total = 0.0;
    for (size_t n = 0; n < commands; n++) total += times[n];
    printf("%zu of %zu poses reached, largest error %.3g um\n", reached, commands, 1e6 * worst);
    if (commands > 0)
        printf("%.3f s in commands; median %.2f us, 99.9 %% %.2f us\n", total, 1e6 * times[commands / 2],
               1e6 * times[commands * 999 / 1000]);

    /* Errors are codes. */
    code = truepose_command(arm, NULL, &conditions, seed, found, joints, NULL);
    printf("without a pose: %s\n", truepose_message(code));
    truepose_arm_free(arm);
    truepose_fit_free(fit);
    free(q);
    free(times);
    return reached == commands && code == TRUEPOSE_ERROR_NULL ? 0 : 1;
}
