// SPDX-License-Identifier: Apache-2.0
// study.html: one file that needs no network. Its parts are in study_page.html, study_page.css and
// study_page.js and are embedded in the program with the library of charts when it is built
// (study_embed.py).
#include "study/study_page.h"

#include <stdlib.h>
#include <string.h>

#include "base/fileio.h"
#include "study/study_report.h"

// Appends the text for a mark of the page, which stands there as <!--NAME-->.
static satin_status add_marked(const struct study_report *report, const char *json,
                               const char *mark, struct study_text *out) {
    if (strncmp(mark, "STYLE", 5) == 0) {
        study_text_bytes(out, study_page_css, study_page_css_size);
    } else if (strncmp(mark, "SCRIPT", 6) == 0) {
        study_text_bytes(out, study_page_js, study_page_js_size);
    } else if (strncmp(mark, "CHARTS", 6) == 0) {
        study_text_bytes(out, study_page_charts, study_page_charts_size);
    } else if (strncmp(mark, "RESULTS", 7) == 0) {
        study_text_add(out, "%s", json);
    } else if (strncmp(mark, "PICTURES", 8) == 0) {
        return study_pictures_add(report, out);
    }
    return SATIN_OK;
}

satin_status study_page_write(const struct study_report *report, const char *json) {
    static const char begin[] = "<!--", end[] = "-->";
    struct study_text page = {0};
    satin_status status = SATIN_OK;
    const char *at = study_page_html, *mark;
    while (status == SATIN_OK && (mark = strstr(at, begin)) != NULL) {
        const char *after = strstr(mark, end);
        if (!after) break;
        study_text_bytes(&page, at, (size_t)(mark - at));
        status = add_marked(report, json, mark + sizeof begin - 1, &page);
        at = after + sizeof end - 1;
    }
    study_text_add(&page, "%s", at);
    char *path = study_store_path(report->store, "study.html");
    if (status == SATIN_OK && (page.failed || !path)) status = SATIN_ERROR_MEMORY;
    if (status == SATIN_OK) status = fileio_write(report->log, path, page.data, page.size);
    free(path);
    free(page.data);
    return status;
}
