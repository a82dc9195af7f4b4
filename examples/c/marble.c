/* A program of the pixel stream editor run on a host's framebuffer.
 *
 *   cargo rustc --release --lib --no-default-features --features capi,threads,deep --crate-type cdylib
 *   cc -Iinclude examples/c/marble.c -Ltarget/release -lpse -lm -o marble && LD_LIBRARY_PATH=target/release ./marble
 *
 * It writes marble.ppm. */
#include "pse.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { WIDTH = 320, HEIGHT = 240 };

static int report(const char *what, pse_error *error) {
    fprintf(stderr, "%s failed:\n%s", what, pse_error_message(error));
    for (size_t i = 0; i < pse_error_count(error); i++) {
        pse_diagnostic fault;
        pse_error_at(error, i, &fault);
        fprintf(stderr, "%s:%u:%u [%s] %s\n", fault.file, fault.line, fault.column, fault.code, fault.message);
    }
    pse_error_free(error);
    return 1;
}

static int never(void *user) {
    (void)user;
    return 0;
}

int main(void) {
    const char *text = "param veins = 4\n"
                       "color = [0.9 0.86 0.8] * (0.6 + 0.4 * sin(veins * (point.x + turbulence(2 * point))))\n";
    pse_error *error = NULL;
    pse_program *program = pse_compile("marble.pse", text, &error);
    if (!program) return report("compiling", error);
    for (size_t i = 0; i < pse_required_count(program); i++) {
        printf("it reads %s\n", pse_required(program, i));
    }
    pse_session *session = pse_session_new(program);
    pse_program_free(program);

    /* The points of a sphere, three numbers a pixel, and bytes of RGBA with the last row first, as OpenGL has them. */
    float *point = malloc(sizeof(float) * 3 * WIDTH * HEIGHT);
    unsigned char *rgba = malloc(4 * WIDTH * HEIGHT);
    for (int y = 0; y < HEIGHT; y++) {
        for (int x = 0; x < WIDTH; x++) {
            float *p = point + 3 * (y * WIDTH + x);
            p[0] = (x + 0.5f) / HEIGHT * 2 - (float)WIDTH / HEIGHT;
            p[1] = 1 - (y + 0.5f) / HEIGHT * 2;
            float rest = 1 - p[0] * p[0] - p[1] * p[1];
            p[2] = rest > 0 ? sqrtf(rest) : 0;
        }
    }
    pse_buffer input = {"point", point, 3 * WIDTH * HEIGHT, PSE_F32, 3, 0, 1, 3, 3 * WIDTH};
    pse_buffer output = {"color", rgba, 4 * WIDTH * HEIGHT, PSE_U8_SRGB, 4, 4 * WIDTH * (HEIGHT - 1), 1, 4, -4 * WIDTH};
    pse_options options = pse_options_default();
    options.abort = never;

    float veins = 6;
    int status = 0;
    if (pse_set(session, "veins", &veins, 1, &error) != 0) status = report("setting a param", error);
    if (!status && pse_run(session, WIDTH, HEIGHT, &input, 1, &output, 1, &options, &error) != 0) {
        status = report("running", error);
    }
    FILE *file = status ? NULL : fopen("marble.ppm", "wb");
    if (file) {
        fprintf(file, "P6\n%d %d\n255\n", WIDTH, HEIGHT);
        for (int y = HEIGHT - 1; y >= 0; y--) {
            for (int x = 0; x < WIDTH; x++) fwrite(rgba + 4 * (y * WIDTH + x), 1, 3, file);
        }
        status = fclose(file) != 0;
    }
    pse_session_free(session);
    free(point);
    free(rgba);

    /* What goes wrong is told with its place. */
    error = NULL;
    if (pse_compile("wrong.pse", "color = nosie(point)\n", &error)) return 1;
    pse_diagnostic fault;
    pse_error_at(error, 0, &fault);
    printf("%s:%u:%u %s\n", fault.file, fault.line, fault.column, fault.message);
    pse_error_free(error);
    return status;
}
