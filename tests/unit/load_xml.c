// SPDX-License-Identifier: Apache-2.0
// The tree of a scene file: order, parameters, includes, references; and every refusal's line.
#include "load/load_xml.h"

#include "base/fileio.h"
#include "scene_case.h"

static satin_status load_xml_read_text(struct scene_case *c, const char *text,
                                       struct load_xml *xml) {
    uint64_t hash = FILEIO_HASH;
    scene_case_file("scene.xml", text);
    return load_xml_read(scene_case_begin(c), (struct log){0}, "scene.xml",
                         &(satin_scene_request){0}, &hash, xml);
}

static void elements_keep_their_order_and_lines(void **state) {
    (void)state;
    struct scene_case c;
    struct load_xml xml;
    assert_int_equal(
        load_xml_read_text(&c,
                           "<!DOCTYPE scene><scene version='3.0.0'>\n"
                           "  <shape type='sphere' id='a'><float name='radius' value='2'/>\n"
                           "    words, which mean nothing -->\n"
                           "    <ref id='m'/></shape>\n"
                           "  <bsdf type='diffuse' id='m'/><alias id='m' as='n'/>\n"
                           "</scene>",
                           &xml),
        SATIN_OK);
    const struct xml_node *shape = xml.root->child, *bsdf = shape->next;
    assert_string_equal(shape->type, "sphere");
    assert_int_equal(shape->place.line, 2);
    assert_int_equal(shape->place.column, 3);
    assert_int_equal(shape->child->tag, XML_FLOAT);
    assert_string_equal(load_xml_get(shape->child, "value"), "2");
    assert_int_equal(shape->child->next->tag, XML_REF);
    assert_int_equal(shape->child->next->place.line, 4);
    assert_null(shape->child->next->next);
    assert_null(bsdf->next);
    assert_ptr_equal(load_xml_find(&xml, "n"), bsdf);
    assert_ptr_equal(load_xml_find(&xml, "a"), shape);
    assert_null(load_xml_find(&xml, "b"));
    load_xml_free(&xml);
}

// Declarations of a document's type change nothing but the entities that they declare, and lines
// stay where they are.
static void the_document_type_is_skipped(void **state) {
    (void)state;
    static const char *const types[] = {
        "<!DOCTYPE scene>\n\n\n",
        "\xef\xbb\xbf<!-- <!DOCTYPE [ --><?pi > ?>\n<!DOCTYPE scene SYSTEM 'a>.dtd'>\n\n",
        "<!DOCTYPE scene PUBLIC \"-//x\" \"y.dtd\" [\n<!-- ]> ' -->\n<?pi ]> ?>]\n>",
        ("<!DOCTYPE scene [<!ENTITY a ']>'><!ENTITY % b \"<x>\">\n%b;<!ELEMENT scene ANY>\n"
         "<!ATTLIST scene version CDATA '&a;&a;' type CDATA '9'>]>\n")};
    for (size_t i = 0; i < sizeof types / sizeof *types; i++) {
        struct scene_case c;
        struct load_xml xml;
        char text[512];
        snprintf(text, sizeof text, "%s%s", types[i],
                 "<scene version='3.0.0'><shape type='sphere' id='&amp;&#65;'/></scene>");
        assert_int_equal(load_xml_read_text(&c, text, &xml), SATIN_OK);
        assert_int_equal(xml.root->place.line, 4);
        assert_string_equal(xml.root->child->id, "&A");
        load_xml_free(&xml);
    }
}

static void entities_are_replaced(void **state) {
    (void)state;
    struct scene_case c;
    struct load_xml xml;
    assert_int_equal(
        load_xml_read_text(&c,
                           "<!DOCTYPE scene [<!ENTITY a 'b'><!ENTITY c '&a;&a;'>\n"
                           "<!ENTITY lamp \"<shape type='sphere' id='&c;'/>\">]>\n"
                           "<scene version='3.0.0'>&lamp;\n<shape type='&c;'/></scene>",
                           &xml),
        SATIN_OK);
    const struct xml_node *lamp = xml.root->child;
    assert_string_equal(lamp->id, "bb");
    assert_int_equal(lamp->place.line, 3);
    assert_string_equal(lamp->next->type, "bb");
    assert_int_equal(lamp->next->place.line, 4);
    assert_int_equal(c.warnings, 0);
    load_xml_free(&xml);
    // Declarations in another file are not read, which a warning reports.
    assert_int_equal(load_xml_read_text(&c,
                                        "<!DOCTYPE scene SYSTEM 'a.dtd'>\n"
                                        "<scene version='3.0.0'><shape type='a&b;'/></scene>",
                                        &xml),
                     SATIN_OK);
    assert_string_equal(xml.root->child->type, "a");
    assert_string_equal(c.warning,
                        "scene.xml:1:24: declarations in other files are not read; "
                        "entities that they declare are empty");
    load_xml_free(&xml);
}

