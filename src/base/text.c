// SPDX-License-Identifier: Apache-2.0
// Words and numbers that users type.
#include "base/text.h"

#include <locale.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WORD_MAX = 48 };  // longer words are not compared, as they are not misspelt names

bool text_double(const char *text, double *out) {
    // strtod also accepts blanks, hexadecimal numbers, inf and nan, which are not allowed.
    if (!text[0] || strspn(text, "+-.0123456789eE") != strlen(text)) return false;
    locale_t plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    if (plain == (locale_t)0) return false;
    char *end = NULL;
    double value = strtod_l(text, &end, plain);
    freelocale(plain);
    if (*end || !isfinite(value)) return false;
    *out = value;
    return true;
}

static char fold_case(char c) {
    if (c >= 'A' && c <= 'Z') return (char)(c - 'A' + 'a');
    return c == '-' ? '_' : c;
}

bool text_same_name(const char *a, const char *b) {
    while (*a && fold_case(*a) == fold_case(*b)) {
        a++;
        b++;
    }
    return !*a && !*b;
}

bool text_is_one_of(const char *name, const char *const *list) {
    for (; *list; list++)
        if (text_same_name(name, *list)) return true;
    return false;
}

static int least(int a, int b) { return a < b ? a : b; }

// The optimal string alignment distance, row by row; the last three rows suffice.
static int edit_distance(const char *a, int na, const char *b, int nb) {
    int row[3][WORD_MAX + 1];
    for (int j = 0; j <= nb; j++) row[0][j] = j;
    for (int i = 1; i <= na; i++) {
        int *now = row[i % 3], *above = row[(i + 2) % 3], *above2 = row[(i + 1) % 3];
        now[0] = i;
        for (int j = 1; j <= nb; j++) {
            char ca = fold_case(a[i - 1]), cb = fold_case(b[j - 1]);
            now[j] = least(least(above[j], now[j - 1]) + 1, above[j - 1] + (ca != cb));
            if (i > 1 && j > 1 && ca == fold_case(b[j - 2]) && cb == fold_case(a[i - 2]))
                now[j] = least(now[j], above2[j - 2] + 1);
        }
    }
    return row[na % 3][nb];
}

void text_nearest_try(struct text_nearest *search, const char *candidate) {
    size_t nw = strlen(search->word), nc = strlen(candidate);
    if (nw > WORD_MAX || nc > WORD_MAX) return;
    int edits = edit_distance(search->word, (int)nw, candidate, (int)nc);
    // At most a third of the letters may differ: beyond that it is another word.
    if (3 * edits > (int)(nw > nc ? nw : nc) || (search->best && edits >= search->edits)) return;
    search->best = candidate;
    search->edits = edits;
}
