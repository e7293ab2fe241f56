// SPDX-License-Identifier: Apache-2.0
// TOML by the library toml++, in the only file that knows it: its tables become a tree of plain
// structs, and every exception becomes a message and a status. A table of toml++ is sorted by its
// keys; here the children have the order of the file, because the order of axes matters.
extern "C" {
#include "toml/toml.h"
}

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <new>
#include <string_view>

#define TOML_HEADER_ONLY 1
#define TOML_EXCEPTIONS 1
#define TOML_ENABLE_FORMATTERS 0
// Numbers are read by std::from_chars. The stream that would read them otherwise depends on the
// locale, and lets std::bad_alloc leave a function that is noexcept.
#define TOML_FLOAT_CHARCONV 1
#include <toml++/toml.h>

namespace {

constexpr int DEPTH_MAX = 64;  // of nested brackets, and of dots in a key

char *duplicate_text(std::string_view text) {
    char *copy = static_cast<char *>(std::malloc(text.size() + 1));
    if (!copy) throw std::bad_alloc();
    std::memcpy(copy, text.data(), text.size());
    copy[text.size()] = 0;
    return copy;
}

// The fewest digits from which the same number is read.
char *number_text(double value) {
    char text[40];
    for (int digits = 6; digits <= 17; digits++) {
        std::snprintf(text, sizeof text, "%.*g", digits, value);
        if (std::strtod(text, nullptr) == value) break;
    }
    // Large whole numbers are written without an exponent, as options of counts take them.
    if (value == std::floor(value) && std::fabs(value) < 1e15)
        std::snprintf(text, sizeof text, "%.0f", value);
    return duplicate_text(text);
}

void set_position(toml_node &out, const toml::source_region &source) {
    out.at.line = static_cast<int>(source.begin.line);
    out.at.column = static_cast<int>(source.begin.column);
}

void convert_node(const toml::node &in, const char *path, toml_node &out);

void allocate_children(toml_node &out, size_t count) {
    if (count == 0) return;
    out.child = static_cast<toml_node *>(std::calloc(count, sizeof *out.child));
    if (!out.child) throw std::bad_alloc();
    out.count = count;
}

void convert_table(const toml::table &in, const char *path, toml_node &out) {
    out.kind = TOML_TABLE;
    allocate_children(out, in.size());
    size_t i = 0;
    for (auto &&[key, value] : in) {
        toml_node &child = out.child[i++];
        child.key = duplicate_text(key.str());
        convert_node(value, path, child);
        set_position(child, key.source());
    }
    std::sort(out.child, out.child + out.count, [](const toml_node &a, const toml_node &b) {
        return a.at.line != b.at.line ? a.at.line < b.at.line : a.at.column < b.at.column;
    });
}

// `out` is zero but for its key.
void convert_node(const toml::node &in, const char *path, toml_node &out) {
    out.at.file = path;
    set_position(out, in.source());
    out.kind = TOML_OTHER;
    if (const toml::table *table = in.as_table()) {
        convert_table(*table, path, out);
    } else if (const toml::array *array = in.as_array()) {
        out.kind = TOML_ARRAY;
        allocate_children(out, array->size());
        for (size_t i = 0; i < out.count; i++) convert_node((*array)[i], path, out.child[i]);
    } else if (const auto *text = in.as_string()) {
        out.kind = TOML_TEXT;
        out.text = duplicate_text(text->get());
    } else if (const auto *whole = in.as_integer()) {
        out.kind = TOML_NUMBER;
        out.number = static_cast<double>(whole->get());
        out.text = duplicate_text(std::to_string(whole->get()));
    } else if (const auto *number = in.as_floating_point()) {
        out.kind = TOML_NUMBER;
        out.number = number->get();
        out.text = number_text(out.number);
    } else if (const auto *flag = in.as_boolean()) {
        out.kind = TOML_FLAG;
        out.text = duplicate_text(flag->get() ? "on" : "off");
    }
}

void free_children(toml_node &node) {
    for (size_t i = 0; i < node.count; i++) free_children(node.child[i]);
    std::free(node.child);
    std::free(node.key);
    std::free(node.text);
}

// One line of a message of toml++, without its long explanations.
satin_status fail_at_source(struct log log, const char *path, const toml::source_region &source,
                            std::string_view what) {
    const size_t line = std::min(what.find('\n'), what.size());
    const log_place at = {path, static_cast<int>(source.begin.line),
                          static_cast<int>(source.begin.column)};
    log_error_at(log, at, "%.*s", static_cast<int>(line), what.data());
    return SATIN_ERROR_INPUT;
}

satin_status fail_at_byte(struct log log, const char *path, std::string_view text, size_t byte,
                          const char *what) {
    log_place at = {path, 1, 1};
    for (const char c : text.substr(0, byte)) {
        if (c == '\n') at.line++;
        // The later bytes of a character in UTF-8 begin no column.
        at.column = c == '\n' ? 1 : at.column + ((c & 0xc0) != 0x80);
    }
    log_error_at(log, at, "%s", what);
    return SATIN_ERROR_INPUT;
}

// The end of the string that begins at byte i. One that is not closed ends with its line, or with
// the text if it may have several lines.
size_t string_end(std::string_view text, size_t i) {
    const char quote = text[i];
    const std::string_view three = quote == '"' ? "\"\"\"" : "'''";
    const bool has_lines = text.substr(i, 3) == three;
    for (i += has_lines ? 3 : 1; i < text.size(); i++) {
        if (quote == '"' && text[i] == '\\') {
            i++;
        } else if (has_lines && text.substr(i, 3) == three) {
            // Up to two quotes before the three that close it belong to it.
            const size_t last = std::min(i + 5, text.size());
            for (i += 3; i < last && text[i] == quote;) i++;
            return i;
        } else if (!has_lines && (text[i] == quote || text[i] == '\n')) {
            return text[i] == quote ? i + 1 : i;
        }
    }
    return text.size();
}

// toml++ descends recursively, and takes a byte of 0 for the end.
satin_status check_text(struct log log, const char *path, std::string_view text) {
    int dots = 0, depth = 0;
    const size_t zero = text.find('\0');
    if (zero != text.npos) return fail_at_byte(log, path, text, zero, "a byte is 0");
    for (size_t i = 0; i < text.size();) {
        const char c = text[i];
        if (c == '"' || c == '\'') {
            i = string_end(text, i);
            continue;
        }
        if (c == '#') {
            i = std::min(text.find('\n', i), text.size());
            continue;
        }
        if (c == '[' || c == '{') depth++;
        if ((c == ']' || c == '}') && depth > 0) depth--;
        if (c == '.') dots++;
        if (std::strchr("=,[]{}\n", c)) dots = 0;
        if (dots > DEPTH_MAX)
            return fail_at_byte(log, path, text, i, "a key has more than 64 dots");
        if (depth > DEPTH_MAX)
            return fail_at_byte(log, path, text, i, "brackets are nested deeper than 64");
        i++;
    }
    return SATIN_OK;
}

}  // namespace