// The billion laughs: ten times as many of each entity in the next, to 10^12 elements or bytes.
static void entities_are_bounded(void **state) {
    (void)state;
    static const char *const first[] = {"<bsdf type='diffuse'/>", "laughter"};
    static const char *const used[] = {"&e12;", "<shape type='&e12;'/>"};
    for (int i = 0; i < 2; i++) {
        char text[4096];
        struct scene_case c;
        struct load_xml xml;
        sprintf(text, "<!DOCTYPE scene [<!ENTITY e0 \"%s\">\n", first[i]);
        for (int k = 1; k <= 12; k++) {
            sprintf(text + strlen(text), "<!ENTITY e%d \"", k);
            for (int n = 0; n < 10; n++) sprintf(text + strlen(text), "&e%d;", k - 1);
            strcat(text, "\">\n");
        }
        sprintf(text + strlen(text), "]>\n<scene version='3.0.0'>%s</scene>", used[i]);
        assert_int_equal(load_xml_read_text(&c, text, &xml), SATIN_ERROR_INPUT);
        assert_non_null(strstr(c.error, ": not XML: limit on input amplification factor"));
        assert_int_equal(c.errors, 1);
    }
}

static void parameters_are_substituted(void **state) {
    (void)state;
    struct scene_case c;
    struct load_xml xml;
    uint64_t hash = FILEIO_HASH, other = FILEIO_HASH;
    scene_case_file("scene.xml",
                    "<scene version='3.0.0'><default name='n' value='1'/>"
                    "<default name='name' value='2$n'/><default name='n' value='9'/>"
                    "<shape type='$kind' id='$name-$n-\\$n'/></scene>");
    satin_define define = {"kind", "cube"};
    struct log log = scene_case_begin(&c);
    assert_int_equal(
        load_xml_read(log, log, "scene.xml",
                      &(satin_scene_request){.defines = &define, .define_count = 1}, &hash, &xml),
        SATIN_OK);
    assert_string_equal(xml.root->child->type, "cube");
    assert_string_equal(xml.root->child->id, "21-1-$n");
    load_xml_free(&xml);
    // A value from outside replaces a default, and counts for the hash.
    satin_define two[] = {{"kind", "cube"}, {"n", "7"}};
    assert_int_equal(
        load_xml_read(log, log, "scene.xml",
                      &(satin_scene_request){.defines = two, .define_count = 2}, &other, &xml),
        SATIN_OK);
    assert_string_equal(xml.root->child->id, "27-7-$n");
    assert_true(hash != other);
    load_xml_free(&xml);
    satin_define wrong[] = {{"kind", "cube"}, {"nam", "7"}};
    assert_int_equal(
        load_xml_read(log, log, "scene.xml",
                      &(satin_scene_request){.defines = wrong, .define_count = 2}, &other, &xml),
        SATIN_ERROR_INPUT);
    assert_string_equal(
        c.error, "scene.xml: parameter 'nam' is defined but not used (did you mean 'name'?)");
}

static void blanks_may_come_before_the_declaration(void **state) {
    (void)state;
    struct scene_case c;
    struct load_xml xml;
    assert_int_equal(load_xml_read_text(&c,
                                        "\n  <?xml version='1.0' encoding='ISO-8859-1'?>\n"
                                        "<scene version='3.0.0'>\n<shape type='caf\xe9'/></scene>",
                                        &xml),
                     SATIN_OK);
    assert_string_equal(xml.root->child->type, "caf\xc3\xa9");
    assert_int_equal(xml.root->child->place.line, 4);
    load_xml_free(&xml);
}

