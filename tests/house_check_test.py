"""The house check finds each kind of error, names its place, and lets pass what is right.

Every test hands a check a small source of its own. Run: python3 -m unittest tests/house_check_test.py
"""

import subprocess
import sys
import unittest
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent))
import house_check as house  # noqa: E402


def body(lines):
    return "".join(f"    Step({i});\n" for i in range(lines))


class HouseCheck(unittest.TestCase):
    def found(self, check, text, file="src/shapes/a.cpp", **others):
        files = [(file, text)] + [(name.replace("__", "/") + ".cpp", other) for name, other in others.items()]
        return house.CHECKS[check](files)

    def passes(self, check, text, file="src/shapes/a.cpp", **others):
        self.assertEqual(self.found(check, text, file, **others), [])

    def fails(self, check, text, place, says, file="src/shapes/a.cpp", **others):
        errors = self.found(check, text, file, **others)
        self.assertEqual(len(errors), 1, errors)
        self.assertTrue(errors[0].startswith(place + ": error: "), errors[0])
        self.assertIn(says, errors[0])

    # --- includes ---
    def test_rooms_below_may_be_included(self):
        self.passes("includes", '#include "core/error.h"\n#include "files/file.h"\n#include <vector>\n')

    def test_rooms_above_may_not(self):
        self.fails("includes", '#include <vector>\n#include "scene/scene.h"\n', "src/shapes/a.cpp:2",
                   "shapes must not include scene")

    def test_core_includes_nothing_of_ours(self):
        self.fails("includes", '#include "files/file.h"\n', "src/core/a.h:1", "core must not include files",
                   file="src/core/a.h")

    def test_an_include_names_its_room(self):
        self.fails("includes", '#include "curve.h"\n', "src/shapes/a.cpp:1", "by its room")

    def test_an_unknown_room(self):
        self.fails("includes", "", "src/util/a.h:1", "no room of the house", file="src/util/a.h")

    def test_rooms_within_a_room_do_not_meet(self):
        self.passes("includes", '#include "figures/plot.h"\n#include "figures/papers/sheet.h"\n',
                    file="src/figures/papers/a.cpp")
        self.passes("includes", '#include "figures/papers/sheet.h"\n', file="src/figures/figure_table.cpp")
        self.fails("includes", '#include "figures/charts/cost.h"\n', "src/figures/papers/a.cpp:1",
                   "figures/papers must not include figures/charts", file="src/figures/papers/a.cpp")

    def test_libraries_stand_behind_our_headers(self):
        for header in ["tbb/parallel_for.h", "glog/logging.h", "zlib.h", "png.h", "OpenEXR/ImfHeader.h"]:
            self.fails("includes", f"#include <{header}>\n", "src/shapes/a.cpp:1", f"<{header}> stands behind")
        self.passes("includes", "#include <tbb/parallel_for.h>\n", file="src/core/parallel.cpp")
        self.passes("includes", "#include <zlib.h>\n", file="src/files/gzip.cpp")
        self.passes("includes", "#include <zlib.h>\n", file="tests/files/file_test.cpp")

    # --- size ---
    def test_length_of_files(self):
        self.passes("size", "int a;\n" * house.MAX_FILE)
        self.fails("size", "int a;\n" * (house.MAX_FILE + 1), "src/shapes/a.cpp:1", "701 lines")

    def test_width_of_lines(self):
        self.passes("size", "// " + "x" * 107 + "\n")
        self.fails("size", "\n// " + "x" * 108 + "\n", "src/shapes/a.cpp:2", "111 columns")
        self.passes("size", "// " + "\u03b2" * 107 + "\n")  # columns, not bytes

    def test_length_of_functions(self):
        self.passes("size", "void F() {\n" + body(78) + "}\n")
        self.fails("size", "int a;\n\nvoid F() {\n" + body(79) + "}\n", "src/shapes/a.cpp:3", "F() has 81 lines")

    def test_a_reason_beside_a_long_function(self):
        self.passes("size", "// Does F.\n// Long because: a step a line.\nvoid F() {\n" + body(90) + "}\n")
        self.fails("size", "// Long because: of G.\nvoid G();\nvoid F() {\n" + body(90) + "}\n",
                   "src/shapes/a.cpp:3", "F() has 92 lines")

    def test_functions_of_every_kind_are_seen(self):
        for head in ["void A::F(int a,\n          int b) const {", "template <class T>\nT F(T a) noexcept {",
                     "A::F(int a) : a_(a), b_{a} {", "bool F(const A &a = {}) {", "auto F() -> int {",
                     "[[noreturn]] void F(const std::array<int, 3> &a) {", "TEST(Some, F) {",
                     "static inline std::unique_ptr<A> F() {", "bool operator==(const A &a) const {"]:
            for before, after in [("", ""), ("namespace a {\n", "}\n"), ("class A : public B {\n  public:\n", "};\n")]:
                errors = self.found("size", f"{before}{head}\n" + body(85) + "}\n" + after)
                self.assertEqual(len(errors), 1, head)

    def test_classes_tables_and_namespaces_are_no_functions(self):
        for head, end in [("namespace a::b {", "}"), ("class A final : public B<int (*)(int)> {", "};"),
                          ("struct A {", "};"), ("const Row kRows[] = {", "};"), ("enum class A : int {", "};")]:
            self.passes("size", head + "\n" + "    int a;\n" * 90 + end + "\n")

    def test_what_stands_inside_counts_with_its_function(self):
        inner = "    const auto g = [&](int i) {\n" + body(20) + "    };\n    for (int i = 0; i < 3; ++i) {\n" + body(60) + "    }\n"
        self.fails("size", "void F() {\n" + inner + "}\n", "src/shapes/a.cpp:1", "F() has 86 lines")

    def test_braces_in_strings_and_comments_do_not_count(self):
        self.passes("size", 'void F() {\n    Print("{{{", \'{\', 1\'000); // {\n    /* { */\n}\n' + "int a;\n" * 90)
        self.fails("size", 'void G() { Print("}"); }\nvoid F() {\n    Print("}");\n' + body(90) + "}\n",
                   "src/shapes/a.cpp:2", "F() has 93 lines")

    # --- types ---
    def test_a_name_has_one_meaning(self):
        self.passes("types", "struct A {\n};\n", src__scene__b="struct B {\n};\n")
        self.fails("types", "struct Box {\n};\n", "src/shapes/a.cpp:1", "Box is also at src/scene/b.cpp:3",
                   src__scene__b="namespace {\n\nclass Box final : public A {\n};\n}\n")

    def test_types_within_types_and_functions_are_their_own(self):
        self.passes("types", "struct A {\n    struct Row {\n    };\n};\n",
                    src__scene__b="struct B {\n    enum class Row { X };\n};\nvoid F() {\n    struct Row {\n    };\n}\n")

    def test_named_namespaces_tell_types_apart(self):
        self.passes("types", "namespace cuticle {\nstruct HairBSDF {\n};\n}\n",
                    src__scene__b="namespace cuticle {\nnamespace as_printed {\nstruct HairBSDF {\n};\n}\n}\n")

    def test_declarations_and_tests_are_no_second_meaning(self):
        self.passes("types", "struct Box {\n};\n", src__scene__b="struct Box;\n", tests__shapes__c="struct Box {\n};\n",
                    src__core__d="struct A::Box {\n};\ntemplate <>\nstruct Box<int> {\n};\n")

    # --- words ---
    def test_comments_have_a_verb(self):
        self.passes("words", "// Returns what is left.\nint F();\n// Ends here, and\n// what follows goes on.\n",
                    file="src/shapes/a.h")
        for word in ["Of", "What", "Where", "Without", "By", "From"]:
            self.fails("words", f"int a;\n// {word} the hair.\nint F();\n", "src/shapes/a.h:2", f'"{word}"',
                       file="src/shapes/a.h")

    def test_a_first_comment_of_a_chunk_is_seen(self):
        self.fails("words", "//> Name the step\n// What it is.\nint F();\n", "src/shapes/a.h:2", '"What"',
                   file="src/shapes/a.h")

    def test_steps_inside_a_function_are_free(self):
        self.passes("words", "void F() {\n    // Where it is zero\n    G();\n}\n")

    def test_questions_have_a_verb(self):
        self.passes("words", "// What does a pixel cost?\nint F();\n", file="src/shapes/a.h")

    def test_min_and_max(self):
        for name in ["kMostLobes", "kSmallestV", "kLargestGroup", "kDeepestTree", "leastArea", "GreatestOf", "fLeast"]:
            self.fails("words", f"int {name} = 0;\n", "src/shapes/a.cpp:1", name)
        self.passes("words", "int kMinV, kMaxLobes, atLeast; // the least of these\n")

    # --- messages ---
    def test_messages_are_format_strings(self):
        self.passes("messages", 'throw Error(loc, "\\"{}\\" is {}", a, b);\nconst auto s = std::to_string(3);\n')
        self.fails("messages", 'int a;\nthrow Error(loc, "it is " + F(a) +\n            std::to_string(b));\n',
                   "src/shapes/a.cpp:3", "format string")
        self.fails("messages", 'Warning("kind", std::to_string(n) + " of them");\n', "src/shapes/a.cpp:1",
                   "format string")

    # --- tables ---
    def test_tables_say_how_to_add_a_row(self):
        table = "const PluginRow<Maker> kLights[] = {\n    {},\n};\n"
        self.passes("tables", "// The lights. To add one: a row.\n" + table)
        self.passes("tables", "// To add an area light: a row.\n" + table)
        self.fails("tables", "// The lights.\n" + table, "src/shapes/a.cpp:2", "kLights")

    # --- the program ---
    def test_the_house_is_read(self):
        files = dict(house.house())
        self.assertIn("src/core/error.h", files)
        names = {name for name, _, _ in house.functions(files["src/core/error.cpp"])}
        self.assertTrue({"Error::WithRemedy", "Suggestion", "Warning", "WarningLog::Flush"} <= names, names)

    def test_an_unknown_check_is_refused(self):
        run = subprocess.run([sys.executable, house.__file__, "nonsense"], capture_output=True, text=True)
        self.assertNotEqual(run.returncode, 0)
        self.assertIn("includes", run.stderr)


if __name__ == "__main__":
    unittest.main()
