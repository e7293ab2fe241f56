// SPDX-License-Identifier: Apache-2.0
// Any bytes given to the OpenEXR reader: a film or one logged line, no crash, bounded memory.
#include "film/film.h"
#include "fuzz_case.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    struct satin_film *film = NULL;
    int lines = 0;
    satin_status status =
        film_parse_exr(data, size, "fuzz", (struct log){fuzz_count, &lines}, &film);
    if ((status == SATIN_OK) != (film != NULL) || lines != (status != SATIN_OK)) abort();
    satin_film_free(film);
    return 0;
}