static void files_are_included(void **state) {
    (void)state;
    struct scene_case c;
    struct load_xml xml;
    scene_case_file("bsdf.xml", "<bsdf version='3.0.0' type='$type' id='b'/>");
    scene_case_file("part.xml",
                    "<scene version='3.0.0'><default name='type' value='diffuse'/>"
                    "<shape type='cube'><include filename='bsdf.xml' name='x'/></shape>"
                    "<shape type='disk'/></scene>");
    assert_int_equal(load_xml_read_text(&c,
                                        "<scene version='3.0.0'><include filename='part.xml'/>"
                                        "<texture type='$type'/></scene>",
                                        &xml),
                     SATIN_OK);
    const struct xml_node *cube = xml.root->child;
    assert_string_equal(cube->type, "cube");
    assert_string_equal(cube->place.file, "part.xml");
    assert_string_equal(cube->child->type, "diffuse");
    assert_string_equal(cube->child->name, "x");
    assert_string_equal(cube->next->type, "disk");
    assert_string_equal(cube->next->next->type, "diffuse");
    assert_ptr_equal(load_xml_find(&xml, "b"), cube->child);
    load_xml_free(&xml);
    scene_case_file("part.xml", "<scene version='3.0.0'>\n<include filename='scene.xml'/></scene>");
    assert_int_equal(load_xml_read_text(
                         &c, "<scene version='3.0.0'><include filename='part.xml'/></scene>", &xml),
                     SATIN_ERROR_INPUT);
    assert_string_equal(c.error, "part.xml:2:1: 'scene.xml' includes itself");
    assert_int_equal(c.errors, 1);
}

// Files that include three others each stop at the bound on files.
static void includes_are_bounded(void **state) {
    (void)state;
    struct scene_case c;
    struct load_xml xml;
    for (int i = 0; i < 20; i++) {
        char name[16], text[256], next[64];
        snprintf(name, sizeof name, "f%d.xml", i);
        snprintf(next, sizeof next, "<include filename='f%d.xml'/>", i + 1);
        snprintf(text, sizeof text, "<scene version='3.0.0'>%s%s%s</scene>", next, next, next);
        if (i == 12) snprintf(text, sizeof text, "<scene version='3.0.0'/>");
        scene_case_file(name, text);
    }
    assert_int_equal(
        load_xml_read_text(&c, "<scene version='3.0.0'><include filename='f0.xml'/></scene>", &xml),
        SATIN_ERROR_INPUT);
    assert_non_null(strstr(c.error, "too many includes"));
    assert_int_equal(c.errors, 1);
}

struct load_xml_refusal {
    const char *text, *error;
};

#define S "<scene version='3.0.0'>"

static const struct load_xml_refusal load_xml_refusals[] = {
    {"", "scene.xml:1:1: the file is empty"},
    {" \n", "scene.xml:2:1: the file is empty"},
    {"just text", "scene.xml:1:1: not XML: syntax error"},
    {S "\n<shape type='cube'>",
     "scene.xml:2:20: not XML: no element found: <shape> of line 2 is not closed"},
    {S "\n<shape type='cube'>\n</scene>",
     "scene.xml:3:3: not XML: mismatched tag: <shape> of line 2 is not closed"},
    {S "<shape type=cube/>\n</scene>",
     "scene.xml:1:36: not XML: not well-formed (invalid token) at 'cube/>'"},
    {S "<shape type='caf\xe9'/></scene>",
     "scene.xml:1:40: not XML: the byte 0xe9 is not UTF-8; another encoding is named by "
     "<?xml version=\"1.0\" encoding=\"ISO-8859-1\"?>"},
    {S "\n <a>", "scene.xml:2:2: unknown element <a>"},
    {S "\n <shap type='cube'/></scene>",
     "scene.xml:2:2: unknown element <shap> (did you mean <shape>?)"},
    {S "<texture type='x'><volume type='constvolume'/></texture></scene>",
     "scene.xml:1:42: <volume> is not supported"},
    {"<scene/>", "scene.xml:1:1: <scene> needs the attribute 'version'"},
    {"<scene version='1.0.0'/>",
     "scene.xml:1:1: version '1.0.0' is not supported: 0.x, 2.x and 3.x are"},
    {S "<camera type='perspective'/></scene>",
     "scene.xml:1:24: <camera> is of Mitsuba 0.3, which is not supported"},
    {S "<shape type='cube'><path value='.'/></shape></scene>",
     "scene.xml:1:43: <path> cannot stand inside <shape>"},
    {S "<include filename='scene.xml'/></scene>", "scene.xml:1:24: 'scene.xml' includes itself"},
    {"<shape version='3.0.0' type='cube'/>",
     "scene.xml:1:1: the root element is <shape>, not <scene>"},
    {S "<scene version='3.0.0'/></scene>", "scene.xml:1:24: <scene> cannot stand inside <scene>"},
    {"<bsdf type='diffuse'/>", "scene.xml:1:1: the root element is <bsdf>, not <scene>"},
    {S "<shape/></scene>", "scene.xml:1:24: <shape> needs the attribute 'type'"},
    {S "<shape type='cube' foo='1'/></scene>", "scene.xml:1:24: <shape> has no attribute 'foo'"},
    {S "<translate x='1'/></scene>", "scene.xml:1:24: <translate> cannot stand inside <scene>"},
    {S "<float name='a' value='1'><float name='b' value='1'/></float></scene>",
     "scene.xml:1:50: <float> cannot stand inside <float>"},
    {S "<shape type='cube' id='a'/>\n<bsdf type='diffuse' id='a'/></scene>",
     "scene.xml:2:1: duplicate id 'a' (first at scene.xml:1:24)"},
    {S "<alias id='a' as='b'/><bsdf type='diffuse' id='a'/></scene>",
     "scene.xml:1:24: alias of 'a', which is not defined before it"},
    {S "<alias id='b' as='b'/></scene>",
     "scene.xml:1:24: alias of 'b', which is not defined before it"},
    {S "<shape type='$what'/></scene>",
     "scene.xml:1:24: undefined parameter '$what' (-D what=VALUE defines it)"},
    {S "<default name='' value='1'/></scene>", "scene.xml:1:24: <default> with an empty name"},
    {"<!DOCTYPE scene [<!ENTITY a SYSTEM 'a.xml'>]>\n" S "&a;</scene>",
     "scene.xml:2:24: an entity that is the file 'a.xml' is not read; <include> reads files"},
    {"<!DOCTYPE scene [<!ENTITY a SYSTEM 'a.xml'>]>\n" S "<shape type='&a;'/></scene>",
     "scene.xml:2:37: not XML: reference to external entity in attribute"},
    {"<!DOCTYPE scene [<!ENTITY a '&b;'><!ENTITY b '&a;'>]>\n" S "<shape type='&a;'/></scene>",
     "scene.xml:2:24: not XML: recursive entity reference"},
    {S "words and an &entity;</scene>", "scene.xml:1:37: not XML: undefined entity"},
    {"<!DOCTYPE scene [<!ENTITY a 'b'>" S "</scene>", "scene.xml:1:33: not XML: syntax error"},
    {S "<include filename='none.xml'/></scene>",
     "scene.xml:1:24: cannot read 'none.xml': No such file or directory"},
};