extern "C" satin_status toml_parse(struct log log, const char *path, const char *text, size_t size,
                                   struct toml_node **root) {
    toml_node *made = nullptr;
    satin_status status = check_text(log, path, std::string_view(text, size));
    if (status != SATIN_OK) return status;
    try {
        const toml::table table = toml::parse(std::string_view(text, size));
        made = static_cast<toml_node *>(std::calloc(1, sizeof *made));
        if (!made) throw std::bad_alloc();
        convert_node(table, path, *made);
        *root = made;
        return SATIN_OK;
    } catch (const toml::parse_error &e) {
        status = fail_at_source(log, path, e.source(), e.description());
    } catch (const std::bad_alloc &) {
        status = log_fail(log, SATIN_ERROR_MEMORY, "%s: not enough memory", path);
    } catch (const std::exception &e) {
        status = log_fail(log, SATIN_ERROR_INTERNAL, "%s: %s", path, e.what());
    } catch (...) {
        status = log_fail(log, SATIN_ERROR_INTERNAL, "%s: toml++ failed", path);
    }
    toml_free(made);
    return status;
}

extern "C" void toml_free(struct toml_node *root) {
    if (!root) return;
    free_children(*root);
    std::free(root);
}

extern "C" const struct toml_node *toml_find(const struct toml_node *table, const char *key) {
    for (size_t i = 0; table && i < table->count; i++)
        if (table->child[i].key && std::strcmp(table->child[i].key, key) == 0)
            return &table->child[i];
    return nullptr;
}
