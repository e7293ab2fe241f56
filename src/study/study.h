// SPDX-License-Identifier: Apache-2.0
// Studies: a file names scenes, references, options that vary, and seeds; all images are rendered
// one after another and compared, and tables and a page show what was found.
#ifndef STUDY_STUDY_H
#define STUDY_STUDY_H

#include <stdbool.h>

#include "base/log.h"

struct study_request {
    const char *file;     // of the study
    const char *folder;   // of the results; made if it does not exist
    const char *program;  // the path of the command `satin`, which renders
    // Called with one line when a render begins or ends. May be NULL.
    void (*report)(void *user, const char *line);
    void *user;
    bool (*interrupted)(void);  // whether to stop; may be NULL
    void (*planned)(void);      // called when the file and the scenes are read; may be NULL
    bool dry;                   // only checks the file and reports what would be rendered
};

// Runs a study, or continues one: renders of which the folder has a result are not repeated. Writes
// study.csv, study.json and study.html into the folder, also if renders failed or it was
// interrupted. SATIN_ERROR_INPUT, logged, if the file, a scene or a reference is wrong;
// SATIN_ERROR_INTERNAL, logged, if a render failed or an image cannot be compared; SATIN_CANCELLED
// if it was interrupted; SATIN_ERROR_IO and SATIN_ERROR_MEMORY, logged.
satin_status study_run(const struct study_request *request, struct log log);

#endif
