/* The pixel stream editor for C and C++: compile a program once, run it on buffers of the host.
 *
 * Build the library:  cargo rustc --release --lib --no-default-features --features capi,threads,deep --crate-type cdylib
 * (`--crate-type staticlib` for a static one). An example is examples/c/marble.c.
 *
 * Strings are UTF-8 and end with 0. A function that can fail takes a `pse_error **`, which may be NULL; on failure it
 * stores an error there, which the caller frees. No function lets a panic or an exception out. A program may be shared by
 * threads; a session is used by one thread at a time. */
#ifndef PSE_H
#define PSE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pse_program pse_program;
typedef struct pse_session pse_session;
typedef struct pse_error pse_error;

/* How the numbers of a buffer are stored. */
typedef enum pse_type {
    PSE_F32 = 0,    /* 32-bit floats */
    PSE_F16 = 1,    /* 16-bit floats, as uint16_t */
    PSE_U8 = 2,     /* 0 to 255 for 0 to 1; values beyond are clipped, NaN is 0 */
    PSE_U8_SRGB = 3 /* the same with the sRGB curve; the fourth component, alpha, without it */
} pse_type;

/* A variable in a buffer. Distances count numbers, not bytes. A `row` below 0 means that the last row comes first:
 * `start` is always the index of the top left pixel. */
typedef struct pse_buffer {
    const char *name;    /* the variable */
    void *data;          /* read from inputs, written to in outputs */
    size_t length;       /* numbers in `data` */
    pse_type type;
    uint32_t components; /* 1: a scalar; else a vector of so many */
    size_t start;
    size_t component;    /* from a component to the next of the same pixel */
    size_t pixel;        /* from a pixel to the next of its row */
    ptrdiff_t row;       /* from a row to the row below */
} pse_buffer;

/* What a run may be told. Begin with pse_options_default(): `size` tells the library which fields there are. */
typedef struct pse_options {
    size_t size;                 /* sizeof(pse_options) */
    float frame;                 /* the value of `frame` */
    uint32_t threads;            /* 0: as many as there are cores; 1: the caller's own and no other */
    int32_t origin[2];           /* the first pixel, from the top left of the whole picture */
    size_t resolution[2];        /* columns and rows of the whole picture; 0: those of the buffers */
    size_t window[4];            /* first column, first row, columns, rows to run; all 0: the whole. Outputs have its size */
    int (*abort)(void *user);    /* called from any of the threads; not 0 ends the run. May be NULL */
    void *user;                  /* for `abort` */
} pse_options;

/* A fault, and where it lies in the text: lines and columns count from 1; 0 where it has no place. */
typedef struct pse_diagnostic {
    const char *code;
    const char *message;
    const char *file;
    uint32_t line, column;
    size_t start, end;           /* bytes of the text */
    int32_t pixel[2];            /* for a fault at run time */
    int has_pixel;
} pse_diagnostic;

/* The version of the library, as "0.1.0". */
const char *pse_version(void);

/* Compiles a program that messages call `name`. NULL on failure. */
pse_program *pse_compile(const char *name, const char *text, pse_error **error);
void pse_program_free(pse_program *program);

/* The variables that inputs have to hold, and those that the program assigns: their number, and the name of one; NULL
 * beyond the last. Names live as long as the program. */
size_t pse_required_count(const pse_program *program);
const char *pse_required(const pse_program *program, size_t index);
size_t pse_assigned_count(const pse_program *program);
const char *pse_assigned(const pse_program *program, size_t index);

/* A session keeps memory and tapes between runs. It holds the program itself, which may be freed before it. */
pse_session *pse_session_new(const pse_program *program);
void pse_session_free(pse_session *session);

/* Sets a param to a scalar (components 1) or a vector. Returns 0, or -1 on failure. */
int pse_set(pse_session *session, const char *name, const float *values, uint32_t components, pse_error **error);

/* Options with every field at its default. */
pse_options pse_options_default(void);

/* Runs the program at every pixel of `width` times `height`. `options` may be NULL. Returns 0, 1 if `abort` ended the run,
 * or -1 on failure. Then outputs may be written in part. */
int pse_run(pse_session *session, size_t width, size_t height, const pse_buffer *inputs, size_t input_count,
            const pse_buffer *outputs, size_t output_count, const pse_options *options, pse_error **error);

/* The whole message of an error, as the command prints it; its faults one by one. All live as long as the error. */
const char *pse_error_message(const pse_error *error);
size_t pse_error_count(const pse_error *error);
int pse_error_at(const pse_error *error, size_t index, pse_diagnostic *diagnostic);
void pse_error_free(pse_error *error);

#ifdef __cplusplus
}
#endif

#endif
