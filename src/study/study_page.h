// SPDX-License-Identifier: Apache-2.0
// Private to study/: the embedded files of the page. Each ends with a 0, which its size leaves out.
#ifndef STUDY_PAGE_H
#define STUDY_PAGE_H

#include <stddef.h>

extern const char study_page_html[], study_page_css[], study_page_js[];
extern const char study_page_charts[];  // Chart.js, with the note of its licence
extern const size_t study_page_css_size, study_page_js_size, study_page_charts_size;

#endif