static void errors_of_xml_name_their_line(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof load_xml_refusals / sizeof *load_xml_refusals; i++) {
        struct scene_case c;
        struct load_xml xml;
        assert_int_equal(load_xml_read_text(&c, load_xml_refusals[i].text, &xml),
                         SATIN_ERROR_INPUT);
        assert_string_equal(c.error, load_xml_refusals[i].error);
        assert_int_equal(c.errors, 1);
    }
}

static void nesting_is_bounded(void **state) {
    (void)state;
    enum { DEPTH = 100000 };
    static const char element[] = "<bsdf type='twosided'>";
    size_t n = sizeof element - 1;
    char *text = malloc(sizeof S + n * DEPTH);
    assert_non_null(text);
    strcpy(text, S);
    for (size_t i = 0; i < DEPTH; i++) memcpy(text + sizeof S - 1 + i * n, element, n);
    text[sizeof S - 1 + n * DEPTH] = 0;
    struct scene_case c;
    struct load_xml xml;
    assert_int_equal(load_xml_read_text(&c, text, &xml), SATIN_ERROR_INPUT);
    free(text);
    assert_string_equal(c.error, "scene.xml:1:1410: elements are nested more than 64 deep");
    assert_int_equal(c.errors, 1);
}

// Each parameter doubles the one before; the text is refused before it is built.
static void substitution_is_bounded(void **state) {
    (void)state;
    char text[8192] = S "<default name='a0' value='xxxxxxxx'/>";
    for (int i = 1; i < 60; i++)
        sprintf(text + strlen(text), "<default name='a%d' value='$a%d$a%d'/>", i, i - 1, i - 1);
    strcat(text, "</scene>");
    struct scene_case c;
    struct load_xml xml;
    assert_int_equal(load_xml_read_text(&c, text, &xml), SATIN_ERROR_INPUT);
    assert_non_null(strstr(c.error, "attribute longer than 65536 bytes"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(elements_keep_their_order_and_lines),
        cmocka_unit_test(the_document_type_is_skipped),
        cmocka_unit_test(entities_are_replaced),
        cmocka_unit_test(entities_are_bounded),
        cmocka_unit_test(parameters_are_substituted),
        cmocka_unit_test(blanks_may_come_before_the_declaration),
        cmocka_unit_test(files_are_included),
        cmocka_unit_test(includes_are_bounded),
        cmocka_unit_test(errors_of_xml_name_their_line),
        cmocka_unit_test(nesting_is_bounded),
        cmocka_unit_test(substitution_is_bounded),
    };
    return cmocka_run_group_tests(tests, folder_case_setup, folder_case_teardown);
}
