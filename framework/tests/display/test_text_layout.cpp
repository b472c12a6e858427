#include "terminal.h"

#include "base/text.h"

#include <regex>

using namespace fresco::host;
using Kind = TextTable::Kind;

namespace
{

const char* const long_names = R"(version: 1
vars: {value: 3}
matrix: {value: {the_first_of_two_values: 3, the_second_of_two_values: 4}}
stages:
  a_source_with_a_name_that_no_narrow_terminal_has_room_for: {type: test.source, value: "${value}"}
  slow: {type: test.slow, input: a_source_with_a_name_that_no_narrow_terminal_has_room_for, steps: 4, step_ms: 50}
  text: {type: test.sink, input: slow, path: x.txt}
)";

/// Lines that were ever written, without what moves the cursor.
Lines written_lines(const std::string& written)
{
    Lines lines;
    std::istringstream stream(std::regex_replace(written, std::regex("\x1b\\[[0-9]*[A-Za-z]|\r"), ""));
    for (std::string line; std::getline(stream, line);)
        lines.push_back(line);
    return lines;
}

/// A word wider than the terminal gets a line of its own.
bool fits(const std::string& line, std::size_t width)
{
    const std::size_t first = line.find_first_not_of(' ');
    return columns(line) <= width || line.find(' ', first) == std::string::npos;
}

}  // namespace

TEST_CASE("Lines are broken at blanks and go on with an indent, words stay whole")
{
    CHECK(folded("one two three four", 9) == "one two\nthree\nfour");
    CHECK(folded("one two three four", 9, 2) == "one two\n  three\n  four");
    CHECK(folded("  one two three", 9, 2) == "  one two\n    three");
    CHECK(folded("a/path/that/is/longer/than/this and more", 10) == "a/path/that/is/longer/than/this\nand more");
    CHECK(folded("one two\nthree four five\n", 10) == "one two\nthree four\nfive\n");
    CHECK(folded("a    b   c", 8) == "a    b\nc");
    CHECK(folded("one two", without_end) == "one two");
    CHECK(folded("größer größer", 6) == "größer\ngrößer");
    CHECK(folded("", 5).empty());
}

TEST_CASE("Long names lose their middle")
{
    CHECK(shortened("texture", 7) == "texture");
    CHECK(shortened("texture@waves", 7) == "tex…ves");
    CHECK(shortened("texture@waves", 8) == "text…ves");
    CHECK(shortened("gräßlich", 5) == "gr…ch");
    CHECK(shortened("部屋の絵画", 7) == "部屋…画");
}

TEST_CASE("A table gives way to a narrow terminal step by step")
{
    TextTable table({{"stage", Kind::name}, {"time", Kind::number}, {"why", Kind::text}});
    table.add({"texture@kitchen,waves", "1.0 s", "the option size_px was changed from 2048 to 1024"});
    table.add({"glb", "12.0 s", ""});
    CHECK(table.text(without_end) == "stage                    time  why\n"
                                     "texture@kitchen,waves   1.0 s  the option size_px was changed from 2048 to 1024\n"
                                     "glb                    12.0 s\n");
    CHECK(table.text(100) == table.text(without_end));
    CHECK(table.text(60) == "stage                    time  why\n"
                            "texture@kitchen,waves   1.0 s  the option size_px was\n"
                            "                               changed from 2048 to 1024\n"
                            "glb                    12.0 s\n");
    CHECK(table.text(40) == "stage                    time\n"
                            "texture@kitchen,waves   1.0 s\n"
                            "    the option size_px was changed from\n"
                            "    2048 to 1024\n"
                            "glb                    12.0 s\n");
    CHECK(table.text(24) == "stage               time\n"
                            "texture@…n,waves   1.0 s\n"
                            "    the option size_px\n"
                            "    was changed from\n"
                            "    2048 to 1024\n"
                            "glb               12.0 s\n");
    CHECK(table.text(16) == "texture@…n,waves\n"
                            "    time 1.0 s\n"
                            "    the option\n"
                            "    size_px was\n"
                            "    changed from\n"
                            "    2048 to 1024\n"
                            "glb\n"
                            "    time 12.0 s\n");
}

TEST_CASE("A path that is wider than its column goes below its row")
{
    TextTable facts({{"", Kind::figure}, {"", Kind::text}});
    facts.add({"descriptions", "/home/somebody/.cache/fresco/descriptors/x86_64"});
    facts.add({"CUDA", "no driver"});
    CHECK(facts.text(61) == "descriptions  /home/somebody/.cache/fresco/descriptors/x86_64\n"
                            "CUDA          no driver\n");
    CHECK(facts.text(60) == "descriptions\n"
                            "    /home/somebody/.cache/fresco/descriptors/x86_64\n"
                            "CUDA          no driver\n");
}

TEST_CASE("At 80 and at 40 columns no line is wider, and no word is split")
{
    Workplace place;
    place.write("room.yaml", long_names);
    place.write("one.yaml", "version: 1\nstages:\n  slow: {type: test.slow, steps: 4, step_ms: 50}\n"
                            "  bad: {type: test.fail, input: slow, how: error}\n");
    place.write("wrong.yaml",
                "version: 1\nstages:\n  slow: {type: test.slow, steps: many, stepms: 3}\n  two: {type: test.nothin}\n");
    const std::vector<Lines> commands{
        {"plan", "room.yaml"},
        {"run", "room.yaml"},
        {"run", "one.yaml"},
        {"plan", "one.yaml"},
        {"check", "wrong.yaml"},
        {"run", "wrong.yaml"},
        {"stages"},
        {"describe", "test.add"},
        {"describe", "read.number"},
        {"store", "ls"},
        {"log", "room.yaml", "slow@the_first_of_two_values"},
        {"doctor"},
        {"--help"},
        {"run", "--help"},
        {"store", "gc", "--help"},
        {"submit", "slurm", "--help"},
        {"run", "room.yaml", "--nothing", "that", "it", "has", "for", "an", "argument", "of", "this", "name"},
        {"new", "stage", "my.dots"}};
    for (const unsigned width : {80U, 40U})
    {
        fs::remove_all(place.file(".fresco"));
        fs::remove_all(place.file("my_dots"));
        for (const Lines& command : commands)
        {
            Terminal terminal(place, command, static_cast<unsigned short>(width), 24);
            terminal.finish();
            const Lines lines = written_lines(terminal.written());
            CAPTURE(width, command, terminal.text());
            CHECK_FALSE(lines.empty());
            for (const std::string& line : lines)
                if (!fits(line, width) && !line.starts_with("  cmake ") &&
                    !line.starts_with("  FRESCO_PLUGIN_PATH="))  // To be copied.
                    FAIL_CHECK(line);
        }
    }
}

TEST_CASE("A file gets whole lines, or those of COLUMNS")
{
    Workplace place;
    place.write("room.yaml", long_names);
    const std::string whole = place.run({"plan", "room.yaml"}).out;
    CHECK(contains(whole, "a_source_with_a_name_that_no_narrow_terminal_has_room_for@the_second_of_two_values  run"));
    place.environment["COLUMNS"] = "60";
    const std::string narrow = place.run({"plan", "room.yaml"}).out;
    for (const std::string& line : written_lines(narrow))
        CHECK(fits(line, 60));
    CHECK(contains(narrow, "a_source_with_"));
}
